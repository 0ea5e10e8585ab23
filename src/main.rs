//! `patterns`: the command line over [`lab`].

use std::process::ExitCode;

fn main() -> ExitCode {
    lab::cli::main()
}
