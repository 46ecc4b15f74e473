//! Document 002, figure 27: the sections of the splitter with 16 processors on the runway.

use super::super::{Comparison, Document, Experiment, ExperimentError, Findings, Table};
use crate::simulators::parks::figure_15::{SCREEN, polygons_moved};
use crate::simulators::parks::{Costs, Machine, simulate};

pub(in crate::experiments) const EXPERIMENTS: &[Experiment] = &[Experiment {
    id: "parks-fig-27",
    document: Document::Parks,
    place: "figure 27, section 4.3",
    title: "Sections of the runway: where a splitter with 16 processors spends its time",
    run: sections,
}];

fn sections() -> Result<Findings, ExperimentError> {
    let columns = [
        ("section", ""),
        ("polygons", ""),
        ("vertices", ""),
        ("segments", ""),
        ("pixels", ""),
        ("time", "cycle"),
    ];
    let mut table = Table::new("sections", &columns);
    let machine = Machine { chunks: 4, interlace: 1 };
    // The two sections in the middle of the lowest row, which landscape and runway fill.
    const FULL: [usize; 2] = [1, 2];
    let mut comparison = Comparison::new();
    let mut all = true;
    for place in super::parks::places() {
        let run = simulate(&machine, &Costs::pdp11(), (SCREEN, SCREEN), &polygons_moved(place))?;
        let most = (0..16).max_by_key(|&i| run.processors[i].polygons()).unwrap_or(0);
        all &= FULL.iter().all(|&full| most != full && run.cycles[full] > run.cycles[most]);
        if place == [0, 0] {
            for (i, (p, cycles)) in run.processors.iter().zip(&run.cycles).enumerate() {
                let counts =
                    [p.polygons(), p.vertices(), p.segments(), p.pixels()].map(|c| (c as f64).into());
                let mut row = vec![format!("({}, {})", i % 4, i / 4).as_str().into()];
                row.extend(counts);
                row.push((*cycles).into());
                table.push_row(row);
            }
        }
    }
    comparison.claim(
        "two sections that only landscape and runway fill take longer than the one with the most polygons, at all 16 \
         places of the small polygons",
        all,
    );
    Ok(Findings {
        tables: vec![table],
        plots: Vec::new(),
        remarks: vec![
            "The scene is rebuilt from appendix C, so that two of these sections have its counts by construction. Sections \
             are columns and rows from the lower left."
                .into(),
        ],
        verdict: comparison.qualitative("The drawing is lost, and the scene is rebuilt."),
    })
}
