use proptest::prelude::*;

use super::*;

/// A number is round if it has one or two digits of its own (1, 2 or 5 in the last place) counted from the step's place.
fn check([low, high]: [f64; 2], ticks: &[Tick], most: usize) {
    let labelled: Vec<&Tick> = ticks.iter().filter(|tick| !tick.label.is_empty()).collect();
    assert!(labelled.len() >= 2 && labelled.len() <= most.max(2), "{low} {high} {most}: {ticks:?}");
    for pair in ticks.windows(2) {
        assert!(pair[0].value < pair[1].value, "{low} {high}: {ticks:?}");
    }
    for tick in ticks {
        assert!((low..=high).contains(&tick.value), "{low} {high}: {tick:?}");
    }
    for tick in &labelled {
        let read = number::parse(&tick.label).unwrap_or(f64::NAN);
        let step = (high * 0.5 - low * 0.5) / most as f64;
        let is_end = tick.value == low || tick.value == high;
        let tolerance = if is_end { step } else { (step * 1e-3).max(tick.value.abs() * 1e-15) };
        assert!((read - tick.value).abs() <= tolerance, "{low} {high}: {tick:?} {read}");
    }
    let labels: std::collections::BTreeSet<&str> = labelled.iter().map(|tick| &*tick.label).collect();
    assert_eq!(labels.len(), labelled.len(), "{low} {high}: {ticks:?}");
}

fn labels(ticks: &[Tick]) -> Vec<&str> {
    ticks.iter().map(|tick| &*tick.label).filter(|label| !label.is_empty()).collect()
}

#[test]
fn usual_ranges() {
    let of = |low, high, most| {
        let ticks = linear([low, high], most, NumberFormat::Auto);
        labels(&ticks).join(" ")
    };
    assert_eq!(of(0.0, 1.0, 6), "0.0 0.2 0.4 0.6 0.8 1.0".replace("0.0", "0"));
    assert_eq!(of(-3.2, 7.9, 6), "−2 0 2 4 6");
    assert_eq!(of(273.15, 373.15, 5), "280 300 320 340 360");
    assert_eq!(of(0.0, 3e-7, 4), "0 1×10⁻⁷ 2×10⁻⁷ 3×10⁻⁷");
    assert_eq!(of(0.0, 2.5e9, 6), "0 0.5×10⁹ 1.0×10⁹ 1.5×10⁹ 2.0×10⁹ 2.5×10⁹");
    assert_eq!(of(1e6, 1e6 + 1e-3, 4), "1000000.0000 1000000.0005 1000000.0010");
    assert_eq!(of(1e5, 9e5, 5), "200000 400000 600000 800000");
}

#[test]
fn logarithms() {
    let of = |low, high, most| labels(&logarithmic([low, high], most, NumberFormat::Auto)).join(" ");
    assert_eq!(of(0.01, 1000.0, 8), "0.01 0.1 1 10 100 1000");
    assert_eq!(of(1e-9, 1e3, 5), "10⁻⁹ 10⁻⁶ 10⁻³ 10⁰ 10³");
    assert_eq!(of(1.0, 20.0, 8), "1 2 5 10 20");
    assert_eq!(of(3.1, 3.9, 5), "3.2 3.4 3.6 3.8");
    let symmetric =
        |low, high, most| labels(&symmetric([low, high], 1.0, most, NumberFormat::Auto)).join(" ");
    assert_eq!(symmetric(-100.0, 1000.0, 9), "−100 −10 −1 0 1 10 100 1000");
    assert_eq!(symmetric(-1e6, 1e6, 5), "−10⁶ −10² 0 10² 10⁶");
}

#[test]
fn ends_that_are_rounded_to_f32_have_marks() {
    let range = |low: f32, high: f32| [f64::from(low), f64::from(high)];
    let of = |range: [f64; 2], most| {
        let ticks = linear(range, most, NumberFormat::Auto);
        assert!(ticks.iter().all(|tick| (range[0]..=range[1]).contains(&tick.value)), "{range:?}: {ticks:?}");
        labels(&ticks).join(" ")
    };
    assert_eq!(of(range(0.1, 0.7), 8), "0.1 0.2 0.3 0.4 0.5 0.6 0.7");
    assert_eq!(of(range(-0.7, -0.1), 8), "−0.7 −0.6 −0.5 −0.4 −0.3 −0.2 −0.1");
    assert_eq!(of(range(1000.1, 1000.5), 8), "1000.1 1000.2 1000.3 1000.4 1000.5");
    // What is really outside has no mark.
    assert_eq!(of([0.1001, 0.6999], 8), "0.2 0.3 0.4 0.5 0.6");
    let of = |range: [f64; 2], most| {
        let ticks = logarithmic(range, most, NumberFormat::Auto);
        assert!(ticks.iter().all(|tick| (range[0]..=range[1]).contains(&tick.value)), "{range:?}: {ticks:?}");
        assert!(ticks.windows(2).all(|pair| pair[0].value < pair[1].value), "{range:?}: {ticks:?}");
        labels(&ticks).join(" ")
    };
    assert_eq!(of(range(0.001, 10.0), 8), "0.001 0.01 0.1 1 10");
    assert_eq!(of(range(0.1, 1000.0), 8), "0.1 1 10 100 1000");
    // In f32, 0.01 is a little less, and 0.1 a little more.
    assert_eq!(of(range(1e-5, 0.01), 8), "10⁻⁵ 10⁻⁴ 10⁻³ 10⁻²");
    assert_eq!(of([0.00101, 9.99], 8), "0.01 0.1 1");
    let ticks = symmetric(range(-0.1, 0.01), 1e-3, 9, NumberFormat::Auto);
    assert_eq!(labels(&ticks).join(" "), "−0.1 −0.01 −0.001 0 0.001 0.01");
}

#[test]
fn ends_of_what_f64_can_represent() {
    for range in [
        [1e-300, 2e-300],
        [-1e300, 1e300],
        [-f64::MAX, f64::MAX],
        [0.0, f64::MAX],
        [0.0, f64::from_bits(1)],
        [1.0, 1.0 + f64::EPSILON],
        [1e6, 1e6 + 1e-3],
        [-1e6 - 1e-3, -1e6],
        [1e15, 1e15 + 1.0],
        [-1e-300, 1e-300],
        [0.0, 5e-324 * 100.0],
    ] {
        for most in [1, 2, 3, 5, 12] {
            let ticks = linear(range, most, NumberFormat::Auto);
            assert!(ticks.len() >= 2 && ticks.len() <= most.max(2), "{range:?} {most} {ticks:?}");
            assert!(ticks.iter().all(|t| (range[0]..=range[1]).contains(&t.value)), "{range:?} {ticks:?}");
            let labels: Vec<_> = ticks.iter().map(|t| &t.label).collect();
            assert_ne!(labels[0], labels[1], "{range:?}");
        }
    }
    assert!(logarithmic([1e-300, 1e300], 5, NumberFormat::Auto).len() >= 2);
    assert!(logarithmic([f64::from_bits(1), f64::MAX], 5, NumberFormat::Auto).len() >= 2);
    assert!(symmetric([-1e300, 1e300], 1e-300, 5, NumberFormat::Auto).len() >= 2);
}

proptest! {
    #[test]
    fn marks_are_round_numbers_in_the_range(
        middle in -1.0f64..1.0, size in -30i32..30, span in -8i32..9, most in 2usize..14, share in 0.1f64..1.0,
    ) {
        let scale: f64 = format!("1e{size}").parse().unwrap();
        let span: f64 = format!("1e{span}").parse().unwrap();
        let low = middle * scale;
        let high = low + span * scale * share;
        prop_assume!((high - low) / low.abs().max(high.abs()) > 1e-10);
        check([low, high], &linear([low, high], most, NumberFormat::Auto), most);
        let (low, high) = (middle.abs().max(1e-3) * scale, middle.abs().max(1e-3) * scale * (1.0 + span * share));
        prop_assume!((high - low) / high > 1e-10);
        check([low, high], &logarithmic([low, high], most, NumberFormat::Auto), most);
        let threshold = scale * 1e-3 * share;
        check([-low, high], &symmetric([-low, high], threshold, most, NumberFormat::Auto), most);
    }
}
