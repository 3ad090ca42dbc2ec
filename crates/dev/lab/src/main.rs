//! The binary `tabletopgen-lab`: parses the command line and calls the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    lab::cli::main()
}
