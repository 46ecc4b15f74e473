//! Document 002, figures 22 to 25: objects that fill part or all of the screen.

use super::super::{Comparison, Document, Experiment, ExperimentError, Findings, Fit, Table};
use super::model_polygons;
use super::parks::{SIZE, run};
use crate::simulators::parks::{Machine, Polygon};

pub(in crate::experiments) const EXPERIMENTS: &[Experiment] = &[Experiment {
    id: "parks-fig-22-25-scenes",
    document: Document::Parks,
    place: "figures 22 to 25",
    title: "Objects that fill part or all of the screen",
    run: objects,
}];

/// Of figures 22 and 23, two views of the shuttle: the input, the times, and how many times as long the splitter takes.
const VIEWS: [(&str, &str, &str); 2] = [
    ("side of the object's picture in figure 22", "2.10 over 1.24, figure 22", "1.69"),
    ("side of the object's picture in figure 23", "2.21 over 1.18, figure 23", "1.87"),
];

fn objects() -> Result<Findings, ExperimentError> {
    let mut table = Table::new(
        "times",
        &[("scene", ""), ("polygons", ""), ("machine", ""), ("time", "10^6 memory cycles")],
    );
    let mut comparison = Comparison::new();
    // A coarse object at one side, like the shuttle from outside (the coordinates are those of a smaller picture), the
    // same in the middle, and walls all round, like the shuttle's cargo bay.
    let object =
        |size| Ok::<_, ExperimentError>(Polygon::of_scene(&model_polygons("builtin:teapot@400", size)?));
    let scenes = [
        ("object at one side", object((320, 320))?),
        ("object in the middle", object(SIZE)?),
        ("cargo bay", walls()),
    ];
    // How evenly an object is spread over the quarters depends on its place: the side of the picture that it fills.
    let mut places = Table::new("places", &[("picture", "px"), ("splitter-4 over interlace-4", "")]);
    let mut ratios = Vec::new();
    for side in (256..=512).step_by(32) {
        let scene = object((side, side))?;
        let [interlace, splitter] = [Machine::PUBLISHED[1], Machine::PUBLISHED[2]]
            .map(|(_, machine)| run(machine, &scene).map(|r| r.slowest().1));
        ratios.push((f64::from(side), splitter? / interlace?));
    }
    ratios.iter().for_each(|p| places.push([p.0.into(), p.1.into()]));
    for (input, figure, printed) in VIEWS {
        let number = format!("splitter-4 takes {printed} of interlace-4 ({figure})");
        comparison.fit(Fit::new(number, input, printed, ratios.clone()));
    }
    for (name, scene) in scenes {
        let mut times = Vec::new();
        for (machine_name, machine) in Machine::PUBLISHED {
            let (_, cycles) = run(machine, &scene)?.slowest();
            table.push([
                name.into(),
                (scene.len() as f64).into(),
                machine_name.into(),
                (cycles / 1e6).into(),
            ]);
            times.push(cycles);
        }
        let [interlace, splitter] = [times[1], times[2]];
        if name == "cargo bay" {
            // 1.97 against 2.01 and 1.83 against 2.02 million cycles.
            let says = format!("even: splitter-4 is faster ({:.3} of interlace-4)", splitter / interlace);
            comparison.claim(says, splitter < interlace);
        }
    }
    Ok(Findings {
        tables: vec![table, places],
        plots: Vec::new(),
        remarks: vec![
            "A teapot of about 400 triangles at one side of the screen stands for the shuttle seen from outside (figures 22 \
             and 23), walls of 88 quadrilaterals that fill the screen for its cargo bay (figures 24 and 25). Where the same \
             teapot stands in the middle, it divides evenly and the splitter gains."
                .into(),
        ],
        verdict: comparison.qualitative("The shuttle is lost."),
    })
}

/// 64 squares that tile the screen behind 24 larger ones.
fn walls() -> Vec<Polygon> {
    let square = |x: i32, y: i32, w: i32, h: i32| {
        Polygon::new([[x, y], [x + w - 1, y], [x + w - 1, y + h - 1], [x, y + h - 1]])
    };
    let tiles = (0..64).map(|i| square(i % 8 * 64, i / 8 * 64, 64, 64));
    let panels = (0..24).map(|i| square(10 + i % 6 * 84, 5 + i / 6 * 128, 70, 110));
    tiles.chain(panels).flatten().collect()
}
