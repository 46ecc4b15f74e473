//! Sort-twice: the part of chapter 6 that follows from formulas.

use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Scale, Series, Table,
};
use crate::models::eldridge::{DESCRIPTOR, PIXEL, SCREEN, distribution, placement, sort_twice};
use crate::units::{Count, Instructions, Pixels, Polygons, Processors, Words};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "eldridge-fig-6-3",
        document: Document::Eldridge,
        place: "figures 6-2 and 6-3",
        title: "Which processor has a composited pixel",
        run: owners,
    },
    Experiment {
        id: "eldridge-fig-6-4",
        document: Document::Eldridge,
        place: "figure 6-4",
        title: "Instructions of the composition per pixel by the size of groups",
        run: per_pixel,
    },
    Experiment {
        id: "eldridge-fig-6-5",
        document: Document::Eldridge,
        place: "figure 6-5",
        title: "Predicted communication of sort-middle and sort-twice",
        run: crossover,
    },
];

const N: Processors = Processors::new(1024.0);
const SCREEN_PIXELS: Pixels = Pixels::new(SCREEN);
const PIXEL_WORDS: Words = Words::new(PIXEL.0);
const PIXEL_OVERHEAD: Instructions = Instructions::new(PIXEL.1);

fn owners() -> Result<Findings, ExperimentError> {
    let (n, g, pixels) = (15u32, 3u32, 16u32);
    let count = |v: u32| Count::new(v.into());
    let mut table =
        Table::new("owners", &[("region", ""), ("pixel", ""), ("starts on", ""), ("ends on", "")]);
    let mut plot = Plot::new(
        "owners",
        "15 processors in groups of 3",
        Axis::linear("pixel of the region"),
        Axis::linear("processor that has it in the end"),
    );
    for r in 0..g {
        let mut points = Vec::new();
        for j in 0..pixels {
            let [start, end] = placement::composite_path(count(n), count(g), count(r), count(j));
            table.push([f64::from(r).into(), f64::from(j).into(), start.get().into(), end.get().into()]);
            points.push((f64::from(j), end.get()));
        }
        plot = plot.with(Series::points(format!("region {r}"), points));
    }
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: Vec::new(),
        verdict: Comparison::of_published(&["E6-fig#"])?.verdict(),
    })
}

fn per_pixel() -> Result<Findings, ExperimentError> {
    let mut table = Table::new(
        "per-pixel",
        &[("group", "processor"), ("for n much larger", "instr"), ("for n = 1024", "instr")],
    );
    let limit = |group: f64| {
        sort_twice::composite_per_pixel(Processors::new(group), PIXEL_WORDS, PIXEL_OVERHEAD).get()
    };
    let exact = |group: f64| {
        let group = Processors::new(group);
        sort_twice::composite(Pixels::new(1.0), group, N, PIXEL_WORDS, PIXEL_OVERHEAD).get()
    };
    for group in (0..=10).map(|power| f64::from(1u32 << power)) {
        table.push([group.into(), limit(group).into(), exact(group).into()]);
    }
    let plot = Plot::new(
        "per-pixel",
        "Composition per pixel of the screen",
        Axis::log2("processors in a group g"),
        Axis::linear("instructions per pixel"),
    )
    .with(Series::formula("n much larger than g (6.4)", Scale::Log2, [1.0, 1024.0], limit))
    .with(Series::formula("n = 1024 (6.3)", Scale::Log2, [1.0, 1024.0], exact));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec!["With all 1024 processors in one group nothing is left to compose.".into()],
        verdict: Comparison::of_published(&["E6.2", "E6.3-g#", "E6.4-g#", "E6-x8"])?.verdict(),
    })
}

fn crossover() -> Result<Findings, ExperimentError> {
    let (a, b) = (Words::new(DESCRIPTOR.0), Instructions::new(DESCRIPTOR.1));
    let half_pass = sort_twice::grouped_pass(a, b, Processors::new(1.0));
    let growth = sort_twice::growth_squared(half_pass, PIXEL_WORDS, PIXEL_OVERHEAD).sqrt();
    // The factor that equation 6.8 prints as 441.
    let printed_growth = 21.0;
    let twice = |p: f64, growth: f64| {
        sort_twice::sort_twice(Polygons::new(p), SCREEN_PIXELS, N, PIXEL_WORDS, growth).get()
    };
    let middle = |p: f64| distribution::two_stages_at_optimum(Polygons::new(p), N, a, b).get();
    let mut table = Table::new(
        "communication",
        &[
            ("visible polygons", ""),
            ("sort-middle", "instr"),
            ("sort-twice", "instr"),
            ("sort-twice as printed", "instr"),
            ("best group", "processor"),
        ],
    );
    let polygons: Vec<f64> = (1..=50).map(|i| f64::from(i) * 2000.0).collect();
    for &p in &polygons {
        let group = sort_twice::optimal_group(
            Polygons::new(p),
            SCREEN_PIXELS,
            N,
            half_pass,
            PIXEL_WORDS,
            PIXEL_OVERHEAD,
        );
        table.push([
            p.into(),
            middle(p).into(),
            twice(p, growth).into(),
            twice(p, printed_growth).into(),
            group.get().into(),
        ]);
    }
    let at =
        |growth: f64| sort_twice::sort_twice_crossover(SCREEN_PIXELS, N, growth, a, b, PIXEL_WORDS).get();
    let points = |of: &dyn Fn(f64) -> f64| polygons.iter().map(|&p| (p, of(p))).collect();
    let plot = Plot::new(
        "communication",
        "Communication of a frame on 1024 processors",
        Axis::linear("visible polygons"),
        Axis::linear("instructions"),
    )
    .with(Series::line("sort-middle (6.9)", points(&middle)))
    .with(Series::line("sort-twice (6.8, corrected)", points(&|p| twice(p, growth))))
    .with(Series::line("sort-twice (6.8, as printed)", points(&|p| twice(p, printed_growth))))
    .with(Series::printed_places("printed crossover", [50_503.0]));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![format!(
            "The curves cross at {:.0} visible polygons; with the printed equation 6.8 at {:.0}, where the document \
             says 50,503.",
            at(growth),
            at(printed_growth)
        )],
        verdict: Comparison::of_published(&[
            "E6.5",
            "E6.7",
            "E6.8-K2",
            "E6.9",
            "E6-50503",
            "E6-cross84",
            "E6-cross78",
        ])?
        .verdict(),
    })
}
