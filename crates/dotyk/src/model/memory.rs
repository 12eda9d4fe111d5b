//! Whether a model fits the memory that it may take, told before anything is factored.
//!
//! ```text
//!   a body:    24|K| + 8|L| + 8(t² + tr + r²)     its stiffness as it is, permuted and analysed; its factor; L_c, X and F_b
//!   applied:   24|K| + 16|L|                      with the factor of the preconditioner, which has not more entries
//!   all:       8 · 3m²                            F, and the system of an exact step with its factor
//! ```
//!
//! |K| and |L| are stored entries, t contact dofs and r rows of a body, m all rows. Where F is assembled without its zeros,
//! Σr² stands for m². Meshes and results are small beside this.

use crate::model::error::Error;
use crate::model::factor::Ordered;
use crate::model::nouns::Model;
use crate::model::parts::part_name;

/// What counts of a body.
pub(crate) struct Demand<'a> {
    /// Its order.
    pub ordered: &'a Ordered,
    /// Entries of its stiffness.
    pub stiffness: usize,
    /// Its dofs.
    pub dofs: usize,
    /// Its rows of B.
    pub rows: usize,
}

impl Demand<'_> {
    /// Bytes, with F assembled or applied.
    fn bytes(&self, dense: bool) -> u64 {
        let [t, r] = [self.ordered.trailing.len(), self.rows].map(|n| n as u64);
        let factor = 8 * self.ordered.stored() as u64;
        let own = match dense {
            true => factor + 8 * (t * t + t * r + r * r),
            false => 2 * factor,
        };
        24 * self.stiffness as u64 + own
    }
}

/// Errors: [`Error::Memory`] when the bodies take more than the model may, with the one that takes most.
pub(crate) fn check<const D: usize>(
    model: &Model<D>,
    bodies: &[Demand<'_>],
    dense: bool,
    m: usize,
) -> Result<(), Error<D>> {
    let Some(free) = model.solver.memory else {
        return Ok(());
    };
    let own: Vec<u64> = bodies.iter().map(|body| body.bytes(dense)).collect();
    let blocks: u64 = bodies.iter().map(|body| (body.rows as u64).pow(2)).sum();
    let shared = match dense {
        true => 24 * blocks.min((m as u64).pow(2)),
        false => 0,
    };
    let needed = own.iter().sum::<u64>() + shared;
    let largest = own.iter().enumerate().max_by_key(|(_, bytes)| **bytes);
    match largest {
        Some((body, &bytes)) if needed > free => Err(Error::Memory {
            body: part_name(model, body),
            unknowns: bodies[body].dofs,
            bytes,
            needed,
            free,
        }),
        _ => Ok(()),
    }
}
