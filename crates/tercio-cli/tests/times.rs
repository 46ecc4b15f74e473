//! Collections of times from the outside: the steps of a simulation as series, films and single pictures.

mod common;

use std::io::Cursor;

use common::Place;

/// The same camera for all pictures.
const VIEW: &str = "--size 48x36 --quiet --eye 0,0,9 --target 0,0,0";

/// A collection of three times, in another order than theirs: a triangle that grows, with a value at each corner.
fn place() -> Place {
    let place = Place::new();
    for (name, size) in [("a", 1), ("b", 2), ("c", 3)] {
        let text = format!(
            "# vtk DataFile Version 3.0\n{name}\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0\n{size} 0 0\n0 {size} 0\n\
             POLYGONS 1 4\n3 0 1 2\nPOINT_DATA 3\nSCALARS p float 1\nLOOKUP_TABLE default\n{size} 2 3\n\
             SCALARS kind int 1\nLOOKUP_TABLE default\n{size} {size} {size}\n"
        );
        std::fs::write(place.path(&format!("{name}.vtk")), text).unwrap();
    }
    let set =
        |time: &str, file: &str| format!("<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}.vtk\"/>");
    let sets = [set("0.30000000000000004", "c"), set("0.1", "a"), set("0.25", "b")].concat();
    let text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\"><Collection>{sets}</Collection></VTKFile>"
    );
    std::fs::write(place.path("run.pvd"), text).unwrap();
    place
}

fn draw(place: &Place, arguments: &str) -> Vec<u8> {
    place.run(&format!("render {arguments} -o alone.png {VIEW}")).ok_silently();
    place.read("alone.png")
}

#[test]
fn numbered_pictures_and_films_show_all_times_in_their_order() {
    let place = place();
    place.run(&format!("render run.pvd -o f_{{:02}}.png {VIEW}")).ok_silently();
    place.run(&format!("render run.pvd -o t{{time}}_{{step}}_{{time:.1f}}.png {VIEW}")).ok_silently();
    place.run(&format!("render run.pvd -o film.webp {VIEW}")).ok_silently();
    place.run(&format!("render run.pvd -o film.gif {VIEW}")).ok_silently();
    let film = place.read("film.webp");
    let mut film = image_webp::WebPDecoder::new(Cursor::new(&film)).unwrap();
    assert_eq!(film.num_frames(), 3);
    let names = ["t0.1_0_0.1.png", "t0.25_1_0.2.png", "t0.3_2_0.3.png"];
    for (number, (file, name)) in ["a", "b", "c"].into_iter().zip(names).enumerate() {
        let alone = draw(&place, &format!("{file}.vtk"));
        assert!(place.read(&format!("f_{number:02}.png")) == alone, "{file}");
        assert!(place.read(name) == alone, "{name}");
        let picture = tercio::image::Picture::from_bytes(&alone).unwrap();
        let tercio::image::Pixels::Eight(pixels) = picture.pixels else { panic!("8 bits") };
        let mut shown = vec![0; film.output_buffer_size().unwrap()];
        film.read_frame(&mut shown).unwrap();
        let expected: Vec<u8> = pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        assert!(shown == expected, "{file} in the film");
    }
    // All have the camera that frames all of them, if none is given.
    place.run("render run.pvd -o g{}.png --size 48x36 --quiet --view front").ok_silently();
    place.run("render a.vtk b.vtk c.vtk -o h{}.png --size 48x36 --quiet --view front").ok_silently();
    assert!((0..3).all(|n| place.read(&format!("g{n}.png")) == place.read(&format!("h{n}.png"))));
}

/// Names, titles and captions of sheets show the times that files of VTK have in their field data.
#[test]
fn files_of_a_series_have_times_of_their_own() {
    let place = place();
    for (name, time) in [("a", "0.1"), ("b", "0.25"), ("c", "0.30000000000000004")] {
        let text = String::from_utf8(place.read(&format!("{name}.vtk"))).unwrap();
        let field = format!("FIELD FieldData 1\nTimeValue 1 1 double\n{time}\nPOINTS");
        std::fs::write(place.path(&format!("step_{name}.vtk")), text.replace("POINTS", &field)).unwrap();
    }
    let steps = "step_a.vtk step_b.vtk step_c.vtk";
    place.run(&format!("render {steps} -o t{{time}}.png {VIEW}")).ok_silently();
    for (name, file) in [("t0.1", "a"), ("t0.25", "b"), ("t0.3", "c")] {
        assert!(place.read(&format!("{name}.png")) == draw(&place, &format!("{file}.vtk")), "{name}");
    }
    let titled = |models: &str, title: &str, output: &str| {
        place.run(&format!("render {models} -o {output} --title {title} {VIEW}")).ok_silently();
    };
    titled(steps, "{time}", "own{}.png");
    titled("run.pvd", "{time}", "pvd{}.png");
    titled("step_b.vtk", "0.25", "b.png");
    assert!((0..3).all(|n| place.read(&format!("own{n}.png")) == place.read(&format!("pvd{n}.png"))));
    assert!(place.read("own1.png") == place.read("b.png"));
    // Of a sheet of files, each with a camera of its own, the captions.
    for (file, time) in [("step_a.vtk", "0.1"), ("step_b.vtk", "0.25"), ("step_c.vtk", "0.3")] {
        place.run(&format!("sheet {file} -o own.png --caption {{time}} --size 48x36 -q")).ok_silently();
        place.run(&format!("sheet {file} -o text.png --caption {time} --size 48x36 -q")).ok_silently();
        assert!(place.read("own.png") == place.read("text.png"), "{file}");
    }
    // `info` prints it, also where the field is behind the points.
    let text = String::from_utf8(place.read("a.vtk")).unwrap();
    let field = "FIELD FieldData 1\nTIME 1 1 float\n1e9\nPOINT_DATA";
    std::fs::write(place.path("behind.vtk"), text.replace("POINT_DATA", field)).unwrap();
    for (file, time) in
        [("step_c.vtk", Some("0.30000000000000004")), ("behind.vtk", Some("1000000000")), ("a.vtk", None)]
    {
        let told = place.run(&format!("info {file}")).ok_silently();
        let row = told.text().lines().find(|line| line.starts_with("time ")).map(|line| line[5..].trim());
        assert_eq!(row, time, "{}", told.text());
        let told = place.run(&format!("info {file} --json")).ok_silently();
        let told: serde_json::Value = serde_json::from_str(told.text()).unwrap();
        assert_eq!(told["time"].as_f64(), time.map(|time| time.parse().unwrap()), "{file}");
    }
    place.run(&format!("render behind.vtk -o b{{time:.1e}}.png {VIEW}")).ok_silently();
    assert!(place.read("b1.0e+09.png") == draw(&place, "a.vtk"));
    // What cannot be read stops no batch.
    let batch =
        place.run(&format!("render step_a.vtk missing.vtk step_b.vtk -o b_{{name}}_{{time}}.png {VIEW}"));
    assert_eq!(batch.code, Some(1), "{}", batch.stderr);
    assert!(batch.stderr.contains("missing.vtk"), "{}", batch.stderr);
    assert!(place.read("b_step_a_0.1.png") == place.read("t0.1.png"));
    assert!(place.read("b_step_b_0.25.png") == place.read("t0.25.png"));
    // Nor does a model without a time, unless all have none.
    let titled = format!("--title {{time}} {VIEW}");
    let batch =
        place.run(&format!("render step_a.vtk a.vtk missing.vtk step_b.vtk -o some_{{name}}.png {titled}"));
    assert_eq!(batch.code, Some(1), "{}", batch.stderr);
    for part in ["a.vtk: {time} is", "missing.vtk"] {
        assert!(batch.stderr.contains(part), "{}", batch.stderr);
    }
    for (name, time) in [("step_a", "0.1"), ("step_b", "0.25")] {
        place.run(&format!("render {name}.vtk -o same.png --title {time} {VIEW}")).ok_silently();
        assert!(place.read(&format!("some_{name}.png")) == place.read("same.png"), "{name}");
    }
    assert!(!place.path("some_a.png").exists());
    place.run(&format!("render a.vtk b.vtk -o n_{{name}}.png {titled}")).failed(2, &["a.vtk: {time} is"]);
    // The bar of another model tells that one's name and time.
    let beside = |title: &str, output: &str| {
        let with = format!("--with step_b.vtk;color-by=p;range=0,9;bar=bottom;bar-title={title}");
        place.run(&format!("render step_a.vtk {with} -o {output} -q --size 320x240")).ok_silently();
    };
    beside("{name}-{time:.2f}", "filled.png");
    beside("step_b-0.25", "written.png");
    assert!(place.read("filled.png") == place.read("written.png"));
    beside("step_a-0.10", "other.png");
    assert!(place.read("filled.png") != place.read("other.png"));
    let none = ["TimeValue", "and it has none (a)"];
    place.run(&format!("render a.vtk -o n.png --title {{time}} {VIEW}")).failed(2, &none);
}

#[test]
fn one_time_is_chosen_by_number_or_by_the_nearest_time() {
    let place = place();
    let all = ["a", "b", "c"].map(|file| draw(&place, &format!("{file}.vtk")));
    for (option, number) in
        [("--step 0", 0), ("--step 2", 2), ("--time 0.25", 1), ("--time 7", 2), ("--time -1", 0)]
    {
        assert!(draw(&place, &format!("run.pvd {option}")) == all[number], "{option}");
    }
    let near = place.run("render run.pvd --time 0.26 -o n.png --size 48x36");
    assert!(near.stderr.contains("has no time 0.26; the nearest is 0.25, step 1"), "{}", near.stderr);
    let turned = place.run("render run.pvd -o n.gif --turntable 2 --size 48x36");
    assert!(turned.stderr.contains("holds 3 times, of which the first is read, 0.1"), "{}", turned.stderr);
    let first = place.run("render run.pvd -o n.png --size 48x36");
    assert!(first.stderr.contains("holds 3 times, of which the first is read, 0.1"), "{}", first.stderr);
    place.run("render run.pvd -o n.png --step 3").failed(2, &["--step 3", "its steps are 0 to 2"]);
    place.run("render model.off -o n.png --step 0").failed(2, &["model.off", "none", "--step and --time"]);
    place.run("render run.pvd -o n.png --step 0 --time 1").failed(2, &["--time"]);
    // What is drawn later is not replaced before.
    let before = place.read("c.vtk");
    place.run("render run.pvd -o c.vtk --format png --size 48x36 --step 0").failed(2, &["c.vtk"]);
    assert!(place.read("c.vtk") == before);
}

#[test]
fn a_colour_means_the_same_at_all_times() {
    let place = place();
    let series = |more: &str| -> [Vec<u8>; 3] {
        place.run(&format!("render run.pvd -o s{{}}.png --color-by {more} --no-bar {VIEW}")).ok_silently();
        [0, 1, 2].map(|n| place.read(&format!("s{n}.png")))
    };
    let each = |options: [&str; 3]| -> [Vec<u8>; 3] {
        let file = |n: usize| ["a", "b", "c"][n];
        [0, 1, 2].map(|n| draw(&place, &format!("{}.vtk --no-bar --color-by {}", file(n), options[n])))
    };
    // Values are 1 2 3, 2 2 3 and 3 2 3.
    let all = series("p");
    assert!(all == each(["p --range 1,3"; 3]), "all times have one range");
    assert!(series("p --range 0%,100%") == all);
    assert!(series("p --range ,3") == all);
    assert!(series("p --log") == each(["p --log --range 1,3"; 3]));
    assert!(series("p --range-over each") == each(["p"; 3]));
    assert!(each(["p"; 3]) != all);
    assert!(series("p --range 2,4") == each(["p --range 2,4"; 3]));
    let kinds = series("kind --categories=2=two");
    assert!(kinds == each(["kind --categories=1=1,2=two,3=3"; 3]), "and one list of categories");
    place
        .run(&format!("render run.pvd -o s{{}}.png --color-by q {VIEW}"))
        .failed(1, &["run.pvd", "there is no attribute \"q\""]);
    // By the first one: the last time has only one value, above all of it.
    let text = place.read("a.vtk");
    let text = String::from_utf8(text).unwrap().replace("\n1 2 3\n", "\n1 2 1.5\n");
    std::fs::write(place.path("a.vtk"), text).unwrap();
    assert!(series("p --range-over first") == each(["p --range 1,2"; 3]));
}

#[test]
fn texts_tell_time_step_and_name() {
    let place = place();
    let texts = "--title {name},{time:.2f} --text bottom-left:{step}/{frame:03}";
    place.run(&format!("render run.pvd -o s{{}}.png {texts} {VIEW}")).ok_silently();
    for (number, (file, time)) in [("a", "0.10"), ("b", "0.25"), ("c", "0.30")].into_iter().enumerate() {
        let same = format!("{file}.vtk --title run,{time} --text bottom-left:{number}/00{number}");
        assert!(draw(&place, &same) == place.read(&format!("s{number}.png")), "{same}");
    }
    let one = draw(&place, "run.pvd --step 1 --title {time}-{step}");
    assert!(one == draw(&place, "b.vtk --title 0.25-1"));
    // The texts of a scalar bar and of a scale bar are no others.
    let bar = "--color-by p --bar-title {name}-{time:.2f} --bar-unit {step} --scale-bar={step}";
    place.run(&format!("render run.pvd -o bar{{}}.png {bar} --range-over each {VIEW}")).ok_silently();
    let same = draw(&place, "b.vtk --color-by p --bar-title run-0.25 --bar-unit 1 --scale-bar=1");
    assert!(place.read("bar1.png") == same);
    let plain = draw(&place, "b.vtk --color-by p --bar-title {{x}}");
    assert!(plain != draw(&place, "b.vtk --color-by p --bar-title x"));
    for (option, text) in [("--bar-title", "{foo}"), ("--bar-unit", "{frame}"), ("--bar-title", "{")] {
        place.run(&format!("render b.vtk -o s.png --color-by p {option} {text}")).failed(2, &[text, "{"]);
    }
    place.run("render b.vtk -o s.png --scale-bar={foo}").failed(2, &["{foo}", "{time}"]);
    // The name of an attribute is no pattern.
    let text = String::from_utf8(place.read("b.vtk")).unwrap().replace("SCALARS p ", "SCALARS {step} ");
    std::fs::write(place.path("braces.vtk"), text).unwrap();
    let braces = draw(&place, "braces.vtk --color-by {step}");
    assert!(braces == draw(&place, "b.vtk --color-by p --bar-title {{step}}"));
    // A turntable counts, and doubled braces are text.
    place.run("render model.off -o s{}.png --turntable 2 --text {frame} --size 48x36 --quiet").ok_silently();
    assert!(place.read("s0.png") != place.read("s1.png"));
    assert!(draw(&place, "b.vtk --title {{x}}") != draw(&place, "b.vtk"));
    place.run("render b.vtk -o s.png --title {x}").failed(2, &["there is no {x}", "{time}"]);
    place.run("render b.vtk -o s.png --title {time}").failed(2, &["{time}", "collection"]);
    place.run("render b.vtk -o s.png --text {frame}").failed(2, &["{frame}"]);
    place.run("render run.pvd -o s{}.png --title {time:x}").failed(2, &["{time:x}"]);
}
