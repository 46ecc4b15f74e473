//! Help, and invalid arguments.

mod common;

use common::Place;

#[test]
fn help_shows_commands_examples_and_groups() {
    let place = Place::new();
    let help = place.run("--help").ok_silently();
    for command in ["render", "info", "compare"] {
        assert!(help.text().contains(command));
        let own = place.run(&format!("{command} --help")).ok_silently();
        assert!(own.text().contains("Examples:") && own.text().contains("Exit code:"), "{command}");
    }
    let render = place.run("render --help").ok_silently();
    for heading in ["Writing:", "Camera:", "Drawing:", "Tuning", "Running:"] {
        assert!(render.text().contains(heading), "{heading}");
    }
    let version = place.run("--version").ok_silently();
    assert_eq!(version.text(), format!("tercio {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn wrong_usage_is_reported_before_any_work() {
    // The model does not exist: opening it first would end with exit code 1.
    let place = Place::new();
    let cases = [
        ("", "--output"),
        ("-o a.bmp", "extension must be .png, .ppm, .webp, .jpg, .svg or .pdf"),
        ("-o a", "extension"),
        ("-o a.png --size 0x5", "--size"),
        ("-o a.png --size 65537x5", "--size"),
        ("-o a.png --aa 3", "expected 1, 2, 4, 8, 16, 2x2 or 4x4 samples"),
        ("-o a.png --aa 1 --aa-filter tent", "--aa-filter has no effect"),
        ("-o a.png --aa-shading sample --aa 1", "--aa-shading has no effect"),
        ("-o a.png --threads 0", "--threads"),
        ("-o a.png --threads 257", "--threads"),
        ("-o a.png --view top --azimuth 3", "--azimuth"),
        ("-o a.png --view top --eye 1,2,3", "--eye"),
        ("-o a.png --eye 1,2", "--eye"),
        ("-o a.png --eye 1e300,0,0", "'--eye <X,Y,Z>': expected numbers of at most 1e100"),
        ("-o a.png --target 1,2,3", "--eye"),
        ("-o a.png --up 0,0,1", "--eye"),
        ("-o a.png --fov 30 --orthographic", "--orthographic"),
        ("-o a.png --fov 180", "--fov"),
        ("-o a.png --zoom 0", "--zoom"),
        ("-o a.png --zoom 1e-30", "'--zoom <FACTOR>': expected a factor of 0.001 to 1000000"),
        ("-o a.png --zoom 1e30", "'--zoom <FACTOR>': expected a factor of 0.001 to 1000000"),
        ("-o a.png --near -1", "--near"),
        ("-o a.png --light sun", "--light"),
        ("-o a.png --shading unlit --light head", "--light"),
        ("-o a.png --color reddish", "--color"),
        ("-o a.png --tile-size 17", "tile size"),
        ("-o a.png --simd mmx", "--simd"),
        ("-o a.png --memory-limit lots", "--memory-limit"),
        ("-o a.png --quiet --verbose", "--verbose"),
        ("-o a.webp --depth 16", "WebP"),
        ("-o a.webp --size 16385x1", "WebP"),
        ("-o a.ppm --background transparent", "transparency"),
        ("-o a.ppm --background #fff,#ffffff00", "transparency"),
        ("-o a.jpg --background transparent", "JPEG has no transparency"),
        ("-o a.jpg --depth 16", "JPEG has no --depth 16"),
        ("-o a.jpg --quality 0", "--quality"),
        ("-o a.png --quality 50", "--quality is for JPEG"),
        ("-o a.webp --turntable 4 --size 20000x10", "16384"),
        ("-o - --stats -", "standard output"),
        ("-o a.png --stats a.png", "a.png"),
        ("--output-depth a.npy --output-ids a.npy", "a.npy"),
        ("--output-depth a.npy --format png", "--output"),
        ("-o a.png --ao 0.5", "follows an equals sign: '--ao=0.5'"),
        ("-o a.png --shadows 1024", "'--shadows=1024'"),
        ("-o a.png --clip-cap #f00", "'--clip-cap=#f00'"),
    ];
    for (arguments, part) in cases {
        place.run(&format!("render missing.ply {arguments}")).failed(2, &[part]);
    }
    place.run("render --edl 2 missing.ply -o a.png").failed(2, &["'--edl=2'"]);
    // What is surplus, not what stands before it.
    let surplus = place.run("render --ao missing.ply other.ply -o a.png");
    surplus.failed(2, &["other.ply"]);
    assert!(!surplus.stderr.contains("equals sign"), "{}", surplus.stderr);
    let levels = if cfg!(target_arch = "x86_64") { "neon" } else { "avx2" };
    place.run(&format!("render missing.ply -o a.png --simd {levels}")).failed(2, &["SIMD level"]);
    assert_eq!(place.names(), ["model.off"]);
}

/// A wrong option gets the tip that helps, or none.
#[test]
fn tips_help() {
    let place = Place::new();
    let cases = [
        ("--wireframe", Some("--mode wireframe")),
        ("--azimut 3", Some("'--azimuth'")),
        ("-e", Some("'--edges'")),
        ("--hdri-file sky.hdr", Some("--environment FILE")),
        ("--foo", None),
        ("--translation", None),
        ("--flub", None),
    ];
    for (option, tip) in cases {
        let outcome = place.run(&format!("render model.off -o a.png {option}"));
        outcome.failed(2, &["unexpected argument", tip.unwrap_or("Usage:")]);
        assert_eq!(outcome.stderr.contains("tip:"), tip.is_some(), "{option}: {}", outcome.stderr);
    }
    place.run("render model.off -o a.png --point-size -3").failed(2, &["--point-size", "above 0"]);
}

/// Names of F3D and PyVista do what those of tercio do.
#[test]
fn options_of_other_programs_are_known() {
    let place = Place::new();
    let pairs = [
        ("--window_size 48,36 --show-edges --off-screen", "--size 48x36 --edges"),
        (
            "--resolution 48,36 --style wireframe --no-background",
            "--size 48x36 --mode wireframe --background transparent",
        ),
        ("-s 48x36 --camera-position 3,2,5 --camera-view-angle 40", "-s 48x36 --eye 3,2,5 --fov 40"),
        (
            "-s 48x36 --scalars @elevation --n-colors 4 --clim 0,1",
            "-s 48x36 --color-by @elevation --bands 4 --range 0,1",
        ),
        (
            "-s 48x36 --point-sprites --parallel-projection",
            "-s 48x36 --mode points --point-shape sphere --orthographic",
        ),
        ("-s 48x36 --up -Z", "-s 48x36 --up-axis z --roll 180 --azimuth -15 --elevation -18"),
        ("-s 48x36 --camera-direction +X", "-s 48x36 --camera-direction 1,0,0"),
    ];
    for (other, own) in pairs {
        place.run(&format!("render model.off -o a.png --quiet {other}")).ok_silently();
        place.run(&format!("render model.off -o b.png --quiet {own}")).ok_silently();
        assert!(place.read("a.png") == place.read("b.png"), "{other}");
    }
}

#[test]
fn commands_without_their_arguments_are_refused() {
    let place = Place::new();
    place.run("bench").failed(2, &["bench"]);
    place.run("compare a.png").failed(2, &["<B>"]);
    for threshold in ["-1", "300", "255.001", "nan"] {
        place
            .run(&format!("compare a.png b.png --threshold {threshold}"))
            .failed(2, &["--threshold", "0 to 255"]);
    }
    place.run("compare a.png b.png --diff d.bmp").failed(2, &["d.bmp"]);
}

#[cfg(not(feature = "mpi"))]
#[test]
fn a_program_without_mpi_tells_mpirun_how_to_build_one() {
    let place = Place::new();
    let run = |arguments: &str, processes: &str| -> common::Outcome {
        let mut command = place.command(arguments);
        command.env("OMPI_COMM_WORLD_SIZE", processes).output().expect("the program starts").into()
    };
    for command in ["render model.off -o a.png", "lab calibrate -o a.toml"] {
        run(command, "4").failed(1, &["mpirun started 4", "--features mpi"]);
    }
    run("render model.off -o a.png --organisation sort-first", "1").failed(1, &["--features mpi"]);
    assert_eq!(place.names(), ["model.off"]);
    // A job of one process is the same as no job.
    run("render model.off -o a.png", "1").ok_silently();
}

/// Messages of other processes of a job come between two writes, not into one.
#[cfg(unix)]
#[test]
fn messages_are_written_at_once() {
    use std::os::fd::OwnedFd;
    use std::os::unix::net::UnixDatagram;

    let place = Place::new();
    std::fs::write(place.path("model.off"), "OFF 0 0 0").unwrap();
    for (arguments, says) in [
        ("render model.off -o a.png --size 0x9", "--size"),
        ("render", "required"),
        ("render model.off -o ./model.off --format png", "an output must not be an input"),
        ("info missing.off", "missing.off"),
    ] {
        // Each write is a message of its own.
        let (reader, writer) = UnixDatagram::pair().unwrap();
        let status = place.command(arguments).stderr(OwnedFd::from(writer)).status().unwrap();
        assert!(!status.success(), "{arguments}");
        reader.set_nonblocking(true).unwrap();
        let mut bytes = [0; 1 << 14];
        let mut writes = Vec::new();
        while let Ok(count @ 1..) = reader.recv(&mut bytes) {
            writes.push(String::from_utf8_lossy(&bytes[..count]).into_owned());
        }
        let [text] = &writes[..] else { panic!("{arguments}: {writes:?}") };
        assert!(
            text.starts_with("error: ") && text.contains(says) && text.ends_with('\n'),
            "{arguments}: {text}"
        );
        assert_eq!(text.contains("For more information"), status.code() == Some(2), "{arguments}: {text}");
    }
}
