//! Sections of the report on contacts: what they transmit, the balance of the bodies, and their nodes.

use crate::geometry::{Point, add_scaled, dot, norm};
use crate::model::{Analysis, Model, Solution};
use crate::output::chain::tangent;
use crate::output::html::{column, escape, figure, left, marked, plain, table, text};
use crate::output::interface::{interface_figure, largest_gap};
use crate::output::json::{closed_and_open, in_contact, largest, max_penetration};
use crate::output::scene::Scene;
use crate::output::text::{
    Labels, count, number, power, quantity, vector, vector_on, without_noise,
};

/// More contact nodes than this are left to `contact.csv`.
const MOST_ROWS: usize = 600;

/// What the contacts transmit, with a figure for each.
pub fn contacts(
    model: &Model<2>,
    solution: &Solution<2>,
    scene: &Scene,
    labels: &Labels,
) -> String {
    if solution.contacts.is_empty() {
        return String::new();
    }
    let mut out = "<h2>Contact</h2>\n".to_string();
    let rows = solution
        .contacts
        .iter()
        .map(|c| {
            let (closed, open) = closed_and_open(&c.nodes);
            vec![
                text(&c.name),
                plain(format!("{} / {}", count(closed), count(open))),
                plain(number(c.length)),
                plain(number(largest(c.nodes.iter().map(|n| n.pressure)))),
                plain(number(largest_gap(&c.nodes))),
                plain(if max_penetration(&c.nodes) == 0.0 {
                    "0".to_string()
                } else {
                    power(max_penetration(&c.nodes))
                }),
                plain(vector(&c.resultant, "")),
            ]
        })
        .collect();
    let heads = [
        left("contact"),
        column("nodes closed / open", ""),
        column("length in contact", &labels.length),
        column("largest pressure", &labels.stress),
        column("largest gap", &labels.length),
        column("penetration", &labels.length),
        column("force on the nonmortar body", &labels.force),
    ];
    out += &table(&heads, rows);
    for (i, (contact, law)) in solution
        .contacts
        .iter()
        .zip(model.contacts.iter().map(|c| &c.law))
        .enumerate()
    {
        let Some(svg) = interface_figure(scene, contact, law, &format!("interface{i}")) else {
            continue;
        };
        let name = |side: &crate::model::SideRef| {
            let body = model
                .bodies
                .get(side.body.0)
                .map_or("?", |b| b.name.as_str());
            format!("{body}.{}", side.side)
        };
        let other = contact
            .mortar
            .as_ref()
            .map_or("a rigid obstacle".to_string(), name);
        let caption = format!(
            "{} against {other}. Pressure is positive in compression, the gap is that after deformation. Arrows: pressure on {}.",
            name(&contact.nonmortar),
            model
                .bodies
                .get(contact.nonmortar.body.0)
                .map_or("the body", |b| b.name.as_str()),
        );
        let title = format!(
            "Contact pressure and gap along the interface {}",
            contact.name
        );
        out += &figure(&svg, &title, &caption);
    }
    out
}

/// Reactions, forces of the contacts and loads on each body.
pub fn balance(model: &Model<2>, solution: &Solution<2>, labels: &Labels) -> String {
    let forces: Vec<(Point<2>, Point<2>)> = solution
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
            let rest: Point<2> = std::array::from_fn(|k| -(reaction[k] + contact[k]));
            // radial forces balance over the full turn
            let force = |f: &Point<2>| match axial {
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
    let heads = [
        left("body"),
        column("reaction of its supports", &labels.force),
        column("force of its contacts", &labels.force),
        column("applied load, by balance", &labels.force),
    ];
    let mut out = format!(
        "<h2>Reactions and balance</h2>\n<p>Forces ON each body, {}. The three add up to zero; what is below 10⁻¹⁰ of the largest is shown as 0.</p>\n{}",
        match axial {
            true => "along the axis z, for the full turn".to_string(),
            false => format!("as ({}, {})", labels.axes[0], labels.axes[1]),
        },
        table(&heads, rows)
    );
    let c = &solution.certificate;
    let sides: Vec<String> = solution
        .contacts
        .iter()
        .map(|k| format!("{} {}", escape(&k.name), power(k.imbalance)))
        .collect();
    let action = if sides.is_empty() {
        String::new()
    } else {
        format!(
            " Action and reaction across the contacts differ by (relative): {}.",
            sides.join(", ")
        )
    };
    out += &format!(
        "<p>What is left over on the worst body: force {}, moment {} (relative {} and {}).{action}</p>\n",
        quantity(c.imbalance_force.value, &labels.force),
        quantity(c.imbalance_moment.value, &labels.energy),
        power(c.imbalance_force.relative),
        power(c.imbalance_moment.relative),
    );
    out
}

/// Force of all contacts ON a body.
fn contact_force(solution: &Solution<2>, body: usize) -> Point<2> {
    let mut force: Point<2> = [0.0; 2];
    for contact in &solution.contacts {
        if contact.nonmortar.body.0 == body {
            force = add_scaled(force, 1.0, contact.resultant);
        }
        if contact.mortar.as_ref().is_some_and(|m| m.body.0 == body) {
            force = add_scaled(force, -1.0, contact.resultant);
        }
    }
    force
}

/// Gap, pressure and state of every contact node.
pub fn contact_nodes(solution: &Solution<2>, labels: &Labels) -> String {
    if solution.contacts.is_empty() {
        return String::new();
    }
    let mut out = "<h2>Contact nodes</h2>\n".to_string();
    for contact in &solution.contacts {
        if contact.nodes.len() > MOST_ROWS {
            out += &format!(
                "<p>Contact {}: {} nodes, listed in contact.csv.</p>\n",
                escape(&contact.name),
                count(contact.nodes.len())
            );
            continue;
        }
        let shear = contact.nodes.iter().any(|n| norm(n.shear) > 0.0);
        let mut heads = vec![
            column("node", ""),
            column(labels.axes[0], &labels.length),
            column(labels.axes[1], &labels.length),
            column("weight", ""),
            column("gap", &labels.length),
            column("pressure", &labels.stress),
        ];
        if shear {
            heads.push(column("shear", &labels.stress));
        }
        heads.push(column("status", ""));
        let rows = contact
            .nodes
            .iter()
            .map(|n| {
                let mut row = vec![
                    plain(n.node.to_string()),
                    plain(number(n.point[0])),
                    plain(number(n.point[1])),
                    plain(number(n.weight)),
                    plain(number(n.gap)),
                    plain(number(n.pressure)),
                ];
                if shear {
                    row.push(plain(number(dot(n.shear, tangent(n.normal)))));
                }
                let status = n.status.name();
                row.push(marked(match in_contact(n.status) {
                    true => format!("<b>{status}</b>"),
                    false => status.to_string(),
                }));
                row
            })
            .collect();
        out += &format!(
            "<details{}>\n<summary>{}: {} nodes</summary>\n{}</details>\n",
            if contact.nodes.len() <= 12 {
                " open"
            } else {
                ""
            },
            escape(&contact.name),
            count(contact.nodes.len()),
            table(&heads, rows)
        );
    }
    out
}
