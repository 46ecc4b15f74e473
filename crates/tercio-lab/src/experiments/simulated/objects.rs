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

/// Of figures 24 and 25, two views of its cargo bay: the input; the polygons on the screen, and the height of the panels with which
/// one processor takes the printed 6.80 and 6.71 million cycles, within 0.3 %; the times, and their ratio.
const BAYS: [(&str, (usize, i32), &str, &str); 2] = [
    (
        "share of the screen's sides that the panels of figure 24 fill",
        (86, 15),
        "1.97 over 2.01, figure 24",
        "0.98",
    ),
    (
        "share of the screen's sides that the panels of figure 25 fill",
        (94, 9),
        "1.83 over 2.02, figure 25",
        "0.91",
    ),
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
        ("cargo bay", walls((88, 110), 1.0)),
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
    // The splitter waits for the quarter with most of the panels: how many that are depends on how far they are spread.
    let mut panels = Table::new(
        "panels",
        &[
            ("figure", ""),
            ("share of the sides", ""),
            ("splitter-4 over interlace-4", ""),
            ("one processor", "10^6 memory cycles"),
        ],
    );
    for (input, of, figure, printed) in BAYS {
        let mut ratios = Vec::new();
        for share in (6..=20).map(|k| f64::from(k) / 20.0) {
            let scene = walls(of, share);
            let [one, interlace, splitter] = [0, 1, 2].map(|k| {
                let (_, machine) = Machine::PUBLISHED[k];
                run(machine, &scene).map(|r| r.slowest().1)
            });
            let (ratio, one) = (splitter? / interlace?, one?);
            panels.push([figure.into(), share.into(), ratio.into(), (one / 1e6).into()]);
            ratios.push((share, ratio));
        }
        let number = format!("splitter-4 takes {printed} of interlace-4 ({figure})");
        comparison.fit(Fit::new(number, input, printed, ratios));
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
        tables: vec![table, places, panels, comparison.intervals()],
        plots: Vec::new(),
        remarks: vec![
            "A teapot of about 400 triangles at one side of the screen stands for the shuttle seen from outside (figures 22 \
             and 23), walls of quadrilaterals that fill the screen, with as many polygons as the document counts, for its cargo bay \
             (figures 24 and 25). Where the same teapot stands in the middle, it divides evenly and the splitter gains. Of each figure \
             one number is fitted with one input; the times themselves depend on more of the scene than that, and are not."
                .into(),
        ],
        verdict: comparison.qualitative("The shuttle is lost."),
    })
}

/// 64 squares that tile the screen, and as many panels before them, 70 pixels wide, as make up so many polygons. They are spread
/// over this share of the screen's width and height.
fn walls((polygons, height): (usize, i32), share: f64) -> Vec<Polygon> {
    let square = |x: i32, y: i32, w: i32, h: i32| {
        Polygon::new([[x, y], [x + w - 1, y], [x + w - 1, y + h - 1], [x, y + h - 1]])
    };
    let tiles = (0..64).map(|i| square(i % 8 * 64, i / 8 * 64, 64, 64));
    let panels = polygons.saturating_sub(64) as i32;
    let rows = (panels + 5) / 6;
    let shrunk = |distance: i32| (f64::from(distance) * share) as i32;
    let at = |i: i32| [10 + shrunk(i % 6 * 84), 5 + shrunk(i / 6 * (512 / rows))];
    let panels = (0..panels).map(|i| square(at(i)[0], at(i)[1], 70, height));
    tiles.chain(panels).flatten().collect()
}
