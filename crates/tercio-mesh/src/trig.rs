//! Trigonometry, logarithms and powers with the same bits on every platform.
//!
//! `f64::sin` and similar functions come from the platform's mathematical library and differ in the last bit from one
//! to the next, which would make a picture depend on the machine. These use only `+ - * /` and `sqrt`, which IEEE 754
//! defines exactly. The absolute error is below 1e-15 for angles up to a few thousand turns.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Pi/2 as a sum of three parts, the first two of 33 bits, so that multiples of them by small whole numbers
/// are exact (Cody and Waite 1980).
const HALF_PI: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    2.022_266_248_795_950_6e-21,
];

/// Horner's scheme, the coefficient of the highest power first.
#[inline(always)]
fn polynomial<const N: usize>(x: f64, coefficients: &[f64; N]) -> f64 {
    let mut sum = 0.0;
    for &c in coefficients {
        sum = sum * x + c;
    }
    sum
}

/// 1 / n!
const fn inverse_factorial(n: u32) -> f64 {
    let (mut product, mut k) = (1.0, 2);
    while k <= n {
        product *= k as f64;
        k += 1;
    }
    1.0 / product
}

/// Sine and cosine of an angle in radians, of magnitude up to 1e6; NaN for non-finite angles.
#[inline]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    const fn series<const N: usize>(highest: u32) -> [f64; N] {
        let mut c = [0.0; N];
        let mut i = 0;
        while i < N {
            let power = highest - 2 * i as u32;
            let sign = if power / 2 % 2 == 1 { -1.0 } else { 1.0 };
            c[i] = sign * inverse_factorial(power);
            i += 1;
        }
        c
    }
    const SIN: [f64; 8] = series(17);
    const COS: [f64; 8] = series(18);

    let turns = angle * (1.0 / FRAC_PI_2);
    // Round to nearest, halves up: `floor` is exact everywhere.
    let quarter = (turns + 0.5).floor();
    let x = ((angle - quarter * HALF_PI[0]) - quarter * HALF_PI[1]) - quarter * HALF_PI[2];
    let x2 = x * x;
    let s = x + x * x2 * polynomial(x2, &SIN);
    let c = (1.0 - 0.5 * x2) + x2 * x2 * polynomial(x2, &COS);
    match quarter as i64 & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Sine and cosine of an angle in degrees, exact at quarter turns, so that named views look exactly along the axes.
pub fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turned = degrees.rem_euclid(360.0);
    if turned == 0.0 {
        (0.0, 1.0)
    } else if turned == 90.0 {
        (1.0, 0.0)
    } else if turned == 180.0 {
        (0.0, -1.0)
    } else if turned == 270.0 {
        (-1.0, 0.0)
    } else {
        sin_cos(turned.to_radians())
    }
}

/// The angle of the vector (x, y) to the x axis, -pi to pi; 0 for the zero vector.
pub fn atan2(y: f64, x: f64) -> f64 {
    let (ay, ax) = (y.abs(), x.abs());
    let (small, large) = if ay < ax { (ay, ax) } else { (ax, ay) };
    if large == 0.0 {
        return 0.0;
    }
    let octant = atan_unit(small / large);
    let quadrant = if ay < ax { octant } else { FRAC_PI_2 - octant };
    let half = if x < 0.0 { PI - quadrant } else { quadrant };
    if y < 0.0 { -half } else { half }
}

/// The arc cosine; arguments outside -1 to 1 count as the nearer end.
pub fn acos(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    atan2(((1.0 - x) * (1.0 + x)).sqrt(), x)
}

/// The arc tangent of a number from 0 to 1.
fn atan_unit(t: f64) -> f64 {
    const SERIES: [f64; 14] = {
        let mut c = [0.0; 14];
        let mut i = 0;
        while i < 14 {
            let power = 29 - 2 * i as u32;
            let sign = if power / 2 % 2 == 1 { -1.0 } else { 1.0 };
            c[i] = sign / power as f64;
            i += 1;
        }
        c
    };
    // Reduce the argument by the addition theorem, then by halving the angle, until the series is short.
    let (base, u) = if t > 0.414_213_562_373_095_1 { (FRAC_PI_4, (t - 1.0) / (t + 1.0)) } else { (0.0, t) };
    let w = u / (1.0 + (1.0 + u * u).sqrt());
    let w2 = w * w;
    base + 2.0 * (w + w * w2 * polynomial(w2, &SERIES))
}

/// The arc cosine to 2e-8 absolute, for weights: Abramowitz and Stegun (1964), 4.4.46.
#[inline(always)]
pub fn acos_coarse(x: f64) -> f64 {
    let a = x.abs().min(1.0);
    let p = polynomial(
        a,
        &[
            -0.001_262_491_1,
            0.006_670_090_1,
            -0.017_088_125_6,
            0.030_891_881_0,
            -0.050_174_304_6,
            0.088_978_987_4,
            -0.214_598_801_6,
            1.570_796_305_0,
        ],
    );
    let half = (1.0 - a).sqrt() * p;
    if x < 0.0 { PI - half } else { half }
}

/// The logarithm to base 2; minus infinity for 0, NaN below. The error is below 1e-15 of the result, or of 1 if that is less.
pub fn log2(x: f64) -> f64 {
    if !(x > 0.0 && x < f64::INFINITY) {
        return if x == 0.0 {
            f64::NEG_INFINITY
        } else if x > 0.0 {
            x
        } else {
            f64::NAN
        };
    }
    // Subnormal numbers are brought into the range in which the exponent counts.
    let (x, shift) = if x < f64::MIN_POSITIVE { (x * (1u64 << 54) as f64, -54) } else { (x, 0) };
    let bits = x.to_bits();
    let mut exponent = (bits >> 52) as i32 - 1023 + shift;
    let mut m = f64::from_bits(bits & ((1 << 52) - 1) | 1.0f64.to_bits());
    if m > std::f64::consts::SQRT_2 {
        (m, exponent) = (m * 0.5, exponent + 1);
    }
    // ln m = 2 artanh s, and |s| < 0.1716.
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let mut sum = 0.0;
    for n in (0..12).rev() {
        sum = sum * s2 + 1.0 / f64::from(2 * n + 1);
    }
    f64::from(exponent) + (2.0 * s * sum) * std::f64::consts::LOG2_E
}

/// 2 to the power of a number. The relative error is below 1e-15; what is too small becomes 0.
pub fn exp2(x: f64) -> f64 {
    if x.is_nan() || x >= 1024.0 {
        return if x.is_nan() { x } else { f64::INFINITY };
    } else if x < -1022.0 {
        return 0.0;
    }
    let whole = (x + 0.5).floor();
    let y = (x - whole) * std::f64::consts::LN_2;
    let mut sum = 1.0;
    for n in (1..16).rev() {
        sum = 1.0 + sum * y / f64::from(n);
    }
    // In two steps, because 2^1024 is infinite, and the product may yet be finite.
    (sum * crate::mesh::power_of_two(whole as i32 / 2))
        * crate::mesh::power_of_two(whole as i32 - whole as i32 / 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sines_and_cosines_are_right(a in prop_oneof![-10f64..10.0, -1e4f64..1e4, -1e-3f64..1e-3]) {
            let (s, c) = sin_cos(a);
            prop_assert!((s - a.sin()).abs() < 5e-16 && (c - a.cos()).abs() < 5e-16, "{s} {c}");
        }

        #[test]
        fn arcs_are_right(y in -10f64..10.0, x in -10f64..10.0, c in -1f64..=1.0) {
            prop_assert!((atan2(y, x) - y.atan2(x)).abs() < 1e-15);
            prop_assert!((acos(c) - c.acos()).abs() < 1e-15);
            prop_assert!((acos_coarse(c) - c.acos()).abs() < 3e-8);
        }
    }

    proptest! {
        #[test]
        fn logarithms_and_powers_are_right(x in -1000f64..1000.0, m in 0.5f64..2.0) {
            let power = exp2(x);
            prop_assert!((power / x.exp2() - 1.0).abs() < 1e-15 * (1.0 + x.abs()), "{power}");
            prop_assert!((log2(power) - power.log2()).abs() <= 1e-15 * x.abs().max(1.0));
            prop_assert!((log2(m) - m.log2()).abs() < 1e-15);
        }
    }

    #[test]
    fn logarithms_of_unusual_numbers_are_right() {
        for (x, expected) in [
            (0.0, f64::NEG_INFINITY),
            (f64::INFINITY, f64::INFINITY),
            (1.0, 0.0),
            (8.0, 3.0),
            (5e-324, -1074.0),
        ] {
            assert_eq!(log2(x), expected, "{x}");
        }
        assert!(log2(-1.0).is_nan() && log2(f64::NAN).is_nan() && exp2(f64::NAN).is_nan());
        assert_eq!(
            [exp2(0.0), exp2(10.0), exp2(-1022.0), exp2(1023.0)],
            [1.0, 1024.0, f64::MIN_POSITIVE, 1023f64.exp2()]
        );
        assert_eq!([exp2(1024.0), exp2(-2000.0)], [f64::INFINITY, 0.0]);
        assert!((exp2(1023.75) / 1023.75f64.exp2() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn axes_are_exact() {
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert_eq!(sin_cos(FRAC_PI_2).0, 1.0);
        assert_eq!(sin_cos(PI).1, -1.0);
        assert_eq!(atan2(1.0, 0.0), FRAC_PI_2);
        assert_eq!(atan2(0.0, -1.0), PI);
        assert_eq!(atan2(-2.0, 0.0), -FRAC_PI_2);
        assert_eq!(acos(-2.0), PI);
        assert_eq!(acos(1.0), 0.0);
    }
}
