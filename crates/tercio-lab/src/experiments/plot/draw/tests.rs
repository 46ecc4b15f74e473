use tercio::vector::{Text, text_width};

use super::super::palette::COLORS;
use super::super::symbols::{COUNT, symbol};
use super::super::{Axis, Series};
use super::*;

fn svg(plot: &Plot) -> String {
    String::from_utf8(plot.to_file(VectorFormat::Svg)).unwrap()
}

/// Left, right, top and bottom of a text.
fn place(text: &Text) -> [f64; 4] {
    let width = text_width(&text.text, text.size);
    let before = text.anchor.share() * width;
    if text.upwards {
        let low = text.at.y + before;
        return [text.at.x - 0.8 * text.size, text.at.x + 0.2 * text.size, low - width, low];
    }
    let left = text.at.x - before;
    [left, left + width, text.at.y - 0.75 * text.size, text.at.y + 0.1 * text.size]
}

impl Plot {
    /// Texts that touch each other or leave the page.
    pub(in super::super::super) fn collisions(&self) -> Vec<String> {
        collisions(&self.page())
    }
}

fn collisions(page: &Page) -> Vec<String> {
    let texts: Vec<_> =
        page.shapes.iter().filter_map(|s| if let Shape::Text(t) = s { Some(t) } else { None }).collect();
    let touch = |a: [f64; 4], b: [f64; 4]| a[0] < b[1] && b[0] < a[1] && a[2] < b[3] && b[2] < a[3];
    let mut found = Vec::new();
    for (i, a) in texts.iter().enumerate() {
        let [left, right, top, bottom] = place(a);
        if left < 0.0 || top < 0.0 || right > page.size[0] || bottom > page.size[1] {
            found.push(format!("{} leaves the page", a.text));
        }
        let others = texts[..i].iter().filter(|b| touch(place(a), place(b)));
        found.extend(others.map(|b| format!("{} touches {}", a.text, b.text)));
    }
    found
}

#[test]
fn a_plot_has_its_labels_and_is_the_same_each_time() {
    let plot = || {
        Plot::new("p", "Passes < all", Axis::log2("d"), Axis::linear("instructions"))
            .with(Series::line("ours", vec![(1.0, 2.0), (4.0, 8.0)]))
            .with(Series::points("printed", vec![(2.0, 4.0), (f64::NAN, 1.0), (0.0, 1.0)]).published())
    };
    let text = svg(&plot());
    assert!(text.contains("Passes &lt; all") && text.contains("printed") && text.contains("viewBox"));
    assert_eq!(text, svg(&plot()));
    assert!(plot().to_file(VectorFormat::Pdf).starts_with(b"%PDF"));
}

#[test]
fn a_plot_without_points_is_drawn() {
    assert!(svg(&Plot::new("p", "t", Axis::log10("x"), Axis::linear("y"))).contains("</svg>"));
}

fn strokes(plot: &Plot, color: [u8; 3]) -> Vec<Vec<DVec2>> {
    let of = |shape: Shape| match shape {
        Shape::Lines { style, lines } if style.color[..3] == color && style.width == 1.8 => lines,
        _ => Vec::new(),
    };
    plot.page().shapes.into_iter().flat_map(of).collect()
}

#[test]
fn a_value_that_is_not_known_is_a_gap() {
    let points = vec![(1.0, 1.0), (2.0, 2.0), (3.0, f64::NAN), (4.0, 1.0), (5.0, 2.0)];
    let plot =
        Plot::new("p", "t", Axis::linear("x"), Axis::linear("y")).with(Series::line("s", points.clone()));
    assert_eq!(strokes(&plot, COLORS[0]).iter().map(Vec::len).collect::<Vec<_>>(), [2, 2]);
    let bars = Plot::new("p", "t", Axis::categories("x", 1, ["a", "b", "c", "d", "e"]), Axis::linear("y"))
        .with(Series::line("s", points));
    let text = svg(&bars);
    assert_eq!((text.matches(">?</text>").count(), text.matches("<path fill=\"#").count()), (1, 4));
    assert!(text.contains("? not known"));
}

#[test]
fn published_values_have_the_colour_of_ours_and_are_dashed() {
    let points = vec![(1.0, 1.0), (2.0, 2.0)];
    let plot = Plot::new("p", "t", Axis::linear("x"), Axis::linear("y"))
        .with(Series::line("a", points.clone()))
        .with(Series::line("b", points.clone()))
        .with(Series::line("b, published", points).published_for("b"));
    // A line and the sample of the legend, and more than these where there are strokes.
    assert_eq!(strokes(&plot, COLORS[0]).len(), 2);
    assert!(strokes(&plot, COLORS[1]).len() > 10);
    assert!(strokes(&plot, COLORS[2]).is_empty());
}

#[test]
fn every_series_of_ten_has_a_colour_and_a_symbol_of_its_own() {
    assert_eq!(COLORS.len(), COUNT);
    let outlines: Vec<_> =
        (0..COLORS.len()).map(|kind| format!("{:?}", symbol(kind, DVec2::ZERO, 1.0))).collect();
    assert!((0..outlines.len()).all(|i| !outlines[..i].contains(&outlines[i])));
}

#[test]
fn the_legend_says_once_what_is_from_the_document() {
    let points = || vec![(1.0, 1.0), (2.0, 2.0)];
    let lines =
        || Plot::new("p", "t", Axis::linear("x"), Axis::linear("y")).with(Series::line("a", points()));
    let both = lines().with(Series::points("b", points()).published());
    let alone = Plot { series: vec![Series::points("b", points()).published()], ..lines() };
    let bars = Plot { x: Axis::categories("x", 1, ["a", "b"]), ..both.clone() };
    let says = |plot: &Plot, what: &str| svg(plot).matches(&format!(">{what}</text>")).count();
    assert_eq!((says(&both, "filled, solid: computed"), says(&lines(), "filled, solid: computed")), (1, 0));
    assert_eq!((says(&alone, "filled, solid: computed"), says(&bars, "filled: computed")), (0, 1));
    for (plot, from) in [(&both, "dashed: from"), (&alone, "dashed: from"), (&bars, "hatched: from")] {
        assert!(svg(plot).contains(from) && collisions(&plot.page()).is_empty(), "{from}");
    }
    assert!(!svg(&lines()).contains("from the document"));
}

#[test]
fn a_line_under_another_one_is_wider() {
    let points = || vec![(1.0, 1.0), (2.0, 2.0), (3.0, 4.0)];
    let far = vec![(1.0, 4.0), (2.0, 1.0), (3.0, 1.0)];
    let plot = |second| {
        Plot::new("p", "t", Axis::linear("x"), Axis::linear("y"))
            .with(Series::line_points("a", points()))
            .with(Series::line_points("b", second))
    };
    let width = |plot: &Plot, of: usize| {
        let widths = plot.page().shapes.into_iter().filter_map(|shape| match shape {
            Shape::Lines { style, .. } if style.color[..3] == COLORS[of] => Some(style.width),
            _ => None,
        });
        widths.fold(0.0, f64::max)
    };
    let (same, apart) = (plot(points()), plot(far));
    assert!(width(&same, 0) > 2.0 * width(&same, 1));
    assert_eq!(width(&apart, 0), width(&apart, 1));
}

/// From the foot of the plot to its top, in dashes; the horizontal axis reaches that far.
#[test]
fn a_printed_place_without_a_height_is_an_upright_line() {
    let ours = Series::line("ours", vec![(0.0, 1.0), (10.0, 8.0)]);
    let plot = Plot::new("p", "Passes", Axis::linear("d"), Axis::linear("y")).with(ours);
    let with = plot.clone().with(Series::printed_places("print", [20.0]));
    let upright = |plot: &Plot| -> Vec<Vec<Vec<DVec2>>> {
        let page = plot.page();
        let lines = page.shapes.into_iter().filter_map(|s| match s {
            Shape::Lines { lines, .. } => Some(lines),
            _ => None,
        });
        lines.filter(|l| l.len() > 10 && l.iter().flatten().all(|p| (p.x - l[0][0].x).abs() < 1e-9)).collect()
    };
    assert!(upright(&plot).is_empty());
    let [line] = &upright(&with)[..] else { panic!("one line") };
    let ends = |of: fn(f64, f64) -> f64| line.iter().flatten().map(|p| p.y).reduce(of).unwrap();
    assert!(ends(f64::max) - ends(f64::min) > 200.0, "{line:?}");
    assert!(svg(&with).contains(">20<") && !svg(&plot).contains(">20<"));
}
