//! The command line: one file per subcommand.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line prints")]

mod bench;
mod convert;
mod curvature;
mod curvature_atlas;
mod curvature_infer;
mod database;
mod figure;
mod level_set;
mod list;
mod rd;
mod reconstruct;
mod refusal;
mod render;
mod run;
mod run_args;
mod topopt;
mod topopt_settings;
mod topopt_table;
mod values;

use crate::{manifest::RunStatus, runner};
use anyhow::Result;
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use std::{io, process::ExitCode, sync::atomic::Ordering};

/// Grow, optimize, reconstruct and look at patterns.
#[derive(Debug, Parser)]
#[command(
    name = "patterns",
    version,
    propagate_version = true,
    after_help = "Exit codes: 0 done; 1 not converged, or interrupted with a checkpoint; 2 error.\n\
                  Start with: patterns rd --spots"
)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Rd(Box<rd::Args>),
    LevelSet(Box<level_set::Args>),
    Topopt(Box<topopt::Args>),
    Curvature(Box<curvature::Args>),
    Reconstruct(Box<reconstruct::Args>),
    Run(Box<run::Args>),
    List(list::Args),
    Figure(figure::Args),
    Render(Box<render::Args>),
    Convert(convert::Args),
    Database(database::Args),
    Bench(bench::Args),
    /// Print a completion script for a shell.
    #[command(
        after_help = "Example: patterns completions bash > ~/.local/share/bash-completion/completions/patterns"
    )]
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page.
    #[command(after_help = "Example: patterns man | man -l -")]
    Man,
}

/// The command line. A negative number is never a flag: what is refused is told by its value.
fn command() -> clap::Command {
    negative_numbers(Cli::command())
}

fn negative_numbers(command: clap::Command) -> clap::Command {
    let names: Vec<String> = command.get_subcommands().map(|c| c.get_name().into()).collect();
    let command = command.mut_args(|argument| match argument.get_action().takes_values() {
        true => argument.allow_negative_numbers(true),
        false => argument,
    });
    names.into_iter().fold(command, |command, name| command.mut_subcommand(name, negative_numbers))
}

/// Runs the program; the exit code is 0 for done, 1 for not converged, 2 for an error.
pub fn main() -> ExitCode {
    let matches = command().try_get_matches();
    let cli = match matches.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) => refusal::explained(error).exit(),
    };
    // A second Ctrl-C stops at once; without a handler every Ctrl-C does.
    let _ = ctrlc::set_handler(|| {
        if runner::INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    match dispatch(cli.command) {
        Ok(code) => code,
        Err(error) => {
            // A reader that closed the pipe (`| head`) is no error of ours.
            let broken_pipe = error
                .downcast_ref::<io::Error>()
                .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe);
            if broken_pipe {
                return ExitCode::SUCCESS;
            }
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn dispatch(command: Command) -> Result<ExitCode> {
    match command {
        Command::Rd(args) => rd::main(&args),
        Command::LevelSet(args) => level_set::main(&args),
        Command::Topopt(args) => topopt::main(&args),
        Command::Curvature(args) => curvature::main(&args),
        Command::Reconstruct(args) => reconstruct::main(&args),
        Command::Run(args) => run::main(&args),
        Command::List(args) => list::main(&args),
        Command::Figure(args) => figure::main(&args),
        Command::Render(args) => render::main(&args),
        Command::Convert(args) => convert::main(&args),
        Command::Database(args) => database::main(&args),
        Command::Bench(args) => bench::main(&args),
        Command::Completions { shell } => {
            clap_complete::generate(shell, &mut Cli::command(), "patterns", &mut io::stdout());
            Ok(ExitCode::SUCCESS)
        }
        Command::Man => {
            clap_mangen::Man::new(Cli::command()).render(&mut io::stdout())?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// The exit code of a finished run.
fn exit_code(status: RunStatus) -> ExitCode {
    match status {
        RunStatus::Done => ExitCode::SUCCESS,
        RunStatus::Failed => ExitCode::from(2),
        RunStatus::Running | RunStatus::Interrupted | RunStatus::NotConverged => ExitCode::from(1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_do_not_clash() {
        command().debug_assert();
    }

    #[test]
    fn a_negative_number_is_refused_as_the_value_that_it_is() {
        for line in ["rd --iterations -5", "curvature --opening -5", "curvature atlas --count -5"] {
            let words = format!("patterns {line}");
            let refused = command().try_get_matches_from(words.split(' '));
            let message = refused.map(|_| ()).unwrap_err().to_string();
            let flag = line.split(' ').rev().nth(1).unwrap();
            assert!(message.contains(&format!("'-5' for '{flag}")), "{message}");
        }
    }

    #[test]
    fn every_command_has_an_example() {
        for command in Cli::command().get_subcommands() {
            let help = command.clone().render_long_help().to_string();
            assert!(help.contains("Example"), "`{}` has no example", command.get_name());
        }
    }
}
