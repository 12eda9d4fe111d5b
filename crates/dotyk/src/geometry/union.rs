//! Groups of connected items, found pair by pair.

/// Groups of the numbers below n; the smallest member of a group stands for it.
#[derive(Debug, Clone)]
pub(crate) struct Groups {
    leads_to: Vec<usize>,
}

impl Groups {
    /// Every number alone.
    pub fn new(n: usize) -> Self {
        Self {
            leads_to: (0..n).collect(),
        }
    }

    /// The smallest member of the group of a number.
    pub fn first(&mut self, mut at: usize) -> usize {
        while self.leads_to[at] != at {
            self.leads_to[at] = self.leads_to[self.leads_to[at]];
            at = self.leads_to[at];
        }
        at
    }

    /// Makes one group of those of two numbers.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.leads_to[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_what_pairs_connect() {
        let mut groups = Groups::new(6);
        for (a, b) in [(4, 1), (5, 3), (1, 5)] {
            groups.join(a, b);
        }
        let firsts: Vec<usize> = (0..6).map(|k| groups.first(k)).collect();
        assert_eq!(firsts, [0, 1, 2, 1, 1, 1]);
    }
}
