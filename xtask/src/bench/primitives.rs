//! What lines, points, glyphs, data and annotation cost, against the plain surface: instructions of pictures.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result};
use tercio_testkit::workspace_root;

use super::report::{Bar, Report, digits};
use super::{Arguments, machine};
use crate::counts::callgrind;
use crate::{dist, packages};

/// One layer, and several. Larger models would take callgrind hours: tubes of 300,000 edges are many triangles.
const MODELS: [&str; 2] = ["builtin:teapot@20k", "builtin:gyroid@20k"];

/// A row: what is drawn, its options, and the most that a picture may take, times the plain surface.
type Primitive = (&'static str, &'static str, Option<f64>);

/// The plain surface, which all others are compared with.
const PLAIN: Primitive = ("plain surface", "", None);

const PRIMITIVES: [Primitive; 38] = [
    ("flat shading", "--shading flat", None),
    ("back faces left out", "--cull back", None),
    ("opacity 0.3", "--opacity 0.3", None),
    ("data of vertices", "--color-by @elevation --no-bar", Some(1.15)),
    ("data of triangles", "--color-by @face --no-bar", Some(1.15)),
    ("data, 8 bands", "--color-by @elevation --no-bar --bands 8", Some(1.15)),
    ("data, logarithms", "--color-by @elevation --no-bar --log", Some(1.15)),
    ("data, categories", "--color-by @component --no-bar --categories", Some(1.15)),
    ("data, 9 isolines", "--color-by @elevation --no-bar --isolines 9", None),
    ("data, opacity by data", "--color-by @elevation --no-bar --opacity-map 0.2,1", None),
    ("contours", "--color-by @elevation --no-bar --mode contours", None),
    ("edges on the surface", "--edges", Some(1.5)),
    ("edges on the surface, 2 pixels", "--edges --line-width 2", Some(1.5)),
    ("edges on the surface, translucent", "--edges --edge-color #20242880", None),
    ("feature edges on the surface", "--edges=feature", Some(1.5)),
    ("silhouette on the surface", "--edges=silhouette", Some(1.5)),
    ("boundaries on the surface", "--edges=boundary", Some(1.5)),
    ("edges and data", "--edges --color-by @elevation --no-bar", None),
    ("wireframe", "--mode wireframe", None),
    ("wireframe, data", "--mode wireframe --color-by @elevation --no-bar", None),
    ("wireframe, tubes", "--mode wireframe --line-shape tube", None),
    ("hidden lines removed", "--mode hidden-line", None),
    ("feature edges alone", "--mode edges", None),
    ("silhouette alone", "--mode edges --edges=silhouette", None),
    ("points, discs", "--mode points", None),
    ("points, squares", "--mode points --point-shape square", None),
    ("points, spheres", "--mode points --point-shape sphere", None),
    ("points, spheres of 12 pixels", "--mode points --point-shape sphere --point-size 12", None),
    ("glyphs: 2,000 arrows", "--glyphs @normal", None),
    ("glyphs: 2,000 lines", "--glyphs @normal --glyph line", None),
    ("glyphs: 2,000 cones", "--glyphs @normal --glyph cone", None),
    ("glyphs: 2,000 spheres", "--glyphs @normal --glyph sphere", None),
    ("scalar bar", "--color-by @elevation", None),
    ("title", "--title Title", None),
    ("axes", "--axes", None),
    ("scale bar", "--scale-bar", None),
    ("bounds", "--bounds", None),
    ("grid", "--grid", None),
];

/// Quadrilaterals along each side of [`QUADRILATERALS`].
const CELLS: usize = 400;

/// Waves of flat quadrilaterals, and of bent ones: files.
const QUADRILATERALS: [&str; 2] = ["quadrilaterals.obj", "bent_quadrilaterals.obj"];

/// What is drawn of the quadrilaterals: all else is that of triangles.
const OF_QUADRILATERALS: [Primitive; 6] = [
    ("edges on the surface", "--edges", Some(1.5)),
    ("edges on the surface, translucent", "--edges --edge-color #20242880", None),
    ("silhouette on the surface", "--edges=silhouette", Some(1.5)),
    ("edges and data", "--edges --color-by @elevation --no-bar", None),
    ("hidden lines removed", "--mode hidden-line", None),
    ("silhouette alone", "--mode edges --edges=silhouette", None),
];

/// What pictures of a model take.
#[derive(Clone, Copy)]
struct Counted {
    /// Before the first one, after the last, and for the first three more than for others.
    once: u64,
    /// For each.
    picture: u64,
}

/// Counts and writes `primitives.md`.
///
/// # Errors
/// tercio does not build, or fails.
pub fn run(arguments: &Arguments) -> Result<()> {
    packages::provide(packages::TESTS);
    let program = match &arguments.tercio {
        Some(program) => std::path::absolute(program)?,
        None => dist::build()?,
    };
    let mut report = Report::new(machine::of("AVX2", "cargo xtask bench primitives")?);
    report.note(
        "Instructions of `tercio render MODEL OPTIONS --size 1024x1024 -o picture_{}.ppm`, in one thread at the AVX2 level, \
         4 samples per pixel, counted by callgrind: they are the same in every run, and do not show waiting for memory. One \
         picture is half of what a turntable of five takes more than a turntable of three; what is left of the latter is \
         taken once, for loading the model and finding edges, points and ranges. Writing the picture is in all of them.",
    );
    let folder = tempfile::tempdir()?;
    for (name, is_bent) in QUADRILATERALS.into_iter().zip([false, true]) {
        std::fs::write(folder.path().join(name), quadrilaterals(is_bent))?;
    }
    let of_triangles = MODELS.map(|model| (model, &PRIMITIVES[..]));
    let of_quadrilaterals = QUADRILATERALS.map(|model| (model, &OF_QUADRILATERALS[..]));
    for (model, primitives) in of_triangles.into_iter().chain(of_quadrilaterals) {
        let count = |(what, options, _): Primitive| {
            counted(&program, model, options, folder.path()).with_context(|| format!("{model}: {what}"))
        };
        let plain = count(PLAIN)?;
        let introduction = format!(
            "Plain, a picture takes {} million instructions, and the run {} million once.",
            millions(plain.picture),
            millions(plain.once)
        );
        let columns =
            ["primitive", "options", "picture, times plain", "limit", "once, millions more than plain"];
        report.table(model, &introduction, &columns);
        for &primitive in primitives {
            let (what, options, most) = primitive;
            let counted = count(primitive)?;
            let ratio = counted.picture as f64 / plain.picture as f64;
            let limit = most.map_or(String::new(), |most| {
                let bar = Bar::Most(most);
                format!("{bar}: {}", bar.verdict(ratio))
            });
            let more = (counted.once as f64 - plain.once as f64) / 1e6;
            report.row(&[what, &format!("`{options}`"), &digits(ratio), &limit, &digits(more)]);
        }
    }
    println!("{}", report.markdown());
    let folder = arguments.output.clone().unwrap_or_else(|| workspace_root().join("docs/performance"));
    report.write_text(&folder, "primitives.md")
}

/// Two runs that differ only in their number of pictures.
fn counted(program: &Path, model: &str, options: &str, folder: &Path) -> Result<Counted> {
    let run = |pictures: &str| {
        let mut all = vec!["render", model, "--turntable", pictures, "-o", "picture_{}.ppm"];
        all.extend("--size 1024x1024 --threads 1 --simd avx2 --quiet".split_whitespace());
        all.extend(options.split_whitespace());
        callgrind::count(program, &all, folder)
    };
    // What is made in the third picture, because several are drawn, is taken once.
    let (three, five) = (run("3")?, run("5")?);
    let picture = five.saturating_sub(three) / 2;
    Ok(Counted { once: three.saturating_sub(3 * picture), picture })
}

/// A file of [`QUADRILATERALS`]: if heights depend on one coordinate only, all are flat.
fn quadrilaterals(is_bent: bool) -> String {
    let mut text = String::new();
    let all = || (0..=CELLS).flat_map(|row| (0..=CELLS).map(move |column| (row, column)));
    for (row, column) in all() {
        let [x, y] = [column, row].map(|k| k as f64 / CELLS as f64 * 4.0 - 2.0);
        let height = 0.4 * (3.0 * x).sin() * if is_bent { (2.5 * y).cos() } else { 1.0 };
        let _ = writeln!(text, "v {x:.6} {y:.6} {height:.6}");
    }
    for (row, column) in all().filter(|(row, column)| *row < CELLS && *column < CELLS) {
        let a = row * (CELLS + 1) + column + 1;
        let _ = writeln!(text, "f {} {} {} {}", a, a + 1, a + CELLS + 2, a + CELLS + 1);
    }
    text
}

fn millions(count: u64) -> String {
    digits(count as f64 / 1e6)
}
