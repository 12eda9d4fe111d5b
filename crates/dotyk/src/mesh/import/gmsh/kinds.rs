//! Gmsh's numbers of element types.
//!
//! Source: Gmsh reference manual, section "Gmsh file formats"; orders and numbers of nodes as its library tells them.

use crate::mesh::CellKind;
use crate::mesh::import::content::ElementType;

/// Number, order and nodes of a type.
type Row = (i64, u8, usize);

/// Name, dimension and types that meshes cannot consist of.
const OTHER_TYPES: [(&str, u8, &[Row]); 11] = [
    ("point", 0, &[(15, 0, 1)]),
    ("pyramid5", 3, &[(7, 1, 5)]),
    ("pyramid13", 3, &[(19, 2, 13)]),
    ("pyramid14", 3, &[(14, 2, 14)]),
    ("line", 1, &LINES),
    ("triangle", 2, &TRIANGLES),
    ("quadrilateral", 2, &QUADRILATERALS),
    ("tetrahedron", 3, &TETRAHEDRA),
    ("hexahedron", 3, &HEXAHEDRA),
    ("prism", 3, &PRISMS),
    ("pyramid", 3, &PYRAMIDS),
];

/// The type of a number; `None` where it is unknown, or has no fixed number of nodes.
pub(super) fn element_type(number: i64) -> Option<ElementType> {
    let ours = |kind: &CellKind| i64::from(kind.gmsh()) == number;
    if let Some(kind) = CellKind::ALL.into_iter().find(ours) {
        return Some(ElementType::of(kind));
    }
    OTHER_TYPES.iter().find_map(|&(name, dimension, rows)| {
        let row = rows.iter().find(|row| row.0 == number);
        row.map(|&(_, order, nodes)| ElementType {
            name,
            dimension,
            nodes,
            order,
        })
    })
}

#[rustfmt::skip]
const LINES: [Row; 8] = [
    (26, 3, 4), (27, 4, 5), (28, 5, 6), (62, 6, 7), (63, 7, 8), (64, 8, 9), (65, 9, 10), (66, 10, 11),
];
#[rustfmt::skip]
const TRIANGLES: [Row; 16] = [
    (20, 3, 9), (21, 3, 10), (22, 4, 12), (23, 4, 15), (24, 5, 15), (25, 5, 21), (42, 6, 28), (43, 7, 36), (44, 8, 45),
    (45, 9, 55), (46, 10, 66), (52, 6, 18), (53, 7, 21), (54, 8, 24), (55, 9, 27), (56, 10, 30),
];
#[rustfmt::skip]
const QUADRILATERALS: [Row; 16] = [
    (36, 3, 16), (37, 4, 25), (38, 5, 36), (39, 3, 12), (40, 4, 16), (41, 5, 20), (47, 6, 49), (48, 7, 64), (49, 8, 81),
    (50, 9, 100), (51, 10, 121), (57, 6, 24), (58, 7, 28), (59, 8, 32), (60, 9, 36), (61, 10, 40),
];
#[rustfmt::skip]
const TETRAHEDRA: [Row; 16] = [
    (29, 3, 20), (30, 4, 35), (31, 5, 56), (32, 4, 22), (33, 5, 28), (71, 6, 84), (72, 7, 120), (73, 8, 165),
    (74, 9, 220), (75, 10, 286), (79, 6, 34), (80, 7, 40), (81, 8, 46), (82, 9, 52), (83, 10, 58), (137, 3, 16),
];
#[rustfmt::skip]
const HEXAHEDRA: [Row; 14] = [
    (92, 3, 64), (93, 4, 125), (94, 5, 216), (95, 6, 343), (96, 7, 512), (97, 8, 729), (98, 9, 1000), (99, 3, 32),
    (100, 4, 44), (101, 5, 56), (102, 6, 68), (103, 7, 80), (104, 8, 92), (105, 9, 104),
];
#[rustfmt::skip]
const PRISMS: [Row; 14] = [
    (90, 3, 40), (91, 4, 75), (106, 5, 126), (107, 6, 196), (108, 7, 288), (109, 8, 405), (110, 9, 550), (111, 3, 24),
    (112, 4, 33), (113, 5, 42), (114, 6, 51), (115, 7, 60), (116, 8, 69), (117, 9, 78),
];
#[rustfmt::skip]
const PYRAMIDS: [Row; 14] = [
    (118, 3, 30), (119, 4, 55), (120, 5, 91), (121, 6, 140), (122, 7, 204), (123, 8, 285), (124, 9, 385), (125, 3, 21),
    (126, 4, 29), (127, 5, 37), (128, 6, 45), (129, 7, 53), (130, 8, 61), (131, 9, 69),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_number_is_listed_once() {
        let other = OTHER_TYPES.iter().flat_map(|(_, _, rows)| rows.iter());
        let mut seen: BTreeSet<i64> = CellKind::ALL.map(|kind| i64::from(kind.gmsh())).into();
        for (number, ..) in other {
            assert!(seen.insert(*number), "{number}");
        }
        assert_eq!(element_type(34), None);
    }

    /// A complete cell of order p has as many nodes as a polynomial of its family has terms.
    #[test]
    fn complete_cells_have_the_nodes_of_their_order() {
        for (name, _, rows) in OTHER_TYPES {
            for &(number, order, nodes) in rows.iter().filter(|row| row.1 > 2) {
                let p = usize::from(order);
                let complete = match name {
                    "line" => p + 1,
                    "triangle" => (p + 1) * (p + 2) / 2,
                    "quadrilateral" => (p + 1).pow(2),
                    "tetrahedron" => (p + 1) * (p + 2) * (p + 3) / 6,
                    "hexahedron" => (p + 1).pow(3),
                    "prism" => (p + 1).pow(2) * (p + 2) / 2,
                    _ => (p + 1) * (p + 2) * (2 * p + 3) / 6,
                };
                assert!(nodes <= complete, "{number}: {nodes} of {complete}");
            }
        }
    }

    #[test]
    fn higher_orders_are_called_by_their_order() {
        assert_eq!(
            element_type(21).unwrap().to_string(),
            "triangle of order 3 (10 nodes)"
        );
        assert_eq!(
            element_type(24).unwrap().to_string(),
            "triangle of order 5 (15 nodes)"
        );
        assert_eq!(element_type(7).unwrap().to_string(), "pyramid5");
        assert_eq!(element_type(5).unwrap().to_string(), "hex8");
    }
}
