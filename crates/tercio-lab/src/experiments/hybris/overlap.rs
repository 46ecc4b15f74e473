//! Overlap of triangles and tiles: figures 2.15 and 2.16.

use crate::experiments::facts::Facts;
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Scale, Series, Table,
};
use crate::models::overlap;
use crate::units::{Length, Pixels, Ratio};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "hybris-fig-2-15",
        document: Document::Hybris,
        place: "figure 2.15",
        title: "Overlap by bounding boxes and exact, by tile and triangle size",
        run: by_tile_and_area,
    },
    Experiment {
        id: "hybris-fig-2-16",
        document: Document::Hybris,
        place: "figure 2.16",
        title: "Overlap for tiles of 32 by 32 pixels",
        run: for_one_tile,
    },
];

pub(super) const TILES: [u32; 6] = [8, 16, 32, 64, 128, 256];
pub(super) const AREAS: [u32; 6] = [1, 4, 16, 64, 256, 1024];
const RHO: Ratio = Ratio::new(3.0);

fn by_tile_and_area() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new(
        "overlap",
        &[
            ("tile", "px"),
            ("area", "pixel"),
            ("bounding box", ""),
            ("bounding box printed", ""),
            ("exact", ""),
            ("exact printed", ""),
        ],
    );
    let plot = |name: &str, title: &str| {
        Plot::new(name, title, Axis::log2("triangle area (pixels)"), Axis::log2("overlap factor"))
    };
    let mut of_boxes = plot("overlap", "Tiles that a triangle's bounding box meets");
    let mut of_triangles = plot("overlap-exact", "Tiles that a triangle meets");
    for tile in TILES {
        let side = Length::new(tile.into());
        let [mut boxes_printed, mut exacts_printed] = [const { Vec::new() }; 2];
        let by_box = |area: f64| overlap::bounding_boxes(side, Pixels::new(area), RHO).get();
        let exact = |area: f64| overlap::exact(side, Pixels::new(area), RHO).get();
        for area in AREAS {
            let area_of = f64::from(area);
            let in_print = facts.printed(&format!("H2.15-bb-{tile}-{area}"))?;
            let exact_in_print = facts.printed(&format!("H2.15-ex-{tile}-{area}"))?;
            table.push([
                side.get().into(),
                area_of.into(),
                by_box(area_of).into(),
                in_print.into(),
                exact(area_of).into(),
                exact_in_print.into(),
            ]);
            boxes_printed.push((area_of, in_print));
            exacts_printed.push((area_of, exact_in_print));
        }
        let (ours, printed) = (format!("tile {tile}"), format!("tile {tile}, published"));
        let published = |points| Series::points(&printed, points).published_for(&ours);
        let formula = |of: &dyn Fn(f64) -> f64| {
            let ends = [AREAS[0], AREAS[AREAS.len() - 1]].map(f64::from);
            Series::formula(&ours, Scale::Log2, ends, of)
        };
        of_boxes = of_boxes.with(formula(&by_box)).with(published(boxes_printed));
        of_triangles = of_triangles.with(formula(&exact)).with(published(exacts_printed));
    }
    Ok(Findings {
        tables: vec![table],
        plots: vec![of_boxes, of_triangles],
        remarks: vec!["Boxes are taken to be square and three times as large as their triangles.".into()],
        verdict: Comparison::of_published(&["H2.15-*-#-#"])?.verdict(),
    })
}

fn for_one_tile() -> Result<Findings, ExperimentError> {
    let side = Length::new(32.0);
    let mut table = Table::new("overlap-32", &[("area", "pixel"), ("bounding box", ""), ("exact", "")]);
    let (mut boxes, mut exacts) = (Vec::new(), Vec::new());
    for step in 0..=64 {
        let area = f64::from(step) * 16.0;
        let a = Pixels::new(area);
        let (by_box, exact) =
            (overlap::bounding_boxes(side, a, RHO).get(), overlap::exact(side, a, RHO).get());
        table.push([area.into(), by_box.into(), exact.into()]);
        boxes.push((area, by_box));
        exacts.push((area, exact));
    }
    let facts = Facts::load()?;
    let printed = |kind: &str| -> Result<Vec<_>, ExperimentError> {
        AREAS.iter().map(|&a| Ok((f64::from(a), facts.printed(&format!("H2.15-{kind}-32-{a}"))?))).collect()
    };
    let plot = Plot::new(
        "overlap-32",
        "Tiles of 32 by 32 pixels that a triangle meets",
        Axis::linear("triangle area (pixels)"),
        Axis::linear("overlap factor"),
    )
    .with(Series::line("bounding boxes (2.4)", boxes))
    .with(Series::line("exact (2.9)", exacts))
    .with(Series::points("figure 2.15, bounding boxes", printed("bb")?).published_for("bounding boxes (2.4)"))
    .with(Series::points("figure 2.15, exact", printed("ex")?).published_for("exact (2.9)"));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "Equation 2.10 holds for convex shapes of any size with 1 + (w + h)/S + a/S^2, the area of the shape's \
             Minkowski sum with a tile; the document derives it for boxes within a tile."
                .into(),
        ],
        verdict: Comparison::of_published(&["H2.15-*-32-#", "H2.1", "H2.7"])?.verdict(),
    })
}
