//! Numbers in columns of fixed width, as CalculiX prints them: `%12.5E` of C in the `.frd`,
//! `1pE13.6` and `E14.7` of Fortran in the `.dat`.

use std::io::Write;

/// Appends `value` with one digit before the point: `1pEw.d` of Fortran, `%w.dE` of C.
///
/// An exponent of three digits takes the place of the `E`, by the rule of Fortran (`1.0-130`).
/// Needs `width >= decimals + 7`.
pub(crate) fn scientific(line: &mut Vec<u8>, value: f64, width: usize, decimals: usize) {
    if !value.is_finite() {
        return not_finite(line, value, width);
    }
    let number = significand(value.abs(), decimals);
    column(line, [width, decimals], value.is_sign_negative(), number);
}

/// Appends `value` with a zero before the point: `Ew.d` of Fortran.
pub(crate) fn fraction(line: &mut Vec<u8>, value: f64, width: usize, decimals: usize) {
    if !value.is_finite() {
        return not_finite(line, value, width);
    }
    let (digits, exponent) = significand(value.abs(), decimals - 1);
    let exponent = if digits == 0 { 0 } else { exponent + 1 };
    column(
        line,
        [width, decimals],
        value.is_sign_negative(),
        (digits, exponent),
    );
}

/// Appends `NaN`, `Infinity` or `-Infinity` as Fortran does.
fn not_finite(line: &mut Vec<u8>, value: f64, width: usize) {
    let text = if value.is_nan() {
        "NaN"
    } else if value > 0.0 {
        "Infinity"
    } else {
        "-Infinity"
    };
    line.resize(line.len() + width - text.len(), b' ');
    line.extend_from_slice(text.as_bytes());
}

/// Appends one column: `digits` are the digits of the mantissa without its point.
fn column(
    line: &mut Vec<u8>,
    [width, decimals]: [usize; 2],
    negative: bool,
    (mut digits, exponent): (u64, i32),
) {
    let start = line.len();
    line.resize(start + width, b' ');
    let field = &mut line[start..];
    let power = exponent.unsigned_abs();
    let sign = if exponent < 0 { b'-' } else { b'+' };
    let [hundreds, tens, ones] = [power / 100, power / 10 % 10, power % 10].map(digit);
    let mark = if power < 100 {
        [b'E', sign]
    } else {
        [sign, hundreds]
    };
    field[width - 4..].copy_from_slice(&[mark[0], mark[1], tens, ones]);
    let point = width - 5 - decimals;
    for place in field[point + 1..width - 4].iter_mut().rev() {
        *place = digit((digits % 10) as u32);
        digits /= 10;
    }
    field[point] = b'.';
    field[point - 1] = digit(digits as u32);
    if negative {
        field[point - 2] = b'-';
    }
}

/// The character of a digit 0 to 9.
fn digit(value: u32) -> u8 {
    b'0' + value as u8
}

/// The first `decimals + 1` digits of `value >= 0`, correctly rounded, and its exponent of ten.
///
/// Scaling in double precision decides all but what lies close to half a unit of the last digit;
/// those few, and the extremes, go to the exact (and slow) formatter of the standard library.
fn significand(value: f64, decimals: usize) -> (u64, i32) {
    if value == 0.0 {
        return (0, 0);
    }
    let lowest = 10_u64.pow(decimals as u32);
    // 2^n is 10^(0.30103 n): the exponent of ten is the one below that, or the next
    let binary = (value.to_bits() >> 52) as i32 - 1023;
    let guess = (30_103 * binary).div_euclid(100_000);
    if guess.abs() < 200 {
        for exponent in [guess, guess + 1] {
            let scaled = value * 10.0_f64.powi(decimals as i32 - exponent);
            let whole = scaled as u64;
            let part = scaled - whole as f64;
            let digits = whole + u64::from(part > 0.5);
            if (lowest..10 * lowest).contains(&digits) {
                if (part - 0.5).abs() > 1e-5 {
                    return (digits, exponent);
                }
                break;
            }
        }
    }
    significand_exact(value, decimals)
}

/// As [`significand`], by the formatter of the standard library.
fn significand_exact(value: f64, decimals: usize) -> (u64, i32) {
    let mut text = [0_u8; 32];
    let mut rest = &mut text[..];
    write!(rest, "{value:.decimals$e}").expect("a number of at most 17 digits fits");
    let length = 32 - rest.len();
    let mut digits = 0;
    let mut bytes = text[..length].iter();
    for byte in bytes.by_ref().take_while(|byte| **byte != b'e') {
        if byte.is_ascii_digit() {
            digits = 10 * digits + u64::from(byte - b'0');
        }
    }
    let negative = bytes.as_slice().first() == Some(&b'-');
    let power = bytes
        .filter(|byte| byte.is_ascii_digit())
        .fold(0, |power, byte| 10 * power + i32::from(byte - b'0'));
    (digits, if negative { -power } else { power })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(value: f64) -> String {
        let mut line = Vec::new();
        scientific(&mut line, value, 12, 5);
        line.push(b'|');
        scientific(&mut line, value, 13, 6);
        line.push(b'|');
        fraction(&mut line, value, 14, 7);
        String::from_utf8(line).unwrap()
    }

    /// The second column of each number is what ccx 2.20 printed for it in a `.dat`.
    #[test]
    fn prints_as_c_and_fortran() {
        assert_eq!(shown(0.0), " 0.00000E+00| 0.000000E+00| 0.0000000E+00");
        assert_eq!(shown(1.0), " 1.00000E+00| 1.000000E+00| 0.1000000E+01");
        assert_eq!(
            shown(-1407.895),
            "-1.40789E+03|-1.407895E+03|-0.1407895E+04"
        );
        assert_eq!(
            shown(9.9999996),
            " 1.00000E+01| 1.000000E+01| 0.1000000E+02"
        );
        assert_eq!(shown(-2.5e-17), "-2.50000E-17|-2.500000E-17|-0.2500000E-16");
        assert_eq!(
            shown(8.012_820_513e113),
            " 8.01282+113| 8.012821+113| 0.8012821+114"
        );
        assert_eq!(shown(-1e-130), "-1.00000-130|-1.000000-130|-0.1000000-129");
        assert_eq!(shown(f64::NAN), "         NaN|          NaN|           NaN");
        assert_eq!(
            shown(f64::NEG_INFINITY),
            "   -Infinity|    -Infinity|     -Infinity"
        );
    }

    /// A tie goes to the even digit, as in the C library.
    #[test]
    fn rounds_ties_to_even() {
        assert_eq!(&shown(100_000.5)[..12], " 1.00000E+05");
        assert_eq!(&shown(100_001.5)[..12], " 1.00002E+05");
        assert_eq!(&shown(100_002.5)[..12], " 1.00002E+05");
        assert_eq!(&shown(999_999.5)[..12], " 1.00000E+06");
        assert_eq!(&shown(999_999.499_999)[..12], " 9.99999E+05");
    }

    #[test]
    fn scaling_agrees_with_the_exact_formatter() {
        let mut state = 12_345_u64;
        for _ in 0..200_000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let value = f64::from_bits(state >> 1);
            if value.is_finite() && value > 0.0 {
                assert_eq!(
                    significand(value, 5),
                    significand_exact(value, 5),
                    "{value:e}"
                );
            }
            let power = (state >> 20) as i32 % 40 - 20;
            let value = (state >> 40) as f64 * 10.0_f64.powi(power) + 1e-30;
            assert_eq!(
                significand(value, 6),
                significand_exact(value, 6),
                "{value:e}"
            );
        }
        for power in -320..308 {
            let value: f64 = format!("1e{power}").parse().unwrap();
            assert_eq!(
                significand(value, 6),
                significand_exact(value, 6),
                "{value:e}"
            );
        }
    }
}
