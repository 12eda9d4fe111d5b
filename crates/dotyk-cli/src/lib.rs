//! Command line of dotyk: arguments, progress and printing, nothing else. A library, so that other programs can include it.
//!
//! Results go to standard output, progress and messages to standard error. Exit status: 0 done, with or without
//! warnings; 1 not converged or not verified; 2 bad input.

/// Does the same with a case of the plane and with one of space.
macro_rules! of_any {
    ($case:expr, |$name:ident| $body:expr) => {
        match $case {
            dotyk::case::AnyCase::Plane($name) => $body,
            dotyk::case::AnyCase::Space($name) => $body,
        }
    };
}

mod book;
mod ccx;
mod check;
mod compare;
mod export;
mod failure;
mod given;
mod import;
mod kept;
mod keys;
mod progress;
mod run;
mod signals;
mod study;
mod text;
mod verify;

use clap::{CommandFactory, Parser, Subcommand};
use dotyk::host::team;
use failure::Failure;
use std::error::Error;
use std::ffi::OsString;

/// Elastic contact mechanics: bodies pressed against each other, with a certificate for every answer.
#[derive(Parser)]
#[command(
    name = "dotyk",
    version,
    after_help = "`dotyk help keys` lists every key of a case file.\n\
                  Exit status: 0 done, 1 not converged or not verified, 2 bad input."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Solve cases, write their results and reports
    Run(run::Arguments),
    /// Look at meshes, supports, floating bodies and contacts without solving
    Check(check::Arguments),
    /// Solve every case that has references and compare with them
    Verify(verify::Arguments),
    /// Solve one case with all solvers
    Compare(compare::Arguments),
    /// Solve one case for many values of its parameters
    Study(study::Arguments),
    /// Write the contact problem of a case, F, d, G, e, Λ and B, for solvers elsewhere
    Export(export::Arguments),
    /// Turn a deck of Abaqus or CalculiX into a case file and a mesh
    Import(import::Arguments),
    /// Not supported yet
    #[command(hide = true)]
    Safety(Later),
    /// Not supported yet
    #[command(hide = true)]
    Limit(Later),
    /// List every key of a case file
    #[command(visible_alias = "keys", after_long_help = keys::TEXT)]
    Reference,
    /// Print what a shell needs to complete commands, such as `dotyk completions bash`
    Completions {
        /// bash, zsh, fish, elvish or powershell
        shell: clap_complete::Shell,
    },
}

/// Arguments of a command of a later version.
#[derive(clap::Args)]
struct Later {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    _arguments: Vec<OsString>,
}

/// Solve cases on several processes: `mpirun -n 4 dotyk-mpi run CASE.toml`.
#[derive(Parser)]
#[command(
    name = "dotyk-mpi",
    version,
    after_help = "Bodies in pieces are shared out, those that `subdomains` under [solver] divides, and large ones without it.\n\
                  For all other commands use `dotyk`.\n\
                  Exit status: 0 done, 1 not converged, 2 bad input."
)]
struct Several {
    #[command(subcommand)]
    command: OfSeveral,
}

#[derive(Subcommand)]
enum OfSeveral {
    /// Solve cases, write their results and reports
    Run(run::Arguments),
}

/// How a command ended, the better first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    Done,
    Unsatisfied,
    /// Some input was refused, and a message was printed.
    Refused,
}

/// Stack of the thread that a command runs on, in bytes: the main thread's stack may be too small, its size is set from outside.
const STACK: usize = 16 << 20;

/// Runs the command with its arguments, its own name the first of them, and returns the exit status.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    on_a_large_stack(arguments, of_arguments)
}

/// The same for `dotyk-mpi`, in a process that works in a team.
pub fn several(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    on_a_large_stack(arguments, |arguments| {
        match Several::try_parse_from(arguments) {
            Ok(Several {
                command: OfSeveral::Run(arguments),
            }) => status(Command::Run(arguments)),
            Err(told) => status_of_parser(&told),
        }
    })
}

/// What a process of a team did not print on standard error, because the first one prints what all have to say.
pub fn unsaid() -> String {
    text::unsaid().clone()
}

/// The same for `dotyk-ccx`, which is called as CalculiX is.
pub fn ccx(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    on_a_large_stack(arguments, |arguments| {
        let parsed = ccx::Arguments::try_parse_from(arguments);
        parsed.map_or_else(|told| status_of_parser(&told), |own| ccx::solve(&own))
    })
}

fn on_a_large_stack(
    arguments: impl IntoIterator<Item = OsString>,
    command: fn(&[OsString]) -> u8,
) -> u8 {
    signals::watch();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let thread = std::thread::Builder::new().stack_size(STACK);
    match thread.spawn(move || command(&arguments)) {
        // a panic has already printed its message
        Ok(command) => command.join().unwrap_or(101),
        Err(e) => status_of(Err(Failure::Message(format!("cannot start a thread: {e}")))),
    }
}

fn of_arguments(arguments: &[OsString]) -> u8 {
    match Cli::try_parse_from(arguments) {
        Ok(cli) => status(cli.command),
        Err(told) => status_of_parser(&told),
    }
}

/// Help and version arrive as errors of the parser, too.
fn status_of_parser(told: &clap::Error) -> u8 {
    match tell(told) {
        Ok(()) => u8::try_from(told.exit_code()).unwrap_or(2),
        Err(failure) => status_of(Err(failure)),
    }
}

/// Prints a message of the parser of the command line.
fn tell(told: &clap::Error) -> Result<(), Failure> {
    let to_errors = told.use_stderr();
    let coloured = match to_errors {
        true => text::colours(&std::io::stderr()),
        false => text::colours(&std::io::stdout()),
    };
    let styled = told.render();
    let plain = styled.to_string();
    // the styles come from the parser: they are dropped where arguments contain control characters
    let words = match coloured && !plain.chars().any(text::commands) {
        true => styled.ansi().to_string(),
        false => text::shown(&plain, false).into_owned(),
    };
    if to_errors {
        text::tell(&words);
        return Ok(());
    }
    text::put(&words)
}

/// Starts the threads that a command asks for, or as many as processors and memory allow. Commands that do not compute need none.
fn start_threads(command: &Command) -> Result<(), Failure> {
    let wanted = match command {
        Command::Run(arguments) => arguments.threads,
        Command::Export(arguments) => arguments.threads,
        Command::Reference | Command::Completions { .. } => return Ok(()),
        _ => None,
    };
    let pool = dotyk::host::threads(wanted.map(usize::from)).map_err(Failure::Message)?;
    match pool.build_global() {
        // a program that includes this one may have started its own threads; what a team joins is paired by its order on one thread
        Err(e) if wanted.is_some() || e.source().is_some() || team().size() > 1 => {
            Err(Failure::Message(format!("cannot start threads: {e}")))
        }
        _ => Ok(()),
    }
}

fn status(command: Command) -> u8 {
    if let Err(failure) = start_threads(&command) {
        return status_of(Err(failure));
    }
    status_of(match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Check(arguments) => check::check(&arguments),
        Command::Verify(arguments) => verify::verify(&arguments),
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::Study(arguments) => study::study(&arguments),
        Command::Export(arguments) => export::export(&arguments),
        Command::Import(arguments) => import::import(&arguments),
        Command::Safety(_) => later("safety"),
        Command::Limit(_) => later("limit"),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "dotyk", &mut script);
            text::print(&String::from_utf8_lossy(&script)).map(|()| Outcome::Done)
        }
        Command::Reference => text::print(keys::TEXT).map(|()| Outcome::Done),
    })
}

fn later(command: &str) -> Result<Outcome, Failure> {
    let message = format!("`dotyk {command}` is not supported yet");
    Err(Failure::Message(message))
}

fn status_of(outcome: Result<Outcome, Failure>) -> u8 {
    match outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Unsatisfied) => 1,
        Ok(Outcome::Refused) => 2,
        Err(failure) => {
            failure.print();
            2
        }
    }
}
