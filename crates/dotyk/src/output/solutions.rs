//! The solutions of load steps as bytes, and back to the bit, for a program that has the model.
//!
//! ```text
//!   dotyk solutions VERSION\n
//!   points and nodes of cells of every body of the model
//!   the solutions, field by field: f64 and lengths in 8 bytes, little-endian
//! ```
//!
//! Only the version that wrote them reads them: another one may have other fields. Borders between materials are those of the model, and
//! the stages of Newton's method that were tried are left out.

use crate::dual::{Certificate, Figure, OfYield};
use crate::geometry::{Point, distance};
use crate::model::{
    Across, BedPoint, BedSolution, BodyId, BodySolution, BoltReport, Borders, ContactNode,
    ContactSolution, CoupleKind, CoupleSolution, Dimension, Division, Extrusion, HistoryPoint,
    Intrusion, LinePoint, MemberKind, MemberSolution, MemberStation, MemberWords, Model, Peak,
    ProbeValue, RigidMode, RigidMotion, Seconds, SectionSolution, SideRef, Singular, SingularPeak,
    Solution, SolverReport, Station, Status, StressAt, Utilisation, Yielding,
};
use crate::output::check_step;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The first bytes.
const HEAD: &str = concat!("dotyk solutions ", env!("CARGO_PKG_VERSION"), "\n");

/// Nodes of a mesh that is made anew may differ by rounding: by less than this part of its size.
const ROUNDING: f64 = 1e-9;

/// The bytes of the solutions of a model.
pub(crate) fn solutions<const D: usize>(model: &Model<D>, steps: &[Solution<D>]) -> Vec<u8> {
    let mut out = HEAD.as_bytes().to_vec();
    meshes(model).put(&mut out);
    put_all(steps, &mut out);
    out
}

/// The solutions that these bytes are, of the same model.
///
/// Errors: bytes of another version, or that are cut off; a model with other meshes, bodies or contacts.
pub(crate) fn read_solutions<const D: usize>(
    model: &Model<D>,
    bytes: &[u8],
) -> Result<Vec<Solution<D>>, String> {
    let mut rest = bytes.strip_prefix(HEAD.as_bytes()).ok_or_else(|| {
        let line = bytes
            .split(|&byte| byte == b'\n')
            .next()
            .unwrap_or_default();
        let found = String::from_utf8_lossy(line)
            .chars()
            .take(40)
            .collect::<String>();
        format!(
            "they begin with `{found}`, and this version reads `{}`",
            HEAD.trim_end()
        )
    })?;
    let broken = || "they are cut off".to_string();
    let kept: Vec<KeptMesh<D>> = Kept::get(&mut rest).ok_or_else(broken)?;
    same_meshes(model, &kept)?;
    let mut steps: Vec<Solution<D>> = Kept::get(&mut rest).ok_or_else(broken)?;
    if !rest.is_empty() {
        return Err("they go on behind their end".to_string());
    }
    for step in &mut steps {
        let stage = model.stage(step.time);
        for (body, answer) in stage.bodies.iter().zip(&mut step.bodies) {
            answer.borders = Borders::of(body).map_err(|error| error.to_string())?;
        }
        check_step(&stage, step).map_err(|error| error.to_string())?;
    }
    Ok(steps)
}

/// Name of a body, its points, and the nodes of the cells of every block.
type KeptMesh<const D: usize> = (String, (Vec<Point<D>>, Vec<Vec<u32>>));

fn meshes<const D: usize>(model: &Model<D>) -> Vec<KeptMesh<D>> {
    let bodies = model.bodies.iter().map(|body| {
        let blocks = body.mesh.blocks().iter();
        let cells = blocks.map(|block| block.nodes.clone()).collect();
        (body.name.clone(), (body.mesh.points().to_vec(), cells))
    });
    bodies.collect()
}

/// Errors: a body that is not there, or whose mesh is another one.
fn same_meshes<const D: usize>(model: &Model<D>, kept: &[KeptMesh<D>]) -> Result<(), String> {
    if model.bodies.len() != kept.len() {
        let (found, before) = (model.bodies.len(), kept.len());
        return Err(format!("the case has {found} bodies now, and had {before}"));
    }
    for (body, (name, (points, cells))) in model.bodies.iter().zip(kept) {
        let own = body.mesh.points();
        let blocks = body.mesh.blocks().iter().map(|block| &block.nodes);
        let size = own.iter().map(|&x| distance(x, own[0])).fold(0.0, f64::max);
        let near = |(a, b): (&Point<D>, &Point<D>)| distance(*a, *b) <= ROUNDING * size;
        let same = body.name == *name
            && own.len() == points.len()
            && own.iter().zip(points).all(near)
            && blocks.eq(cells);
        if !same {
            return Err(format!("the mesh of body `{name}` is another one now"));
        }
    }
    Ok(())
}

/// What becomes bytes and comes back from them.
trait Kept: Sized {
    fn put(&self, out: &mut Vec<u8>);

    /// Takes itself from the beginning of the bytes; `None` where they are none of its kind.
    fn get(from: &mut &[u8]) -> Option<Self>;
}

fn put_all<T: Kept>(items: &[T], out: &mut Vec<u8>) {
    items.len().put(out);
    items.iter().for_each(|item| item.put(out));
}

/// Numbers and lengths by their bytes.
macro_rules! numbers {
    ($($type:ty)+) => {$(
        impl Kept for $type {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }

            fn get(from: &mut &[u8]) -> Option<Self> {
                let (own, rest) = from.split_first_chunk()?;
                *from = rest;
                Some(Self::from_le_bytes(*own))
            }
        }
    )+};
}

numbers!(u8 u32 u64 f64);

impl Kept for usize {
    fn put(&self, out: &mut Vec<u8>) {
        (*self as u64).put(out);
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        u64::get(from)?.try_into().ok()
    }
}

impl Kept for bool {
    fn put(&self, out: &mut Vec<u8>) {
        u8::from(*self).put(out);
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        Some(u8::get(from)? != 0)
    }
}

impl Kept for String {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        out.extend(self.bytes());
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        Self::from_utf8(Vec::get(from)?).ok()
    }
}

impl<T: Kept> Kept for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        put_all(self, out);
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        let count = usize::get(from)?;
        // an item has one byte at least
        (count <= from.len()).then_some(())?;
        (0..count).map(|_| T::get(from)).collect()
    }
}

impl<T: Kept> Kept for Arc<[T]> {
    fn put(&self, out: &mut Vec<u8>) {
        put_all(self, out);
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        Vec::get(from).map(Self::from)
    }
}

impl<T: Kept + Copy + Default, const N: usize> Kept for [T; N] {
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|item| item.put(out));
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        let mut items = [T::default(); N];
        for item in &mut items {
            *item = T::get(from)?;
        }
        Some(items)
    }
}

impl<T: Kept> Kept for Option<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.is_some().put(out);
        self.iter().for_each(|item| item.put(out));
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        match bool::get(from)? {
            true => T::get(from).map(Some),
            false => Some(None),
        }
    }
}

impl<A: Kept, B: Kept> Kept for (A, B) {
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
        self.1.put(out);
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        Some((A::get(from)?, B::get(from)?))
    }
}

impl<K: Kept + Ord, V: Kept> Kept for BTreeMap<K, V> {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        for (key, value) in self {
            key.put(out);
            value.put(out);
        }
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        let entries: Vec<(K, V)> = Kept::get(from)?;
        Some(entries.into_iter().collect())
    }
}

/// Of the model.
impl Kept for Borders {
    fn put(&self, _: &mut Vec<u8>) {}

    fn get(_: &mut &[u8]) -> Option<Self> {
        Some(Self::default())
    }
}

impl Kept for BodyId {
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        usize::get(from).map(Self)
    }
}

/// By the key.
impl Kept for MemberWords {
    fn put(&self, out: &mut Vec<u8>) {
        self.key.to_string().put(out);
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        let key = String::get(from)?;
        MemberKind::ALL.iter().find(|kind| kind.key == key).copied()
    }
}

impl<const D: usize> Kept for SolverReport<D> {
    fn put(&self, out: &mut Vec<u8>) {
        let Self {
            method,
            tried: _,
            iterations,
            products,
            rho,
            history,
            bolts,
            contraction,
        } = self;
        method.put(out);
        [*iterations, *products].put(out);
        [*rho, *contraction]
            .iter()
            .for_each(|number| number.put(out));
        history.put(out);
        bolts.put(out);
    }

    fn get(from: &mut &[u8]) -> Option<Self> {
        let method = Kept::get(from)?;
        let [iterations, products] = Kept::get(from)?;
        Some(Self {
            method,
            tried: Vec::new(),
            iterations,
            products,
            rho: Kept::get(from)?,
            contraction: Kept::get(from)?,
            history: Kept::get(from)?,
            bolts: Kept::get(from)?,
        })
    }
}

/// Closed families, by their places in a list of all.
macro_rules! choices {
    ($($type:ident { $($choice:ident)+ })+) => {$(
        impl Kept for $type {
            fn put(&self, out: &mut Vec<u8>) {
                // no choice is missing
                match self { $(Self::$choice)|+ => {} }
                let all = [$(Self::$choice),+];
                all.iter().position(|choice| choice == self).unwrap_or(0).put(out);
            }

            fn get(from: &mut &[u8]) -> Option<Self> {
                [$(Self::$choice),+].get(usize::get(from)?).copied()
            }
        }
    )+};
}

choices! {
    Status { Open Closed Stick Slip Tied Fixed }
    CoupleKind { Rigid Average }
    Dimension { Length Force Stress Area Moment ForcePerLength MomentPerLength Ratio Energy Angle Other }
    Singular { PointLoad PointSupport Corner EndOfSupport EndOfContact }
}

/// Field by field: none can be left out.
macro_rules! fields {
    ($($type:ident $(<$D:ident>)? { $($field:ident)+ })+) => {$(
        impl$(<const $D: usize>)? Kept for $type$(<$D>)? {
            fn put(&self, out: &mut Vec<u8>) {
                let Self { $($field),+ } = self;
                $($field.put(out);)+
            }

            fn get(from: &mut &[u8]) -> Option<Self> {
                Some(Self { $($field: Kept::get(from)?),+ })
            }
        }
    )+};
}

fields! {
    Solution<D> {
        time counted_from bodies contacts beds members sections certificate overlap converged solver division warnings probes dofs
        contact_unknowns threads seconds
    }
    BodySolution<D> {
        name displacement fitted borders stress strain von_mises reactions contact_forces member_forces side_reactions
        part_reactions floating_modes rigid reaction couples strain_energy dofs peak utilisation pore_pressure yielding inelastic
    }
    RigidMode<D> { description displacement }
    RigidMotion<D> { translation rotation }
    CoupleSolution<D> { name kind point displacement rotation force moment reaction }
    Yielding { strain equivalent share cells extent }
    Utilisation<D> { nodal overstressed judged peak }
    StressAt<D> { value at }
    Peak<D> { most place }
    SingularPeak<D> { place away usual share }
    ContactSolution<D> {
        name nonmortar mortar nodes cyclic first resultant moment length imbalance length_stick length_slip obstacle dissipated
        dissipated_total
    }
    ContactNode<D> {
        node partner point normal weight gap pressure shear slip displacement_nonmortar displacement_mortar status
    }
    SideRef { body side }
    BedSolution<D> { name side compression_only points resultant }
    BedPoint<D> { point normal area pressure gap shear closed }
    MemberSolution<D> { name kind length stations tightening shortening }
    MemberStation<D> { s point length force }
    SectionSolution { name length closed extrusion stations }
    Extrusion { axis length places means }
    Station { s point toward_first thickness normal shear moment hoop across utilisation }
    Across { point along shear moment twist }
    Certificate {
        penetration tension complementarity imbalance_force imbalance_moment energy_gap slip_violation force_error rounding
        between_nodes overlap yields
    }
    Figure { value relative limit }
    OfYield { equilibrium yield_violation flow }
    Intrusion<D> { body other obstacle point depth allowed named waits }
    HistoryPoint { iteration residual active }
    BoltReport<D> { contact point force moved }
    ProbeValue { name quantity dimension value at line }
    LinePoint { s point value starts }
    Seconds { read assemble order factor condense contact recover write total }
    Division { subdomains coarse iterations }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tunnel;
    use std::slice::from_ref;

    #[test]
    fn solutions_come_back_to_the_bit() {
        let (model, mut solution) = tunnel::solved();
        solution.solver.tried.clear();
        let bytes = solutions(&model, from_ref(&solution));
        let back = read_solutions(&model, &bytes).unwrap();
        // NaN is no equal of itself
        assert_eq!(format!("{back:?}"), format!("{:?}", [solution]));
        assert_eq!(solutions(&model, &back), bytes);
    }

    #[test]
    fn bytes_of_something_else_are_refused() {
        let (model, solution) = tunnel::solved();
        let bytes = solutions(&model, from_ref(&solution));
        let refused = |bytes: &[u8]| read_solutions(&model, bytes).unwrap_err();
        for cut in [
            HEAD.len(),
            HEAD.len() + 100,
            bytes.len() / 2,
            bytes.len() - 1,
        ] {
            assert_eq!(refused(&bytes[..cut]), "they are cut off");
        }
        assert!(refused(b"dotyk solutions 0.0.9\nrest").contains("`dotyk solutions 0.0.9`"));
        assert!(refused(&[&bytes[..], b"0"].concat()).contains("behind their end"));
        let mut other = model.clone();
        other.bodies[0].name = "other".to_string();
        let wrong = read_solutions(&other, &bytes).unwrap_err();
        assert!(wrong.contains("another one now"), "{wrong}");
        other.bodies.pop();
        let wrong = read_solutions(&other, &bytes).unwrap_err();
        assert!(wrong.contains("bodies now"), "{wrong}");
    }
}
