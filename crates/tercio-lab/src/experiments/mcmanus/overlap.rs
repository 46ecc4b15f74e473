//! Raster cycles and overlap: tables 1, figures 5 and 6.

use super::{BOX_AREA, FROM_CYCLES, POLYGONS, raster_cycles};
use crate::experiments::facts::Facts;
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Scale, Series, Table,
};
use crate::models::{mcmanus, overlap};
use crate::units::{Count, Hertz, Length, Pixels, Polygons};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "mcmanus-table-1",
        document: Document::McManus,
        place: "table 1",
        title: "Raster cycles and overlap by the size of regions",
        run: measured_overlap,
    },
    Experiment {
        id: "mcmanus-fig-5",
        document: Document::McManus,
        place: "figure 5, equations 2 to 6",
        title: "Places of a box among regions of 2 by 2",
        run: places,
    },
    Experiment {
        id: "mcmanus-fig-6",
        document: Document::McManus,
        place: "figure 6",
        title: "Polygon rate by equation 7 and measured",
        run: predicted_rate,
    },
];

/// The least and the largest side of a region in the document's tables, in pixels.
const ENDS: [f64; 2] = [1.0, 512.0];

fn measured_overlap() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new(
        "overlap",
        &[("side", "px"), ("raster cycles", ""), ("measured", ""), ("printed", ""), ("equation 6", "")],
    );
    let mut in_print = Vec::new();
    let model = |side: Length| mcmanus::overlap_of_area(side, Pixels::new(BOX_AREA)).get();
    for (side, cycles) in raster_cycles(&facts)? {
        let ours = mcmanus::measured_overlap(cycles, Polygons::new(POLYGONS)).get();
        let by_model = model(side);
        let printed = facts.printed(&format!("M-T1-{}", side.get()))?;
        table.push([side.get().into(), cycles.get().into(), ours.into(), printed.into(), by_model.into()]);
        in_print.push((side.get(), printed));
    }
    let plot = Plot::new(
        "overlap",
        "Regions that a polygon meets",
        Axis::log2("side of a region (pixels)"),
        Axis::log10("regions per polygon"),
    )
    .with(Series::formula("equation 6", Scale::Log2, ENDS, |side| model(Length::new(side))))
    .with(Series::points("table 1", in_print).published());
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "The scene is lost; the raster cycles are the document's. Equation 6 knows the mean box area only.".into(),
        ],
        verdict: Comparison::of_published(&["M-T1-#", "M-dev"])?.verdict(),
    })
}

fn places() -> Result<Findings, ExperimentError> {
    let mut table = Table::new(
        "places",
        &[
            ("box", "px"),
            ("regions a side", ""),
            ("alpha", ""),
            ("beta", ""),
            ("gamma", ""),
            ("equation 6", ""),
            ("counted", ""),
        ],
    );
    let (mut closed, mut counted) = (Vec::new(), Vec::new());
    for w in 1..=16u32 {
        let (side, width) = (Length::new(2.0), Length::new(w.into()));
        let [i, alpha, beta, gamma] = mcmanus::places(side, width);
        let by_equation = mcmanus::overlap_of_places(side, width).get();
        let by_count = overlap::pixel_boxes_counted(Count::new(2.0), Count::new(w.into()))?.get();
        table.push([
            width.get().into(),
            i.into(),
            alpha.into(),
            beta.into(),
            gamma.into(),
            by_equation.into(),
            by_count.into(),
        ]);
        closed.push((width.get(), by_equation));
        counted.push((width.get(), by_count));
    }
    let plot = Plot::new(
        "places",
        "Regions of 2 by 2 that a square box meets, mean over all places",
        Axis::linear("side of the box (pixels)"),
        Axis::linear("regions"),
    )
    .with(Series::line("equation 6", closed))
    .with(Series::points("counted at every place", counted));
    let correction = "Equation 4 needs + 1 where - 1 is printed; then equations 2 to 6 collapse to \
                      ((sqrt N + A - 1)/A)^2.";
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec!["Figure 5 shows boxes of 7 and 8 pixels.".into()],
        verdict: {
            let mut comparison =
                Comparison::of_published(&["M-ex7", "M-ex8", "M-C-#", "M-C49", "M-brute-#-#"])?;
            let gamma = |w: f64| mcmanus::placements_as_printed(Length::new(2.0), Length::new(w))[2];
            // Figure 5: a box of 8 pixels meets 25 regions of 2 by 2 at one place.
            comparison.correct(correction, gamma(8.0) != 1.0);
            comparison.verdict()
        },
    })
}

fn predicted_rate() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let per_second = Hertz::new(1e6);
    let mut table = Table::new(
        "rates",
        &[
            ("side", "px"),
            ("equation 7", "polygon/s"),
            ("measured", "polygon/s"),
            ("printed", "polygon/s"),
            ("deviation", "%"),
        ],
    );
    let (mut measured, mut in_print) = (Vec::new(), Vec::new());
    let model = |side: Length| mcmanus::rate(side, Pixels::new(BOX_AREA), per_second).get();
    for (side, cycles) in raster_cycles(&facts)? {
        let by_model = model(side);
        let by_cycles = mcmanus::measured_rate(cycles, Polygons::new(POLYGONS), per_second).get();
        let deviation = 100.0 * (by_cycles / by_model - 1.0);
        let printed = facts.printed(&format!("M-T2P-{}", side.get()))?;
        table.push([side.get().into(), by_model.into(), by_cycles.into(), printed.into(), deviation.into()]);
        in_print.push((side.get(), printed));
        measured.push((side.get(), by_cycles));
    }
    let plot = Plot::new(
        "rates",
        "Polygons a second of one array",
        Axis::log2("side of the array (pixels)"),
        Axis::linear("polygons a second"),
    )
    .with(Series::formula("equation 7", Scale::Log2, ENDS, |side| model(Length::new(side))))
    .with(Series::points(FROM_CYCLES, measured))
    .with(Series::points("table 2", in_print).published_for(FROM_CYCLES));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: Vec::new(),
        verdict: Comparison::of_published(&["M-dev", "M-T2P-#", "M-molnar8"])?.verdict(),
    })
}
