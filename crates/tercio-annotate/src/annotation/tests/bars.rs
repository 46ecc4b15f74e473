//! Labels of scalar bars and of lists of categories, and the order of several bars.

use super::*;
use crate::layout::TextBlock;

/// Numbers of a scale that is not even do not say what is at its ends: these have numbers of their own, upright and level.
#[test]
fn ends_of_logarithmic_bars_are_told() {
    let symmetric = Scale::SymmetricLog { threshold: 1.0 };
    for (range, scale, ends) in [
        ([0.00123, 7890.0], Scale::Log, ["0.00123", "7890"]),
        ([3.12, 3.91], Scale::Log, ["3.12", "3.91"]),
        ([1e-9, 5e9], Scale::Log, ["10⁻⁹", "5×10⁹"]),
        ([1.0, 1000.0], Scale::Log, ["1", "1000"]),
        ([-345.0, 12.0], symmetric, ["−345", "12"]),
        ([0.0, 4567.0], symmetric, ["0", "4570"]),
        // Numbers of files are rounded to `f32`.
        ([f64::from(1e-5_f32), 1.0], Scale::Log, ["10⁻⁵", "10⁰"]),
        ([f64::from(1e-4_f32), f64::from(1e14_f32)], Scale::Log, ["10⁻⁴", "10¹⁴"]),
    ] {
        for is_upright in [true, false] {
            let bar = ScalarBar { is_upright, ..bar(range, scale) };
            for length in [120.0, 400.0] {
                let ticks = bar.with_room(bar.ticks(9, 9), length, 11.0);
                let labels: Vec<&str> =
                    ticks.iter().map(|tick| &*tick.label).filter(|label| !label.is_empty()).collect();
                assert_eq!([labels.first(), labels.last()], [Some(&ends[0]), Some(&ends[1])], "{range:?}");
                assert!(bar.have_room(&ticks, length, 11.0), "{range:?} {length}: {labels:?}");
                assert_eq!([ticks[0].value, ticks[ticks.len() - 1].value], range);
            }
            let place = Place::named(if is_upright { "right" } else { "bottom" }).expect("a place");
            let annotation = Annotation { bars: vec![ScalarBar { place, ..bar }], ..Annotation::default() };
            assert_eq!(annotation.fixed(640, 480).layout.left_out, Vec::<String>::new(), "{range:?}");
        }
    }
}

/// Borders of bands on scales that are not even: each has the digits that tell it, whatever the others have.
#[test]
fn borders_on_logarithmic_scales_are_told_each_by_itself() {
    let symmetric = Scale::SymmetricLog { threshold: 0.01 };
    for (range, scale, bands, expected) in [
        ([0.00501, 501.19], Scale::Log, 2, "0.00501 1.585 501"),
        ([1e-4, 1e4], Scale::Log, 2, "0.0001 1 10000"),
        ([5.01e-9, 5012.0], Scale::Log, 3, "5.01×10⁻⁹ 5.01×10⁻⁵ 0.501 5010"),
        ([1e-20, 1e20], Scale::Log, 8, "10⁻²⁰ 10⁻¹⁵ 10⁻¹⁰ 10⁻⁵ 1 100000 10¹⁰ 10¹⁵ 10²⁰"),
        ([1000.0, 1010.0], Scale::Log, 2, "1000 1005 1010"),
        ([-100.0, 100.0], symmetric, 2, "−100 0 100"),
        ([-1e8, 1e8], symmetric, 2, "−10⁸ 0 10⁸"),
    ] {
        let mut banded = bar(range, scale);
        banded.colors.bands = Some(bands);
        let labels: Vec<String> = banded.ticks(9, 9).into_iter().map(|tick| tick.label).collect();
        assert_eq!(labels.join(" "), expected, "{range:?}, {bands} bands");
    }
}

/// A mark beside that of an end is left out alone: marks elsewhere stay.
#[test]
fn marks_between_powers_stay_beside_ends() {
    let bar = bar([1.0, 9050.0], Scale::Log);
    let ticks = bar.without_merged(bar.with_room(bar.ticks(9, 9), 400.0, 11.0), 400.0, 11.0);
    assert!(ticks.len() > 30 && !ticks.iter().any(|tick| tick.value == 9000.0), "{ticks:?}");
}

/// Numbers between which others are left out need no digits that tell these apart.
#[test]
fn few_numbers_of_many_bands_have_few_digits() {
    let mut banded = bar([0.0, 1.0], Scale::Linear);
    banded.colors.bands = Some(64);
    let labels = |most: usize| -> String {
        let ticks = banded.ticks(most, most).into_iter().map(|tick| tick.label);
        ticks.filter(|label| !label.is_empty()).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(labels(5), "0 0.25 0.50 0.75 1.00");
    assert_eq!(labels(9), "0 0.125 0.250 0.375 0.500 0.625 0.750 0.875 1.000");
    assert!(labels(64).starts_with("0 0.0312 0.0625"), "{}", labels(64));
}

/// A title that is too long loses words before its unit.
#[test]
fn cut_titles_keep_their_units() {
    let name =
        "a name that is far too long for any bar of a small picture with words and words and more words";
    for width in [60.0, 100.0, 200.0] {
        let block = TextBlock::fit_with_unit(&format!("{name} (kPa)"), 11.0, width, 1);
        let whole = TextBlock::fit_with_unit("p (kPa)", 11.0, width, 1);
        assert!(block.is_cut && block.has_unit && block.size[0] <= width + 1.0, "{width}: {block:?}");
        assert!(!whole.is_cut, "{width}");
    }
    // Where not even the unit has room, and where there is none, the end is cut off as ever.
    assert!(!TextBlock::fit_with_unit(&format!("{name} (kPa)"), 11.0, 20.0, 1).has_unit);
    assert!(!TextBlock::fit_with_unit(name, 11.0, 60.0, 1).has_unit);
    let titled = ScalarBar { title: format!("{} (kPa)", name.repeat(3)), ..bar([-1.0, 2.0], Scale::Linear) };
    let annotation = Annotation { bars: vec![titled], ..Annotation::default() };
    assert_eq!(annotation.fixed(640, 480).layout.left_out, ["a part of the title of bar"]);
}

/// Also where not all of them have room.
#[test]
fn bars_that_have_room_are_in_the_order_of_the_models() {
    let bars =
        (0..9).map(|number| ScalarBar { title: format!("{number}"), ..bar([0.0, 1.0], Scale::Linear) });
    let annotation = Annotation { bars: bars.collect(), ..Annotation::default() };
    let fixed = annotation.fixed(300, 200);
    assert!(!fixed.layout.left_out.is_empty());
    let left = |name: String| fixed.layout.placed.iter().find(|p| p.what == name).map(|p| p.rect[0]);
    let placed: Vec<f64> = (0..9).filter_map(|number| left(bar_name(number))).collect();
    assert!(placed.len() > 1 && placed.is_sorted(), "{placed:?}");
}

/// Bars of several models are in the order of these, at every border.
#[test]
fn bars_are_read_in_the_order_of_the_models() {
    for (name, is_upright) in
        [("right", true), ("left", true), ("bottom", false), ("top", false), ("top-right", true)]
    {
        let place = Place::named(name).expect("a place");
        let of_model = |title: &str| ScalarBar {
            place,
            is_upright,
            title: title.into(),
            ..bar([0.0, 1.0], Scale::Linear)
        };
        let bars = ["first", "second", "third"].map(of_model).to_vec();
        let layout = Annotation { bars, ..Annotation::default() }.fixed(1024, 768).layout;
        let at =
            |what: &str| layout.placed.iter().find(|placed| placed.what == what).expect("it is there").rect;
        for pair in [[at("bar"), at("bar 2")], [at("bar 2"), at("bar 3")]] {
            let k = if is_upright { 0 } else { 1 };
            assert!(pair[0][k + 2] <= pair[1][k], "{name}: {pair:?}");
        }
    }
}

/// A list of categories that is asked for as level has its entries beside each other.
#[test]
fn level_lists_have_entries_beside_each_other() {
    let list = |count: u32, place: &str| {
        let color = [9, 9, 9, 255];
        let entry = |i: u32| Category { value: i.into(), label: format!("label {i}"), color };
        let mut list = bar([0.0, 1.0], Scale::Linear);
        list.colors.categories = (0..count).map(entry).collect();
        (list.is_upright, list.place) = (false, Place::named(place).expect("a place"));
        let annotation = Annotation { bars: vec![list], ..Annotation::default() };
        let layout = annotation.fixed(640, 480).layout;
        (layout.placed.first().map(|placed| placed.rect), layout.left_out)
    };
    for (place, is_level) in [("bottom", true), ("top", true), ("right", false), ("bottom-left", true)] {
        let (rect, left_out) = list(4, place);
        let [left, top, right, bottom] = rect.expect("there is room");
        let [across, down] = [right - left, bottom - top];
        let is_so = if is_level { across > 3.0 * down } else { down > across };
        assert!(is_so && left_out.is_empty(), "{place}: {rect:?}");
    }
    // More of them take more lines; far too many are counted.
    let heights = [4, 20, 40].map(|count| list(count, "bottom").0.expect("there is room"));
    let heights = heights.map(|rect| rect[3] - rect[1]);
    assert!(heights[0] < heights[1] && heights[1] < heights[2], "{heights:?}");
    assert!(list(4000, "bottom").0.is_some());
}

/// The axes are not left out of a picture that is larger than one that has them.
#[test]
fn larger_pictures_have_axes_that_smaller_ones_have() {
    for scale in [0.6, 0.8, 0.97, 1.0, 1.03, 1.5] {
        let mut is_there = false;
        for short in 8..400 {
            let annotation =
                Annotation { axes: Place::named("bottom-left"), text_scale: scale, ..Annotation::default() };
            let has_axes = annotation.fixed(short * 4 / 3, short).axes.is_some();
            assert!(has_axes || !is_there, "{scale} {short}");
            is_there = has_axes;
        }
        assert!(is_there);
    }
}

/// The same range has the same form of numbers, however many there are: coordinates far from 0 are written out.
#[test]
fn numbers_of_a_range_have_one_form() {
    for range in [[1_234_567.0, 1_234_890.0], [5.4e6, 5.413e6], [0.0, 2.5e9], [1e6, 9e6], [2e7, 2.1e7]] {
        let forms: Vec<bool> = (2..14)
            .flat_map(|most| {
                let mut banded = bar(range, Scale::Linear);
                let round = banded.ticks(most, most);
                banded.colors.bands = Some(5);
                [round, banded.ticks(most, most)]
            })
            .flat_map(|ticks| ticks.into_iter().map(|tick| tick.label))
            .filter(|label| !label.is_empty() && label != "0")
            .map(|label| label.contains('×'))
            .collect();
        assert!(forms.iter().all(|form| *form == forms[0]), "{range:?}: {forms:?}");
        assert_eq!(forms[0], range[1] >= range[0] * 1.02, "{range:?}");
    }
}
