//! `patterns database`: the classes that pictures are compared with.

use crate::{
    database,
    inputs::FileInputs,
    output,
    reconstruct::evaluate::{self, Plan},
};
use anyhow::{Context as _, Result, bail};
use patterns::disocclusion::{self, Calibration, Class, Database, PATTERNS, Values};
use rayon::prelude::*;
use std::{
    fs,
    io::{self, Write as _},
    path::{Path, PathBuf},
    process::ExitCode,
};

/// List, show, check and calibrate the classes of patterns that pictures are compared with.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: patterns database show turing-spots")]
pub(super) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// List the classes.
    #[command(after_help = "Example: patterns database list")]
    List {
        /// Also the classes of this folder.
        #[arg(long, value_name = "DIR")]
        database: Option<PathBuf>,
    },
    /// Show a class: its model, ranges and configuration.
    #[command(after_help = "Example: patterns database show gray-scott-mu")]
    Show {
        /// Name of the class.
        name: String,
        /// Also the classes of this folder.
        #[arg(long, value_name = "DIR")]
        database: Option<PathBuf>,
    },
    /// Check a file that describes a class, at the ends of every range.
    #[command(after_help = "Example: patterns database check my-class.toml")]
    Check {
        /// The file.
        file: PathBuf,
    },
    /// Check a class, calibrate it and put both into a folder of your own.
    #[command(after_help = "Example: patterns database add my-class.toml --to my-database")]
    Add {
        /// The file.
        file: PathBuf,
        /// Folder of classes and their calibrations.
        #[arg(long, value_name = "DIR", default_value = "patterns-database")]
        to: PathBuf,
    },
    /// Make a labelled folder of hidden pictures of unseen seeds for `reconstruct --evaluate`.
    #[command(after_help = "Example: patterns database evaluate --patterns 2 --out cases")]
    Evaluate {
        /// Patterns of each class, each harmed in 14 ways.
        #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1000))]
        patterns: u64,
        /// Only these classes.
        #[arg(long, value_name = "CLASS,..", value_delimiter = ',')]
        classes: Vec<String>,
        /// Seed of parameters, patterns and harms; the calibration has 1.
        #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
        seed: u64,
        /// Also the classes of this folder.
        #[arg(long, value_name = "DIR")]
        database: Option<PathBuf>,
        /// Output folder.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        /// Overwrite an output folder that is not empty.
        #[arg(long)]
        force: bool,
    },
    /// Run every class again and write the calibration (many minutes).
    #[command(after_help = "Example: patterns database calibrate --out calibration.bin")]
    Calibrate {
        /// File to write.
        #[arg(long, value_name = "FILE", default_value = "calibration.bin")]
        out: PathBuf,
    },
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    match &args.action {
        Action::List { database } => list(database.as_deref())?,
        Action::Show { name, database } => show(name, database.as_deref())?,
        Action::Check { file } => {
            let class = database::check(file)?;
            println!("{}: class `{}`, {} ranges", file.display(), class.name, class.ranges.len());
        }
        Action::Add { file, to } => add(file, to)?,
        Action::Evaluate { patterns, classes, seed, database, out, force } => {
            let plan = Plan { classes: classes.clone(), patterns: *patterns, seed: *seed };
            let count = evaluate::make(&plan, database.as_deref(), out, *force)?;
            println!("{}: {count} pictures; labels.csv has what they are", out.display());
        }
        Action::Calibrate { out } => {
            let database = Database::built_in()?;
            let classes: Vec<&Class> = database.classes.iter().filter(|c| c.free_seeds).collect();
            let calibration = calibrate(&classes, Path::new("."))?;
            output::save_bytes(out, &calibration.to_bytes())?;
            println!("{}: {} classes", out.display(), calibration.classes.len());
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn list(folder: Option<&Path>) -> Result<()> {
    let mut out = io::stdout().lock();
    for class in database::load(folder)?.0.classes {
        writeln!(out, "{:28} {:7} {}", class.name, class.model.name, class.about)?;
    }
    Ok(())
}

fn show(name: &str, folder: Option<&Path>) -> Result<()> {
    let (database, _) = database::load(folder)?;
    let Some(class) = database.find(name) else {
        let known: Vec<_> = database.classes.iter().map(|c| c.name.as_str()).collect();
        bail!("no class `{name}`; known classes: {}", known.join(", "));
    };
    let mut out = io::stdout().lock();
    writeln!(out, "{}: {}", class.name, class.about)?;
    let matched = if class.free_seeds { "by statistics" } else { "pixel by pixel" };
    writeln!(out, "model {}, compared {matched}", class.model.name)?;
    for range in &class.ranges {
        let values = match &range.values {
            Values::Between { low, high, log, integer } => {
                let scale = if *log { ", logarithmic" } else { "" };
                let whole = if *integer { ", whole numbers" } else { "" };
                format!("[{low}, {high}]{scale}{whole}")
            }
            Values::Choices(list) => format!("one of {list:?}"),
        };
        writeln!(out, "  {:32} {values}", range.key)?;
    }
    writeln!(out, "\n{}", toml::to_string(&class.config)?)?;
    Ok(())
}

fn add(file: &Path, to: &Path) -> Result<()> {
    let class = database::check(file)?;
    if Database::built_in()?.find(&class.name).is_some() {
        bail!("`{}`: name: `{}` is in the database already", file.display(), class.name);
    }
    let text = fs::read(file).with_context(|| format!("cannot read `{}`", file.display()))?;
    fs::create_dir_all(to).with_context(|| format!("cannot make `{}`", to.display()))?;
    // The class first: a folder that cannot be written to is refused before the work.
    let entry = to.join(format!("{}.toml", class.name));
    output::save_bytes(&entry, &text)?;
    let base = file.parent().unwrap_or(Path::new("."));
    let calibrated = class.free_seeds.then(|| calibrate(&[&class], base)).transpose();
    let saved = calibrated.and_then(|calibration| match calibration {
        Some(calibration) => {
            output::save_bytes(&entry.with_extension("bin"), &calibration.to_bytes())
        }
        None => Ok(()),
    });
    if let Err(error) = saved {
        // A class without its calibration would make the folder useless.
        let _ = fs::remove_file(&entry);
        return Err(error);
    }
    println!("{}: class `{}` added", to.display(), class.name);
    Ok(())
}

/// Runs the patterns of every class, side by side.
fn calibrate(classes: &[&Class], base: &Path) -> Result<Calibration> {
    let jobs: Vec<(&Class, u64)> =
        classes.iter().flat_map(|class| (0..PATTERNS).map(|index| (*class, index))).collect();
    let bar = evaluate::progress(jobs.len());
    let found: Vec<_> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(class, index)| {
            let inputs = FileInputs::new(vec![base.to_path_buf()]);
            let samples = disocclusion::samples(class, *index, &inputs);
            bar.inc(1);
            samples.with_context(|| format!("class `{}`, pattern {index}", class.name))
        })
        .collect::<Result<_>>()?;
    bar.finish_and_clear();
    let per_class = found.chunks(PATTERNS as usize).map(<[_]>::concat);
    let names = classes.iter().map(|class| class.name.clone());
    let calibration = Calibration { classes: names.zip(per_class).collect() };
    if let Some((name, list)) = calibration.classes.iter().find(|(_, list)| list.len() < 20) {
        bail!("class `{name}`: only {} of its patterns have two colours", list.len() / 5);
    }
    Ok(calibration)
}
