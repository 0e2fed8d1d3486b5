//! The acquirer's command line; see `acquirer --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    acquirer::cli::main()
}
