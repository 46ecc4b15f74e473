//! C programs over MPI: compiled here, and linked with what `cargo xtask capi` installs.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tercio::glam::{DAffine3, DMat3, DVec3};
use tercio::mesh::arrays::{Arrays, Positions};
use tercio::mesh::color::srgb_to_linear;
use tercio::raster::sampling::{SamplePattern, Sampling};
use tercio::scene::{Background, Projection, UpAxis};
use tercio::{Camera, Framing, Picture, Session, Settings};
use tercio_testkit::workspace_root;

/// Seconds after which a job is considered to hang.
const HANGS: &str = "300";

/// Where the libraries are: beside the folder of this program.
fn libraries() -> PathBuf {
    let program = std::env::current_exe().expect("this program's path");
    let folder = program.parent().and_then(Path::parent).expect("the folder of the profile").join("examples");
    let how = "cargo build --workspace --example tercio --features tercio-capi/mpi,tercio-capi/library";
    assert!(folder.join("libtercio.so").is_file(), "no library in {}: {how}", folder.display());
    folder
}

/// Compiles a C program, with the shared library or the archive; warnings are errors.
fn compile(source: &str, folder: &Path, is_static: bool) -> PathBuf {
    let (root, libraries) = (workspace_root().join("crates/tercio-capi"), libraries());
    let program = folder.join(Path::new(source).file_stem().expect("a name"));
    let mut cc = Command::new("mpicc");
    cc.args(["-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-o"]).arg(&program);
    cc.arg("-I").arg(root.join("include")).arg(root.join(source));
    if is_static {
        cc.arg(libraries.join("libtercio.a")).args(["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl"]);
    } else {
        cc.arg("-L")
            .arg(&libraries)
            .arg("-ltercio")
            .arg(format!("-Wl,-rpath,{}", libraries.display()))
            .arg("-lm");
    }
    let output = cc.output().expect("mpicc starts");
    assert!(output.status.success(), "{source}: {}", String::from_utf8_lossy(&output.stderr));
    program
}

/// Runs a program; as a job of some processes unless there are none; also as root.
fn run(program: &Path, processes: usize, arguments: &[&str]) -> Output {
    let mut command = Command::new("timeout");
    command.args(["--kill-after=10", HANGS]);
    if processes > 0 {
        command.args(["mpirun", "--oversubscribe", "-n", &processes.to_string()]);
    }
    command.arg(program).args(arguments);
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    let output = command.output().expect("timeout and mpirun start");
    let shown = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{processes} processes, {arguments:?}: {shown}");
    output
}

/// Positions, colours and triangles.
type Saddle = (Vec<[f64; 3]>, Vec<[u8; 4]>, Vec<[u32; 3]>);

/// The saddle of `check.c`, whole.
fn saddle(scale: f64, lift: f64) -> Saddle {
    let (mut positions, mut colors, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for y in 0..25 {
        for x in 0..25 {
            let height = scale * f64::from((x - 12) * (x - 12) - (y - 12) * (y - 12)) / 64.0 + lift;
            positions.push([x.into(), y.into(), height]);
            colors.push([(10 * x) as u8, (10 * y) as u8, 90, 255]);
            if x < 24 && y < 24 {
                let a = (y * 25 + x) as u32;
                triangles.extend([[a, a + 1, a + 26], [a, a + 26, a + 25]]);
            }
        }
    }
    (positions, colors, triangles)
}

/// Writes the pictures of `check.c`, made in Rust, as `expected-...`; returns the pixels of the second one.
fn expected(folder: &Path) -> Vec<[u8; 4]> {
    let mut session = Session::alone();
    let mut settings = Settings::new(160, 120);
    settings.sampling = Sampling::of(SamplePattern::Sparse4);
    *session.background_mut() = Background::Solid([0.2, 0.3, 0.4, 1.0]);
    let arrays = |(positions, colors, triangles): &Saddle, then: &mut dyn FnMut(&Arrays)| {
        then(&Arrays { vertex_colors: Some(colors), ..Arrays::new(Positions::F64(positions), triangles) });
    };
    arrays(&saddle(2.0, 0.0), &mut |arrays| _ = session.add(arrays).expect("a part"));
    let square = [[0.0, 0.0, 1.0], [8.0, 0.0, 1.0], [8.0, 8.0, 1.0], [0.0, 8.0, 1.0]];
    let halves = [[0, 1, 2], [0, 2, 3]];
    let flat =
        Arrays { normals: Some(&[[0.0, 0.0, 1.0]; 4]), ..Arrays::new(Positions::F32(&square), &halves) };
    let square = session.add(&flat).expect("a part");
    let surface = session.surface_mut(square).expect("the part");
    surface.base_color = [0.9, 0.2, 0.1].map(|c| srgb_to_linear(c) as f32);
    surface.opacity = 0.5;
    let turn = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
    *session.transform_mut(square).expect("the part") =
        DAffine3::from_mat3_translation(turn, DVec3::new(16.0, 4.0, 2.0));
    arrays(&saddle(-0.5, 4.0), &mut |arrays| session.show(arrays).expect("shown"));
    let framing =
        Framing { up_axis: UpAxis::Z, azimuth: 20.0, elevation: 30.0, zoom: 1.25, ..settings.framing() };
    let fitted = session.camera(&framing).expect("a camera");
    let placed = Camera {
        eye: DVec3::new(-20.0, -30.0, 25.0),
        target: DVec3::new(12.0, 12.0, 0.0),
        up: DVec3::Z,
        projection: Projection::Perspective { fov_y: 40f64.to_radians() },
        ..fitted
    };
    for (name, camera) in [("first", fitted), ("second", placed)] {
        let frame = session.render(&camera, &settings).expect("a picture").expect("rank 0");
        Picture::from_frame(frame).save(folder.join(format!("expected-{name}.png"))).expect("a file");
    }
    session.frame().expect("the last picture").planes.color.clone()
}

#[test]
fn c_programs_get_the_pictures_of_rust() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = compile("tests/c/check.c", folder.path(), false);
    let pixels = expected(folder.path());
    let at = |name: &str| folder.path().join(name);
    let where_to = folder.path().to_str().expect("a path").to_owned();
    let jobs = [
        (0, "sort-last"),
        (1, "sort-last"),
        (2, "sort-last"),
        (3, "sort-last"),
        (2, "sort-middle"),
        (3, "sort-first"),
        (3, "sort-twice"),
    ];
    for (processes, organisation) in jobs {
        let how = if processes == 0 { "alone" } else { "mpi" };
        run(&program, processes, &[how, organisation, &where_to]);
        for name in ["first.png", "second.png"] {
            let [found, expected] = [name.to_owned(), format!("expected-{name}")]
                .map(|name| std::fs::read(at(&name)).expect("a file"));
            assert!(found == expected, "{name} of {processes} processes, {organisation}");
            std::fs::remove_file(at(name)).expect("the file");
        }
        let raw = std::fs::read(at("second.raw")).expect("pixels");
        assert!(raw == pixels.as_flattened(), "pixels of {processes} processes, {organisation}");
    }
}

#[test]
fn a_simulation_in_c_draws_itself_while_it_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = compile("examples/galaxies.c", folder.path(), true);
    let mut pictures: Vec<Vec<Vec<u8>>> = Vec::new();
    for processes in [1, 2, 3] {
        let out = folder.path().join(processes.to_string());
        let options = "--bodies 301 --steps 40 --every 20 --size 200x150 --pictures";
        let mut arguments: Vec<&str> = options.split(' ').collect();
        arguments.push(out.to_str().expect("a path"));
        let output = run(&program, processes, &arguments);
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(
            text.contains(&format!("40 steps of 301 bodies in {processes} processes, 2 pictures")),
            "{text}"
        );
        assert!(text.contains("elapsed seconds: ") && text.contains("processor seconds: "), "{text}");
        // What is computed is gravity: the energy stays.
        let words: Vec<&str> =
            text.lines().find(|l| l.starts_with("energy")).expect("a line").split(' ').collect();
        let [before, after] = [1, 3].map(|k| words[k].parse::<f64>().expect("a number"));
        assert!(before < 0.0 && (after / before - 1.0).abs() < 1e-3, "{text}");
        let names = ["galaxies-00020.png", "galaxies-00040.png"];
        pictures.push(names.iter().map(|name| std::fs::read(out.join(name)).expect("a picture")).collect());
    }
    assert!(pictures[0][0] != pictures[0][1], "nothing moves");
    assert!(
        pictures.iter().all(|of_job| *of_job == pictures[0]),
        "pictures depend on the number of processes"
    );
    let wrong = Command::new("timeout")
        .args([HANGS, "mpirun", "-n", "1"])
        .arg(&program)
        .args(["--bodies", "x"])
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .output()
        .expect("mpirun starts");
    assert_eq!(wrong.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("usage: galaxies"));
}
