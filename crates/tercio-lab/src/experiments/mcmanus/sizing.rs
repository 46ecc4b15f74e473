//! Area and performance: tables 2 and 3, figures 2, 3, 4 and 7.

use super::{BOX_AREA, FROM_CYCLES, POLYGONS, raster_cycles};
use crate::experiments::facts::Facts;
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Scale, Series, Table,
};
use crate::models::mcmanus::{self, optimum};
use crate::units::{Cycles, Hertz, Length, Pixels, Polygons, SquareInches};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "mcmanus-table-2",
        document: Document::McManus,
        place: "table 2",
        title: "Areas of geometry engine, array and renderer",
        run: areas,
    },
    Experiment {
        id: "mcmanus-fig-2",
        document: Document::McManus,
        place: "figure 2",
        title: "Raster cycles by silicon area, pixel processors alone",
        run: without_overhead,
    },
    Experiment {
        id: "mcmanus-fig-3",
        document: Document::McManus,
        place: "figure 3",
        title: "Raster cycles by silicon area, geometry engines included",
        run: with_overhead,
    },
    Experiment {
        id: "mcmanus-fig-4",
        document: Document::McManus,
        place: "figure 4",
        title: "Performance by silicon area of one renderer",
        run: performance_by_area,
    },
    Experiment {
        id: "mcmanus-fig-7",
        document: Document::McManus,
        place: "figure 7, equations 8 to 13",
        title: "The optimal array: slope of the curve and of replication",
        run: slopes,
    },
    Experiment {
        id: "mcmanus-table-3",
        document: Document::McManus,
        place: "table 3",
        title: "Optimal arrays of six images",
        run: optimal_arrays,
    },
];

/// Raster cycles a second.
const PER_SECOND: Hertz = Hertz::new(1e6);

/// The rate (polygons a second) and the area of a renderer (square inches) that table 2 prints.
fn printed(facts: &Facts, side: Length) -> Result<[f64; 2], ExperimentError> {
    Ok([facts.printed(&format!("M-T2P-{}", side.get()))?, facts.printed(&format!("M-T2R-{}", side.get()))?])
}

fn areas() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new(
        "areas",
        &[
            ("side", "px"),
            ("rate", "polygon/s"),
            ("rate printed", "polygon/s"),
            ("geometry engine", "in2"),
            ("array", "in2"),
            ("renderer", "in2"),
            ("renderer printed", "in2"),
            ("per million polygons a second", "in2"),
        ],
    );
    let (mut costs, mut in_print) = (Vec::new(), Vec::new());
    for (side, cycles) in raster_cycles(&facts)? {
        let rate = mcmanus::measured_rate(cycles, Polygons::new(POLYGONS), PER_SECOND);
        let renderer = mcmanus::renderer_area(side, rate).get();
        let cost = renderer / (rate.get() / 1e6);
        let [printed_rate, printed_area] = printed(&facts, side)?;
        table.push([
            side.get().into(),
            rate.get().into(),
            printed_rate.into(),
            mcmanus::geometry_area(rate).get().into(),
            mcmanus::array_area(side).get().into(),
            renderer.into(),
            printed_area.into(),
            cost.into(),
        ]);
        costs.push((side.get(), cost));
        in_print.push((side.get(), printed_area / (printed_rate / 1e6)));
    }
    let plot = Plot::new(
        "areas",
        "Area of a renderer per million polygons a second",
        Axis::log2("side of the array (pixels)"),
        Axis::log10("square inches"),
    )
    .with(Series::line_points(FROM_CYCLES, costs))
    .with(Series::points("table 2: printed area over printed rate", in_print).published_for(FROM_CYCLES));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec!["The least area per polygon a second has the array of 16 by 16.".into()],
        verdict: Comparison::of_published(&["M-T2P-#", "M-T2G-#", "M-T2A-#", "M-T2R-#", "M-opt16", "M-mpu"])?
            .verdict(),
    })
}

/// Raster cycles of a frame against the area of a system of 1 to 1000 arrays of each size.
fn systems(
    name: &str,
    title: &str,
    area: impl Fn(Length, Cycles) -> SquareInches,
) -> Result<(Table, Plot), ExperimentError> {
    let mut table =
        Table::new(name, &[("side", "px"), ("arrays", ""), ("area", "in2"), ("raster cycles", "cycle")]);
    let mut plot =
        Plot::new(name, title, Axis::log10("area (square inches)"), Axis::log10("raster cycles of a frame"));
    for (side, cycles) in raster_cycles(&Facts::load()?)? {
        let one = area(side, cycles);
        let mut points = Vec::new();
        for arrays in [1.0, 10.0, 100.0, 1000.0] {
            let (total, each) = (one * arrays, cycles / arrays);
            table.push([side.get().into(), arrays.into(), total.get().into(), each.get().into()]);
            points.push((total.get(), each.get()));
        }
        plot = plot.with(Series::line(format!("{0} by {0}", side.get()), points));
    }
    Ok((table, plot))
}

fn without_overhead() -> Result<Findings, ExperimentError> {
    let (table, plot) =
        systems("systems", "Systems of 1 to 1000 arrays, pixel processors alone", |side, _| {
            mcmanus::array_area(side)
        })?;
    let mut comparison = Comparison::new();
    // Area times cycles is constant along a line, so lines are ordered by it everywhere.
    let costs: Vec<f64> = raster_cycles(&Facts::load()?)?
        .into_iter()
        .map(|(side, c)| mcmanus::array_area(side).get() * c.get())
        .collect();
    for (pair, side) in costs.windows(2).zip(super::SIDES.iter().skip(1)) {
        comparison.claim(format!("{side} lies right of its half"), pair[0] < pair[1]);
    }
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "Without overhead the smallest array is the most efficient one, as the document states.".into(),
        ],
        verdict: comparison.verdict(),
    })
}

fn with_overhead() -> Result<Findings, ExperimentError> {
    let area = |side: Length, cycles: Cycles| {
        mcmanus::renderer_area(side, mcmanus::measured_rate(cycles, Polygons::new(POLYGONS), PER_SECOND))
    };
    let (table, plot) = systems("systems", "Systems of 1 to 1000 renderers", area)?;
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec!["With a geometry engine for each array the line of 16 by 16 is the lowest.".into()],
        verdict: Comparison::of_published(&["M-opt16", "M-T2R-#"])?.verdict(),
    })
}

fn performance_by_area() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new(
        "performance",
        &[
            ("side", "px"),
            ("area", "in2"),
            ("rate", "polygon/s"),
            ("area printed", "in2"),
            ("rate printed", "polygon/s"),
        ],
    );
    let (mut points, mut in_print) = (Vec::new(), Vec::new());
    for (side, cycles) in raster_cycles(&facts)? {
        let rate = mcmanus::measured_rate(cycles, Polygons::new(POLYGONS), PER_SECOND);
        let area = mcmanus::renderer_area(side, rate).get();
        let [printed_rate, printed_area] = printed(&facts, side)?;
        table.push([
            side.get().into(),
            area.into(),
            rate.get().into(),
            printed_area.into(),
            printed_rate.into(),
        ]);
        points.push((area, rate.get()));
        in_print.push((printed_area, printed_rate));
    }
    // More renderers of the best size: a line through the origin, tangent to the curve.
    let best = points.iter().copied().max_by(|a, b| (a.1 / a.0).total_cmp(&(b.1 / b.0))).unwrap_or_default();
    let linear = |area: f64| best.1 / best.0 * area;
    let plot = Plot::new(
        "performance",
        "One renderer with a larger and larger array",
        Axis::log10("area (square inches)"),
        Axis::linear("polygons a second"),
    )
    .with(Series::line_points("arrays of 1 to 512", points))
    .with(Series::points("the same in table 2", in_print).published_for("arrays of 1 to 512"))
    .with(Series::formula(
        "replicating the best renderer",
        Scale::Log10,
        [0.5, 2.0].map(|copies| copies * best.0),
        linear,
    ));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: Vec::new(),
        verdict: Comparison::of_published(&["M-T2P-#", "M-T2R-#"])?.verdict(),
    })
}

fn slopes() -> Result<Findings, ExperimentError> {
    let area = Pixels::new(23.9);
    let mut table = Table::new(
        "slopes",
        &[
            ("side", "px"),
            ("replication P/R", "polygon/s/in2"),
            ("growth P'/R'", "polygon/s/in2"),
            ("equation 11 over R'", "polygon/s/in2"),
        ],
    );
    let (mut replication, mut growth, mut printed) = (Vec::new(), Vec::new(), Vec::new());
    for step in 2..=64u32 {
        let side = Length::new(step.into());
        let linear = optimum::replication_slope(side, area, PER_SECOND);
        let slope = optimum::growth_slope(side, area, PER_SECOND);
        let of_eleven =
            optimum::misread_rate_slope(side, area, PER_SECOND) / optimum::area_slope(side, area, PER_SECOND);
        table.push([side.get().into(), linear.into(), slope.into(), of_eleven.into()]);
        replication.push((side.get(), linear));
        growth.push((side.get(), slope));
        printed.push((side.get(), of_eleven));
    }
    let plot = Plot::new(
        "slopes",
        "N = 23.9: the array is best where the curves cross",
        Axis::linear("side of the array (pixels)"),
        Axis::log10("polygons a second per square inch"),
    )
    .with(Series::line("replication, P/R", replication))
    .with(Series::line("larger arrays, P'/R'", growth))
    .with(Series::line("the same with equation 11", printed));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            format!(
                "The optimum is {:.2}; with equation 11 and its own overlap {:.2}, the document's \"very close\" to 16.",
                optimum::optimal_side(area).get(),
                optimum::misread_optimal_side(area, PER_SECOND)?.get()
            ),
            "Equation 11 has five damaged or wrong coefficients, and is the derivative of another overlap than equation 6 \
             (i^2 + 1 for i^2 + i). The printed optimum comes from that equation alone: with the true derivative the optimum \
             has a closed form, A^3 = (sqrt N - 1) 1.3673 / 0.000871, and is not the printed one."
                .into(),
        ],
        verdict: Comparison::of_published(&["M-eq11", "M-eq11-wrong", "M-fig7-eq11", "M-fig7-true", "M-12"])?.verdict(),
    })
}

fn optimal_arrays() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new(
        "optimal",
        &[
            ("image", ""),
            ("mean box", "pixel"),
            ("closed form", "px"),
            ("power of two", "px"),
            ("printed", "px"),
        ],
    );
    let (mut chosen, mut published) = (Vec::new(), Vec::new());
    for image in ["Headlow", "Frame20", "Frame70", "Cube20", "ShuttleB", "Room"] {
        let id = format!("M-T3-{image}");
        let area = Pixels::new(facts.given(&id, "N")?);
        let power = optimum::optimal_power_of_two(area, PER_SECOND).get();
        let printed = facts.printed(&id)?;
        table.push([
            image.into(),
            area.get().into(),
            optimum::optimal_side(area).get().into(),
            power.into(),
            printed.into(),
        ]);
        chosen.push((area.get(), power));
        published.push((area.get(), printed));
    }
    let curve = (0..=60)
        .map(|i| {
            let area = 10f64.powf(1.0 + f64::from(i) * 0.06);
            (area, optimum::optimal_side(Pixels::new(area)).get())
        })
        .collect();
    let plot = Plot::new(
        "optimal",
        "The best array by the mean size of bounding boxes",
        Axis::log10("mean area of a bounding box (pixels)"),
        Axis::log2("side of the array (pixels)"),
    )
    .with(Series::line("closed form of equation 13", curve))
    .with(Series::points("best power of two, equation 7", chosen))
    .with(Series::points("table 3", published).published_for("best power of two, equation 7"));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![format!(
            "The images are lost, their mean box areas are printed. That of table 1 is Frame20 with {BOX_AREA}."
        )],
        verdict: Comparison::of_published(&["M-T3-*", "M-Aopt-*"])?.verdict(),
    })
}
