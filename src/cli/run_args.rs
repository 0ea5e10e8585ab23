//! Flags that every run takes, and what is printed at its end.

use crate::{
    manifest::RunStatus,
    request::Request,
    runner::{self, Film, Options, Outcome},
};
use anyhow::{Result, bail};
use clap::Args;
use std::{path::PathBuf, process::ExitCode};

/// Flags that every run takes.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Run")]
pub(super) struct RunArgs {
    /// Output folder [default: out/<command>-<n>, the first that is free].
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Overwrite an output folder that is not empty.
    #[arg(long)]
    pub(super) force: bool,
    /// Seed of all random numbers; the same seed gives the same bytes [default: 0].
    #[arg(long, value_name = "N")]
    pub(super) seed: Option<u64>,
    /// Threads, 0 for all cores; the results do not depend on it [default: all cores].
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<usize>,
    /// Go on with an interrupted run from its checkpoint, to the same bytes.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["out", "force", "seed", "set", "frames", "animation"])]
    pub(super) resume: Option<PathBuf>,
    /// Iterations between checkpoints [default: one checkpoint a minute].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) checkpoint_every: Option<u64>,
    /// Frames of the animation, 0 for none [default: 100].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(0..=10_000))]
    pub(super) frames: Option<u64>,
    /// Format of the animation: animation.gif, animation.apng or no file [default: gif].
    #[arg(long, value_parser = ["gif", "apng", "none"])]
    pub(super) animation: Option<String>,
    /// Set any key of the configuration, e.g. --set kinetics.feed=0.03 (repeatable).
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<String>,
    /// Print nothing but errors.
    #[arg(long)]
    pub(super) quiet: bool,
    /// Print run.json on standard output instead of the summary.
    #[arg(long)]
    pub(super) json: bool,
}

impl RunArgs {
    /// Runs `request`, or resumes, and prints the end.
    ///
    /// # Errors
    /// As [`runner::run`] and [`runner::resume`].
    pub(super) fn execute(&self, mut request: Request) -> Result<ExitCode> {
        if let Some(seed) = self.seed {
            request.seed = seed;
        }
        for assignment in &self.set {
            request.set_text(assignment)?;
        }
        let options = self.options();
        let pool = thread_pool(self.threads)?;
        let outcome = pool.install(|| match &self.resume {
            Some(folder) => {
                let command = runner::read_manifest(folder)?.command;
                if !request.command.is_empty() && request.command != command {
                    bail!("--resume {}: that is a run of `{command}`", folder.display());
                }
                runner::resume(folder, &options)
            }
            None => runner::run(&request, &options),
        })?;
        self.report(&outcome)?;
        Ok(super::exit_code(outcome.manifest.status))
    }

    fn options(&self) -> Options {
        let (film, frames) = match self.animation.as_deref() {
            Some("apng") => (Film::Apng, self.frames),
            Some("none") => (Film::Gif, Some(0)),
            _ => (Film::Gif, self.frames),
        };
        Options {
            out: self.out.clone(),
            force: self.force,
            checkpoint_every: self.checkpoint_every,
            frames: frames.unwrap_or(100),
            film,
            quiet: self.quiet || self.json,
        }
    }

    fn report(&self, outcome: &Outcome) -> Result<()> {
        use std::io::Write as _;
        let mut out = std::io::stdout().lock();
        let manifest = &outcome.manifest;
        let folder = outcome.folder.display();
        if self.json {
            write!(out, "{}", manifest.to_json()?)?;
        }
        if self.json || self.quiet {
            return Ok(());
        }
        if manifest.status == RunStatus::Interrupted {
            writeln!(out, "interrupted at iteration {}; the state is saved.", manifest.iterations)?;
            writeln!(out, "Go on with: patterns run --resume {folder}")?;
            return Ok(());
        }
        for note in &outcome.notes {
            writeln!(out, "note: {note}")?;
        }
        let end = if manifest.status == RunStatus::Done { "done" } else { "not converged" };
        let seconds = outcome.seconds;
        writeln!(out, "{end}: {} iterations in {seconds:.2} s", manifest.iterations)?;
        for (name, value) in &manifest.metrics {
            writeln!(out, "  {name:20} {}", short(*value))?;
        }
        writeln!(out, "{} files in {folder}: {}", manifest.files.len(), manifest.files.join(" "))?;
        Ok(())
    }
}

/// Six significant digits, without trailing zeros.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-4..1e7).contains(&value.abs()) {
        let digits = 5 - value.abs().max(1e-4).log10().floor() as i32;
        let text = format!("{value:.*}", digits.max(0) as usize);
        if text.contains('.') {
            return text.trim_end_matches('0').trim_end_matches('.').into();
        }
        return text;
    }
    format!("{value:.5e}")
}

/// A pool of `threads` threads, all cores for 0 or `None`.
///
/// # Errors
/// If there are more than 1024, or the system has no more threads.
pub(super) fn thread_pool(threads: Option<usize>) -> Result<rayon::ThreadPool> {
    let threads = threads.unwrap_or(0);
    if threads > 1024 {
        bail!("--threads {threads} is outside its range [0, 1024]");
    }
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?)
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 1.0, 90.5, 0.123_456_789, 123_456_789.0, -1e-9].map(short);
        assert_eq!(shown, ["0", "1", "90.5", "0.123457", "1.23457e8", "-1.00000e-9"]);
    }
}
