//! Processes that solve one case side by side.
//!
//! Each of them has all of the model and goes the same way through it, step for step; the pieces of divided bodies are spread over
//! them. What a process finds out about its own pieces, all others get by [`Team::join`], in the order of the pieces, so that every
//! one of them decides alike and the bits of the answer do not depend on their number. That holds while each process works on one
//! thread: what is joined is paired by the order of the calls.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// The processes that solve a case side by side, seen by one of them.
pub trait Team: Send + Sync {
    /// Number of this process, the first one has 0.
    fn rank(&self) -> usize;

    /// Number of all processes.
    fn size(&self) -> usize;

    /// Number of processes that share the memory of this machine, this one among them.
    fn neighbours(&self) -> usize;

    /// Whether this process is in no team, which is more than to be the only one of a team.
    fn is_alone(&self) -> bool {
        false
    }

    /// The parts of all processes one behind the other, the same for all; it returns when all have called it. `what` names the call: all
    /// must be in the same one.
    fn join(&self, what: &str, own: Vec<f64>) -> Vec<f64>;
}

/// A process of its own.
struct Alone;

impl Team for Alone {
    fn rank(&self) -> usize {
        0
    }

    fn size(&self) -> usize {
        1
    }

    fn neighbours(&self) -> usize {
        1
    }

    fn is_alone(&self) -> bool {
        true
    }

    fn join(&self, _what: &str, own: Vec<f64>) -> Vec<f64> {
        own
    }
}

static TEAM: OnceLock<Arc<dyn Team>> = OnceLock::new();

/// Makes this process one of a team, before it does anything else.
///
/// Errors: it has been working alone already, or is one of another team.
pub fn work_in(team: Arc<dyn Team>) -> Result<(), String> {
    let told = "this process has begun to work without the others";
    TEAM.set(team).map_err(|_| told.to_string())
}

/// The team of this process; one of its own unless it was told otherwise.
pub fn team() -> Arc<dyn Team> {
    Arc::clone(TEAM.get_or_init(|| Arc::new(Alone)))
}

/// Number of processes of the team, one file of the fields of a body for each; none in a process that is in no team.
pub(crate) fn processes() -> Option<usize> {
    let team = team();
    (!team.is_alone()).then(|| team.size())
}

/// The part of `count` things that a process has: they are shared out evenly and in order.
pub(crate) fn share(team: &dyn Team, count: usize) -> Range<usize> {
    let before = |rank: usize| rank * count / team.size();
    before(team.rank())..before(team.rank() + 1)
}

/// The part of the whole that a process has at most, where `count` things are shared out.
pub(crate) fn largest_share(team: &dyn Team, count: usize) -> f64 {
    count.div_ceil(team.size()) as f64 / count.max(1) as f64
}

/// The least of the values that the processes have, of which all have one or none has.
pub(crate) fn least(team: &dyn Team, own: Option<u64>) -> Option<u64> {
    let own = own.map(|own| own as f64).into_iter().collect();
    let all = team.join("least value", own);
    let least = all.into_iter().reduce(f64::min);
    least.map(|least| least as u64)
}

/// Whether what every process did by itself is done.
pub fn all_done(own: bool) -> bool {
    let failed = if own { Vec::new() } else { vec![1.0] };
    team().join("what failed", failed).is_empty()
}

/// Whether all processes have the same values here.
pub fn alike(own: impl Hash) -> bool {
    let mut hasher = DefaultHasher::new();
    own.hash(&mut hasher);
    // a number has 53 bits
    let own = (hasher.finish() >> 11) as f64;
    let all = team().join("the same values", vec![own]);
    all.iter().all(|other| *other == own)
}

/// Processes that are threads, for tests.
#[cfg(test)]
pub(crate) mod threads {
    use super::Team;
    use std::sync::{Arc, Barrier, Mutex};

    struct Thread {
        rank: usize,
        parts: Arc<Vec<Mutex<Vec<f64>>>>,
        barrier: Arc<Barrier>,
    }

    impl Team for Thread {
        fn rank(&self) -> usize {
            self.rank
        }

        fn size(&self) -> usize {
            self.parts.len()
        }

        fn neighbours(&self) -> usize {
            self.size()
        }

        fn join(&self, _what: &str, own: Vec<f64>) -> Vec<f64> {
            *self.parts[self.rank].lock().unwrap() = own;
            self.barrier.wait();
            let parts = self.parts.iter().map(|part| part.lock().unwrap().clone());
            let all = parts.collect::<Vec<_>>().concat();
            // no one gives the next part before all have read this one
            self.barrier.wait();
            all
        }
    }

    /// What each of so many members of a team does, in the order of their numbers.
    pub(crate) fn in_teams<T: Send>(
        size: usize,
        member: impl Fn(Arc<dyn Team>) -> T + Sync,
    ) -> Vec<T> {
        let parts: Arc<Vec<_>> = Arc::new((0..size).map(|_| Mutex::default()).collect());
        let barrier = Arc::new(Barrier::new(size));
        let member = &member;
        std::thread::scope(|scope| {
            let members: Vec<_> = (0..size)
                .map(|rank| {
                    let (parts, barrier) = (Arc::clone(&parts), Arc::clone(&barrier));
                    let own = Thread {
                        rank,
                        parts,
                        barrier,
                    };
                    scope.spawn(move || member(Arc::new(own)))
                })
                .collect();
            members.into_iter().map(|own| own.join().unwrap()).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::threads::in_teams;
    use super::*;

    #[test]
    fn parts_are_joined_in_order_and_shares_cover_all() {
        let joined = in_teams(3, |team| {
            let own = share(&*team, 8);
            let all = team.join("numbers", own.map(|k| k as f64).collect());
            (all, least(&*team, Some(5 - team.rank() as u64)))
        });
        let expected = (0..8).map(f64::from).collect::<Vec<_>>();
        for (all, least) in joined {
            assert_eq!((all, least), (expected.clone(), Some(3)));
        }
        assert_eq!(least(&Alone, None), None);
        assert_eq!(share(&Alone, 4), 0..4);
    }
}
