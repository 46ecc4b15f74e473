//! Whole commands that draw many pictures, and VTK files with appended raw arrays.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use serde_json::Value;
use tercio_testkit::workspace_root;

use super::parallel::{build, simd};
use super::report::{Bar, Report, digits};
use super::{Arguments, machine};

/// Small files of a batch.
const FILES: usize = 1000;
/// Pictures of the film.
const PICTURES: usize = 360;
/// Points along each axis of the VTK files: of a surface, and of a box of hexahedra.
const SURFACE: usize = 1400;
const BOX: usize = 110;

/// Measures and writes `batch.md`.
///
/// # Errors
/// tercio does not build, or fails.
pub fn run(arguments: &Arguments) -> Result<()> {
    let program = match &arguments.tercio {
        Some(program) => program.clone(),
        None => build(false)?,
    };
    let mut report = Report::new(machine::of(&simd(&program)?, "cargo xtask bench batch")?);
    let folder = tempfile::tempdir()?;
    commands(&program, folder.path(), arguments, &mut report)?;
    vtk(&program, folder.path(), arguments, &mut report)?;
    report.note_load();
    println!("{}", report.markdown());
    let output = arguments.output.clone().unwrap_or_else(|| workspace_root().join("docs/performance"));
    report.write_text(&output, "batch.md")
}

/// Runs the program, and returns the seconds.
fn seconds(program: &Path, folder: &Path, arguments: &[&str]) -> Result<f64> {
    let mut command = Command::new(program);
    command.args(arguments).arg("--quiet").current_dir(folder).env("TERCIO_CONFIG", "none");
    let begin = Instant::now();
    let status = command.stdin(Stdio::null()).status()?;
    ensure!(status.success(), "tercio {}: {status}", arguments.join(" "));
    Ok(begin.elapsed().as_secs_f64())
}

fn least(rounds: u32, mut measure: impl FnMut() -> Result<f64>) -> Result<f64> {
    (0..rounds).try_fold(f64::INFINITY, |least, _| Ok(measure()?.min(least)))
}

/// Commands that draw many pictures.
fn commands(program: &Path, folder: &Path, arguments: &Arguments, report: &mut Report) -> Result<()> {
    let introduction = format!(
        "Seconds of a command with the threads that it takes by default, the least of {} runs; files are in the page cache.",
        arguments.rounds
    );
    report.table("Many pictures", &introduction, &["command", "pictures", "seconds", "bar", ""]);
    let stl = folder.join("stl");
    std::fs::create_dir(&stl)?;
    for number in 0..FILES {
        std::fs::write(stl.join(format!("part-{number:04}.stl")), small_stl(number))?;
    }
    let files: Vec<String> = (0..FILES).map(|n| format!("stl/part-{n:04}.stl")).collect();
    let to = "thumbs-{name}.png";
    let thumbs: Vec<&str> = std::iter::once("render")
        .chain(files.iter().map(String::as_str))
        .chain(["--size", "256x256", "-o", to])
        .collect();
    let measured = least(arguments.rounds, || seconds(program, folder, &thumbs))?;
    report.judge(
        "`render *.stl --size 256x256 -o {name}.png`, 200 triangles each",
        &FILES.to_string(),
        measured,
        Bar::Most(10.0),
    );
    // Where the real model is, it is the one that the aim is for.
    let dragon = tercio_testkit::shared_data().map(|data| data.join("meshes/ply/dragon_vrip.ply.gz"));
    let (title, model) = match dragon.filter(|path| path.is_file()) {
        Some(path) => ("dragon", path.display().to_string()),
        None => ("builtin:teapot@870k", "builtin:teapot@870k".to_owned()),
    };
    let count = PICTURES.to_string();
    let film = ["render", &model, "--turntable", &count, "--size", "1920x1080", "-o", "film-{:04}.png"];
    let measured = least(arguments.rounds, || seconds(program, folder, &film))?;
    let what = format!("`render` the {title} `--turntable {PICTURES} --size 1920x1080 -o {{:04}}.png`");
    report.judge(&what, &count, measured, Bar::Most(6.0));
    Ok(())
}

/// A bowl of 200 triangles, each of its own form.
fn small_stl(number: usize) -> Vec<u8> {
    const SIDE: usize = 10;
    let at = |i: usize, j: usize| {
        let [x, y] = [i, j].map(|k| k as f32 / SIDE as f32 - 0.5);
        [x, y, (x * x + y * y) * (1.0 + number as f32 / 100.0)]
    };
    let mut file = vec![0; 80];
    file.extend((2 * SIDE as u32 * SIDE as u32).to_le_bytes());
    for (i, j) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        for triangle in [[a, b, c], [a, c, d]] {
            file.extend([0; 12]);
            file.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
            file.extend([0; 2]);
        }
    }
    file
}

/// Files of VTK: how fast they are read.
fn vtk(program: &Path, folder: &Path, arguments: &Arguments, report: &mut Report) -> Result<()> {
    let introduction = format!(
        "`load.milliseconds.read` of `--stats`: from the page cache to the triangles of the surface and their data, the least of {} \
         runs. Arrays are raw and appended; numbers of points have 64 bits.",
        arguments.rounds
    );
    report.table("VTK files", &introduction, &["file", "megabytes", "gigabytes a second", "bar", ""]);
    let files: [(&str, &str, PathBuf); 3] = [
        ("triangles", ".vtp", surface(&folder.join("surface.vtp"), false)?),
        ("triangles", ".vtu", surface(&folder.join("surface.vtu"), true)?),
        ("hexahedra", ".vtu", hexahedra(&folder.join("box.vtu"))?),
    ];
    for (what, extension, path) in files {
        let megabytes = std::fs::metadata(&path)?.len() as f64 / 1e6;
        let model = path.display().to_string();
        let read = least(arguments.rounds, || {
            let stats = "stats.json";
            seconds(
                program,
                folder,
                &["render", &model, "--size", "64x64", "-o", "vtk.png", "--stats", stats],
            )?;
            let stats: Value = serde_json::from_slice(&std::fs::read(folder.join(stats))?)?;
            stats["load"]["milliseconds"]["read"].as_f64().context("no time of reading in --stats")
        })?;
        report.judge(
            &format!("`{extension}`, {what}"),
            &digits(megabytes),
            megabytes / read,
            Bar::Least(1.0),
        );
    }
    Ok(())
}

/// Writes a file with appended raw arrays: the heads before and after the offsets of each.
fn write_vtk(path: &Path, kind: &str, counts: &str, arrays: &[(&str, Vec<u8>)]) -> Result<PathBuf> {
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\"><{kind}><Piece {counts}>"
    );
    let mut offset = 0;
    for (head, bytes) in arrays {
        let _ =
            write!(text, "{}", head.replace("{offset}", &format!("format=\"appended\" offset=\"{offset}\"")));
        offset += 8 + bytes.len();
    }
    let _ = write!(text, "</Piece></{kind}><AppendedData encoding=\"raw\">_");
    let mut file = text.into_bytes();
    for (_, bytes) in arrays {
        file.extend((bytes.len() as u64).to_le_bytes());
        file.extend_from_slice(bytes);
    }
    file.extend(b"</AppendedData></VTKFile>");
    std::fs::write(path, file)?;
    Ok(path.to_owned())
}

fn bytes<const N: usize>(numbers: impl Iterator<Item = [u8; N]>) -> Vec<u8> {
    numbers.flatten().collect()
}

/// A wavy surface with a value at each point.
fn surface(path: &Path, is_unstructured: bool) -> Result<PathBuf> {
    const N: usize = SURFACE;
    let height = |i: usize| ((i % N) as f32 / 50.0).sin() * 30.0 * ((i / N) as f32 / 70.0).cos();
    let points = (0..N * N).flat_map(|i| [(i % N) as f32, (i / N) as f32, height(i)]).map(f32::to_le_bytes);
    let cells = (0..(N - 1) * (N - 1)).flat_map(|cell| {
        let a = cell / (N - 1) * N + cell % (N - 1);
        [a, a + 1, a + N + 1, a, a + N + 1, a + N]
    });
    let triangles = 2 * (N - 1) * (N - 1);
    let values = bytes((0..N * N).map(|i| height(i).to_le_bytes()));
    let mut arrays = vec![
        ("<PointData><DataArray type=\"Float32\" Name=\"height\" {offset}/></PointData>", values),
        ("<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" {offset}/></Points>", bytes(points)),
    ];
    let corners = bytes(cells.map(|n| (n as u64).to_le_bytes()));
    let ends = bytes((1..=triangles).map(|n| (3 * n as u64).to_le_bytes()));
    let connectivity = "<DataArray type=\"Int64\" Name=\"connectivity\" {offset}/>";
    let (kind, count) = if is_unstructured {
        arrays.push(("<Cells><DataArray type=\"UInt8\" Name=\"types\" {offset}/>", vec![5; triangles]));
        arrays.push((connectivity, corners));
        arrays.push(("<DataArray type=\"Int64\" Name=\"offsets\" {offset}/></Cells>", ends));
        ("UnstructuredGrid", "NumberOfCells")
    } else {
        arrays.push(("<Polys><DataArray type=\"Int64\" Name=\"connectivity\" {offset}/>", corners));
        arrays.push(("<DataArray type=\"Int64\" Name=\"offsets\" {offset}/></Polys>", ends));
        ("PolyData", "NumberOfPolys")
    };
    write_vtk(path, kind, &format!("NumberOfPoints=\"{}\" {count}=\"{triangles}\"", N * N), &arrays)
}

/// A box of hexahedra with a value at each point and one at each cell.
fn hexahedra(path: &Path) -> Result<PathBuf> {
    const N: usize = BOX;
    let split = |i: usize, n: usize| [i % n, i / n % n, i / n / n];
    let points = (0..N * N * N).flat_map(|i| split(i, N)).map(|c| (c as f32).to_le_bytes());
    let cells = (N - 1) * (N - 1) * (N - 1);
    let corners = (0..cells).flat_map(|cell| {
        let [x, y, z] = split(cell, N - 1);
        let at = |x: usize, y: usize, z: usize| x + N * (y + N * z);
        [
            at(x, y, z),
            at(x + 1, y, z),
            at(x + 1, y + 1, z),
            at(x, y + 1, z),
            at(x, y, z + 1),
            at(x + 1, y, z + 1),
            at(x + 1, y + 1, z + 1),
            at(x, y + 1, z + 1),
        ]
    });
    let value = |i: usize| ((i % 1000) as f32).to_le_bytes();
    let arrays = [
        (
            "<PointData><DataArray type=\"Float32\" Name=\"p\" {offset}/></PointData>",
            bytes((0..N * N * N).map(value)),
        ),
        (
            "<CellData><DataArray type=\"Float32\" Name=\"c\" {offset}/></CellData>",
            bytes((0..cells).map(value)),
        ),
        ("<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" {offset}/></Points>", bytes(points)),
        ("<Cells><DataArray type=\"UInt8\" Name=\"types\" {offset}/>", vec![12; cells]),
        (
            "<DataArray type=\"Int64\" Name=\"connectivity\" {offset}/>",
            bytes(corners.map(|n| (n as u64).to_le_bytes())),
        ),
        (
            "<DataArray type=\"Int64\" Name=\"offsets\" {offset}/></Cells>",
            bytes((1..=cells).map(|n| (8 * n as u64).to_le_bytes())),
        ),
    ];
    let counts = format!("NumberOfPoints=\"{}\" NumberOfCells=\"{cells}\"", N * N * N);
    write_vtk(path, "UnstructuredGrid", &counts, &arrays)
}
