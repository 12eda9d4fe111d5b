//! Nodes excluded from a contact, or from its friction.
//!
//! The rows of an excluded node are left out: no force acts there and no gap is checked, neither at the node nor on its facets.
//! The rows of the other nodes are the same as with it.

use crate::contact::{ContactError, End, Interface, Role};
use crate::fem::{Place, describe, nearest_node, side_nodes};
use std::collections::BTreeSet;

impl<const D: usize> End<'_, D> {
    /// The nodes of the side. Errors: an unknown or empty side.
    pub(super) fn nodes(&self) -> Result<BTreeSet<usize>, ContactError> {
        let facets = self.facets()?.iter();
        let nodes = facets.flat_map(|&facet| self.body.mesh.facet_nodes(facet));
        Ok(nodes.map(|node| node as usize).collect())
    }

    /// The nodes of the side at some places of its body: on another side, or nearest to a point.
    ///
    /// Errors: an unknown side, a point far from all nodes, a place without a node of this side, a side without remaining nodes.
    pub fn nodes_at(&self, places: &[Place<D>]) -> Result<BTreeSet<usize>, ContactError> {
        let mesh = &self.body.mesh;
        let fail = |source| ContactError::Side {
            body: self.body.name.clone(),
            source,
        };
        let own = self.nodes()?;
        let mut found = BTreeSet::new();
        for place in places {
            let nodes = match place {
                Place::Side(side) => side_nodes(mesh, side).map_err(fail)?,
                Place::Point(point) => {
                    BTreeSet::from([nearest_node(mesh, *point, "excluded point").map_err(fail)?])
                }
            };
            found.extend(nodes.intersection(&own));
            if nodes.is_disjoint(&own) {
                return Err(ContactError::NotOnSide {
                    side: self.name(),
                    place: describe(place),
                });
            }
        }
        if found.len() == own.len() {
            return Err(ContactError::NothingLeft { side: self.name() });
        }
        Ok(found)
    }
}

impl<const D: usize> Interface<D> {
    /// Leaves nodes of the nonmortar side out. No condition may be implied yet.
    pub fn exclude(&mut self, out: &BTreeSet<usize>) {
        for node in self.nodes.iter_mut().filter(|n| out.contains(&n.node)) {
            node.role = Role::Excluded;
            node.opposite.clear();
            (node.gap, node.clearance) = (f64::NAN, f64::NAN);
            node.rows = [None; D];
        }
        self.keep_rows_of_nodes();
    }

    /// Leaves the friction of nodes of the nonmortar side out. No condition may be implied yet.
    pub fn smooth(&mut self, out: &BTreeSet<usize>) {
        for node in self.nodes.iter_mut().filter(|n| out.contains(&n.node)) {
            node.rows[1..].fill(None);
        }
        self.keep_rows_of_nodes();
    }

    /// Drops the rows that no node has, and moves those behind them up.
    fn keep_rows_of_nodes(&mut self) {
        let mut kept = vec![false; self.nonmortar.len()];
        let rows = self.nodes.iter().flat_map(|node| node.rows);
        rows.flatten().for_each(|row| kept[row] = true);
        self.keep_rows(&kept);
    }
}
