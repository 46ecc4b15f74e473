//! `--watch` draws again after a change of any file that the picture is made of.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A program that is ended with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn watch(folder: &Path, arguments: &str) -> Running {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tercio"));
    command.args(["render", "--watch", "--quiet"]).args(arguments.split_whitespace());
    let errors = fs::File::create(folder.join("errors")).expect("a file");
    command.current_dir(folder).env("TERCIO_CONFIG", "none").stdin(Stdio::null()).stderr(errors);
    Running(command.spawn().expect("the program starts"))
}

/// Waits until a file holds something else than before. It is never seen half written.
#[track_caller]
fn changed(folder: &Path, name: &str, before: &[u8]) -> Vec<u8> {
    let begin = Instant::now();
    // Only so that a test that fails ends.
    while begin.elapsed() < Duration::from_secs(120) {
        if let Ok(now) = fs::read(folder.join(name))
            && now != before
        {
            return now;
        }
        sleep(Duration::from_millis(20));
    }
    panic!("{name} stays as it is: {}", fs::read_to_string(folder.join("errors")).unwrap_or_default());
}

/// Replaces a file at once, as programs do that others watch.
fn replace(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join("new"), text).expect("room");
    fs::rename(folder.join("new"), folder.join(name)).expect("the same folder");
}

const MODEL: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";

#[test]
fn changes_of_the_model_and_of_its_materials_are_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    replace(folder, "a.obj", MODEL);
    replace(folder, "a.mtl", "newmtl m\nKd 1 0 0\n");
    let _running = watch(folder, "a.obj -o a.png --size 32x32");
    let red = changed(folder, "a.png", b"");
    replace(folder, "a.mtl", "newmtl m\nKd 0 0 1.0\n");
    let blue = changed(folder, "a.png", &red);
    replace(folder, "a.obj", &(MODEL.to_owned() + "v 1 1 0\nf 2 4 3\n"));
    let quad = changed(folder, "a.png", &blue);
    // A model that is wrong is reported, the picture stays, and the next change is drawn.
    replace(folder, "a.obj", "v 0 0 0\nf 1 2 3\n");
    let told = changed(folder, "errors", b"");
    assert!(String::from_utf8_lossy(&told).contains("a.obj: line 2"), "{}", String::from_utf8_lossy(&told));
    assert_eq!(fs::read(folder.join("a.png")).expect("the picture"), quad);
    replace(folder, "a.obj", MODEL);
    assert_eq!(changed(folder, "a.png", &quad), blue);
    // Another library, and the old one is gone.
    replace(folder, "b.mtl", "newmtl m\nKd 1 0 0\n");
    replace(folder, "a.obj", &MODEL.replace("a.mtl", "b.mtl"));
    fs::remove_file(folder.join("a.mtl")).expect("it was there");
    assert_eq!(changed(folder, "a.png", &blue), red);
}

#[test]
fn changes_of_a_colour_map_and_of_another_model_are_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    replace(folder, "map.txt", "#ff0000\n#00ff00\n");
    replace(folder, "other.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let _running = watch(
        folder,
        "builtin:sphere@1k -o a.png --size 32x32 --color-by @elevation --colormap map.txt --with other.obj",
    );
    let first = changed(folder, "a.png", b"");
    replace(folder, "map.txt", "#ff0000\n#0000ff\n");
    let second = changed(folder, "a.png", &first);
    replace(folder, "other.obj", "v 0 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3\n");
    changed(folder, "a.png", &second);
}
