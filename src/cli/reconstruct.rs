//! `patterns reconstruct`: the model of a picture that is hidden in part, and its whole.

use super::{
    run_args::{RunArgs, thread_pool},
    values,
};
use crate::{
    reconstruct::{self, Options, evaluate},
    request::Request,
    runner::Outcome,
};
use anyhow::{Result, bail};
use std::{io::Write as _, path::PathBuf, process::ExitCode, time::Duration};
use toml::Value;

/// Find the model and parameters that made a pattern, and fill what is hidden.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    patterns reconstruct photo.png --mask mask.png\n  \
    patterns reconstruct photo.png --mask-box 40,40,64,64 --truth whole.png\n  \
    patterns reconstruct noisy.png\n  \
    patterns reconstruct --example turing-spots --share 0.25\n  \
    patterns reconstruct --evaluate cases --out table")]
pub(super) struct Args {
    /// The picture: PNG, JPEG, BMP, PNM, TIFF or NPY; without a mask, flat regions, random dots
    /// and noise count as hidden.
    #[arg(value_name = "PICTURE", required_unless_present_any = ["example", "evaluate"])]
    picture: Option<String>,
    /// An image of the picture's size whose light pixels are hidden.
    #[arg(long, value_name = "FILE")]
    mask: Option<String>,
    /// A hidden box: column, row, width and height in pixels.
    #[arg(long, value_name = "X,Y,W,H", conflicts_with = "mask")]
    mask_box: Option<String>,
    /// A hidden disk: column and row of its middle and radius in pixels.
    #[arg(long, value_name = "X,Y,R", conflicts_with_all = ["mask", "mask_box"])]
    mask_circle: Option<String>,
    /// The whole picture, to measure the reconstruction against.
    #[arg(long, value_name = "FILE")]
    truth: Option<String>,
    /// Instead of a picture: a pattern of this class, hidden in part by the program.
    #[arg(long, value_name = "CLASS", conflicts_with_all = ["picture", "mask", "mask_box", "mask_circle", "truth"])]
    example: Option<String>,
    /// What is done to the example [default: box].
    #[arg(long, requires = "example", value_parser = ["box", "small-boxes", "dots", "speckle", "blur", "invert", "rotate"])]
    harm: Option<String>,
    /// Part of the example that is hidden, in [0, 1) [default: 0.25].
    #[arg(long, value_name = "PART", requires = "example")]
    share: Option<f64>,
    /// Keep the example's mask back, so that it has to be found.
    #[arg(long, requires = "example")]
    find: bool,
    /// Further classes: a folder that `patterns database add` filled.
    #[arg(long, value_name = "DIR")]
    database: Option<String>,
    /// Seconds that the whole shall take: the search for parameters ends early enough. A run
    /// that meets it depends on the machine's speed; run.json says how far it came [default:
    /// none].
    #[arg(long, value_name = "SECONDS")]
    budget: Option<f64>,
    /// Most generations of the search for parameters, 0 for none [default: 5; 16 for structures].
    #[arg(long, value_name = "N")]
    generations: Option<u64>,
    /// Classes whose scores are computed [default: 4].
    #[arg(long, value_name = "N")]
    candidates: Option<u64>,
    /// Samples of what may be hidden [default: 1; 6 where a hole is wider than two wavelengths].
    #[arg(long, value_name = "N")]
    samples: Option<u64>,
    /// Identify the pictures of a folder that `patterns database evaluate` made, and write
    /// the table.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["picture", "example", "mask", "mask_box", "mask_circle", "truth"])]
    evaluate: Option<PathBuf>,
    /// Output folder [default: out/reconstruct-<n>, the first that is free].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite an output folder that is not empty.
    #[arg(long)]
    force: bool,
    /// Seed of all random numbers; the same seed gives the same bytes [default: 0].
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    seed: u64,
    /// Threads, 0 for all cores; the results do not depend on it [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
    /// Print run.json on standard output instead of the summary.
    #[arg(long)]
    json: bool,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    if let Some(budget) = args.budget.filter(|&budget| !(budget > 0.0 && budget < 1e6)) {
        bail!("--budget {budget} is outside its range (0, 1e6)");
    }
    let options = Options {
        out: args.out.clone(),
        force: args.force,
        quiet: args.quiet || args.json,
        budget: args.budget.map_or(Duration::MAX, Duration::from_secs_f64),
    };
    let pool = thread_pool(args.threads)?;
    if let Some(folder) = &args.evaluate {
        let database = args.database.as_ref().map(PathBuf::from);
        let table = pool.install(|| evaluate::run(folder, database.as_deref(), &options))?;
        if !args.quiet {
            print!("{table}");
        }
        return Ok(ExitCode::SUCCESS);
    }
    let request = args.request()?;
    let outcome = pool.install(|| reconstruct::run(&request, &options))?;
    report(&outcome, args.quiet, args.json)?;
    Ok(ExitCode::SUCCESS)
}

impl Args {
    fn request(&self) -> Result<Request> {
        let mut request = Request::new("reconstruct", self.seed);
        if let Some(picture) = &self.picture {
            request.set("picture", picture.as_str().into(), picture)?;
        }
        request.set_flag("mask", self.mask.clone())?;
        request.set_flag("truth", self.truth.clone())?;
        request.set_flag("database", self.database.clone())?;
        if let Some(text) = &self.mask_box {
            let list = values::integers(text, "--mask-box")?;
            if list.as_array().is_none_or(|l| {
                l.len() != 4 || l.iter().any(|v| v.as_integer().is_none_or(|v| v < 0))
            }) {
                bail!("--mask-box {text}: expected column,row,width,height, each at least 0");
            }
            request.set_flag("mask_box", Some(list))?;
        }
        if let Some(text) = &self.mask_circle {
            let list = values::list(text, "--mask-circle")?;
            if list.as_array().is_none_or(|l| l.len() != 3) {
                bail!("--mask-circle {text}: expected column,row,radius");
            }
            request.set_flag("mask_circle", Some(list))?;
        }
        if let Some(class) = &self.example {
            let mut table = toml::Table::new();
            table.insert("class".into(), class.as_str().into());
            table.insert("seed".into(), Value::Integer(self.seed.wrapping_add(1) as i64));
            table.insert("harm".into(), self.harm.as_deref().unwrap_or("box").into());
            table.insert("share".into(), self.share.unwrap_or(0.25).into());
            table.insert("find".into(), self.find.into());
            request.set("example", Value::Table(table), "--example")?;
        }
        request.set_flag("generations", values::integer(self.generations))?;
        request.set_flag("candidates", values::integer(self.candidates))?;
        request.set_flag("samples", values::integer(self.samples))?;
        Ok(request)
    }
}

/// A reconstruction from a file, by the flags of `patterns run`.
pub(super) fn repeat(mut request: Request, run: &RunArgs) -> Result<ExitCode> {
    if let Some(seed) = run.seed {
        request.seed = seed;
    }
    for assignment in &run.set {
        request.set_text(assignment)?;
    }
    let options = Options {
        out: run.out.clone(),
        force: run.force,
        quiet: run.quiet || run.json,
        // The generations are given: the clock shall not change the result.
        budget: Duration::MAX,
    };
    let outcome = thread_pool(run.threads)?.install(|| reconstruct::run(&request, &options))?;
    report(&outcome, run.quiet, run.json)?;
    Ok(ExitCode::SUCCESS)
}

/// What was found and where it is.
fn report(outcome: &Outcome, quiet: bool, json: bool) -> Result<()> {
    let mut out = std::io::stdout().lock();
    let manifest = &outcome.manifest;
    if json {
        write!(out, "{}", manifest.to_json()?)?;
    }
    if json || quiet {
        return Ok(());
    }
    for note in &outcome.notes {
        writeln!(out, "{note}")?;
    }
    writeln!(out, "done in {:.2} s", outcome.seconds)?;
    for (name, value) in &manifest.metrics {
        writeln!(out, "  {name:26} {value:.4}")?;
    }
    let (files, folder) = (&manifest.files, outcome.folder.display());
    writeln!(out, "{} files in {folder}: {}", files.len(), files.join(" "))?;
    Ok(())
}
