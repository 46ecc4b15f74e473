//! What culling by quantised normals is worth: sections 3.2.4 and 3.2.5.

use glam::DVec3;
use tercio_mesh::{Mesh, builtin, trig};

use super::scenes::{SCREEN, SMALL};
use crate::experiments::facts::Facts;
use crate::experiments::sweep::sweep;
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Fit, Plot, Series, Table,
};
use crate::machines::load;
use crate::predict::views;
use crate::simulators::hybris::planes::{Ball, Culled, behind_all, count};

pub(crate) const EXPERIMENTS: &[Experiment] = &[Experiment {
    id: "hybris-sec-3-2-4-culling",
    document: Document::Hybris,
    place: "sections 3.2.4 and 3.2.5",
    title: "Culling by planes in 32 bits, of triangles and of partitions",
    run: culling,
}];

/// Replacements of the bunny: as many triangles.
const MODELS: [(&str, &str); 2] = [("teapot", SMALL), ("sphere", "builtin:sphere@69451")];
/// Views round each model.
const VIEWS: u32 = 8;

/// Mean counts a frame.
struct Counted {
    model: &'static str,
    /// Triangles culled by their planes.
    culled: f64,
    /// Vertices that partitions spare.
    spared: f64,
}

/// The eye and the ball of a mesh, in its own coordinates.
fn place(mesh: &Mesh, view: u32) -> (DVec3, Ball) {
    let bounds = mesh.bounds();
    let unit = mesh.unit();
    let local = |p: DVec3| (p - mesh.origin) / unit;
    let eye = local(views::camera(&bounds, SCREEN, view, VIEWS).eye);
    (eye, Ball { centre: local(bounds.center()), radius: 0.5 * bounds.size().length() / unit })
}

fn of_model(mesh: &Mesh) -> Result<Culled, ExperimentError> {
    let all: Vec<_> = (0..VIEWS).collect();
    let counts = sweep(&all, |&view| {
        let (eye, ball) = place(mesh, view);
        Ok(count(mesh, eye, ball))
    })?;
    Ok(counts.into_iter().fold(Culled::default(), |s, c| Culled {
        triangles: s.triangles + c.triangles,
        back: s.back + c.back,
        by_plane: s.by_plane + c.by_plane,
        wrong: s.wrong + c.wrong,
        partitions: s.partitions + c.partitions,
        whole: s.whole + c.whole,
        vertices: s.vertices + c.vertices,
        spared: s.spared + c.spared,
    }))
}

/// The share of triangles culled by the direction alone, by the angle of view, in percent.
fn by_direction(mesh: &Mesh) -> Vec<(f64, f64)> {
    let (eye, ball) = place(mesh, 0);
    let towards = eye - ball.centre;
    let towards = towards / towards.length();
    let share = |degrees: f64| {
        let (sine, _) = trig::sin_cos((0.5 * degrees).to_radians());
        100.0 * behind_all(mesh, towards, sine) as f64 / mesh.triangles.len() as f64
    };
    (0..=30).map(|i| 2.0 * f64::from(i)).map(|degrees| (degrees, share(degrees))).collect()
}

fn culling() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let rate = facts.given("H4.7c", "single")?;
    // Cycles of a frame of the bunny.
    let frame = load("hybris-single-cpu")?.clock()? / rate;
    let mut table = Table::new(
        "culled",
        &[
            ("model", ""),
            ("triangles", ""),
            ("showing their back", "%"),
            ("culled by their plane", "%"),
            ("left to set-up", "%"),
            ("culled wrongly", ""),
            ("partitions culled", "%"),
            ("vertices spared", "%"),
        ],
    );
    let mut comparison = Comparison::new();
    let mut directions =
        Table::new("directions", &[("model", ""), ("angle of view", "degree"), ("culled", "%")]);
    let (mut counted, mut by_angle) = (Vec::new(), Vec::new());
    for (model, spec) in MODELS {
        let mesh = builtin::make(spec)?;
        let c = of_model(&mesh)?;
        let of = |part: u64, whole: u64| 100.0 * part as f64 / whole.max(1) as f64;
        let triangles = c.triangles / u64::from(VIEWS);
        table.push([
            model.into(),
            (triangles as f64).into(),
            of(c.back, c.triangles).into(),
            of(c.by_plane, c.triangles).into(),
            of(c.back.saturating_sub(c.by_plane), c.triangles).into(),
            (c.wrong as f64).into(),
            of(c.whole, c.partitions).into(),
            of(c.spared, c.vertices).into(),
        ]);
        comparison.claim(
            format!(
                "{model}: no triangle that shows its front is culled, and {:.1} % of those that do not are left to set-up",
                of(c.back.saturating_sub(c.by_plane), c.back)
            ),
            c.wrong == 0 && c.by_plane < c.back,
        );
        comparison.claim(
            format!("{model}: {:.0} % of the partitions are culled whole", of(c.whole, c.partitions)),
            c.whole > 0 && c.by_plane < c.triangles,
        );
        let mean = |n: u64| n as f64 / f64::from(VIEWS);
        counted.push(Counted { model, culled: mean(c.by_plane), spared: mean(c.spared) });
        let points = by_direction(&mesh);
        points.iter().for_each(|p| directions.push([model.into(), p.0.into(), p.1.into()]));
        by_angle.push(Fit::new(
            format!("40 % culled by a direction, {model}"),
            "angle of view in degrees",
            "40",
            points,
        ));
    }
    // The frame rate is that with both. A frame without partitions' culling takes what it saves longer, and one without
    // culling by planes that and what planes save.
    let saved = |number: f64, cycles: f64, before: f64| 100.0 * number * cycles / (frame * before);
    let curve = |most: u32, of: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..=40).map(|i| f64::from(i * most) / 40.0).map(|cycles| (cycles, of(cycles))).collect()
    };
    let [mut planes, mut groups] = [
        ("triangles", "Gain by culling triangles before set-up", "cycles saved a triangle"),
        ("partitions", "Gain by culling partitions", "cycles of a vertex"),
    ]
    .map(|(name, title, x)| {
        Plot::new(name, title, Axis::linear(x), Axis::linear("gain in frames a second, %"))
    });
    let (mut of_planes, mut of_groups) = (Vec::new(), Vec::new());
    for c in &counted {
        let single = curve(160, &|cycles| saved(c.culled, cycles, 1.08));
        let whole = curve(400, &|cycles| saved(c.spared, cycles, 1.0));
        let number = |gain: &str| format!("{gain} % with the {}'s counts", c.model);
        of_planes.push(Fit::new(
            number("7"),
            "cycles that a triangle culled early saves",
            "7",
            single.clone(),
        ));
        of_groups.push(Fit::new(number("8"), "cycles of a vertex", "8", whole.clone()));
        planes = planes.with(Series::line(c.model, single));
        groups = groups.with(Series::line(c.model, whole));
    }
    comparison.fit_one_of(of_planes);
    comparison.fit_one_of(of_groups);
    comparison.fit_one_of(by_angle);
    let level = |most: f64, gain: f64| vec![(0.0, gain), (most, gain)];
    planes = planes.with(Series::line("section 3.2.4", level(160.0, 7.0)).published());
    groups = groups.with(Series::line("section 3.2.5", level(400.0, 8.0)).published());
    Ok(Findings {
        tables: vec![table, directions, comparison.intervals()],
        plots: vec![planes, groups],
        remarks: vec![
            format!(
                "The bunny is not part of this program: a teapot and a sphere of as many triangles take its place, each \
                 seen from {VIEWS} sides; both are shown. What is culled is counted; what that saves depends on the \
                 costs of a vertex and of a triangle's late test, which the document does not state. They are swept, \
                 with a frame of {:.1} million cycles (500 MHz, {rate} frames a second, New Single CPU of figure 4.12): \
                 with the older row's 16 frames a second they would be {:.0} % larger.",
                frame / 1e6,
                100.0 * (rate / 16.0 - 1.0)
            ),
            "That a test against the direction of view culls up to 40 % is what the document says of normal masks: more \
             with a narrower view, half with none."
                .into(),
        ],
        verdict: comparison.qualitative("The bunny, and the costs of a vertex and of a late test, are not given."),
    })
}
