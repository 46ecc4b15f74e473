//! Colours that stay apart in grey print and for colour-blind readers, and what tells series apart without them.

/// Ten colours, each eight steps of lightness from the next, so that they differ in grey; found by a search for the
/// largest distances as seen with and without colour blindness. Neighbours in this order differ most.
pub(super) const COLORS: [[u8; 3]; 10] = [
    [15, 45, 255],
    [225, 60, 120],
    [135, 210, 0],
    [105, 0, 0],
    [30, 0, 30],
    [165, 165, 195],
    [120, 105, 15],
    [15, 75, 60],
    [225, 90, 225],
    [0, 0, 120],
];

/// Strokes and gaps of the lines of published series, in pixels.
pub(super) const DASHES: [&[f64]; 5] =
    [&[6.0, 4.0], &[2.0, 3.0], &[10.0, 3.0, 2.0, 3.0], &[12.0, 4.0], &[6.0, 3.0, 2.0, 3.0, 2.0, 3.0]];

#[cfg(test)]
mod tests {
    use super::*;

    /// Machado, Oliveira, Fernandes: A Physiologically-based Model for Simulation of Color Vision Deficiency, 2009, full
    /// severity, in linear light.
    const PROTANOPIA: [[f64; 3]; 3] = [
        [0.152_286, 1.052_583, -0.204_868],
        [0.114_503, 0.786_281, 0.099_216],
        [-0.003_882, -0.048_116, 1.051_998],
    ];
    const DEUTERANOPIA: [[f64; 3]; 3] = [
        [0.367_322, 0.860_646, -0.227_968],
        [0.280_085, 0.672_501, 0.047_413],
        [-0.011_820, 0.042_940, 0.968_881],
    ];
    const TRITANOPIA: [[f64; 3]; 3] = [
        [1.255_528, -0.076_749, -0.178_779],
        [-0.078_411, 0.930_809, 0.147_602],
        [0.004_733, 0.691_367, 0.303_900],
    ];
    const PLAIN: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// Linear sRGB to XYZ: IEC 61966-2-1.
    const XYZ: [[f64; 3]; 3] = [
        [0.412_456, 0.357_576, 0.180_437],
        [0.212_673, 0.715_152, 0.072_175],
        [0.019_334, 0.119_192, 0.950_304],
    ];

    fn times(m: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        m.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
    }

    /// CIE L*a*b* of a colour as seen by someone.
    fn lab(color: [u8; 3], seen: [[f64; 3]; 3]) -> [f64; 3] {
        let linear = color.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        let [x, y, z] = times(XYZ, times(seen, linear).map(|c| c.clamp(0.0, 1.0)));
        let f = |t: f64| {
            if t > 216.0 / 24_389.0 { t.cbrt() } else { (24_389.0 / 27.0 * t + 16.0) / 116.0 }
        };
        let [x, y, z] = [f(x / 0.950_47), f(y), f(z / 1.088_83)];
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// The least distance of two of the first `count` colours.
    fn least(count: usize, seen: impl Fn([u8; 3]) -> [f64; 3]) -> f64 {
        let all: Vec<_> = COLORS[..count].iter().map(|&c| seen(c)).collect();
        let distance =
            |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let pairs = (0..count).flat_map(|i| (0..i).map(move |j| (i, j)));
        pairs.map(|(i, j)| distance(&all[i], &all[j])).fold(f64::MAX, f64::min)
    }

    #[test]
    fn colours_are_far_apart_in_grey_and_for_the_colour_blind() {
        let grey = |c| [lab(c, PLAIN)[0], 0.0, 0.0];
        // A difference of 2.3 is just noticeable side by side (Mahy, Van Eycken, Oosterlinck, 1994).
        assert!(least(10, grey) > 3.0 * 2.3, "{}", least(10, grey));
        assert!(least(4, grey) > 14.0, "{}", least(4, grey));
        assert!(least(10, |c| lab(c, PLAIN)) > 40.0);
        for seen in [PROTANOPIA, DEUTERANOPIA, TRITANOPIA] {
            assert!(least(10, |c| lab(c, seen)) > 20.0, "{}", least(10, |c| lab(c, seen)));
        }
        // All can be seen on white.
        assert!(COLORS.iter().all(|&c| lab(c, PLAIN)[0] < 80.0));
    }
}
