//! C programs over MPI: compiled here, and linked with what `cargo xtask capi` installs.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tercio::glam::{DAffine3, DMat3, DVec3};
use tercio::mesh::arrays::{Arrays, Positions};
use tercio::mesh::color::srgb_to_linear;
use tercio::raster::sampling::{SamplePattern, Sampling};
use tercio::scene::{Background, Projection, UpAxis};
use tercio::{Camera, Framing, Picture, Session, Settings};
use tercio_testkit::data::on_ci;
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
    let other = folder.path().join("other");
    std::fs::create_dir(&other).expect("a folder");
    let jobs = [
        ("alone", 0, "sort-last"),
        ("mpi", 1, "sort-last"),
        ("mpi", 2, "sort-last"),
        ("mpi", 3, "sort-last"),
        ("mpi", 2, "sort-middle"),
        ("mpi", 3, "sort-first"),
        ("mpi", 3, "sort-twice"),
        // Two communicators of a part of the processes each.
        ("split", 5, "sort-last"),
        ("split", 4, "sort-middle"),
        ("split", 2, "sort-first"),
    ];
    for (how, processes, organisation) in jobs {
        run(&program, processes, &[how, organisation, folder.path().to_str().expect("a path")]);
        let what = format!("{processes} processes, {how}, {organisation}");
        for place in [folder.path(), &other].into_iter().take(1 + usize::from(how == "split")) {
            for name in ["first.png", "second.png"] {
                let found = std::fs::read(place.join(name)).expect("a picture");
                let expected = std::fs::read(folder.path().join(format!("expected-{name}"))).expect("a file");
                assert!(found == expected, "{name} in {}, {what}", place.display());
                std::fs::remove_file(place.join(name)).expect("the file");
            }
            let raw = std::fs::read(place.join("second.raw")).expect("pixels");
            assert!(raw == pixels.as_flattened(), "pixels in {}, {what}", place.display());
            std::fs::remove_file(place.join("second.raw")).expect("the file");
        }
    }
}

/// What `pkg-config` says is needed to compile and to link with what is installed in a folder.
fn pkg_config(prefix: &Path, options: &[&str]) -> Vec<String> {
    let mut command = Command::new("pkg-config");
    command.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")).args(options).arg("tercio");
    let output = command.output().expect("pkg-config starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("text");
    text.split_whitespace().map(str::to_owned).collect()
}

/// With the libraries as `cargo xtask capi` installs them: the shared one, then the archive alone.
#[test]
fn c_programs_link_with_what_pkg_config_says() {
    if Command::new("pkg-config").arg("--version").output().is_err() {
        assert!(!on_ci(), "pkg-config is absent, and on CI it has to be there");
        // Not `eprintln!`: the test harness captures that if the test passes.
        let _ =
            writeln!(std::io::stderr(), "skipped: c_programs_link_with_what_pkg_config_says: no pkg-config");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let prefix = folder.path().join("prefix");
    let mut install = Command::new(env!("CARGO"));
    install.current_dir(workspace_root()).args(["xtask", "capi", "--mpi", "--prefix"]).arg(&prefix);
    let output = install.arg("--built").arg(libraries()).output().expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(pkg_config(&prefix, &["--modversion"]), [env!("CARGO_PKG_VERSION")]);
    let pixels = expected(folder.path());
    for options in [&["--cflags", "--libs"][..], &["--static", "--cflags", "--libs"]] {
        let is_static = options.contains(&"--static");
        if is_static {
            for name in ["libtercio.so", "libtercio.so.0"] {
                std::fs::remove_file(prefix.join("lib").join(name)).expect("the library");
            }
        }
        let program = folder.path().join("check");
        let mut cc = Command::new("mpicc");
        cc.args(["-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-o"]).arg(&program);
        cc.arg(workspace_root().join("crates/tercio-capi/tests/c/check.c"))
            .args(pkg_config(&prefix, options));
        let output = cc.output().expect("mpicc starts");
        assert!(output.status.success(), "{options:?}: {}", String::from_utf8_lossy(&output.stderr));
        let mut check = Command::new(&program);
        check.args(["alone", "sort-last"]).arg(folder.path());
        let output = check.env("LD_LIBRARY_PATH", prefix.join("lib")).output().expect("the program starts");
        assert!(output.status.success(), "{options:?}: {}", String::from_utf8_lossy(&output.stderr));
        let raw = folder.path().join("second.raw");
        assert!(std::fs::read(&raw).expect("pixels") == pixels.as_flattened(), "{options:?}");
        std::fs::remove_file(raw).expect("the file");
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
