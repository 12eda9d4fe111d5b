//! Errors of a mesh: each names the place, the datum and the remedy.

use crate::mesh::OutlinePlace;
use thiserror::Error;

/// Errors of a mesh or of one of its sides.
///
/// Blocks, cells and nodes are counted from zero, cells within their block.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshError {
    /// No block has a cell.
    #[error("the mesh has no cells")]
    Empty,
    /// More nodes than an index or a machine holds.
    #[error("the mesh would have {nodes} nodes, more than {most}: ask for fewer cells")]
    TooLarge {
        /// How many.
        nodes: u128,
        /// How many are possible.
        most: usize,
    },
    /// A plane cell in a solid mesh, or the other way round.
    #[error("block {block}: {kind} cells do not fill a mesh of dimension {dimension}")]
    Dimension {
        /// Block.
        block: usize,
        /// Name of its cell kind.
        kind: &'static str,
        /// Dimension of the mesh.
        dimension: usize,
    },
    /// The node list of a block does not divide into cells.
    #[error(
        "block {block}: {length} node indices do not divide into {kind} cells of {nodes} nodes each"
    )]
    RaggedBlock {
        /// Block.
        block: usize,
        /// Name of its cell kind.
        kind: &'static str,
        /// Length of its node list.
        length: usize,
        /// Nodes per cell.
        nodes: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("node {node}: the coordinates {point:?} are not finite")]
    NotFinite {
        /// Node.
        node: usize,
        /// Its coordinates, missing ones zero.
        point: [f64; 3],
    },
    /// A cell names a node that does not exist.
    #[error("cell {cell} of block {block}: node {node} does not exist, there are {points} nodes")]
    NodeOutOfRange {
        /// Block.
        block: usize,
        /// Cell.
        cell: usize,
        /// Index that it names.
        node: u32,
        /// Number of nodes.
        points: usize,
    },
    /// Two cells have the same corners, and differ.
    #[error(
        "cell {} of block {} and cell {} of block {} overlap: they have the same corners, but differ in kind or middle nodes; remove one", .second.1, .second.0, .first.1, .first.0
    )]
    Overlap {
        /// Block and cell that come first.
        first: (usize, usize),
        /// Block and cell of the other one.
        second: (usize, usize),
    },
    /// A cell names a node twice.
    #[error(
        "cell {cell} of block {block} names node {node} twice: give it distinct nodes or remove it"
    )]
    RepeatedNode {
        /// Block.
        block: usize,
        /// Cell.
        cell: usize,
        /// Node.
        node: u32,
    },
    /// The nodes of a cell lie on a line.
    #[error(
        "cell {cell} of block {block}, near {near:?}, has no volume (largest Jacobian {jacobian:e}): remove it or move its nodes apart"
    )]
    ZeroVolume {
        /// Block.
        block: usize,
        /// Cell.
        cell: usize,
        /// Mean of its nodes.
        near: [f64; 3],
        /// Largest absolute value of the Jacobian.
        jacobian: f64,
    },
    /// The Jacobian of a cell changes sign.
    #[error(
        "cell {cell} of block {block}, near {near:?}, is folded (its Jacobian runs from {low:e} to {high:e}): move its nodes, or use more cells where the boundary is curved"
    )]
    Folded {
        /// Block.
        block: usize,
        /// Cell.
        cell: usize,
        /// Mean of its nodes.
        near: [f64; 3],
        /// Smallest Jacobian.
        low: f64,
        /// Largest Jacobian.
        high: f64,
    },
    /// A node that no cell uses would make the stiffness singular.
    #[error("node {node} at {point:?} belongs to no cell: remove it")]
    LooseNode {
        /// Node.
        node: usize,
        /// Its coordinates, missing ones zero.
        point: [f64; 3],
    },
    /// A side that the mesh does not have.
    #[error("there is no side `{side}`: the mesh has {known}")]
    UnknownSide {
        /// Name that was asked for.
        side: String,
        /// Names that exist, in a list.
        known: String,
    },
    /// Two sides of one name.
    #[error("the side `{side}` exists already: choose another name")]
    SideExists {
        /// Name.
        side: String,
    },
    /// A cut along facets of which one is not between two cells.
    #[error("a cut runs between cells, and at {point:?} it runs along the boundary")]
    CutOutside {
        /// The middle of the facet, missing coordinates zero.
        point: [f64; 3],
    },
    /// A cut around whose end the cells behind and ahead of it are connected.
    #[error("the cut ends within the body, near {point:?}: it must go through")]
    CutEnds {
        /// The middle of a facet of it, missing coordinates zero.
        point: [f64; 3],
    },
    /// A side names a facet that does not exist.
    #[error("side `{side}`: facet {local} of cell {cell} of block {block} does not exist")]
    FacetOutOfRange {
        /// Side.
        side: String,
        /// Block.
        block: u32,
        /// Cell.
        cell: u32,
        /// Local index of the facet.
        local: u32,
    },
    /// The box of a patch holds no whole facet.
    #[error(
        "patch `{patch}`: no whole facet of side `{of}` lies between {min:?} and {max:?}: its facets must lie in the box with all their corners"
    )]
    EmptyPatch {
        /// Name of the patch.
        patch: String,
        /// Side that it is cut from.
        of: String,
        /// Lower corner of the box, missing coordinates zero.
        min: [f64; 3],
        /// Upper corner of the box, missing coordinates zero.
        max: [f64; 3],
    },
    /// A generator cannot work with a value.
    #[error("{generator}: {key} = {value}: {need}")]
    Parameter {
        /// Generator, as in a case file.
        generator: &'static str,
        /// Key, as in a case file.
        key: &'static str,
        /// The given value.
        value: String,
        /// The requirement.
        need: &'static str,
    },
    /// A mesh without a generator is to be made anew.
    #[error(
        "its cells come from a file or a program, or from a generator whose cells keep their sizes: it cannot be made anew with other sizes"
    )]
    NoGenerator,
    /// A mesh with a side of which only its facets are known is to be made anew.
    #[error(
        "the facets of side `{side}` were picked one by one, and cannot be found again in a mesh made anew: cut the side out with a box, or join it from others"
    )]
    PickedSide {
        /// Name.
        side: String,
    },
    /// An outline that cannot be meshed.
    #[error("outline, {place}: {problem}")]
    Outline {
        /// Where.
        place: OutlinePlace,
        /// The fault and its remedy.
        problem: String,
    },
    /// A drawing that cannot be meshed.
    #[error("drawing, {place}: {problem}")]
    Drawing {
        /// Where.
        place: OutlinePlace,
        /// The fault and its remedy.
        problem: String,
    },
}
