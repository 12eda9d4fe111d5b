//! The command `dotyk`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(dotyk_cli::main(std::env::args_os()))
}
