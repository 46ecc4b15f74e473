//! The numbers and marks of bars and axes.

use super::*;

/// Bands are marked at their borders where there is room, and what is asked for is there or named.
#[test]
fn marks_of_bars() {
    let banded = |bands, marks| {
        let mut banded = bar([10.0, 18.1], Scale::Linear);
        banded.colors.bands = Some(bands);
        ScalarBar { marks, ..banded }
    };
    let values = |bar: &ScalarBar, close| -> Vec<f64> {
        bar.ticks(8, close).iter().filter(|tick| !tick.label.is_empty()).map(|tick| tick.value).collect()
    };
    let borders = banded(10, Marks::Usual);
    assert_eq!(values(&borders, 20), borders.colors.boundaries());
    assert_eq!(values(&borders, 9).len(), 6);
    assert_eq!(values(&banded(10, Marks::Count(3)), 20), [10.0, 14.05, 18.1]);
    let asked = banded(10, Marks::At(vec![17.25, 11.0, 99.0]));
    assert_eq!(values(&asked, 20), [11.0, 17.25]);
    assert_eq!(asked.ticks(8, 20)[1].label, "17.25");
    let labels =
        |bar: &ScalarBar| bar.ticks(8, 20).into_iter().map(|tick| tick.label).collect::<Vec<_>>().join(" ");
    assert_eq!(labels(&asked), "11.00 17.25");
    assert_eq!(labels(&banded(3, Marks::Count(3))), "10.00 14.05 18.10");
    // On a logarithmic scale every number has its own, and what is outside through rounding is inside.
    let ends = [f64::from(0.1f32), f64::from(1000.0f32)];
    assert_eq!(
        labels(&ScalarBar { marks: Marks::At(vec![0.1, 2.5, 1000.0]), ..bar(ends, Scale::Log) }),
        "0.1 2.5 1000"
    );
    assert_eq!(
        labels(&ScalarBar {
            marks: Marks::At(vec![0.1, 0.7]),
            ..bar([f64::from(0.1f32), f64::from(0.7f32)], Scale::Linear)
        }),
        "0.1 0.7"
    );
    let both = ScalarBar { marks: Marks::At(vec![11.0, 11.01, 99.0]), ..asked.clone() };
    let annotation = Annotation { bars: vec![both], ..Annotation::default() };
    assert_eq!(
        annotation.fixed(640, 480).layout.left_out,
        ["the mark 99 of bar, which is not in its range", "some numbers of bar"]
    );
    let annotation = Annotation { bars: vec![asked], ..Annotation::default() };
    assert_eq!(annotation.fixed(640, 480).layout.left_out, ["the mark 99 of bar, which is not in its range"]);
}

/// Values that are given have their numbers where these do not touch each other; those that have no room are named, and keep their
/// marks. This holds at any length, upright and level.
#[test]
fn given_numbers_do_not_lie_on_each_other() {
    for (range, scale, values) in [
        ([-1.0, 1.0], Scale::Linear, vec![0.0, 0.01, 0.5, 0.51]),
        ([0.5, 3.0], Scale::Linear, vec![2.8, 2.85, 1.0, 2.0]),
        ([1e-3, 1e6], Scale::Log, vec![1.0, 1.5, 2.0, 900.0, 1000.0]),
    ] {
        for (name, is_upright) in [("right", true), ("bottom", false), ("right", false), ("top", true)] {
            for size in [(120, 90), (400, 300), (400, 400), (1024, 768)] {
                let what = format!("{values:?} {name} {is_upright} {size:?}");
                let place = Place::named(name).expect("a place");
                let marks = Marks::At(values.clone());
                let bar = ScalarBar { place, is_upright, marks, shows_nan: false, ..bar(range, scale) };
                let annotation = Annotation { bars: vec![bar.clone()], ..Annotation::default() };
                let left_out = annotation.fixed(size.0, size.1).layout.left_out;
                let has_no_room = left_out == ["bar"];
                assert!(
                    has_no_room || left_out.contains(&"some numbers of bar".to_owned()),
                    "{what}: {left_out:?}"
                );
            }
            let bar = ScalarBar { is_upright, marks: Marks::At(values.clone()), ..bar(range, scale) };
            for length in [20.0, 60.0, 150.0, 400.0] {
                let all = bar.ticks(9, 9);
                let marked = bar.with_room(all.clone(), length, 11.0);
                assert!(bar.have_room(&marked, length, 11.0) && marked.len() == values.len(), "{marked:?}");
                assert!(!bar.have_room(&all, length, 11.0), "{all:?}");
                assert!(marked.iter().any(|tick| !tick.label.is_empty()));
            }
        }
    }
}

/// Both ends of a range have their numbers, however many of those between them have no room; at even distances where that is possible.
#[test]
fn ends_of_bars_keep_their_numbers() {
    let labelled = |bar: &ScalarBar, most: usize| -> Vec<usize> {
        let ticks = bar.ticks(most, most).into_iter().enumerate();
        ticks.filter(|(_, tick)| !tick.label.is_empty()).map(|(number, _)| number).collect()
    };
    let counted = |count| ScalarBar { marks: Marks::Count(count), ..bar([0.0, 1.0], Scale::Linear) };
    assert_eq!(labelled(&counted(11), 11), (0..11).collect::<Vec<_>>());
    assert_eq!(labelled(&counted(11), 5), [0, 5, 10]);
    assert_eq!(labelled(&counted(8), 4), [0, 3, 7]);
    assert_eq!(labelled(&counted(12), 5), [0, 3, 6, 11]);
    for (count, is_upright) in (2..=64).flat_map(|count| [(count, true), (count, false)]) {
        for length in [30.0, 60.0, 150.0, 400.0] {
            let bar = ScalarBar { is_upright, ..counted(count) };
            for most in 2..12 {
                let numbers = labelled(&bar, most);
                let ends = [numbers.first(), numbers.last()];
                assert!(
                    ends == [Some(&0), Some(&(count - 1))] && numbers.len() <= most,
                    "{count} {most}: {numbers:?}"
                );
            }
            let ticks = bar.with_room(bar.ticks(9, 9), length, 11.0);
            assert!(
                bar.have_room(&ticks, length, 11.0) && !ticks[count - 1].label.is_empty(),
                "{count} {length}"
            );
        }
    }
    // A level close to the end gives way to it.
    let mut levels = bar([0.0, 1.0], Scale::Linear);
    levels.colors.levels = vec![0.5, 0.99];
    let labels =
        |bar: &ScalarBar| bar.with_room(bar.ticks(9, 9), 100.0, 11.0).into_iter().map(|tick| tick.label);
    assert_eq!(labels(&levels).collect::<Vec<_>>(), ["0", "0.50", "", "1.00"]);
}

/// Numbers that a file has in `f32` are printed with the digits that mean them, also beside a level at the same place.
#[test]
fn levels_at_ends_are_printed_as_they_are_given() {
    let mut bar = bar([f64::from(0.1f32), f64::from(0.3f32)], Scale::Linear);
    let labels = |bar: &ScalarBar| bar.ticks(9, 9).into_iter().map(|tick| tick.label).collect::<Vec<_>>();
    bar.colors.levels = vec![0.15, 0.2, 0.3, 0.1];
    assert_eq!(labels(&bar), ["0.10", "0.15", "0.20", "0.30"]);
    bar.colors.levels = vec![f64::from(0.2f32)];
    assert_eq!(labels(&bar), ["0.1", "0.2", "0.3"]);
    // Whole numbers are those that they are, and a level between two of them separates them.
    bar.colors.levels = vec![123_456_788.0];
    bar.colors.range = [123_456_784.0, 123_456_792.0];
    assert_eq!(labels(&bar), ["123456784", "123456788", "123456792"]);
    bar.colors.levels = vec![16_777_217.0, 16_777_219.0];
    bar.colors.range = [16_777_216.0, 16_777_220.0];
    assert_eq!(labels(&bar), ["16777216", "16777217", "16777219", "16777220"]);
}

/// Marks between the numbers of a short logarithmic bar would merge: there are none, or only powers of ten.
#[test]
fn marks_of_short_bars_do_not_merge() {
    for range in [[1e-5, 30.0], [1.0, 1e3], [1e-300, 1e300]] {
        let bar = bar(range, Scale::Log);
        for length in [30.0, 90.0, 200.0, 2000.0] {
            let ticks = bar.without_merged(bar.with_room(bar.ticks(5, 5), length, 11.0), length, 11.0);
            let at: Vec<f64> = ticks.iter().map(|tick| bar.colors.position(tick.value) * length).collect();
            assert!(
                ticks.len() >= 2 && at.windows(2).all(|pair| pair[1] - pair[0] >= 2.9),
                "{range:?}: {at:?}"
            );
        }
    }
    let bar = bar([1.0, 1e3], Scale::Log);
    assert_eq!(
        bar.without_merged(bar.ticks(5, 5), 400.0, 11.0).len(),
        28,
        "they are there where there is room"
    );
}

/// Numbers of an axis that is short in the picture are fewer: none is skipped between two others, so that their distances become
/// smaller with the distance from the eye, and nowhere larger again.
#[test]
fn numbers_of_a_short_axis_are_even() {
    let mut seen = 0;
    let bounds = [DVec3::new(-1.0, -1.0, -30.0), DVec3::new(1.0, 1.0, 2.0)];
    for (turn, size) in (0..60).flat_map(|turn| [(200, 150), (400, 300), (900, 700)].map(|size| (turn, size)))
    {
        let (sin, cos) = sin_cos_degrees(f64::from(turn) - 30.0);
        let eye = DVec3::new(sin * 9.0, 2.0, cos * 9.0);
        let camera = camera(eye, Projection::Perspective { fov_y: 0.6 });
        let annotation = Annotation { bounds: true, ..Annotation::default() };
        let laid_out = check(&annotation, &annotation.room(size, ROUND).place(&camera), size, bounds);
        let of_axis = laid_out.placed.iter().filter(|placed| placed.what == "number of the z axis");
        let centers: Vec<[f64; 2]> =
            of_axis.map(|p| [(p.rect[0] + p.rect[2]) * 0.5, (p.rect[1] + p.rect[3]) * 0.5]).collect();
        let steps: Vec<f64> = centers
            .windows(2)
            .map(|pair| [0, 1].map(|k| pair[1][k] - pair[0][k]))
            .map(|[x, y]| (x * x + y * y).sqrt())
            .collect();
        assert!(steps.windows(2).all(|pair| pair[1] > pair[0] * 0.97), "{size:?} {turn}: {steps:?}");
        seen += centers.len();
    }
    assert!(seen > 180, "{seen}");
}
