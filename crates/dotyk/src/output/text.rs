//! Numbers, units and names for readers: four significant digits, thin spaces, true minus signs.
//!
//! Invariant: the same number gives the same text on every machine; a number that is not finite gives a dash.

use crate::geometry::norm;
use crate::model::{Analysis, Dimension, Model, Peak, Solution, Units};

/// Names of Cartesian axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Thin space that does not break.
pub const THIN: char = '\u{202f}';

/// Significant digits of every number in the report.
const DIGITS: i32 = 4;

/// A number with four significant digits: `1 234`, `−0.012 34` without inner spaces, `3.142 × 10⁻⁷` outside [1e-3, 1e6).
pub fn number(value: f64) -> String {
    if value == f64::INFINITY {
        return "∞".to_string();
    }
    if !value.is_finite() {
        return "–".to_string();
    }
    if value == 0.0 {
        return "0".to_string();
    }
    let scientific = format!("{:.*e}", DIGITS as usize - 1, value.abs());
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if value < 0.0 { "−" } else { "" };
    if (-3..6).contains(&exponent) {
        let decimals = (DIGITS - 1 - exponent).max(0) as usize;
        let rounded: f64 = scientific.parse().unwrap_or(value.abs());
        let fixed = format!("{rounded:.decimals$}");
        return format!("{sign}{}", grouped(trimmed(&fixed)));
    }
    format!(
        "{sign}{}{THIN}×{THIN}10{}",
        trimmed(mantissa),
        superscript(exponent)
    )
}

/// A small or large figure such as a residual: two significant digits and a power of ten.
pub fn power(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_string();
    }
    if value == 0.0 {
        return "0".to_string();
    }
    let scientific = format!("{value:.1e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let mantissa = mantissa.replace('-', "−");
    match trimmed(&mantissa) {
        "1" => format!("10{}", superscript(exponent)),
        other => format!("{other}{THIN}×{THIN}10{}", superscript(exponent)),
    }
}

/// A count with thin spaces between thousands.
pub fn count(value: usize) -> String {
    grouped(&value.to_string())
}

/// Seconds with a sensible number of digits.
pub fn seconds(value: f64) -> String {
    if !value.is_finite() {
        "–".to_string()
    } else if value < 0.1 {
        format!("{:.1}{THIN}ms", value * 1e3)
    } else {
        format!("{value:.2}{THIN}s")
    }
}

/// Integer exponent in raised digits.
pub fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32('⁰' as u32 + (digit as u32 - '0' as u32)).unwrap_or(digit),
        })
        .collect()
}

/// Removes trailing zeros after the decimal point.
fn trimmed(fixed: &str) -> &str {
    if fixed.contains('.') {
        fixed.trim_end_matches('0').trim_end_matches('.')
    } else {
        fixed
    }
}

/// Thin spaces between thousands of the integer part, from five digits on.
fn grouped(fixed: &str) -> String {
    let (whole, rest) = match fixed.find('.') {
        Some(dot) => fixed.split_at(dot),
        None => (fixed, ""),
    };
    if whole.len() < 5 {
        return fixed.to_string();
    }
    let mut out = String::new();
    for (i, c) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) {
            out.push(THIN);
        }
        out.push(c);
    }
    out + rest
}

/// Labels of the quantities of a model; empty without a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    /// Length.
    pub length: String,
    /// Force.
    pub force: String,
    /// Force per area.
    pub stress: String,
    /// Force per volume.
    pub density: String,
    /// Force times length.
    pub energy: String,
    /// Length times length.
    pub area: String,
    /// Force per length.
    pub per_length: String,
    /// Moment per length.
    pub moment_per_length: String,
    /// Names of the axes, one for each dimension.
    pub axes: &'static [&'static str],
}

impl Labels {
    /// Labels of a model.
    pub fn of<const D: usize>(model: &Model<D>) -> Self {
        Self::new(
            &model.units,
            match model.analysis {
                Analysis::Axisymmetric => &["r", "z"],
                _ => &AXES[..D],
            },
        )
    }

    /// Labels in these units, with these names of axes.
    pub fn new(units: &Units, axes: &'static [&'static str]) -> Self {
        let length = units.length.clone().unwrap_or_default();
        let force = units.force.clone().unwrap_or_default();
        let both = !length.is_empty() && !force.is_empty();
        let join = |text: String| if both { text } else { String::new() };
        Self {
            stress: join(format!("{force}/{length}²")),
            density: join(format!("{force}/{length}³")),
            energy: join(format!("{force}{THIN}{length}")),
            per_length: join(format!("{force}/{length}")),
            moment_per_length: join(format!("{force}{THIN}{length}/{length}")),
            area: match length.is_empty() {
                true => String::new(),
                false => format!("{length}²"),
            },
            axes,
            length,
            force,
        }
    }

    /// Label of the extent of a contact, with the unit.
    pub fn extent(&self) -> (&'static str, &str) {
        match self.axes.len() {
            3 => ("area", &self.area),
            _ => ("length", &self.length),
        }
    }

    /// Label of the extent of a part of a body, with the unit.
    pub fn interior(&self) -> (&'static str, String) {
        let (word, power) = match self.axes.len() {
            3 => ("volume", '³'),
            _ => ("area", '²'),
        };
        let unit = match self.length.is_empty() {
            true => String::new(),
            false => format!("{}{power}", self.length),
        };
        (word, unit)
    }

    /// The closed part of a contact, in words.
    pub fn in_contact(&self) -> &'static str {
        match self.axes.len() {
            3 => "Area in contact",
            _ => "Length in contact",
        }
    }

    /// The unit label of a quantity.
    pub fn unit(&self, dimension: Dimension) -> &str {
        match dimension {
            Dimension::Length => &self.length,
            Dimension::Area => &self.area,
            Dimension::Moment | Dimension::Energy => &self.energy,
            Dimension::Angle => "rad",
            Dimension::Force => &self.force,
            Dimension::Stress => &self.stress,
            Dimension::ForcePerLength => &self.per_length,
            Dimension::MomentPerLength => &self.moment_per_length,
            Dimension::Ratio | Dimension::Other => "",
        }
    }
}

/// A number and its unit.
pub fn quantity(value: f64, unit: &str) -> String {
    if unit.is_empty() || !value.is_finite() {
        number(value)
    } else {
        format!("{}{THIN}{unit}", number(value))
    }
}

/// A value, or zero where it is a rounding error on this scale.
pub fn without_noise(value: f64, scale: f64) -> f64 {
    const NOISE: f64 = 1e-10;
    if value.abs() < NOISE * scale {
        0.0
    } else {
        value
    }
}

/// Scales of the numbers of a solution; values far below them are rounding, and shown as zero.
pub struct Scales {
    force: f64,
    stress: f64,
    length: f64,
    /// Of contacts from the origin.
    reach: f64,
}

impl Scales {
    /// The largest sum of forces on a side, of the supports of a body or of loads, stress and displacement. Loads that balance
    /// themselves have no resultant: their size is told by their work, twice the elastic energy, over the largest displacement.
    pub fn of<const D: usize>(solution: &Solution<D>) -> Self {
        let nodes = solution.contacts.iter().map(|contact| contact.nodes.iter());
        let pressed = nodes.map(|nodes| {
            let forces = nodes.map(|node| (node.pressure * node.weight).abs());
            forces.filter(|force| force.is_finite()).sum::<f64>()
        });
        let nodes = solution.contacts.iter().flat_map(|c| &c.nodes);
        let reach = nodes.map(|node| norm(node.point)).fold(0.0, f64::max);
        let bodies = || solution.bodies.iter();
        let held = bodies().map(|body| body.reactions.iter().map(|f| norm(*f)).sum());
        let coupled = bodies().flat_map(|body| body.couples.iter().map(|c| norm(c.force)));
        let loaded = bodies().map(|body| 2.0 * body.strain_energy / body.max_displacement());
        let loaded = loaded.filter(|force| force.is_finite());
        let stresses = bodies().flat_map(|body| body.stress.as_flattened());
        let touching = solution.contacts.iter().flat_map(|contact| &contact.nodes);
        let beds = solution.beds.iter().flat_map(|bed| &bed.points);
        let pressures = touching.map(|node| node.pressure);
        let pressures = pressures.chain(beds.map(|at| at.pressure));
        let moved = bodies().flat_map(|body| body.displacement.iter().map(|u| norm(*u)));
        Self {
            force: pressed
                .chain(held)
                .chain(coupled)
                .chain(loaded)
                .fold(0.0, f64::max),
            stress: stresses
                .copied()
                .chain(pressures.filter(|p| p.is_finite()))
                .fold(0.0, |most, s| most.max(s.abs())),
            length: moved.fold(0.0, f64::max),
            reach,
        }
    }

    /// A place; coordinates that are rounding errors of those of the contacts are zero.
    pub fn place(&self, at: &[f64]) -> String {
        vector_on(at, self.reach, "")
    }

    /// A value, or zero where it is rounding.
    pub fn without_noise(&self, value: f64, dimension: Dimension) -> f64 {
        let scale = match dimension {
            Dimension::Force => self.force,
            Dimension::Stress => self.stress,
            Dimension::Length => self.length,
            Dimension::Moment => self.force * self.reach,
            // 1 is failure
            Dimension::Ratio => 1.0,
            Dimension::ForcePerLength | Dimension::MomentPerLength => 0.0,
            Dimension::Area | Dimension::Energy | Dimension::Angle | Dimension::Other => 0.0,
        };
        without_noise(value, scale)
    }
}

/// A vector and its unit; components that are rounding errors of the largest are zero.
pub fn vector(values: &[f64], unit: &str) -> String {
    vector_on(values, 0.0, unit)
}

/// The same, where rounding errors come from numbers as large as `scale`.
pub fn vector_on(values: &[f64], scale: f64, unit: &str) -> String {
    let scale = values.iter().fold(scale, |s, v| s.max(v.abs()));
    let list: Vec<String> = values
        .iter()
        .map(|&v| number(without_noise(v, scale)))
        .collect();
    let list = format!("({})", list.join(", "));
    if unit.is_empty() {
        list
    } else {
        format!("{list}{THIN}{unit}")
    }
}

/// A name with its unit in brackets, for axes and table heads.
pub fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() {
        name.to_string()
    } else {
        format!("{name} [{unit}]")
    }
}

/// Words on a largest value of a body that is due to the mesh; `None` for one that belongs to the model.
pub fn singular_peak<const D: usize>(
    what: &str,
    peak: Option<Peak<D>>,
    [unit, length]: [&str; 2],
) -> Option<String> {
    let singular = peak?.place?;
    let away = singular.away.map_or(String::new(), |away| {
        format!(
            " Farther than two cells from such places the largest is {}, at {}.",
            quantity(away.value, unit),
            vector(&away.at, length)
        )
    });
    Some(format!(
        "The largest {what} is at {}: it grows as the mesh is refined, and means nothing by itself.{away}",
        singular.place
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_significant_digits() {
        assert_eq!(number(1.79018), "1.79");
        assert_eq!(number(-0.793434), "−0.7934");
        assert_eq!(number(123456.0), "123\u{202f}500");
        assert_eq!(number(9999.6), "10\u{202f}000");
        assert_eq!(number(0.00123456), "0.001235");
        assert_eq!(number(-3.04760e-5), "−3.048\u{202f}×\u{202f}10⁻⁵");
        assert_eq!(number(2.1e11), "2.1\u{202f}×\u{202f}10¹¹");
        assert_eq!(number(0.0), "0");
        assert_eq!(number(f64::NAN), "–");
    }

    #[test]
    fn powers_of_ten_lose_their_one() {
        assert_eq!(power(1e-8), "10⁻⁸");
        assert_eq!(power(2.34e-12), "2.3\u{202f}×\u{202f}10⁻¹²");
    }

    #[test]
    fn counts_are_grouped_from_five_digits_on() {
        assert_eq!(count(1234), "1234");
        assert_eq!(count(1234567), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn rounding_errors_of_a_vector_are_zero() {
        assert_eq!(vector(&[612.0, -1.8e-13], ""), "(612, 0)");
        assert_eq!(
            vector(&[1e-13, 0.0], "N"),
            "(1\u{202f}×\u{202f}10⁻¹³, 0)\u{202f}N"
        );
        assert_eq!(vector_on(&[1e-9, 0.0], 1e6, ""), "(0, 0)");
    }
}
