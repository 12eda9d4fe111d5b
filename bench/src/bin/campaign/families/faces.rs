//! Sides that face several surfaces, sides that extend beyond the facing part, and contacts that have nodes in common: each
//! beside an equivalent problem with simpler contacts.

use super::travel::{edge, triangle};
use super::{Scene, floors::polygon};
use crate::amount::Amount;
use crate::plane::Vector;
use crate::problem::{
    Against, Contact, Known, Law, Other, Patch, Problem, Shape, clamp, hold, on, side, steps,
};

/// Names of the edge of each tread: as a part of the whole top, and its own name alone.
const TREADS: [[&str; 2]; 5] = [
    ["top t0", "t0"],
    ["top t1", "t1"],
    ["top t2", "t2"],
    ["top t3", "t3"],
    ["top t4", "t4"],
];

/// Names of flanks, of the pushed comb and of the holding comb.
const FLANKS: [[&str; 2]; 5] = [
    ["flank t0", "t0"],
    ["flank t1", "t1"],
    ["flank t2", "t2"],
    ["flank t3", "t3"],
    ["flank t4", "t4"],
];

/// Adds the problem with another list of contacts.
fn otherwise(scene: &mut Scene, name: &'static str, contacts: Vec<Contact>, tolerance: f64) {
    let problem = Problem {
        contacts,
        ..scene.problem.clone()
    };
    scene.problem.other = Some(Box::new(Other {
        name,
        parts: (0..problem.bodies.len()).map(|b| vec![b]).collect(),
        problem,
        tolerance,
    }));
}

/// The contact between other sides of the same bodies.
fn between(contact: &Contact, name: &str, sides: [(&str, &str); 2]) -> Contact {
    let mut again = contact.clone();
    again.name = name.to_string();
    let find = |body: &str| {
        let own = sides.iter().find(|(b, _)| *b == body);
        own.map_or("", |(_, side)| side)
    };
    again.own.side = find(&contact.own.body).to_string();
    if let Against::Side { side, .. } = &mut again.against {
        side.side = find(&side.body.clone()).to_string();
    }
    again
}

/// Fixes the side that carries the multipliers: the program might choose another one for a part.
fn decided(scene: &mut Scene, contact: usize) {
    if let Against::Side { chosen, .. } = &mut scene.problem.contacts[contact].against {
        *chosen = false;
    }
}

/// A block on a floor of two to five treads, of which at least one is touched and the others lie lower by much or little; the
/// floor's upper side includes the risers. The same with one contact for each tread.
pub fn steps_of_a_floor(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 1, 2]);
    scene.problem.times = steps(count);
    let n = scene.random.count(2, 5);
    let deep = scene.random.between(0.5, 1.0);
    let little = scene.strain * scene.random.between(0.05, 1.5);
    let touched = scene.random.count(0, n - 1);
    let mut heights: Vec<f64> = Vec::new();
    for k in 0..n {
        // neighbouring treads have different levels: a contact that ends within a level side would cut facets in two that a single
        // contact leaves whole
        let level = heights.last().is_some_and(|h| *h == 0.0) || k + 1 == touched;
        let height = if k == touched {
            0.0
        } else {
            match scene.random.count(usize::from(level), 3) {
                0 => 0.0,
                1 => -little * scene.random.between(0.2, 1.0),
                _ => -scene.random.between(0.05, 0.35),
            }
        };
        heights.push(height);
    }
    let mut corners: Vec<Vector> = vec![[0.0, -deep]];
    let mut names: Vec<&'static str> = vec!["low", "end"];
    let mut xs = vec![0.0];
    for _ in 0..n {
        xs.push(xs[xs.len() - 1] + scene.random.between(0.3, 0.8));
    }
    corners.push([xs[n], -deep]);
    corners.push([xs[n], heights[n - 1]]);
    for k in (0..n).rev() {
        names.push(TREADS[k][0]);
        corners.push([xs[k], heights[k]]);
        if k > 0 && heights[k - 1] != heights[k] {
            names.push("top");
            corners.push([xs[k], heights[k - 1]]);
        }
    }
    names.push("start");
    let kind = triangle(scene);
    let area = xs[n] * deep;
    let size = scene.cell_length(area, 2, kind).clamp(0.06, 0.4);
    let shape = polygon(size, &corners, &names, &[]);
    scene.add("floor", shape, kind);
    scene.problem.bodies[0].supports.push(clamp(on("low")));
    let (a, b) = (
        scene.random.between(-0.2, 0.2),
        xs[n] + scene.random.between(-0.2, 0.2),
    );
    let tall = scene.random.between(0.4, 1.0);
    scene.block("block", [a, 0.0], [b, tall], 2);
    scene.press_upright(1);
    let law = scene.law(0.2);
    let c = scene.touch(side("block", "bottom"), side("floor", "top"), law);
    decided(scene, c);
    let whole = scene.problem.contacts[c].clone();
    let each = (0..n).map(|k| {
        between(
            &whole,
            &format!("t{k}"),
            [("block", "bottom"), ("floor", TREADS[k][1])],
        )
    });
    let each = each.collect();
    otherwise(scene, "treads", each, 1e-6);
    scene.holds("pressed down, upright by its left side, above a tread that it touches");
}

/// Two combs that hook into each other, all flanks of a comb one side, in contact or with a small gap. The same with one contact
/// for each pair of teeth.
pub fn teeth(scene: &mut Scene) {
    let n = scene.random.count(2, 5);
    let count = scene.random.pick(&[1, 1, 2]);
    scene.problem.times = steps(count);
    let pitch = scene.random.between(0.7, 1.1);
    let thick = pitch * scene.random.between(0.3, 0.4);
    let reach = scene.random.between(0.2, 0.6);
    let play = reach * scene.random.between(0.1, 0.4);
    let little = scene.strain * scene.random.pick(&[0.0, 0.05, 0.5]);
    // the pushed comb on the left, its teeth to the right; flanks look down
    let base = 0.3 * pitch;
    let mut left: Vec<(Vector, &'static str)> = Vec::new();
    let mut start = [0.0, -base];
    left.push(([0.6, -base], "low"));
    for (k, names) in FLANKS.iter().enumerate().take(n) {
        let y = k as f64 * pitch;
        left.push(([0.6, y], "root"));
        left.push(([0.6 + reach, y], names[0]));
        left.push(([0.6 + reach, y + thick], "tip"));
        left.push(([0.6, y + thick], "back"));
    }
    let top = n as f64 * pitch;
    left.push(([0.6, top], "root"));
    left.push(([0.0, top], "top"));
    left.push((start, "left"));
    let far = 0.6 + reach + play;
    let mut right: Vec<(Vector, &'static str)> = Vec::new();
    // from its upper left corner down along the teeth, which look up
    let mut tips: Vec<(Vector, &'static str)> = Vec::new();
    for (k, names) in FLANKS.iter().enumerate().take(n) {
        let gap = if k == 0 {
            0.0
        } else {
            little * scene.random.unit()
        };
        let y = k as f64 * pitch - gap;
        tips.push(([far, y], names[0]));
        tips.push(([0.6 + play, y], "tip"));
        tips.push(([0.6 + play, y - thick], "back"));
        tips.push(([far, y - thick], "root"));
    }
    right.push(([far + 0.6, -pitch], "low"));
    right.push(([far + 0.6, top], "right"));
    right.push(([far, top], "upper"));
    // every corner is reached by the edge before it: the first flank from the root above
    let mut before = "root";
    for k in (0..n).rev() {
        let tooth = &tips[4 * k..4 * k + 4];
        right.push((tooth[0].0, before));
        right.push((tooth[1].0, tooth[0].1));
        right.push((tooth[2].0, "tip"));
        right.push((tooth[3].0, "back"));
        before = "root";
    }
    right.push(([far, -pitch], "root"));
    let outline = |size: f64, start: Vector, list: &[(Vector, &'static str)]| Shape::Outline {
        size,
        from: start,
        edges: list.iter().map(|&(to, name)| edge(to, name)).collect(),
    };
    let size = scene.random.between(0.1, 0.3) * pitch;
    let kind = triangle(scene);
    let shape = outline(size, start, &left);
    scene.add("pushed", shape, kind);
    start = [far, -pitch];
    let size = scene.random.between(0.1, 0.3) * pitch;
    let shape = outline(size, start, &right);
    let kind = triangle(scene);
    scene.add("holding", shape, kind);
    scene.problem.bodies[1].supports.push(clamp(on("right")));
    scene.press_upright(0);
    let law = scene.law(0.2);
    let c = scene.touch(side("pushed", "flank"), side("holding", "flank"), law);
    decided(scene, c);
    let whole = scene.problem.contacts[c].clone();
    let each = (0..n).map(|k| {
        let name = FLANKS[k][1];
        between(&whole, name, [("pushed", name), ("holding", name)])
    });
    let each = each.collect();
    otherwise(scene, "teeth", each, 1e-6);
    scene.holds("upright by its left side, pushed onto teeth below");
}

/// Two or three blocks on each other whose whole boundaries are sides, with a small clearance or interference. The same with only
/// the sides that face each other.
pub fn whole(scene: &mut Scene) {
    let high = scene.random.count(2, 3);
    let count = scene.random.pick(&[1, 1, 2]);
    scene.problem.times = steps(count);
    let off = scene.strain * scene.random.pick(&[0.0, 0.0, 0.3, -0.3, -1.0]);
    let mut y = 0.0;
    let outlines = scene.random.chance(0.4);
    for k in 0..high {
        let name = format!("b{k}");
        let (w, h) = (
            scene.random.between(0.6, 1.5),
            scene.random.between(0.4, 1.0),
        );
        let left = scene.random.between(-0.1, 0.1) - 0.5 * w;
        if outlines {
            let corners = [[left, y], [left + w, y], [left + w, y + h], [left, y + h]];
            let kind = triangle(scene);
            let size = scene.cell_length(w * h, high, kind).clamp(0.06, 0.5);
            let shape = polygon(size, &corners, &["bottom", "right", "top", "left"], &[]);
            scene.add(&name, shape, kind);
        } else {
            scene.block(&name, [left, y], [left + w, y + h], high);
        }
        scene.problem.bodies[k].supports.push(match k {
            0 => clamp(on("bottom")),
            _ => hold(on("left"), 0),
        });
        y += h + off;
    }
    let p = scene.strain * scene.random.between(0.2, 1.0);
    scene.problem.bodies[high - 1].press("top", Amount::from(p));
    let mut plain = Vec::new();
    for k in 1..high {
        let (above, below) = (format!("b{k}"), format!("b{}", k - 1));
        let all = "left+bottom+right+top";
        let law = scene.law(0.2);
        let c = scene.touch(side(&above, all), side(&below, all), law);
        decided(scene, c);
        let whole = &scene.problem.contacts[c];
        plain.push(between(
            whole,
            &whole.name.clone(),
            [(&above, "bottom"), (&below, "top")],
        ));
    }
    otherwise(scene, "facing", plain, 1e-6);
    scene.holds("pressed down, all upright by their left sides");
}

/// Least number of facets of a side with which its parts and the whole side agree within the resolution of the mesh.
const FEWEST: usize = 4;

/// A block on a floor whose top is two to four sides, or whose own sole is: contacts with nodes in common, or a list. The same
/// with one contact over all of it.
pub fn shared(scene: &mut Scene) {
    let count = scene.random.pick(&[1, 1, 2]);
    scene.problem.times = steps(count);
    let w = scene.random.between(0.8, 2.0);
    let n = scene.random.count(2, 4);
    let kind = scene.kind();
    let per = scene.random.count(1, 6);
    let (up, margin) = (scene.random.count(1, 8), scene.random.between(0.0, 0.3));
    let on_floor = scene.random.chance(0.5);
    // the side that is divided has whole cells in each of its parts
    let (low, wide) = if on_floor {
        (-margin, w + 2.0 * margin)
    } else {
        (0.0, w)
    };
    let deep = scene.random.between(0.4, 1.0);
    if on_floor {
        scene.rectangle(
            "floor",
            [low, -deep],
            [low + wide, 0.0],
            [n * per, up],
            kind,
        );
        scene.block("block", [0.0, 0.0], [w, deep], 2);
    } else {
        scene.block("floor", [-margin, -deep], [w + margin, 0.0], 2);
        scene.rectangle("block", [0.0, 0.0], [w, deep], [n * per, up], kind);
    }
    let (divided, of) = if on_floor { (0, "top") } else { (1, "bottom") };
    let parts = ["p0", "p1", "p2", "p3"];
    let body = &mut scene.problem.bodies[divided];
    for (k, part) in parts.iter().enumerate().take(n) {
        let at = |k: usize| low + wide * k as f64 / n as f64;
        body.patches.push(Patch {
            name: (*part).to_string(),
            of,
            low: [at(k) - 1e-3, -1e-3],
            high: [at(k + 1) + 1e-3, 1e-3],
        });
    }
    let p = scene.strain;
    scene.problem.bodies[0].supports.push(clamp(on("bottom")));
    let block = &mut scene.problem.bodies[1];
    block.supports.push(hold(on("left"), 0));
    let slope = p * scene.random.between(-0.5, 0.5);
    block.press(
        "top",
        Amount::new(p, [slope, 0.0], crate::amount::Time::Always),
    );
    let law = if scene.random.chance(0.15) {
        Law::Tied
    } else {
        scene.law(0.25)
    };
    let name = |k: usize| {
        if on_floor {
            [("floor", parts[k]), ("block", "bottom")]
        } else {
            [("floor", "top"), ("block", parts[k])]
        }
    };
    let c = scene.touch(side("block", "bottom"), side("floor", "top"), law);
    decided(scene, c);
    let whole = scene.problem.contacts[c].clone();
    let list = scene.random.chance(0.3);
    scene.problem.contacts = if list {
        let all = parts[..n].join("+");
        let sides = if on_floor {
            [("floor", &all[..]), ("block", "bottom")]
        } else {
            [("floor", "top"), ("block", &all[..])]
        };
        vec![between(&whole, "c0", sides)]
    } else {
        (0..n)
            .map(|k| between(&whole, &format!("c{k}"), name(k)))
            .collect()
    };
    // a list is the same side, with the same answer. Contacts of parts have other conditions where a facet is cut in two or the
    // nodes of the sides do not coincide: the answers differ by the resolution of the mesh, too coarse with two or three facets
    if list || n * per >= FEWEST {
        let limit = if list { 1e-6 } else { 0.1 };
        otherwise(scene, "union", vec![whole], limit);
    }
    scene.problem.known = Known::Holds;
    scene.problem.reason = "pressed down, upright by its left side".to_string();
}
