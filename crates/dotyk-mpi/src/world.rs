//! The processes that `mpirun` has started.
//!
//! Before they exchange anything they tell each other how much, in which call, the number of the call, or that they have come to their
//! end. Processes that have gone different ways are found out there, and end all.

#![allow(unsafe_code)]

use dotyk::host::Team;
use std::ffi::{c_int, c_longlong};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::process::exit;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Duration;

unsafe extern "C" {
    fn dotyk_mpi_begin(rank: *mut c_int, size: *mut c_int, neighbours: *mut c_int) -> c_int;
    fn dotyk_mpi_heads(own: *const c_longlong, all: *mut c_longlong);
    fn dotyk_mpi_gather(
        own: *const f64,
        all: *mut f64,
        counts: *const c_int,
        places: *const c_int,
        rank: c_int,
    );
    fn dotyk_mpi_end();
    fn dotyk_mpi_abort(status: c_int);
}

/// Status of processes that cannot go on.
const REFUSED: u8 = 2;

/// How long a process that finds itself alone leaves the others to say why they have ended.
const PATIENCE: Duration = Duration::from_secs(2);

/// All of them, seen by one.
pub struct World {
    rank: c_int,
    size: usize,
    neighbours: usize,
    /// Number of exchanges so far.
    calls: AtomicI64,
}

/// What a process is about to do: the number of values that it gives, or less than zero at its end; the number of the exchange, and
/// what is exchanged.
type Head = [c_longlong; 3];

impl World {
    /// Enters it.
    ///
    /// Errors: an MPI that does not start, or that threads may not call in turn; in words.
    pub fn enter() -> Result<Self, String> {
        let (mut rank, mut size, mut neighbours) = (0, 1, 1);
        // SAFETY: three places for numbers; MPI is entered once, by the main thread
        let failed = unsafe { dotyk_mpi_begin(&mut rank, &mut size, &mut neighbours) };
        match failed {
            0 => {}
            1 => return Err("MPI does not start".to_string()),
            _ => {
                let told = "this MPI does not let threads call it in turn (MPI_THREAD_SERIALIZED): use another build of it";
                return Err(told.to_string());
            }
        }
        let [size, neighbours] = [size, neighbours].map(|count| count.max(1) as usize);
        Ok(Self {
            rank,
            size,
            neighbours,
            calls: AtomicI64::new(0),
        })
    }

    /// Leaves it when all do. One that ends while the others go on ends them, too.
    pub fn leave(&self, status: u8) {
        let ended = -1 - c_longlong::from(status);
        let heads = self.heads([ended, 0, 0]);
        if heads.iter().any(|head| head[0] >= 0) {
            // the first process has said its own
            eprint!("{}", dotyk_cli::unsaid());
            self.end_all(status.max(1));
        }
        // SAFETY: MPI was entered, and is left once, by all
        unsafe { dotyk_mpi_end() };
    }

    /// What all are about to do, in the order of their numbers.
    fn heads(&self, own: Head) -> Vec<Head> {
        let mut all: Vec<c_longlong> = vec![0; 3 * self.size];
        // SAFETY: three numbers of each process
        unsafe { dotyk_mpi_heads(own.as_ptr(), all.as_mut_ptr()) };
        all.as_chunks().0.to_vec()
    }

    fn end_all(&self, status: u8) -> ! {
        // SAFETY: MPI was entered; this does not return
        unsafe { dotyk_mpi_abort(c_int::from(status)) };
        exit(c_int::from(status))
    }

    /// A number of values as MPI counts them.
    fn counted(&self, count: usize) -> c_int {
        c_int::try_from(count).unwrap_or_else(|_| {
            eprintln!("  x more than 2^31 numbers of one model are to be exchanged");
            self.end_all(REFUSED)
        })
    }
}

impl Team for World {
    fn rank(&self) -> usize {
        self.rank as usize
    }

    fn size(&self) -> usize {
        self.size
    }

    fn neighbours(&self) -> usize {
        self.neighbours
    }

    fn join(&self, what: &str, own: Vec<f64>) -> Vec<f64> {
        if self.size == 1 {
            return own;
        }
        let mut hasher = DefaultHasher::new();
        what.hash(&mut hasher);
        let call = self.calls.fetch_add(1, Ordering::Relaxed);
        let here = [call, hasher.finish() as c_longlong];
        let count = c_longlong::from(self.counted(own.len()));
        let heads = self.heads([count, here[0], here[1]]);
        if let Some(rank) = heads
            .iter()
            .position(|head| head[0] < 0 || head[1..] != here)
        {
            std::thread::sleep(PATIENCE);
            match heads[rank][0] < 0 {
                true => eprintln!("  x process {rank} has ended before the others"),
                false => eprintln!(
                    "  x process {rank} has gone another way than process {} ({what}): are the machines and the files of all processes the same?",
                    self.rank
                ),
            }
            self.end_all(REFUSED);
        }
        let counts: Vec<c_int> = heads.iter().map(|head| head[0] as c_int).collect();
        let mut places: Vec<c_int> = Vec::with_capacity(self.size);
        let mut all = 0;
        for &count in &counts {
            places.push(self.counted(all));
            all += count as usize;
        }
        let mut joined = vec![0.0; self.counted(all) as usize];
        let (counts, places) = (counts.as_ptr(), places.as_ptr());
        // SAFETY: the own part has the own count of values, and `joined` has room for all of them at their places
        unsafe { dotyk_mpi_gather(own.as_ptr(), joined.as_mut_ptr(), counts, places, self.rank) };
        joined
    }
}
