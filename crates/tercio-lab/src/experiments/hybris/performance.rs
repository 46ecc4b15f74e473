//! Rates, speed-ups, sizes and utilisation: figures 3.18, 4.11 and 4.12, equations 4.1 to 4.7.

use crate::experiments::comparison::named;
use crate::experiments::facts::Facts;
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Series, Table,
};
use crate::models::amdahl;
use crate::published;
use crate::units::{FrameRate, Ratio, Seconds};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "hybris-fig-3-18",
        document: Document::Hybris,
        place: "figure 3.18, sections 3.5 and 4.3 to 4.5",
        title: "Sizes of triangle nodes, buffers, tiles and heaps",
        run: sizes,
    },
    Experiment {
        id: "hybris-sec-2-1-2",
        document: Document::Hybris,
        place: "sections 2.1.2, 3.2.11 and 4.2.1",
        title: "Bandwidths of memories and buses",
        run: bandwidths,
    },
    Experiment {
        id: "hybris-sec-4-5-2",
        document: Document::Hybris,
        place: "equation 4.1, section 4.5.2",
        title: "Video timing",
        run: video,
    },
    Experiment {
        id: "hybris-fig-4-11",
        document: Document::Hybris,
        place: "figure 4.11",
        title: "Utilisation of the field-programmable device",
        run: utilisation,
    },
    Experiment {
        id: "hybris-fig-4-12",
        document: Document::Hybris,
        place: "figure 4.12",
        title: "Triangle rates of all implementations",
        run: rates,
    },
    Experiment {
        id: "hybris-eq-4-7",
        document: Document::Hybris,
        place: "equations 4.2 to 4.7",
        title: "Speed-up of the dual processor without its serial part",
        run: speed_ups,
    },
];

/// A table of published numbers next to the computed ones.
fn beside_ours(name: &str, names: &[&str]) -> Result<Table, ExperimentError> {
    let mut table =
        Table::new(name, &[("number", ""), ("place", ""), ("ours", ""), ("printed", ""), ("unit", "")]);
    for number in named(names)? {
        let check = published::check(number);
        let unit = match &check.number.unit {
            Some(unit) => unit.clone(),
            None => crate::models::registry::find(&check.number.model)?.unit.to_owned(),
        };
        let ours = check.ours?.as_number();
        let printed = check.number.printed.as_ref().and_then(|v| v.as_number());
        table.push([
            check.number.id.as_str().into(),
            check.number.place.as_str().into(),
            ours.into(),
            printed.into(),
            unit.as_str().into(),
        ]);
    }
    Ok(table)
}

fn sizes() -> Result<Findings, ExperimentError> {
    let of = [
        "H3-node",
        "H3-buf",
        "H3-333",
        "H3-15",
        "H3-289",
        "H3-36",
        "H4-tile",
        "H4-hash",
        "H4-64M",
        "H3-8k",
        "H1-208353",
    ];
    Ok(Findings {
        tables: vec![beside_ours("sizes", &of)?],
        plots: Vec::new(),
        remarks: Vec::new(),
        verdict: Comparison::of_published(&of)?.verdict(),
    })
}

fn bandwidths() -> Result<Findings, ExperimentError> {
    let of = ["H2-kyro", "H2-gf2u", "H3-neon", "H4-agp"];
    Ok(Findings {
        tables: vec![beside_ours("bandwidths", &["H2-kyro", "H2-gf2u", "H3-neon", "H4-agp", "H4-agpW"])?],
        plots: Vec::new(),
        remarks: Vec::new(),
        verdict: Comparison::of_published(&of)?.verdict(),
    })
}

fn video() -> Result<Findings, ExperimentError> {
    let of = ["H4.1a", "H4.1b", "H4-vga#"];
    Ok(Findings {
        tables: vec![beside_ours("video", &of)?],
        plots: Vec::new(),
        remarks: Vec::new(),
        verdict: Comparison::of_published(&of)?.verdict(),
    })
}

fn utilisation() -> Result<Findings, ExperimentError> {
    Ok(Findings {
        tables: vec![beside_ours("utilisation", &["H4.11-*"])?],
        plots: Vec::new(),
        remarks: vec!["The tool cuts percentages off, it does not round them.".into()],
        verdict: Comparison::of_published(&["H4.11-*"])?.verdict(),
    })
}

fn rates() -> Result<Findings, ExperimentError> {
    let table = beside_ours("rates", &["H4.12-*-*"])?;
    let facts = Facts::load()?;
    let implementations = [
        ("new", "New Single CPU"),
        ("1", "Single CPU"),
        ("2", "Dual CPU"),
        ("fpga", "FPGA"),
        ("asic", "ASIC"),
        ("gf2", "GeForce 2 GTS"),
    ];
    let mut plot = Plot::new(
        "rates",
        "Triangle rates that the document measured",
        Axis::categories("implementation", 1, implementations.map(|i| i.1)),
        Axis::linear("triangles a second"),
    );
    for (model, label) in [("bunny", "bunny, 69,451 triangles"), ("buddha", "Buddha, 1,087,716 triangles")] {
        let mut points = Vec::new();
        for (at, (name, _)) in implementations.iter().enumerate() {
            // The document gives no rate for the bunny on the ASIC.
            let rate = facts.printed(&format!("H4.12-{model}-{name}")).unwrap_or(f64::NAN);
            points.push((at as f64 + 1.0, rate));
        }
        plot = plot.with(Series::points(label, points).published());
    }
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "Frame rates are the document's measurements on its own machines; the rates are recomputed from them. Its \
             screen size is not stated, so absolute frame rates cannot be predicted."
                .into(),
        ],
        verdict: Comparison::of_published(&["H4.12-*-*"])?.verdict(),
    })
}

fn speed_ups() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let idle = FrameRate::new(120.0);
    let mut table = Table::new(
        "speed-ups",
        &[
            ("model and row", ""),
            ("one processor", "frame/s"),
            ("two processors", "frame/s"),
            ("observed", ""),
            ("parallel part", ""),
            ("printed", ""),
        ],
    );
    for (name, id) in [
        ("bunny", "H4.7a"),
        ("Buddha", "H4.7b"),
        ("bunny against New Single CPU", "H4.7c"),
        ("Buddha against New Single CPU", "H4.7d"),
    ] {
        let (single, dual) =
            (FrameRate::new(facts.given(id, "single")?), FrameRate::new(facts.given(id, "dual")?));
        table.push([
            name.into(),
            single.get().into(),
            dual.get().into(),
            amdahl::observed(single, dual).get().into(),
            amdahl::parallel_speed_up(single, dual, idle)?.get().into(),
            facts.printed(id)?.into(),
        ]);
    }
    let serial = Seconds::from(idle);
    let whole = Seconds::from(FrameRate::new(facts.given("H4.7a", "single")?));
    let curve: Vec<_> = (1..=64)
        .map(|p| {
            let p = f64::from(p);
            (p, whole / amdahl::time(whole - serial, Ratio::new(p), serial))
        })
        .collect();
    let plot = Plot::new(
        "speed-ups",
        "Bunny with a serial part of 1/120 s: Amdahl's law",
        Axis::linear("processors"),
        Axis::linear("observed speed-up"),
    )
    .with(Series::line("equation 4.2", curve))
    .with(Series::points("published, two processors", vec![(2.0, facts.printed("H4.5")?)]).published());
    let correction = "Equation 4.5 is printed upside down.";
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: Vec::new(),
        verdict: Comparison::verdict_of_published(
            &["H4.5", "H4.5b", "H4.7a", "H4.7b", "H4.7c", "H4.7d"],
            correction,
        )?,
    })
}
