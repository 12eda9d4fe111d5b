//! The regions of a drawing, filled, and the bodies that are made of them.
//!
//! A facet of a body belongs to the sides named by its line, and to the side named like the region beyond it. A facet with neither
//! belongs to the side `outline`.

use crate::geometry::Point;
use crate::mesh::outline::divide::{Rib, Sizes};
use crate::mesh::outline::drawing::{SAME, check_division, check_values, extent};
use crate::mesh::outline::net::{Net, Part};
use crate::mesh::outline::nouns::{Contour, Drawing, OutlinePart, OutlinePlace, Region};
use crate::mesh::outline::partition::Partition;
use crate::mesh::outline::wishes::Wishes;
use crate::mesh::{Generator, Mesh, MeshError, SizeField};
use std::sync::Arc;

/// The filled regions of a drawing.
#[derive(Debug, Clone)]
pub struct Regions {
    drawing: Arc<Drawing>,
    ribs: Vec<Rib>,
    net: Net,
    /// Sides by the names of its line, for each curve.
    names: Vec<Vec<String>>,
    /// The region that each face belongs to.
    region_of: Vec<usize>,
    /// The filled faces.
    parts: Vec<Part>,
}

/// A body of some regions of a drawing.
#[derive(Debug)]
struct OfRegions {
    drawing: Arc<Drawing>,
    regions: Vec<String>,
}

impl Generator<2> for OfRegions {
    /// All curves of the drawing are divided, and the faces of the body are filled: bodies that are made anew with one size field
    /// have the same nodes on their common lines.
    fn anew(&self, sizes: &SizeField<2>, nodes: &[Point<2>]) -> Result<Mesh<2>, MeshError> {
        let wishes = Wishes {
            sizes: Some(sizes),
            nodes,
        };
        let names: Vec<&str> = self.regions.iter().map(String::as_str).collect();
        let own = |region: &str| names.contains(&region);
        self.drawing.filled(&wishes, own)?.filling(&names)
    }

    fn drawing(&self) -> Option<&Drawing> {
        Some(&self.drawing)
    }
}

impl Drawing {
    /// Fills all regions. Lines may meet, cross and coincide; ends beyond the last crossing are cut off. Faces without a region
    /// stay empty.
    ///
    /// Errors, each naming line, edge or region: numbers that are not finite, arcs that do not exist; lines that dangle
    /// or nearly coincide; corners below one degree; regions without a point, with a point outside of all lines or on one, of
    /// the name of another region or a line, or not separated from another; sizes that are not positive, or exceed that of the
    /// drawing; a kind of cell that is not a triangle; more than two million corners of cells.
    pub fn build(&self) -> Result<Regions, MeshError> {
        self.filled(&Wishes::default(), |_| true)
    }

    /// Fills some regions.
    fn filled(
        &self,
        wishes: &Wishes<'_>,
        fills: impl Fn(&str) -> bool,
    ) -> Result<Regions, MeshError> {
        check_values(self.size, self.growth, &self.refine, self.cell)?;
        let mut drawn = Vec::new();
        for (line, contour) in self.lines.iter().enumerate() {
            drawn.extend(contour.curves(OutlinePart::Line(line))?);
        }
        if drawn.is_empty() {
            return Err(whole(OutlinePart::Drawing).error("it has no lines"));
        }
        let (_, diameter) = extent(drawn.iter())?;
        for drawn in &drawn {
            check_division(self.size, drawn, diameter)?;
        }
        self.check_names()?;
        let drawn = wishes.cut(drawn, SAME * diameter);
        let mut partition = Partition::of(&drawn, self.size)?;
        let (faces, region_of) = self.faces(&partition)?;
        partition.keep(&faces)?;
        let size_of = |face: usize| {
            let own = self.regions[region_of[face]].size;
            own.map_or(self.size, |size| size.min(self.size))
        };
        for rib in &mut partition.ribs {
            let beside = rib.faces.into_iter().flatten().map(size_of);
            rib.size = beside.fold(rib.size, f64::min);
        }
        let field = wishes.field(&self.refine, self.growth);
        let sizes = |largest: f64| Sizes {
            largest,
            growth: self.growth,
            field: &field,
            binding: wishes.sizes.is_some(),
        };
        let counted = partition.areas.iter().enumerate();
        let counted: Vec<_> = counted.map(|(f, &area)| (f, area, size_of(f))).collect();
        sizes(self.size).few_enough(&partition.ribs, &counted, &self.refine)?;
        let net = Net::of(&partition.ribs, &sizes(self.size))
            .ok_or_else(|| whole(OutlinePart::Drawing).too_many())?;
        let places = (&partition.ribs[..], &partition.places[..]);
        let filled = region_of.iter().enumerate();
        let filled = filled.map(|(face, &region)| (face, &self.regions[region].name));
        let filled = filled.filter(|(_, region)| fills(region));
        let parts = filled.map(|(face, region)| {
            net.fill(places, face, Some(region.clone()), &sizes(size_of(face)))
        });
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        Ok(Regions {
            drawing: Arc::new(self.clone()),
            ribs: partition.ribs,
            net,
            names: partition.names,
            region_of,
            parts,
        })
    }

    /// Regions have a name and a point; names of sides have one meaning.
    fn check_names(&self) -> Result<(), MeshError> {
        let edges = self.lines.iter().flat_map(|line| match line {
            Contour::Path { edges, .. } => edges.iter().flat_map(|e| &e.names).collect(),
            Contour::Circle { names, .. } => names.iter().collect::<Vec<_>>(),
        });
        let lines: Vec<&String> = edges.collect();
        for (k, region) in self.regions.iter().enumerate() {
            let place = region.place(k);
            if self.regions[..k].iter().any(|r| r.name == region.name) {
                let problem = "another region has this name: give all its points in one list";
                return Err(place.error(problem));
            }
            if lines.contains(&&region.name) {
                let problem = "a line has this name, too: both would name a side of the same bodies; choose another one";
                return Err(place.error(problem));
            }
            if region.at.is_empty() {
                return Err(place.error("it has no point: `at` says where it is"));
            }
            if let Some(size) = region
                .size
                .filter(|size| !(*size > 0.0 && *size <= self.size))
            {
                return Err(place.error(format!(
                    "the size {size} must be positive and not exceed that of the drawing, {}",
                    self.size
                )));
            }
        }
        match self.regions.is_empty() {
            true => Err(whole(OutlinePart::Drawing)
                .error("it has no regions: a name and a point `at` in each say what is filled")),
            false => Ok(()),
        }
    }

    /// The faces that regions name, and the region of each.
    fn faces(&self, partition: &Partition) -> Result<(Vec<usize>, Vec<usize>), MeshError> {
        let (mut faces, mut region_of): (Vec<usize>, Vec<usize>) = Default::default();
        for (k, region) in self.regions.iter().enumerate() {
            let place = region.place(k);
            for &at in &region.at {
                if !at.iter().all(|c| c.is_finite()) {
                    return Err(place.error(format!("the coordinates {at:?} are not finite")));
                }
                let face = partition.face_at(at).map_err(|rib| {
                    let line = &partition.places[rib];
                    place.error(format!("its point {at:?} lies on {line}: move it aside"))
                })?;
                let Some(face) = face else {
                    return Err(place.error(format!(
                        "its point {at:?} is surrounded by no lines: the region is not closed, or the point is wrong"
                    )));
                };
                match faces.iter().position(|&f| f == face) {
                    None => {
                        faces.push(face);
                        region_of.push(k);
                    }
                    Some(before) if region_of[before] == k => {
                        return Err(place.error(format!(
                            "its point {at:?} is in the same part as another one: one point for each part"
                        )));
                    }
                    Some(before) => {
                        let other = &self.regions[region_of[before]];
                        return Err(place.error(format!(
                            "no line separates it from region `{}`: there is a way from {at:?} to {:?}; a line between them is missing or does not reach the next one",
                            other.name, other.at[0]
                        )));
                    }
                }
            }
        }
        Ok((faces, region_of))
    }
}

impl Region {
    fn place(&self, number: usize) -> OutlinePlace {
        OutlinePlace {
            names: vec![self.name.clone()],
            ..whole(OutlinePart::Region(number))
        }
    }
}

fn whole(part: OutlinePart) -> OutlinePlace {
    OutlinePlace {
        part,
        ..OutlinePlace::default()
    }
}

impl Regions {
    /// Names of the regions.
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.drawing.regions.iter().map(|r| r.name.as_str())
    }

    /// The mesh of a body made of some regions: cells are in groups of their names, nodes on lines first. Along a line that
    /// it shares with another body both have the same nodes.
    ///
    /// Errors: an unknown region, an empty list.
    pub fn mesh(&self, regions: &[&str]) -> Result<Mesh<2>, MeshError> {
        Ok(self.filling(regions)?.made_by(OfRegions {
            drawing: Arc::clone(&self.drawing),
            regions: regions.iter().map(|name| name.to_string()).collect(),
        }))
    }

    fn filling(&self, regions: &[&str]) -> Result<Mesh<2>, MeshError> {
        if let Some(unknown) = regions
            .iter()
            .find(|name| !self.names().any(|n| n == **name))
        {
            let known: Vec<&str> = self.names().collect();
            return Err(whole(OutlinePart::Drawing).error(format!(
                "it has no region `{unknown}`: it has {}",
                known.join(", ")
            )));
        }
        let region = |face: usize| &self.drawing.regions[self.region_of[face]].name;
        let own = |part: &&Part| regions.contains(&region(part.face).as_str());
        let parts: Vec<&Part> = self.parts.iter().filter(own).collect();
        let cell = self.drawing.cell;
        self.net.mesh(&self.ribs, cell, &parts, |rib, beyond| {
            let mut sides = self.names[rib].clone();
            sides.extend(beyond.map(|face| region(face).clone()));
            if sides.is_empty() {
                sides.push("outline".to_string());
            }
            sides
        })
    }
}
