//! What the campaign does in its own way in the plane and in space.

use crate::check::View;
use crate::cuts::check_sections;
use crate::judgement::Judgement;
use crate::overlap::check_overlaps;
use crate::problem::Problem;
use crate::random::Random;
use crate::raw::Answer;
use crate::solve::Solvable;
use crate::touch::{Facing, Touch};
use crate::twin::Twin;
use crate::{families, lines, polygons, solids, twins};

/// Problems of the plane (D = 2) or of space (D = 3).
pub trait Dimension<const D: usize>: Solvable<D> {
    /// Names of all families.
    fn families() -> Vec<&'static str>;

    /// The problem of a seed, of this family or of one that the seed chooses; with `more` among the later families.
    fn of_seed(seed: u64, family: Option<&str>, more: bool) -> Self;

    /// Some twins.
    fn twins(&self, answer: &Answer<D>, random: &mut Random) -> Vec<Twin<D>>;

    /// The parts of a side that face the other side.
    fn facing(&self, touch: &Touch<'_, D>) -> Facing<D>;

    /// Further checks of a step.
    fn check_more(&self, judgement: &mut Judgement, view: &View<'_, D>);
}

impl Dimension<2> for Problem<2> {
    fn families() -> Vec<&'static str> {
        let all = families::FAMILIES.iter().chain(&families::MORE);
        all.map(|(name, _)| *name).collect()
    }

    fn of_seed(seed: u64, family: Option<&str>, more: bool) -> Self {
        families::problem(seed, family, more)
    }

    fn twins(&self, answer: &Answer, random: &mut Random) -> Vec<Twin<2>> {
        twins::of_plane(self, answer, random)
    }

    fn facing(&self, touch: &Touch<'_, 2>) -> Facing<2> {
        lines::facing(self, touch)
    }

    fn check_more(&self, judgement: &mut Judgement, view: &View<'_, 2>) {
        check_overlaps(judgement, view);
        check_sections(judgement, view);
    }
}

impl Dimension<3> for Problem<3> {
    fn families() -> Vec<&'static str> {
        solids::FAMILIES.map(|(name, _)| name).to_vec()
    }

    fn of_seed(seed: u64, family: Option<&str>, _more: bool) -> Self {
        solids::problem(seed, family)
    }

    fn twins(&self, answer: &Answer<3>, random: &mut Random) -> Vec<Twin<3>> {
        twins::of_space(self, answer, random)
    }

    fn facing(&self, touch: &Touch<'_, 3>) -> Facing<3> {
        polygons::facing(touch)
    }

    fn check_more(&self, _judgement: &mut Judgement, _view: &View<'_, 3>) {}
}
