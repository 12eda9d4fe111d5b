//! What the result files of CalculiX hold: the mesh, the answers at the ends of steps, and what
//! the deck asks to be written of them.

use std::ops::Range;

/// Nodes and elements of a deck, as result files list them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Number and coordinates of each node, in units of length; z = 0 in the plane.
    /// CalculiX lists nodes by ascending number (up to ten digits).
    pub nodes: Vec<(u64, [f64; 3])>,
    /// The elements, in the order in which they are listed.
    pub elements: Vec<Element>,
    /// Names of the materials; [`Element::material`] counts them from 1.
    pub materials: Vec<String>,
    /// Lines of *HEADING; PrePoMax finds its model by them.
    pub headings: Vec<String>,
}

/// One element.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Its number in the deck.
    pub number: u64,
    /// Its shape.
    pub kind: Kind,
    /// Numbers of its nodes in the order of the deck (that of Abaqus), as many as `kind` has.
    pub nodes: Vec<u64>,
    /// Number of its material, from 1.
    pub material: u32,
}

/// Shape of an element; the discriminant is its type in the `.frd`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Brick of 8 nodes (C3D8).
    Hex8 = 1,
    /// Wedge of 6 nodes (C3D6).
    Prism6 = 2,
    /// Tetrahedron of 4 nodes (C3D4).
    Tet4 = 3,
    /// Brick of 20 nodes (C3D20).
    Hex20 = 4,
    /// Wedge of 15 nodes (C3D15).
    Prism15 = 5,
    /// Tetrahedron of 10 nodes (C3D10).
    Tet10 = 6,
    /// Triangle of 3 nodes (CPS3, CPE3, CAX3).
    Tri3 = 7,
    /// Triangle of 6 nodes (CPS6, CPE6, CAX6).
    Tri6 = 8,
    /// Quadrilateral of 4 nodes (CPS4, CPE4, CAX4).
    Quad4 = 9,
    /// Quadrilateral of 8 nodes (CPS8, CPE8, CAX8).
    Quad8 = 10,
}

/// The answer at the end of a step; arrays go by index of [`Mesh::nodes`].
///
/// A quantity that no request names may be left empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// Numbers of the step and of the increment in it, from 1.
    pub number: [usize; 2],
    /// Total time at its end.
    pub time: f64,
    /// Displacement `[x, y, z]` of each node, in units of length.
    pub displacement: Vec<[f64; 3]>,
    /// Force `[x, y, z]` on each node, loads and reactions together, in units of force.
    pub reaction: Vec<[f64; 3]>,
    /// Stress `[xx, yy, zz, xy, xz, yz]` at each node, in units of stress.
    pub stress: Vec<[f64; 6]>,
    /// Strain `[xx, yy, zz, xy, xz, yz]` at each node, components of the tensor.
    pub strain: Vec<[f64; 6]>,
    /// The slave nodes in contact.
    pub contact: Vec<ContactNode>,
}

/// Contact at a nonmortar (slave) node: CDIS and CSTR.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactNode {
    /// Number of the node.
    pub node: u64,
    /// Clearance along the normal, negative where the surfaces overlap, in units of length.
    pub gap: f64,
    /// Relative tangential displacement along both tangents, in units of length.
    pub slip: [f64; 2],
    /// Pressure, positive where the surfaces press, in units of stress.
    pub pressure: f64,
    /// Shear stress along both tangents, in units of stress.
    pub shear: [f64; 2],
}

/// A quantity of the `.frd`, in the order in which CalculiX writes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrdQuantity {
    /// U, block `DISP`.
    Displacement,
    /// S, block `STRESS`.
    Stress,
    /// E, block `TOSTRAIN`.
    Strain,
    /// RF, block `FORC`.
    Reaction,
    /// CDIS and CSTR, block `CONTACT`.
    Contact,
}

/// A request for the `.dat`.
#[derive(Clone, Debug, PartialEq)]
pub enum Print {
    /// `*NODE PRINT`.
    Nodes(NodePrint),
    /// `*EL PRINT`.
    Points(PointPrint),
    /// `*CONTACT PRINT` of CDIS or CSTR.
    Contact(ContactPrint),
    /// `*CONTACT PRINT` of CF.
    ContactForce(ContactForce),
}

/// Values at the nodes of a set.
#[derive(Clone, Debug, PartialEq)]
pub struct NodePrint {
    /// Name of the set; printed in upper case.
    pub set: String,
    /// Indices of [`Mesh::nodes`], in the order in which they are printed.
    pub nodes: Vec<usize>,
    /// What is printed.
    pub quantity: NodeQuantity,
    /// Whether the sum over the set is printed; displacements are never summed.
    pub totals: Totals,
}

/// A quantity at nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeQuantity {
    /// U.
    Displacement,
    /// RF.
    Reaction,
}

/// TOTALS of a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Totals {
    /// The values alone.
    #[default]
    No,
    /// The values and their sum.
    Yes,
    /// The sum alone.
    Only,
}

/// Values at the integration points of a set of elements.
#[derive(Clone, Debug, PartialEq)]
pub struct PointPrint {
    /// Name of the set; printed in upper case.
    pub set: String,
    /// What is printed.
    pub quantity: PointQuantity,
    /// The values, in the order in which they are printed.
    pub rows: Vec<PointRow>,
}

/// A quantity at integration points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointQuantity {
    /// S, in units of stress.
    Stress,
    /// E, components of the tensor.
    Strain,
}

/// Number of the element, number of the integration point from 1, and the components
/// `[xx, yy, zz, xy, xz, yz]`.
pub type PointRow = (u64, usize, [f64; 6]);

/// Values at the slave nodes of a contact pair.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ContactPrint {
    /// What is printed.
    pub quantity: ContactQuantity,
    /// The slave nodes of the pair among [`Step::contact`].
    pub nodes: Range<usize>,
}

/// A quantity at slave nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactQuantity {
    /// CDIS: gap and slip, in units of length.
    Displacement,
    /// CSTR: pressure and shear, in units of stress.
    Stress,
}

/// Force that a contact pair carries, on its slave surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactForce {
    /// Name of the slave surface; printed in upper case.
    pub slave: String,
    /// Name of the master surface; printed in upper case.
    pub master: String,
    /// Force `[x, y, z]`, in units of force.
    pub force: [f64; 3],
    /// Moment `[x, y, z]` of the force about the origin, in units of force times length.
    pub moment: [f64; 3],
    /// Center of gravity of the area in contact, in units of length.
    pub center: [f64; 3],
    /// Mean of the normal over the area in contact (not of length one on a curved surface).
    pub normal: [f64; 3],
    /// Area in contact, in units of length squared.
    pub area: f64,
}
