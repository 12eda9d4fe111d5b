//! The command `dotyk-mpi`: `dotyk run` on the processes that `mpirun` starts.

#[cfg(mpi)]
mod world;

use std::process::ExitCode;

#[cfg(mpi)]
fn main() -> ExitCode {
    use std::sync::Arc;
    let world = match world::World::enter() {
        Ok(world) => Arc::new(world),
        Err(told) => return refused(&told),
    };
    let team: Arc<dyn dotyk::host::Team> = world.clone();
    if let Err(told) = dotyk::host::work_in(team) {
        return refused(&told);
    }
    let status = dotyk_cli::several(std::env::args_os());
    world.leave(status);
    ExitCode::from(status)
}

#[cfg(not(mpi))]
fn main() -> ExitCode {
    refused(
        "dotyk-mpi was built where there was no MPI: install one with its compiler `mpicc`, as Debian's libopenmpi-dev and openmpi-bin, and build it again",
    )
}

/// Prints why nothing can be done, as other messages of the command line are printed.
fn refused(told: &str) -> ExitCode {
    eprintln!("  x {told}");
    ExitCode::from(2)
}
