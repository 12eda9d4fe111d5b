//! Sections of the report on contacts: their forces, the balance of the bodies, and their nodes.

use crate::geometry::{Point, add_scaled, norm, sub};
use crate::model::{Analysis, ContactNode, ContactSolution, Model, Solution, Status, listed};
use crate::output::chain::along_tangent;
use crate::output::figures::Figures;
use crate::output::html::{column, left, marked, plain, table, text};
use crate::output::interface::{largest_gap, length_scale};
use crate::output::json::{closed_and_open, in_contact, largest, max_penetration, range};
use crate::output::markup::{Markup, markup};
use crate::output::text::{
    Labels, count, number, power, quantity, vector, vector_on, without_noise,
};

/// Most contacts with pictures, in the plane and in space.
const PICTURED: [usize; 2] = [12, 6];

/// The nodes of more contacts than this are listed out of sight together.
const MOST_LISTS: usize = 12;

/// With more contact nodes than this they are listed only in `contact.csv`.
const MOST_ROWS: usize = 600;

/// The forces of the contacts, with a figure for each.
pub fn contacts<const D: usize>(
    solution: &Solution<D>,
    figures: &Figures<'_>,
    labels: &Labels,
) -> Markup {
    if solution.contacts.is_empty() {
        return Markup::default();
    }
    let mut out = markup!("<h2>Contact</h2>\n");
    let (extent, unit) = labels.extent();
    let angles: Vec<Option<f64>> = solution.contacts.iter().map(opening_angle).collect();
    let gapes = angles.iter().any(Option::is_some);
    let rows = solution
        .contacts
        .iter()
        .zip(&angles)
        .map(|(c, angle)| {
            let (closed, open) = closed_and_open(&c.nodes);
            let mut row = vec![
                text(&c.name),
                plain(format!("{} / {}", count(closed), count(open))),
                plain(number(c.length)),
                plain(pressures(c)),
                plain(number(largest_gap(&c.nodes))),
                plain(
                    match without_noise(max_penetration(&c.nodes), length_scale(c.nodes.iter())) {
                        0.0 => "0".to_string(),
                        depth => power(depth),
                    },
                ),
                plain(vector(&c.resultant, "")),
            ];
            if gapes {
                row.push(plain(angle.map_or("–".to_string(), number)));
            }
            row
        })
        .collect();
    let mut heads = vec![
        left("contact"),
        column("nodes closed / open", ""),
        column(&format!("{extent} in contact"), unit),
        column("pressure where it touches", &labels.stress),
        column("largest gap", &labels.length),
        column("penetration", &labels.length),
        column("force on the first side", &labels.force),
    ];
    heads.extend(gapes.then(|| column("opening angle", "rad")));
    out += table(&heads, rows);
    let open: Vec<&str> = solution
        .contacts
        .iter()
        .filter(|contact| !touches(contact))
        .map(|contact| contact.name.as_str())
        .collect();
    if !open.is_empty() {
        out += markup!(
            "<p>Open everywhere, and not drawn: {}.</p>\n",
            open.join(", ")
        );
    }
    let most = if D == 3 { PICTURED[1] } else { PICTURED[0] };
    let drawn = bearing_most(solution, most);
    let left = solution.contacts.len() - open.len() - drawn.len();
    if left > 0 && !drawn.is_empty() {
        out += markup!(
            "<p>Pictures show the {} contacts that bear most, tied ones last; of the other {} the table tells, and contact.csv.</p>\n",
            count(drawn.len()),
            count(left)
        );
    }
    let drawn = drawn
        .into_iter()
        .map(|index| figures.contact(solution, index));
    out + drawn.collect()
}

/// At least one of its nodes touches.
fn touches<const D: usize>(contact: &ContactSolution<D>) -> bool {
    contact.nodes.iter().any(|node| in_contact(node.status))
}

/// Indices of at most this many contacts that touch: those that are not tied and bear most; in their order.
fn bearing_most<const D: usize>(solution: &Solution<D>, most: usize) -> Vec<usize> {
    let contacts = &solution.contacts;
    let mut list: Vec<usize> = (0..contacts.len())
        .filter(|&i| touches(&contacts[i]))
        .collect();
    let tied = |i: usize| {
        let first = contacts[i].nodes.first();
        first.is_some_and(|node| node.status == Status::Tied)
    };
    let force = |i: usize| norm(contacts[i].resultant);
    list.sort_by(|&a, &b| tied(a).cmp(&tied(b)).then(force(b).total_cmp(&force(a))));
    list.truncate(most);
    list.sort_unstable();
    list
}

/// A side is flat if its normals differ by at most this.
const FLAT_PICTURE: f64 = 1e-6;

/// The angle by which a flat joint between two bodies of the plane gapes: the slope of its gap, by least squares, where it is
/// open; `None` for a joint that is closed, or open everywhere.
fn opening_angle<const D: usize>(contact: &ContactSolution<D>) -> Option<f64> {
    let known = contact.nodes.iter().filter(|node| node.gap.is_finite());
    let known: Vec<_> = known.collect();
    let first = known.first()?.normal;
    let flat = |node: &&ContactNode<D>| norm(sub(node.normal, first)) <= FLAT_PICTURE;
    let (closed, open) = closed_and_open(&contact.nodes);
    if D != 2 || contact.mortar.is_none() || closed == 0 || open < 2 || !known.iter().all(flat) {
        return None;
    }
    let open: Vec<_> = known
        .into_iter()
        .filter(|n| n.status == Status::Open)
        .collect();
    // along the side, which a normal of the plane is turned into
    let along = |node: &ContactNode<D>| node.point[1] * first[0] - node.point[0] * first[1];
    let mean = |of: &dyn Fn(&ContactNode<D>) -> f64| {
        open.iter().map(|node| of(node)).sum::<f64>() / open.len() as f64
    };
    let (centre, gap) = (mean(&along), mean(&|node| node.gap));
    let (mut slope, mut spread) = (0.0, 0.0);
    for node in &open {
        let s = along(node) - centre;
        slope += s * (node.gap - gap);
        spread += s * s;
    }
    (spread > 0.0).then(|| (slope / spread).abs())
}

/// The least and the largest pressure of closed nodes.
fn pressures<const D: usize>(contact: &ContactSolution<D>) -> String {
    let touching = contact.nodes.iter().filter(|n| in_contact(n.status));
    let most = largest(touching.clone().map(|n| n.pressure));
    let [low, high] = range(touching.map(|n| without_noise(n.pressure, most)));
    match low < high {
        true => format!("{} … {}", number(low), number(high)),
        // one node or no node
        false => number(if high.is_finite() { high } else { 0.0 }),
    }
}

/// Reactions, forces of the contacts and loads on each body.
pub fn balance<const D: usize>(
    model: &Model<D>,
    solution: &Solution<D>,
    labels: &Labels,
) -> Markup {
    let forces: Vec<(Point<D>, Point<D>)> = solution
        .bodies
        .iter()
        .enumerate()
        .map(|(i, body)| (body.reaction, contact_force(solution, i)))
        .collect();
    let scale = largest(forces.iter().flat_map(|(a, b)| [norm(*a), norm(*b)]));
    let axial = model.analysis == Analysis::Axisymmetric;
    let rows = solution
        .bodies
        .iter()
        .zip(&forces)
        .map(|(body, (reaction, contact))| {
            let rest: Point<D> = std::array::from_fn(|k| -(reaction[k] + contact[k]));
            // radial forces balance over the full turn
            let force = |f: &Point<D>| match axial {
                true => plain(number(without_noise(f[1], scale))),
                false => plain(vector_on(f, scale, "")),
            };
            vec![
                text(&body.name),
                force(reaction),
                force(contact),
                force(&rest),
            ]
        })
        .collect();
    let springs = model.bodies.iter().any(|body| !body.springs.is_empty());
    let held = match springs {
        true => "reaction of its supports and springs",
        false => "reaction of its supports",
    };
    let members = solution.members_by_kind();
    let members = members.map(|(kind, _)| kind.apart_plural);
    let touching: Vec<&str> = ["contacts"].into_iter().chain(members).collect();
    let touching = format!("force of its {}", listed(&touching, "and"));
    let heads = [
        left("body"),
        column(held, &labels.force),
        column(&touching, &labels.force),
        column("applied load, by balance", &labels.force),
    ];
    let out = markup!(
        "<h2>Reactions and balance</h2>\n<p>Forces ON each body, {}. The three add up to zero; what is below 10⁻¹⁰ of the largest is shown as 0.</p>\n{}",
        match axial {
            true => "along the axis z, for the full turn".to_string(),
            false => format!("as ({})", labels.axes.join(", ")),
        },
        table(&heads, rows)
    );
    let c = &solution.certificate;
    let worst = solution
        .contacts
        .iter()
        .max_by(|a, b| a.imbalance.total_cmp(&b.imbalance));
    let action = worst.map_or(String::new(), |contact| {
        format!(
            " Action and reaction across a contact differ at most by {} (relative), in {}.",
            power(contact.imbalance),
            contact.name
        )
    });
    out + markup!(
        "<p>What is left over on the worst body: force {}, moment {} (relative {} and {}).{}</p>\n",
        quantity(c.imbalance_force.value, &labels.force),
        quantity(c.imbalance_moment.value, &labels.energy),
        power(c.imbalance_force.relative),
        power(c.imbalance_moment.relative),
        action,
    )
}

/// Force of all contacts ON a body.
fn contact_force<const D: usize>(solution: &Solution<D>, body: usize) -> Point<D> {
    let mut force: Point<D> = [0.0; D];
    for contact in &solution.contacts {
        let sign = contact.sign();
        if contact.nonmortar.body.0 == body {
            force = add_scaled(force, sign, contact.resultant);
        }
        if contact.mortar.as_ref().is_some_and(|m| m.body.0 == body) {
            force = add_scaled(force, -sign, contact.resultant);
        }
    }
    let members = solution.bodies[body].member_forces.values();
    members.fold(force, |sum, &pull| add_scaled(sum, 1.0, pull))
}

/// Gap, pressure and state of every contact node.
pub fn contact_nodes<const D: usize>(solution: &Solution<D>, labels: &Labels) -> Markup {
    if solution.contacts.is_empty() {
        return Markup::default();
    }
    let many = solution.contacts.len() > MOST_LISTS;
    let mut out = Markup::default();
    for contact in &solution.contacts {
        if contact.nodes.len() > MOST_ROWS {
            out += markup!(
                "<p>Contact {}: {} nodes, listed in contact.csv.</p>\n",
                contact.name,
                count(contact.nodes.len())
            );
            continue;
        }
        let shear = contact.nodes.iter().any(|n| norm(n.shear) > 0.0);
        let mut heads = vec![column("node", "")];
        let axes = labels.axes.iter();
        heads.extend(axes.map(|axis| column(axis, &labels.length)));
        heads.push(column("weight", ""));
        heads.push(column("gap", &labels.length));
        heads.push(column("pressure", &labels.stress));
        if shear {
            heads.push(column("shear", &labels.stress));
        }
        heads.push(column("status", ""));
        let rows = contact
            .nodes
            .iter()
            .map(|n| {
                let mut row = vec![plain(n.node.to_string())];
                row.extend(n.point.map(|x| plain(number(x))));
                row.extend([n.weight, n.gap, n.pressure].map(|x| plain(number(x))));
                if shear {
                    row.push(plain(match D {
                        2 => number(along_tangent(n.shear, n.normal)),
                        _ => vector(&n.shear, ""),
                    }));
                }
                let status = n.status.name();
                row.push(marked(match in_contact(n.status) {
                    true => markup!("<b>{}</b>", status),
                    false => markup!("{}", status),
                }));
                row
            })
            .collect();
        out += markup!(
            "<details{}>\n<summary>{}: {} nodes</summary>\n{}</details>\n",
            match contact.nodes.len() <= 12 && touches(contact) && !many {
                true => " open",
                false => "",
            },
            contact.name,
            count(contact.nodes.len()),
            table(&heads, rows)
        );
    }
    let head = markup!("<h2>Contact nodes</h2>\n");
    match many {
        true => {
            let all = count(solution.contacts.len());
            head + markup!(
                "<details>\n<summary>{} contacts</summary>\n{}</details>\n",
                all,
                out
            )
        }
        false => head + out,
    }
}
