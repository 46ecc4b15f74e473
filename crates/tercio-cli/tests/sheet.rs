//! Contact sheets from the outside.

mod common;

use common::{OCTAHEDRON, Place};
use tercio::image::{Picture, Pixels};

/// A picture, with its size.
fn read(place: &Place, name: &str) -> (usize, usize, Vec<[u8; 4]>) {
    let picture = Picture::from_bytes(&place.read(name)).unwrap();
    let Pixels::Eight(pixels) = picture.pixels else { panic!("8 bits") };
    (picture.width as usize, picture.height as usize, pixels.to_vec())
}

/// Where a picture is in a sheet, exactly: all places.
fn places(sheet: &(usize, usize, Vec<[u8; 4]>), part: &(usize, usize, Vec<[u8; 4]>)) -> Vec<(usize, usize)> {
    let (width, height) = (part.0, part.1);
    let mut found = Vec::new();
    for top in 0..=sheet.1.saturating_sub(height) {
        for left in 0..=sheet.0.saturating_sub(width) {
            let row = |y: usize| &sheet.2[(top + y) * sheet.0 + left..][..width];
            if (0..height).all(|y| row(y) == &part.2[y * width..][..width]) {
                found.push((left, top));
            }
        }
    }
    found
}

/// Makes models of different shapes.
fn place_with(names: &[&str]) -> Place {
    let place = Place::new();
    for (number, name) in names.iter().enumerate() {
        let text = OCTAHEDRON.replacen("0 1 0", &format!("0.{0} 1.{0} 0", number + 1), 1);
        std::fs::write(place.path(name), text).unwrap();
    }
    place
}

const CELL: &str = "--size 60x45 --quiet";

#[test]
fn a_sheet_has_the_pictures_that_its_models_give_alone_in_order() {
    let place = place_with(&["a.off", "b.off", "c.off", "d.off", "e.off"]);
    place.run(&format!("sheet *.off -o sheet.png --columns 3 {CELL}")).ok_silently();
    let sheet = read(&place, "sheet.png");
    let mut found = Vec::new();
    for name in ["a", "b", "c", "d", "e", "model"] {
        // On the sheet's paper.
        place.run(&format!("render {name}.off -o alone.png --background #ffffff {CELL}")).ok_silently();
        let at = places(&sheet, &read(&place, "alone.png"));
        assert_eq!(at.len(), 1, "{name}: {at:?}");
        found.push(at[0]);
    }
    assert!(found[0].1 == found[2].1 && found[0].0 < found[1].0 && found[1].0 < found[2].0, "{found:?}");
    assert!(found[3].0 == found[0].0 && found[3].1 > found[0].1 + 45 && found[5].1 == found[3].1);
    // Names are written below the pictures, and nothing else is on the paper.
    let below = |at: (usize, usize)| {
        let rows = at.1 + 45..at.1 + 45 + 16;
        rows.flat_map(|y| &sheet.2[y * sheet.0 + at.0..][..60]).filter(|p| p[1] < 200).count()
    };
    assert!(
        found.iter().all(|&at| below(at) > 5),
        "{:?}",
        found.iter().map(|&at| below(at)).collect::<Vec<_>>()
    );
    // The bytes do not depend on threads.
    for threads in ["1", "3"] {
        place.run(&format!("sheet *.off -o again.png --columns 3 --threads {threads} {CELL}")).ok_silently();
        assert!(place.read("again.png") == place.read("sheet.png"), "{threads} threads");
    }
    // Pictures touch nothing on paper of any colour.
    place.run(&format!("sheet a.off b.off -o blue.png --background #336699 --caption= {CELL}")).ok_silently();
    let blue = read(&place, "blue.png");
    assert_eq!(blue.2[0], [0x33, 0x66, 0x99, 255]);
    place.run(&format!("render b.off -o alone.png --background #336699 {CELL}")).ok_silently();
    let at = places(&blue, &read(&place, "alone.png"))[0];
    assert_eq!(blue.2[at.1 * blue.0 + at.0], blue.2[0], "the picture's ground is the paper");
    place.run(&format!("sheet a.off b.off -o clear.png --background transparent {CELL}")).ok_silently();
    assert_eq!(read(&place, "clear.png").2[0][3], 0);
    place.run(&format!("sheet a.off b.off -o a.jpg {CELL}")).ok_silently();
    assert_eq!(read(&place, "a.jpg").0, read(&place, "clear.png").0);
}

#[test]
fn views_turns_and_times_are_places_of_a_sheet() {
    let place = place_with(&["a.off"]);
    let alone = |arguments: &str| {
        place.run(&format!("render {arguments} -o alone.png --background #ffffff {CELL}")).ok_silently();
        read(&place, "alone.png")
    };
    place.run(&format!("sheet a.off -o s.png --view front,left,top --columns 1 {CELL}")).ok_silently();
    let sheet = read(&place, "s.png");
    let at = ["front", "left", "top"].map(|view| places(&sheet, &alone(&format!("a.off --view {view}"))));
    assert!(
        at.iter().all(|at| at.len() == 1) && at[0][0].1 < at[1][0].1 && at[1][0].1 < at[2][0].1,
        "{at:?}"
    );
    place.run(&format!("sheet a.off -o s.png --turntable 4 --title Turned {CELL}")).ok_silently();
    place.run(&format!("render a.off -o t{{}}.png --turntable 4 --background #ffffff {CELL}")).ok_silently();
    let sheet = read(&place, "s.png");
    (0..4).for_each(|n| assert!(!places(&sheet, &read(&place, &format!("t{n}.png"))).is_empty(), "{n}"));
    // A collection of times: all with the camera and the range of the series.
    for (name, size) in [("t1", 1.0), ("t2", 2.0)] {
        let text = format!(
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0\n{size} 0 0\n0 {size} 0\n\
             POLYGONS 1 4\n3 0 1 2\nPOINT_DATA 3\nSCALARS p float 1\nLOOKUP_TABLE default\n{size} 2 3\n"
        );
        std::fs::write(place.path(&format!("{name}.vtk")), text).unwrap();
    }
    let sets = "<DataSet timestep=\"0\" file=\"t1.vtk\"/><DataSet timestep=\"0.5\" file=\"t2.vtk\"/>";
    let text = format!("<VTKFile type=\"Collection\"><Collection>{sets}</Collection></VTKFile>");
    std::fs::write(place.path("run.pvd"), text).unwrap();
    let data = "--color-by p --no-bar --view front";
    place.run(&format!("sheet run.pvd -o s.png {data} {CELL}")).ok_silently();
    place.run(&format!("render run.pvd -o t{{}}.png --background #ffffff {data} {CELL}")).ok_silently();
    let sheet = read(&place, "s.png");
    (0..2).for_each(|n| assert_eq!(places(&sheet, &read(&place, &format!("t{n}.png"))).len(), 1, "{n}"));
}

#[test]
fn a_bad_file_has_a_place_that_says_so() {
    let place = place_with(&["a.off", "c.off"]);
    std::fs::remove_file(place.path("model.off")).unwrap();
    std::fs::write(place.path("b.off"), "OFF\n3 1 0\n0 0 0\n").unwrap();
    let outcome = place.run("sheet a.off b.off c.off -o s.png --columns 3 --size 60x45");
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    for part in ["error: b.off: ", "2 models of 3 drawn, 1 failed"] {
        assert!(outcome.stderr.contains(part), "{part:?} is not in {}", outcome.stderr);
    }
    let sheet = read(&place, "s.png");
    let mut at = Vec::new();
    for name in ["a", "c"] {
        place.run(&format!("render {name}.off -o alone.png --background #ffffff {CELL}")).ok_silently();
        at.push(places(&sheet, &read(&place, "alone.png"))[0]);
    }
    // Between them, in the same row, words.
    let left = at[0].0 + (at[1].0 - at[0].0) / 2;
    let words = (at[0].1..at[0].1 + 45).flat_map(|y| &sheet.2[y * sheet.0 + left..][..60]);
    assert!(words.filter(|p| p[1] < 160).count() > 30);
    // If nothing can be drawn, nothing is written.
    let before = place.read("s.png");
    place.run("sheet b.off -o s.png --size 60x45").failed(1, &["b.off", "nothing was drawn"]);
    assert!(place.read("s.png") == before);
}

#[test]
fn what_makes_no_sheet_is_refused_before_models_are_read() {
    let place = Place::new();
    for (arguments, parts) in [
        ("none.off -o a.gif", &["a sheet is a picture"][..]),
        ("none.off -o a.png --depth 16", &["8 bits"]),
        ("none.off -o a.png --output-ids i.npy", &["--output-ids"]),
        ("none.off -o a.png --stats -", &["--stats"]),
        ("none.off -o a.png --stereo pair", &["--stereo pair"]),
        ("none.off -o a.png --watch", &["--watch"]),
        ("none.off -o a.jpg --background transparent", &["JPEG", "transparency"]),
        ("none.off -o a.webp --size 9000x10 --columns 3 none.off none.off", &["webp", "16384"]),
        ("none.off -o a.png --caption {time}", &["{time}"]),
        ("none.off -o a.png --columns 0", &["--columns"]),
        ("none.off -o a.png --with model.off", &["--with"]),
        ("none.off -o a.png --together", &["--together"]),
        ("none.off -o a.png --save-scene a.toml", &["--save-scene"]),
        ("none.off -o a.png --config none", &["--config"]),
        ("none.off -o x_{foo}.png", &["there is no {foo}", "{name}"]),
        ("none.off -o x_{frame}.png --turntable 3", &["one picture", "--caption"]),
        ("none.off a.off -o x_{name}.png", &["in common", "--caption"]),
        ("none.off -o x_{view}.png --view top,left", &["in common", "--caption"]),
        ("none.off -o x_{frame}.png", &["{frame}"]),
        ("none.off a.off -o a.png --text {frame}", &["{frame}", "--turntable", "--caption"]),
        ("none.off a.off -o a.png --caption {step}", &["{step}", ".pvd"]),
        ("none.off -o x_{time:5}.png", &["{time:05}"]),
        ("none.off scene.toml -o a.png", &["scene.toml: a scene file", "tercio render"]),
        ("none.off", &["--output"]),
        ("model.off -o model.off --format png", &["an output must not be an input"]),
    ] {
        place.run(&format!("sheet {arguments}")).failed(2, parts);
    }
    place.run("sheet model.off -o missing/a.png").failed(1, &["missing"]);
    assert_eq!(place.names(), ["model.off"]);
}

#[test]
fn models_of_a_sheet_or_a_batch_share_a_range() {
    let place = place_with(&["a.off", "b.off"]);
    std::fs::write(place.path("c.off"), OCTAHEDRON.replacen("0 1 0", "0 3 0", 1)).unwrap();
    let data = "--color-by @elevation --no-bar --background #ffffff";
    let alone = |name: &str, range: &str| {
        place.run(&format!("render {name}.off -o alone.png {data} {range} {CELL}")).ok_silently();
        read(&place, "alone.png")
    };
    let sheet = |models: &str, over: &str| {
        place.run(&format!("sheet {models} -o sheet.png {data} {over} {CELL}")).ok_silently();
        read(&place, "sheet.png")
    };
    let has = |sheet: &_, part: &_| places(sheet, part).len() == 1;
    let of_all = ["a", "c"].map(|name| alone(name, "--range=-1,3"));
    let own = ["a", "c"].map(|name| alone(name, ""));
    assert!(of_all[0] != own[0]);
    for over in ["", "--range-over all"] {
        let sheet = sheet("a.off c.off", over);
        assert!(of_all.iter().all(|part| has(&sheet, part)), "{over}");
    }
    let each = sheet("a.off c.off", "--range-over each");
    assert!(own.iter().all(|part| has(&each, part)));
    let first = sheet("c.off a.off", "--range-over first");
    assert!(of_all.iter().all(|part| has(&first, part)));
    // Pictures of their own: only if that is asked for. One that cannot be read is reported as ever.
    std::fs::write(place.path("bad.off"), "OFF\n").unwrap();
    for (over, expected) in [("", &own), ("--range-over each", &own), ("--range-over all", &of_all)] {
        let run = format!("render a.off c.off bad.off -o n_{{name}}.png {data} {over} {CELL}");
        place.run(&run).failed(1, &["bad.off"]);
        for (name, expected) in ["a", "c"].iter().zip(expected) {
            assert!(read(&place, &format!("n_{name}.png")) == *expected, "{name} {over}");
        }
    }
    // The range is that of the first one that can be read; a warning says so.
    let told = "the range is that of c.off, as bad.off cannot be read";
    for run in ["render bad.off c.off a.off -o m_{name}.png", "sheet bad.off c.off a.off -o first.png"] {
        let run = place.run(&format!("{run} {data} --range-over first --size 60x45"));
        assert!(run.code == Some(1) && run.stderr.contains(told), "{}", run.stderr);
    }
    for (name, expected) in ["a", "c"].iter().zip(&of_all) {
        assert!(read(&place, &format!("m_{name}.png")) == *expected, "{name}");
    }
    let sheet = read(&place, "first.png");
    assert!(of_all.iter().all(|part| has(&sheet, part)));
}

#[test]
fn what_is_wrong_about_a_sheet_is_told() {
    let place = place_with(&["a.off", "b.off"]);
    for name in ["s.svg", "s.pdf", "s.gif"] {
        place.run(&format!("sheet a.off b.off -o {name}")).failed(2, &["a sheet is a picture", ".png"]);
    }
    place.run("sheet a.off -o s.png --stereo pair").failed(2, &["--stereo pair"]);
    place.run("sheet a.off -o s.png --title {name}").failed(2, &["--title", "--caption"]);
    place.run("sheet a.off -o s.png --title {foo}").failed(2, &["{foo}", "{time}"]);
}

#[test]
fn the_name_of_a_sheet_has_the_placeholders_of_one_picture() {
    let place = place_with(&["a.off"]);
    for (arguments, name) in [
        ("a.off -o one_{name}_{view}.png --view top", "one_a_top.png"),
        ("a.off -o turn_{name}.png --turntable 2", "turn_a.png"),
        ("a.off a.off -o x{{1}}.png", "x{1}.png"),
        ("a.off a.off -o two_{name}_{view}.png --view top", "two_a_top.png"),
    ] {
        place.run(&format!("sheet {arguments} {CELL}")).ok_silently();
        assert!(place.names().contains(&name.into()), "{name}: {:?}", place.names());
    }
}

/// A model in VTK's format, with a time if there is one.
fn timed(place: &Place, name: &str, time: Option<&str>) {
    let time = time.map_or_else(String::new, |t| format!("FIELD FieldData 1\nTimeValue 1 1 double\n{t}\n"));
    let text = format!(
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n{time}POINTS 3 float\n0 0 0\n1 0 0\n0 1 0\n\
         POLYGONS 1 4\n3 0 1 2\n"
    );
    std::fs::write(place.path(name), text).unwrap();
}

#[test]
fn a_model_without_the_time_that_is_told_has_a_place_that_says_so() {
    let place = Place::new();
    timed(&place, "a.vtk", Some("0.5"));
    timed(&place, "b.vtk", None);
    timed(&place, "c.vtk", Some("0.5"));
    place.run(&format!("render a.vtk -o a.png --background #ffffff {CELL}")).ok_silently();
    for (option, told) in [("--caption t={time}", "{time} is"), ("--text {time}", "{time} is")] {
        let run = place.run(&format!("sheet a.vtk b.vtk c.vtk -o s.png {option} --size 60x45"));
        assert_eq!(run.code, Some(1), "{}", run.stderr);
        for part in ["error: b.vtk: ", told, "2 models of 3 drawn, 1 failed, 3 pictures"] {
            assert!(run.stderr.contains(part), "{part:?} is not in {}", run.stderr);
        }
        let sheet = read(&place, "s.png");
        if option.starts_with("--caption") {
            assert_eq!(places(&sheet, &read(&place, "a.png")).len(), 2);
        }
    }
    // If no model has one, that is a wrong option.
    place.run("sheet b.vtk b.vtk -o s.png --caption {time}").failed(2, &["b.vtk", "{time} is"]);
    // The name of the sheet has the time of all its models, if they have one.
    place.run(&format!("sheet a.vtk c.vtk -o at_{{time}}.png {CELL}")).ok_silently();
    assert!(place.names().contains(&"at_0.5.png".into()), "{:?}", place.names());
    place.run("sheet a.vtk b.vtk -o at_{time}.png").failed(2, &["in common"]);
    // Also if the place of one of them only tells that it has none.
    place.run("sheet a.vtk b.vtk -o at_{time}.png --caption {time}").failed(2, &["in common"]);
    place.run("sheet a.vtk b.vtk -o {name}.png --caption {time}").failed(2, &["in common"]);
}

#[test]
fn the_place_of_a_model_that_cannot_be_read_says_why_once() {
    let place = place_with(&["a.off"]);
    // Twice the words are more lines, and more dark pixels.
    place.run("sheet a.off none.off -o s.png --size 300x200 --quiet");
    let sheet = read(&place, "s.png");
    let is_row = |y: usize| (sheet.0 / 2 + 20..sheet.0 - 40).any(|x| sheet.2[y * sheet.0 + x][1] < 210);
    let rows: Vec<bool> = (60..180).map(is_row).collect();
    let lines = rows.windows(2).filter(|pair| !pair[0] && pair[1]).count();
    assert_eq!(lines, 2, "what happened, and why");
}
