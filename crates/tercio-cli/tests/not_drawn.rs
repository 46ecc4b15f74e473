//! Content of a model that is not drawn is reported once, with counts; and so is an empty picture.

mod common;

use std::fs;

use common::Place;
use serde_json::{Value, json};

/// Three vertices, one of them translucent, a triangle, two points, a line, and materials of which one is unused.
fn place() -> Place {
    let place = Place::new();
    let model = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl glass\nf 1/1 2/1 3/1\nusemtl red\nf 1/1 3/1 2/1\n\
        p 1 2\nl 1 2 3\ncstype bezier\ndeg 2\ncurv 0 1 1 2 3\nend\n";
    fs::write(place.path("m.obj"), model).unwrap();
    let library = "newmtl glass\nd 0.5\nmap_Kd a.png\ndisp b.png\nnewmtl red\nmap_Ka a.png\nrefl c.png\n\
        newmtl unused\nd 0.1\ndisp d.png\n";
    fs::write(place.path("m.mtl"), library).unwrap();
    let header =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    let cloud = format!("{header}end_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
    fs::write(place.path("cloud.ply"), cloud).unwrap();
    let clear = format!(
        "{header}property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
         comment TextureFile skin.png\nelement face 1\nproperty list uchar int vertex_indices\n\
         element edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n\
         0 0 0 1 1 1 255\n1 0 0 1 1 1 254\n0 1 0 1 1 1 0\n0 0 1 1 1 1 255\n3 0 1 2\n0 1\n1 2\n"
    );
    fs::write(place.path("clear.ply"), clear).unwrap();
    fs::write(place.path("lines.off"), "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n1 2\n").unwrap();
    place
}

fn json_of(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn what_is_not_drawn_is_reported_once() {
    let place = place();
    let cases = [("m.obj", "1 free-form curve, 2 textures"), ("clear.ply", "1 texture")];
    for (model, list) in cases {
        let warning = format!(
            "warning: {model}: not drawn: {list} (tercio draws triangles, lines and points, and textures of "
        );
        let outcome = place.run(&format!("render {model} -o {model}.a.png --size 32x24 -v --view front"));
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        assert_eq!(outcome.stderr.matches("not drawn").count(), 1, "{}", outcome.stderr);
        assert!(outcome.stderr.contains(&warning), "{}", outcome.stderr);
        let info = place.run(&format!("info {model}")).ok_silently();
        let row = info.text().lines().find(|line| line.starts_with("not drawn")).unwrap();
        assert!(row.ends_with(list), "{row}");
    }
    assert!(!place.run("info model.off").ok_silently().text().contains("not drawn"));

    let expected = json!({
        "points": 0, "lines": 0, "curves": 1, "surfaces": 0, "textures": 2,
    });
    let info = json_of(place.run("info m.obj --json -q").ok_silently().text());
    assert_eq!(info["not_drawn"], expected);
    assert_eq!(
        info["translucent"],
        json!({ "materials": 1, "vertices": 0, "faces": 0, "lines": 0, "points": 0 })
    );
    let stats = place.run("render m.obj -o b.png --size 32x24 --stats - -q --view front").ok_silently();
    assert_eq!(json_of(stats.text())["load"]["not_drawn"], expected);
}

#[test]
fn a_model_of_points_and_lines_says_so() {
    let place = place();
    place
        .run("render lines.off -o a.png")
        .failed(1, &["no triangles", "only 1 point, 1 line", "--allow-empty"]);
    place.run("render cloud.ply -o a.png").ok_silently();
    for model in ["cloud.ply", "lines.off"] {
        let info = place.run(&format!("info {model}")).ok_silently();
        assert!(
            info.text().contains("there are no triangles") && !info.text().contains("closed"),
            "{}",
            info.text()
        );
        let info = json_of(place.run(&format!("info {model} --json -q")).ok_silently().text());
        assert!(info["topology"].is_null() && info["triangles"] == 0, "{info:#}");
    }
}

#[test]
fn an_empty_picture_replaces_nothing_unless_requested() {
    let place = place();
    let cases = [
        ("lines.off", "the model has no triangles"),
        ("model.off --eye 0,0,5 --target 0,0,9", "behind the camera"),
        ("model.off --eye 0,0,5 --target 9,0,5", "outside the picture"),
        ("model.off --near 1000", "--near is 1000"),
    ];
    for (arguments, reason) in cases {
        let render = format!("render {arguments} --size 64x48 -o a.png --output-depth d.npy --stats s.json");
        // Where there was no file, none is created.
        place
            .run(&render)
            .failed(1, &["nothing was drawn", reason, "no picture was written", "--allow-empty"]);
        assert!(!place.path("a.png").exists() && !place.path("d.npy").exists());
        // The statistics contain the reason.
        assert_eq!(
            json_of(&String::from_utf8(place.read("s.json")).unwrap())["frame"]["backend"]["pixels_visible"],
            0
        );
        for name in ["a.png", "d.npy"] {
            fs::write(place.path(name), "good").unwrap();
        }
        place.run(&format!("{render} -q")).failed(1, &[reason, "left as they are"]);
        place.run(&format!("render {arguments} -o a.png")).failed(1, &[reason, "a.png was left as it is"]);
        assert_eq!((place.read("a.png"), place.read("d.npy")), (b"good".to_vec(), b"good".to_vec()));
        let outcome = place.run(&format!("{render} --allow-empty"));
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        assert!(
            outcome.stderr.starts_with("warning: ") && outcome.stderr.contains(reason),
            "{}",
            outcome.stderr
        );
        assert!(place.read("a.png").starts_with(b"\x89PNG") && place.read("d.npy").starts_with(b"\x93NUMPY"));
        place.run(&format!("{render} --allow-empty -q")).ok_silently();
        for name in ["a.png", "d.npy", "s.json"] {
            fs::remove_file(place.path(name)).unwrap();
        }
    }
}
