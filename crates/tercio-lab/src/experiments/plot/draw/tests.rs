use tercio::vector::{Text, text_width};

use super::super::palette::COLORS;
use super::super::symbols::{COUNT, symbol};
use super::super::{Axis, Scale, Series};
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
    /// Texts that touch each other or a symbol or leave the page, series that cannot be told apart, and lines with corners where no
    /// symbol says that a value was computed.
    pub(in super::super::super) fn collisions(&self) -> Vec<String> {
        let page = self.page();
        let mut found = collisions(&page);
        if self.x.categories.is_none() {
            let traits: Vec<_> = self.looks().iter().map(Look::traits).collect();
            let alike = |i: &usize| traits[..*i].contains(&traits[*i]);
            let labels = (0..traits.len()).filter(alike).map(|i| &self.series[i].label);
            found.extend(labels.map(|label| format!("{label} looks like another series")));
            found.extend(symbols_on_text(&page));
            found.extend(corners(&page));
        }
        found
    }
}

/// Left, right, top and bottom of the symbols: small areas, and small closed lines.
fn symbols(page: &Page) -> Vec<[f64; 4]> {
    let outlines = page.shapes.iter().filter_map(|shape| match shape {
        Shape::Area { polygons, .. } => polygons.first(),
        Shape::Lines { lines, .. } => {
            lines.first().filter(|line| line.len() > 3 && line.first() == line.last())
        }
        Shape::Text(_) => None,
    });
    let of = |outline: &Vec<DVec2>| {
        let reach = |of: fn(&DVec2) -> f64| {
            outline.iter().map(of).fold([f64::MAX, f64::MIN], |[low, high], v| [low.min(v), high.max(v)])
        };
        let ([left, right], [top, bottom]) = (reach(|p| p.x), reach(|p| p.y));
        [left, right, top, bottom]
    };
    outlines.map(of).filter(|[left, right, top, bottom]| right - left < 30.0 && bottom - top < 30.0).collect()
}

fn touch(a: [f64; 4], b: [f64; 4]) -> bool {
    a[0] < b[1] && b[0] < a[1] && a[2] < b[3] && b[2] < a[3]
}

fn symbols_on_text(page: &Page) -> Vec<String> {
    let symbols = symbols(page);
    let texts = page.shapes.iter().filter_map(|s| if let Shape::Text(t) = s { Some(t) } else { None });
    let covered = texts.filter(|text| symbols.iter().any(|&symbol| touch(symbol, place(text))));
    covered.map(|text| format!("a symbol touches {}", text.text)).collect()
}

/// Lines of ours through few points that turn by more than five degrees between two straight parts of twelve pixels, without symbols in
/// their colour.
fn corners(page: &Page) -> Vec<String> {
    let mut found = Vec::new();
    for shape in &page.shapes {
        let Shape::Lines { style: Style { color, width, cap: Cap::Round }, lines } = shape else { continue };
        let has_symbols = page.shapes.iter().any(|s| matches!(s, Shape::Area { color: c, .. } if c == color));
        if *width < 1.8 || has_symbols {
            continue;
        }
        let turns = |p: &[DVec2]| {
            let [before, after] = [p[1] - p[0], p[2] - p[1]];
            before.length().min(after.length()) > 12.0 && before.angle_to(after).abs().to_degrees() > 5.0
        };
        let corner =
            lines.iter().filter(|line| line.len() < 16).flat_map(|line| line.windows(3)).find(|p| turns(p));
        found.extend(corner.map(|p| format!("a line of {color:?} has a corner at {}", p[1])));
    }
    found
}

fn collisions(page: &Page) -> Vec<String> {
    let texts: Vec<_> =
        page.shapes.iter().filter_map(|s| if let Shape::Text(t) = s { Some(t) } else { None }).collect();
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
        .with(Series::line("a", vec![(1.0, 2.0), (2.0, 1.0)]))
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
    for (plot, from) in
        [(&both, "dashed: published"), (&alone, "dashed: published"), (&bars, "hatched: published")]
    {
        assert!(svg(plot).contains(from) && collisions(&plot.page()).is_empty(), "{from}");
    }
    assert!(!svg(&lines()).contains("published"));
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

/// Symbols say where values are: a line has none, neither among the data nor in the legend.
#[test]
fn lines_have_no_symbols_and_the_legend_shows_what_is_drawn() {
    let empty = || Plot::new("p", "t", Axis::linear("x"), Axis::linear("y"));
    let values = || vec![(1.0, 1.0), (2.0, 3.0), (3.0, 2.0)];
    let lines = empty()
        .with(Series::line("a", values()))
        .with(Series::line("b", vec![(1.0, 2.0), (3.0, 1.0)]).published());
    assert!(symbols(&lines.page()).is_empty());
    let points = lines
        .with(Series::points("c", values()))
        .with(Series::line_points("d", vec![(1.0, 3.0), (3.0, 3.0)]));
    // Three and two values, and one symbol each in the legend.
    assert_eq!(symbols(&points.page()).len(), 3 + 1 + 2 + 1);
    // Lines and samples of a, d and, in strokes, of b.
    assert_eq!([0, 2, 3].map(|of| strokes(&points, COLORS[of]).len()), [2, 0, 2]);
    assert!(corners(&empty().with(Series::line("a", values())).page())[0].contains("has a corner"));
}

/// A line of ours beside points that are joined by one would look the same.
#[test]
fn series_of_one_colour_can_be_told_apart() {
    let points = || vec![(1.0, 1.0), (2.0, 2.0)];
    let plot = |first: Series, second: Series| {
        let plot = Plot::new("p", "t", Axis::linear("x"), Axis::linear("y"));
        plot.with(first).with(second.like("a")).looks().iter().map(|look| look.number).collect::<Vec<_>>()
    };
    let equation = || Series::line("equation", points());
    assert_eq!(plot(Series::line_points("a", points()), equation()), [0, 1]);
    assert_eq!(plot(Series::points("a", points()), equation()), [0, 0]);
    assert_eq!(plot(Series::line_points("a", points()), equation().published()), [0, 0]);
    let twice = Plot::new("p", "t", Axis::linear("x"), Axis::linear("y"));
    let of_eleven =
        (0..=COLORS.len()).fold(twice, |plot, k| plot.with(Series::points(k.to_string(), points())));
    assert!(!of_eleven.collisions().iter().any(|c| c.contains("looks like")), "{:?}", of_eleven.collisions());
    let of_lines = of_eleven.series.into_iter().map(|s| Series { mark: Mark::Line, ..s });
    let of_lines =
        Plot { series: of_lines.collect(), ..Plot::new("p", "t", Axis::linear("x"), Axis::linear("y")) };
    assert!(of_lines.collisions().contains(&"10 looks like another series".to_owned()));
}

#[test]
fn symbols_at_the_origin_leave_its_numbers_free() {
    let scales: [fn(&'static str) -> Axis; 3] = [Axis::linear, Axis::log2, Axis::log10];
    for scale in scales {
        let points = || vec![(1.0, 1.0), (1000.0, 1000.0)];
        let plot = Plot::new("p", "t", scale("x"), scale("y"))
            .with(Series::points("a", points()))
            .with(Series::line_points("b", points()))
            .with(Series::points("published", points()).published());
        assert!(plot.collisions().is_empty(), "{:?}", plot.collisions());
        // What is drawn at the origin is there.
        let frame = symbols(&plot.page());
        assert!(frame.len() >= 6, "{frame:?}");
    }
}

/// On the page, a formula is nowhere more than half a pixel from its value.
#[test]
fn formulas_bend_where_they_do() {
    let of = |x: f64| 600_000.0 * x / 3.0;
    for (scale, axis) in
        [(Scale::Log10, Axis::log10("x")), (Scale::Log2, Axis::log2("x")), (Scale::Linear, Axis::linear("x"))]
    {
        let series = Series::formula("replication", scale, [1.5, 96.0], of);
        assert_eq!([series.points[0].0, series.points[256].0].map(|x| (x * 1e9).round() / 1e9), [1.5, 96.0]);
        let (x, y) = (axis.scale, Axis::linear("y").scale);
        // Where the line is between two points, against the value there, as shares of 500 and of 340 pixels.
        let [low, high] = [1.5, 96.0].map(|end| x.place(end));
        let worst = series.points.windows(2).map(|p| {
            let middle = 0.5 * (x.place(p[0].0) + x.place(p[1].0));
            let value = match scale {
                Scale::Linear => middle,
                Scale::Log2 => middle.exp2(),
                Scale::Log10 => 10f64.powf(middle),
            };
            let drawn = 0.5 * (y.place(p[0].1) + y.place(p[1].1));
            assert!(low <= middle && middle <= high);
            (drawn - of(value)).abs() / of(96.0) * 340.0
        });
        assert!(worst.fold(0.0, f64::max) < 0.5);
    }
    let plot = Plot::new("p", "t", Axis::log10("x"), Axis::linear("y"));
    assert!(plot.clone().with(Series::formula("all", Scale::Log10, [1.0, 8.0], of)).collisions().is_empty());
    // Three points, as once: the middle one is a corner.
    let three = Series::line("three", [1.0, 2.0, 8.0].map(|x| (x, of(x))).to_vec());
    assert!(plot.with(three).collisions()[0].contains("has a corner"));
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
