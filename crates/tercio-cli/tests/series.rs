//! Series of pictures from the outside: turntables, views, camera paths, films, models of a series.

mod common;

use std::io::Cursor;
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use common::Place;
use tercio::image::{Picture, Pixels};

const SMALL: &str = "--size 64x48 --quiet";

fn pixels(bytes: &[u8]) -> Vec<[u8; 4]> {
    match Picture::from_bytes(bytes).unwrap().pixels {
        Pixels::Eight(pixels) => pixels.to_vec(),
        _ => panic!("8 bits"),
    }
}

/// The pictures of a turntable of six steps, which must exist.
fn turntable(place: &Place, more: &str) -> Vec<Vec<u8>> {
    place.run(&format!("render model.off -o f_{{:02}}.png --turntable 6 {SMALL} {more}")).ok_silently();
    (0..6).map(|n| place.read(&format!("f_{n:02}.png"))).collect()
}

#[test]
fn every_picture_of_a_series_has_the_bytes_that_its_camera_gives_alone() {
    let place = Place::new();
    let frames = turntable(&place, "--stats stats.json --elevation 25");
    // The model looks the same after a quarter turn.
    assert!(frames[1] != frames[0] && frames[2] != frames[1], "the camera turns");
    let stats: serde_json::Value = serde_json::from_slice(&place.read("stats.json")).unwrap();
    for (n, frame) in frames.iter().enumerate() {
        let camera = &stats["pictures"][n]["camera"];
        let vector = |name: &str| {
            let numbers = camera[name].as_array().unwrap().iter().map(|v| v.as_f64().unwrap().to_string());
            numbers.collect::<Vec<_>>().join(",")
        };
        let (eye, target, up) = (vector("eye"), vector("target"), vector("up"));
        let alone = format!("--eye {eye} --target {target} --up {up}");
        place.run(&format!("render model.off -o alone.png {SMALL} {alone}")).ok_silently();
        assert!(place.read("alone.png") == *frame, "picture {n}");
    }
    // The same with ranks, and from other numbers of threads.
    for more in ["--ranks 2", "--threads 1", "--threads 3"] {
        assert!(turntable(&place, &format!("--elevation 25 {more}")) == frames, "{more}");
    }
    // Views are those that single runs draw.
    place
        .run(&format!("render model.off -o {{view}}.png --view front,top --view isometric {SMALL}"))
        .ok_silently();
    for view in ["front", "top", "iso"] {
        place.run(&format!("render model.off -o alone.png --view {view} {SMALL}")).ok_silently();
        assert!(place.read("alone.png") == place.read(&format!("{view}.png")), "{view}");
    }
}

#[test]
fn films_hold_the_frames() {
    let place = Place::new();
    let frames: Vec<Vec<[u8; 4]>> = turntable(&place, "").iter().map(|f| pixels(f)).collect();
    for name in ["a.gif", "a.apng", "a.webp", "a.y4m"] {
        place.run(&format!("render model.off -o {name} --turntable 6 --fps 10 {SMALL}")).ok_silently();
    }
    let bytes = place.read("a.apng");
    let mut apng = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
    let bytes = place.read("a.gif");
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut gif = options.read_info(&bytes[..]).unwrap();
    let bytes = place.read("a.webp");
    let mut webp = image_webp::WebPDecoder::new(Cursor::new(&bytes)).unwrap();
    assert_eq!(webp.num_frames(), 6);
    let y4m = place.read("a.y4m");
    let header = y4m.iter().position(|&b| b == b'\n').unwrap() + 1;
    assert!(y4m.starts_with(b"YUV4MPEG2 W64 H48 F10:1 "));
    let piped = place.run(&format!("render model.off -o - --format y4m --turntable 6 --fps 10 {SMALL}"));
    assert!(piped.ok_silently().stdout == y4m, "standard output gets the same");
    for (n, frame) in frames.iter().enumerate() {
        let mut shown = vec![0; apng.output_buffer_size().unwrap()];
        apng.next_frame(&mut shown).unwrap();
        let expected: Vec<u8> = frame.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        assert!(shown == expected, "picture {n} of the APNG");
        assert_eq!(webp.read_frame(&mut shown).unwrap(), 100);
        assert!(shown == expected, "picture {n} of the WebP");
        let shown = gif.read_next_frame().unwrap().unwrap();
        assert_eq!(shown.delay, 10);
        let squares: f64 = frame
            .iter()
            .zip(shown.buffer.as_chunks::<4>().0)
            .map(|(a, b)| (0..3).map(|k| f64::from(a[k].abs_diff(b[k])).powi(2)).sum::<f64>())
            .sum();
        let off = (squares / (frame.len() * 3) as f64).sqrt();
        assert!(off < 3.0, "picture {n} of the GIF is off by {off}");
        let luma = &y4m[header + n * (6 + 64 * 48 * 3) + 6..][..64 * 48];
        let y = |p: &[u8; 4]| {
            16.0 + 219.0 / 255.0
                * (0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]))
        };
        assert!(
            frame.iter().zip(luma).all(|(p, &l)| (y(p) - f64::from(l)).abs() < 0.51),
            "picture {n} of Y4M"
        );
    }
}

#[cfg(unix)]
#[test]
fn ffmpeg_gets_the_pixels_and_its_failure_is_told() {
    use std::os::unix::fs::PermissionsExt as _;
    let place = Place::new();
    let frames = turntable(&place, "");
    // Keeps what it gets in the file that it is to make.
    let script = "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nfor last; do :; done\ncat > \"$last\"\n";
    let make = |text: &str| {
        std::fs::write(place.path("ffmpeg"), text).unwrap();
        std::fs::set_permissions(place.path("ffmpeg"), std::fs::Permissions::from_mode(0o755)).unwrap();
    };
    make(script);
    let path = format!("{}:{}", place.path("").display(), std::env::var("PATH").unwrap());
    let run = |arguments: &str| -> common::Outcome {
        place.command(arguments).env("PATH", &path).output().unwrap().into()
    };
    run(&format!("render model.off -o a.mp4 --turntable 6 {SMALL}")).ok_silently();
    let expected: Vec<u8> = frames.iter().flat_map(|f| pixels(f)).flat_map(|p| [p[0], p[1], p[2]]).collect();
    assert!(place.read("a.mp4") == expected);
    run("render model.off -o b.mp4 --turntable 6 --size 63x48").failed(2, &["even width"]);
    make("#!/bin/sh\n[ \"$1\" = -version ] && exit 0\necho 'no encoder' >&2\nexit 3\n");
    run(&format!("render model.off -o b.mp4 --turntable 6 {SMALL}")).failed(1, &["b.mp4", "no encoder"]);
    make("#!/bin/sh\nexit 1\n");
    run(&format!("render model.off -o b.webm --turntable 6 {SMALL}")).failed(1, &["webm", "ffmpeg"]);
    assert!(place.names().iter().all(|name| !name.starts_with("b.") && !name.starts_with(".tercio")));
}

#[test]
fn a_reader_of_a_film_that_has_enough_is_no_error() {
    use std::io::Read as _;
    let place = Place::new();
    let arguments = "render model.off -o - --format y4m --turntable 5000 --size 640x480 --quiet";
    let mut child = place.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut [0; 10_000]).unwrap();
    drop(stdout);
    let outcome = child.wait_with_output().unwrap();
    assert_eq!((outcome.status.code(), outcome.stderr), (Some(0), vec![]));
}

#[cfg(unix)]
#[test]
fn a_series_that_was_killed_is_resumed() {
    let place = Place::new();
    let run = "render builtin:teapot@20k -o f_{:03}.png --turntable 40 --size 320x240 --quiet";
    place.run(run).ok_silently();
    let whole: Vec<Vec<u8>> = (0..40).map(|n| place.read(&format!("f_{n:03}.png"))).collect();
    let count = |place: &Place| place.names().iter().filter(|n| n.starts_with("f_")).count();
    let again = Place::new();
    let mut child = again.command(run).stderr(Stdio::null()).spawn().unwrap();
    let begin = Instant::now();
    while count(&again) < 3 && begin.elapsed() < Duration::from_secs(60) {
        thread::sleep(Duration::from_millis(1));
    }
    // SIGKILL: nothing is cleaned up.
    child.kill().unwrap();
    child.wait().unwrap();
    let there: Vec<String> = again.names().into_iter().filter(|n| n.starts_with("f_")).collect();
    assert!(there.len() >= 3);
    for name in &there {
        let number: usize = name[2..5].parse().unwrap();
        assert!(again.read(name) == whole[number], "{name} appeared when it was whole");
    }
    // One that something else has cut, and one of another size, are drawn again; the others are not touched.
    std::fs::write(again.path(&there[0]), &whole[0][..whole[0].len() - 5]).unwrap();
    again.run(&format!("render model.off -o {} --size 32x24 --quiet", there[1])).ok_silently();
    let stats = again.run(&format!("{run} --resume --stats -")).ok_silently();
    let stats: serde_json::Value = serde_json::from_str(stats.text()).unwrap();
    assert_eq!(stats["pictures_found"], there.len() - 2);
    assert_eq!(stats["pictures"].as_array().unwrap().len(), 42 - there.len());
    for (number, expected) in whole.iter().enumerate() {
        assert!(again.read(&format!("f_{number:03}.png")) == *expected, "picture {number}");
    }
}

/// Files that are there are those of this series only if no model was changed since.
#[test]
fn a_resumed_series_draws_again_what_is_older_than_its_inputs() {
    let place = Place::new();
    // From a second ago: files get the time of the system's last tick, which is before now.
    let later = |name: &str, seconds: u64| {
        let file = std::fs::File::options().append(true).open(place.path(name)).unwrap();
        let now = std::time::SystemTime::now() - Duration::from_secs(1);
        file.set_modified(now + Duration::from_secs(seconds)).unwrap();
    };
    let found = |run: &str| {
        let stats = place.run(&format!("{run} {SMALL} --resume --stats -")).ok_silently();
        let stats: serde_json::Value = serde_json::from_str(stats.text()).unwrap();
        stats["pictures_found"].as_u64().unwrap()
    };
    std::fs::write(place.path("scene.toml"), "[[model]]\nfile = 'model.off'\n").unwrap();
    for (run, input) in [
        ("model.off -o t{}.png --turntable 3", "model.off"),
        ("scene.toml -o s{}.png --turntable 3", "scene.toml"),
    ] {
        later("model.off", 0);
        assert_eq!((found(run), found(run)), (0, 3), "{run}");
        later(input, 60);
        assert_eq!(found(run), 0, "{run}");
    }
    // A series of models: its camera and colours are those of all of them.
    std::fs::copy(place.path("model.off"), place.path("b.off")).unwrap();
    let run = "model.off b.off -o m{}.png";
    later("model.off", 0);
    assert_eq!((found(run), found(run)), (0, 2));
    later("b.off", 60);
    assert_eq!(found(run), 0);
    // One picture was made since.
    later("m1.png", 120);
    assert_eq!(found(run), 1);
}

#[test]
fn keyframes_are_passed_exactly() {
    let place = Place::new();
    let csv =
        "time,eye_x,eye_y,eye_z,target_x,target_y,target_z\n0,0,0,5,0,0,0\n1,4,1,3,0,0.2,0\n2,5,0,0,0,0,0\n";
    std::fs::write(place.path("path.csv"), csv).unwrap();
    place
        .run(&format!("render model.off -o p{{}}.png --camera-path path.csv --frames 5 {SMALL}"))
        .ok_silently();
    for (number, camera) in [
        (0, "--eye 0,0,5 --target 0,0,0"),
        (2, "--eye 4,1,3 --target 0,0.2,0"),
        (4, "--eye 5,0,0 --target 0,0,0"),
    ] {
        place.run(&format!("render model.off -o alone.png {camera} {SMALL}")).ok_silently();
        assert!(place.read("alone.png") == place.read(&format!("p{number}.png")), "picture {number}");
    }
    std::fs::write(place.path("bad.csv"), "time,eye_x\n").unwrap();
    place
        .run("render model.off -o p{}.png --camera-path bad.csv")
        .failed(1, &["bad.csv", "eye_y is missing"]);
    place.run("render model.off -o path.csv --format y4m --camera-path path.csv").failed(2, &["path.csv"]);
}

/// Whether the model does not reach the border of a picture, whose background has one colour in each row.
fn is_whole(place: &Place, name: &str) -> bool {
    let pixels = pixels(&place.read(name));
    let rows: Vec<_> = pixels.chunks(64).collect();
    let is_one = |row: &&[[u8; 4]]| row.iter().all(|p| *p == row[0]);
    assert!(!rows.iter().all(is_one), "{name} shows the model");
    [rows[0], rows[rows.len() - 1]].iter().all(is_one) && rows.iter().all(|row| row[0] == row[row.len() - 1])
}

#[test]
fn models_of_a_series_have_one_camera_and_natural_order() {
    let place = Place::new();
    for (name, size) in [("s10.off", 1.0), ("s9.off", 0.5)] {
        let points = [[size, 0.0], [0.0, size], [-size, -size]].map(|[x, y]| format!("{x} {y} 0\n")).concat();
        std::fs::write(place.path(name), format!("OFF\n3 1 0\n{points}3 0 1 2\n")).unwrap();
    }
    let series = format!("render s10.off s9.off -o s{{step}}.png --view front {SMALL}");
    let is_whole = |name: &str| is_whole(&place, name);
    place.run(&series).ok_silently();
    assert!(is_whole("s0.png") && is_whole("s1.png"), "all models are framed");
    let all = [place.read("s0.png"), place.read("s1.png")];
    place.run(&format!("{series} --frame-over first")).ok_silently();
    assert!(is_whole("s0.png") && !is_whole("s1.png"), "the first model is framed");
    assert!(all[0] != place.read("s0.png"));
    place.run(&format!("render s9.off -o alone.png --view front {SMALL}")).ok_silently();
    assert!(place.read("s0.png") == place.read("alone.png"), "the first one is s9, and has its own camera");
    place.run(&format!("render s10.off -o alone.png --view front {SMALL}")).ok_silently();
    assert!(place.read("s1.png") != place.read("alone.png"), "the second has that of the first");
    std::fs::write(place.path("s11.off"), "OFF\nno model").unwrap();
    place.run(&format!("render s9.off s10.off s11.off -o s.gif {SMALL}")).failed(1, &["s11.off"]);
    assert!(!place.names().contains(&"s.gif".to_owned()), "a film with a step that is missing is none");
}

#[test]
fn copies_and_glyphs_of_all_steps_are_framed() {
    let place = Place::new();
    let mut times = String::new();
    for (number, size) in [1, 2, 3].into_iter().enumerate() {
        let text = format!(
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 {size} 0 0 0 {size} 0\n\
             POLYGONS 1 4\n3 0 1 2\nPOINT_DATA 3\nVECTORS v float\n0 {size} 0 0 {size} 0 0 {size} 0\n"
        );
        std::fs::write(place.path(&format!("t{number}.vtk")), text).unwrap();
        times += &format!("<DataSet timestep=\"{number}\" file=\"t{number}.vtk\"/>");
    }
    let collection = format!("<VTKFile type=\"Collection\"><Collection>{times}</Collection></VTKFile>");
    std::fs::write(place.path("run.pvd"), collection).unwrap();
    let scene = "[[model]]\nfile = 'run.pvd'\n[[model.instance]]\ntranslate = [6, 0, 0]\n";
    std::fs::write(place.path("two.toml"), scene).unwrap();
    for run in ["two.toml", "run.pvd --glyphs v --glyph line --glyph-scale 2"] {
        place.run(&format!("render {run} -o p{{step}}.png --view front {SMALL}")).ok_silently();
        assert!((0..3).all(|n| is_whole(&place, &format!("p{n}.png"))), "{run}");
    }
    // A pipe is read once.
    let of = |name: &str| place.read(name);
    let input = of("t0.vtk");
    let piped = place.run_with_input("render - t2.vtk -o q{step}.png --view front --size 64x48", &input);
    assert!(piped.stderr.contains("standard input can be read only once"), "{}", piped.stderr);
    place.run(&format!("render t0.vtk -o alone.png --view front {SMALL}")).ok_silently();
    assert!(of("q0.png") == of("alone.png"));
    let colored = format!("render - t2.vtk -o q{{step}}.png --color-by v {SMALL}");
    place.run_with_input(&colored, &input).failed(2, &["standard input can be read only once", "--range"]);
}

#[test]
fn what_makes_no_series_is_refused_before_the_model_is_read() {
    let place = Place::new();
    for (arguments, parts) in [
        ("-o a.png --turntable 6", &["6 pictures", "frame_{:04}.png", ".gif"][..]),
        ("-o - --turntable 6", &["6 pictures"]),
        ("-o a.gif", &["--turntable"]),
        ("-o {frame}.png", &["{frame} numbers a series"]),
        ("-o {nmae}{}.png --turntable 2", &["no {nmae}", "{name}"]),
        ("-o a.gif --turntable 2 --fps 60", &["50 pictures a second"]),
        ("-o a.y4m --turntable 2 --background transparent", &["transparency"]),
        ("-o a.gif --turntable 2 --resume", &["--resume"]),
        ("-o a.png --resume", &["--resume"]),
        ("-o a.y4m --turntable 2 --loop 3", &["--loop"]),
        ("-o {view}.png --view top,top", &["2 pictures"]),
        ("-o {}.png --view top,front --turntable 3", &["--turntable turns one view"]),
        ("-o a.gif --turntable 2 --depth 16", &["--depth 16"]),
        ("-o a.gif --turntable 2 --stereo pair", &["--stereo pair"]),
        ("-o {}.png --output-depth d.npy --turntable 2", &["--output-depth d.npy"]),
        ("-o {}.png --turntable 0", &["--turntable"]),
        ("other.ply -o a.png", &["2 models", "{name}"]),
        ("other.ply -o a.gif --turntable 2", &["one camera"]),
    ] {
        place.run(&format!("render missing.ply {arguments}")).failed(2, parts);
    }
    assert_eq!(place.names(), ["model.off"]);
}

#[test]
fn pictures_that_show_nothing_are_told_of() {
    let place = Place::new();
    let away = "time,eye_x,eye_y,eye_z,target_x,target_y,target_z\n0,0,0,5,0,0,0\n1,0,0,5,0,0,9\n";
    std::fs::write(place.path("path.csv"), away).unwrap();
    let run = "render model.off -o p{}.png --camera-path path.csv --frames 2 --size 64x48";
    let outcome = place.run(run);
    assert_eq!(outcome.code, Some(0));
    assert!(outcome.stderr.contains("1 of 2 pictures show nothing"), "{}", outcome.stderr);
    assert!(place.names().contains(&"p1.png".to_owned()), "a gap would break a film");
    let other = Place::new();
    other
        .run("render model.off -o p{}.png --turntable 3 --size 64x48 --eye 0,0,5 --target 0,0,9")
        .failed(1, &["nothing was drawn"]);
    assert_eq!(other.names(), ["model.off"]);
}

#[test]
fn errors_of_names_say_what_there_is() {
    let place = Place::new();
    std::fs::copy(place.path("model.off"), place.path("b.off")).unwrap();
    let known = ["there is no {foo}", "{frame}", "{view}", "{step}", "{time}", "{name}"];
    for run in
        ["model.off -o f_{foo}.png", "model.off b.off -o f_{foo}.png", "model.off b.off -o {name}_{foo}.png"]
    {
        place.run(run).failed(2, &known);
    }
    // A batch: each model has one picture.
    let outcome = place.run("model.off b.off -o n_{frame}_{name}.png");
    outcome.failed(2, &["of this model there is one", "without {name}", "--turntable"]);
    assert!(!outcome.stderr.contains("or several models\n"), "{}", outcome.stderr);
    place.run("model.off b.off -o n_{step}_{name}.png").failed(2, &["{step}", "without {name}"]);
    place.run(&format!("model.off -o a{{{{1}}}}.png {SMALL}")).ok_silently();
    assert!(place.names().contains(&"a{1}.png".to_owned()));
}
