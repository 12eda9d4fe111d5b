//! Elements of Abaqus and CalculiX, their faces, and what they become.
//!
//! Nodes are in the order of the deck, which is that of VTK for all kinds here; faces S1, S2, .. (P1, P2, .. of *DLOAD) list
//! corners. Source: CalculiX CrunchiX user's manual, chapter "Element types"; Abaqus has the same.

use crate::results::Kind as Form;
use dotyk::model::Analysis;

/// What an element is made of.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    /// As result files call it.
    pub form: Form,
    pub dimension: usize,
    pub nodes: usize,
    pub corners: usize,
    /// Corners of each face, from 0.
    pub faces: &'static [&'static [usize]],
    /// Middle nodes of edges: the ends of each, in the order of the nodes behind the corners.
    pub edges: &'static [[usize; 2]],
    /// Number of the element type in Gmsh, and its nodes in the order of Gmsh.
    pub gmsh: (u32, &'static [usize]),
}

const TRI_FACES: &[&[usize]] = &[&[0, 1], &[1, 2], &[2, 0]];
const QUAD_FACES: &[&[usize]] = &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]];
const TET_FACES: &[&[usize]] = &[&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]];
const PRISM_FACES: &[&[usize]] = &[
    &[0, 1, 2],
    &[3, 4, 5],
    &[0, 1, 4, 3],
    &[1, 2, 5, 4],
    &[2, 0, 3, 5],
];
const HEX_FACES: &[&[usize]] = &[
    &[0, 1, 2, 3],
    &[4, 7, 6, 5],
    &[0, 4, 5, 1],
    &[1, 5, 6, 2],
    &[2, 6, 7, 3],
    &[3, 7, 4, 0],
];
const TRI_EDGES: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 0]];
const QUAD_EDGES: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 3], [3, 0]];
const TET_EDGES: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
const PRISM_EDGES: &[[usize; 2]] = &[
    [0, 1],
    [1, 2],
    [2, 0],
    [3, 4],
    [4, 5],
    [5, 3],
    [0, 3],
    [1, 4],
    [2, 5],
];
const HEX_EDGES: &[[usize; 2]] = &[
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [4, 5],
    [5, 6],
    [6, 7],
    [7, 4],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

const fn shape(
    form: Form,
    [dimension, nodes, corners]: [usize; 3],
    faces: &'static [&'static [usize]],
    edges: &'static [[usize; 2]],
    gmsh: (u32, &'static [usize]),
) -> Shape {
    Shape {
        form,
        dimension,
        nodes,
        corners,
        faces,
        edges,
        gmsh,
    }
}

static TRI3: Shape = shape(Form::Tri3, [2, 3, 3], TRI_FACES, &[], (2, &[0, 1, 2]));
static TRI6: Shape = shape(
    Form::Tri6,
    [2, 6, 3],
    TRI_FACES,
    TRI_EDGES,
    (9, &[0, 1, 2, 3, 4, 5]),
);
static QUAD4: Shape = shape(Form::Quad4, [2, 4, 4], QUAD_FACES, &[], (3, &[0, 1, 2, 3]));
static QUAD8: Shape = shape(
    Form::Quad8,
    [2, 8, 4],
    QUAD_FACES,
    QUAD_EDGES,
    (16, &[0, 1, 2, 3, 4, 5, 6, 7]),
);
static TET4: Shape = shape(Form::Tet4, [3, 4, 4], TET_FACES, &[], (4, &[0, 1, 2, 3]));
static TET10: Shape = shape(
    Form::Tet10,
    [3, 10, 4],
    TET_FACES,
    TET_EDGES,
    (11, &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
);
static PRISM6: Shape = shape(
    Form::Prism6,
    [3, 6, 6],
    PRISM_FACES,
    &[],
    (6, &[0, 1, 2, 3, 4, 5]),
);
static PRISM15: Shape = shape(
    Form::Prism15,
    [3, 15, 6],
    PRISM_FACES,
    PRISM_EDGES,
    (18, &[0, 1, 2, 3, 4, 5, 6, 8, 12, 7, 13, 14, 9, 11, 10]),
);
static HEX8: Shape = shape(
    Form::Hex8,
    [3, 8, 8],
    HEX_FACES,
    &[],
    (5, &[0, 1, 2, 3, 4, 5, 6, 7]),
);
static HEX20: Shape = shape(
    Form::Hex20,
    [3, 20, 8],
    HEX_FACES,
    HEX_EDGES,
    (
        17,
        &[
            0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14,
        ],
    ),
);

impl Shape {
    /// Corners and middle nodes of a face, from 0.
    pub fn face_nodes(&self, face: usize) -> Vec<usize> {
        let corners = self.faces[face];
        let on = |edge: &[usize; 2]| edge.iter().all(|end| corners.contains(end));
        let middle = self.edges.iter().enumerate().filter(|(_, edge)| on(edge));
        // of the edges between corners of a face none crosses it: all are its own
        let middle = middle.map(|(index, _)| self.corners + index);
        corners.iter().copied().chain(middle).collect()
    }
}

/// An element type of a deck.
#[derive(Debug)]
pub(crate) struct Kind {
    pub shape: &'static Shape,
    pub analysis: Analysis,
    /// Its linear cells have incompatible modes.
    pub enhanced: bool,
    /// What is told: it becomes something else than what its name says.
    pub told: Option<&'static str>,
}

const FULL: Option<&str> = Some("is integrated in full");
const NO_REDUCED: Option<&str> =
    Some("becomes the cell with enhanced strains, which needs no hourglass control");

/// The element type of a name in capitals.
///
/// Errors: why there is no such cell.
pub(crate) fn kind(name: &str) -> Result<Kind, &'static str> {
    let solid = |shape, enhanced, told| {
        Ok(Kind {
            shape,
            analysis: Analysis::Solid,
            enhanced,
            told,
        })
    };
    match name {
        "C3D8" | "C3D8I" => return solid(&HEX8, true, None),
        "C3D8R" => return solid(&HEX8, true, NO_REDUCED),
        "C3D20" => return solid(&HEX20, false, None),
        "C3D20R" => return solid(&HEX20, false, FULL),
        "C3D4" => return solid(&TET4, false, None),
        "C3D10" => return solid(&TET10, false, None),
        "C3D6" => return solid(&PRISM6, false, None),
        "C3D15" => return solid(&PRISM15, false, None),
        _ => {}
    }
    let analysis = match name.get(..3) {
        Some("CPS") => Analysis::PlaneStress,
        Some("CPE") => Analysis::PlaneStrain,
        Some("CAX") => Analysis::Axisymmetric,
        _ => return Err(unknown(name)),
    };
    let plane = |shape, enhanced, told| {
        Ok(Kind {
            shape,
            analysis,
            enhanced,
            told,
        })
    };
    let turned = analysis == Analysis::Axisymmetric;
    match &name[3..] {
        "3" => plane(&TRI3, false, None),
        "6" => plane(&TRI6, false, None),
        "4" | "4I" if !turned => plane(&QUAD4, true, None),
        "4R" if !turned => plane(&QUAD4, true, NO_REDUCED),
        "4" => plane(&QUAD4, false, None),
        "4R" => plane(&QUAD4, false, FULL),
        "8" => plane(&QUAD8, false, None),
        "8R" => plane(&QUAD8, false, FULL),
        _ => Err(unknown(name)),
    }
}

fn unknown(name: &str) -> &'static str {
    let starts = |words: &[&str]| words.iter().any(|word| name.starts_with(word));
    match () {
        () if starts(&["S", "M3D"]) && !name.starts_with("SPRING") => {
            "shells and membranes are not supported: use solid elements"
        }
        () if starts(&["B", "T3D", "T2D"]) => {
            "beams and trusses are not supported: use solid elements, or `[[bar]]` in a case"
        }
        () if starts(&["SPRING", "DASHPOT"]) => {
            "springs are not supported in a deck: use `[[spring]]` in a case"
        }
        () if starts(&["GAP"]) => "gap elements are not supported: use *CONTACT PAIR",
        () if name.ends_with('H') => {
            "hybrid elements are not supported: nearly incompressible material needs none up to `poisson` = 0.49"
        }
        () if name.ends_with('T') => {
            "elements for coupled temperature are not supported: use the element without T"
        }
        () => {
            "unknown element type: known are C3D4 C3D6 C3D8 C3D8I C3D8R C3D10 C3D15 C3D20 C3D20R and CPS, CPE, CAX with 3, 4, 4R, 6, 8, 8R"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_have_their_middle_nodes() {
        // S6 of C3D20: 4-8-5-1 with the middle nodes 16, 17, 20, 12 of the deck
        let mut face = HEX20.face_nodes(5);
        face.sort_unstable();
        assert_eq!(face, [0, 3, 4, 7, 11, 15, 16, 19]);
        assert_eq!(QUAD8.face_nodes(1), [1, 2, 5]);
        assert_eq!(HEX8.face_nodes(0), [0, 1, 2, 3]);
    }

    #[test]
    fn every_order_of_gmsh_is_a_permutation() {
        for shape in [
            &TRI6, &QUAD8, &TET10, &PRISM15, &HEX20, &HEX8, &PRISM6, &TET4, &TRI3, &QUAD4,
        ] {
            let mut order = shape.gmsh.1.to_vec();
            order.sort_unstable();
            assert_eq!(
                order,
                (0..shape.nodes).collect::<Vec<_>>(),
                "{:?}",
                shape.form
            );
            assert_eq!(shape.corners + shape.edges.len(), shape.nodes);
        }
    }
}
