//! The command `dotyk-ccx`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(dotyk_cli::ccx(std::env::args_os()))
}
