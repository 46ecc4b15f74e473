//! Golden pictures: what a test drew when somebody reviewed and accepted it.
//!
//! They are in `tests/golden/<topic>/<name>.png` at the workspace root. The names of their tests begin with `golden_`,
//! because `cargo xtask bless` runs the tests whose name contains "golden". Only that command writes golden pictures,
//! and it shows the difference first.

use std::env;
use std::path::{Path, PathBuf};

use crate::data::workspace_root;
use crate::picture::Picture;

/// Environment variable: the folder that [`check`] writes pictures into instead of comparing them.
pub const BLESS_VARIABLE: &str = "TERCIO_BLESS";

/// The folder of the golden pictures.
pub fn golden_folder() -> PathBuf {
    workspace_root().join("tests/golden")
}

/// Compares a picture (RGBA8, rows from the top) with the golden one, byte for byte. `topic` and `name`
/// are the golden picture's folder and file name.
///
/// # Panics
/// If they differ, or if there is no golden picture. What was drawn and the difference are then in
/// `golden-diff` in the target folder.
#[track_caller]
pub fn check(topic: &str, name: &str, width: u32, height: u32, rgba: &[u8]) {
    assert_plain(topic);
    assert_plain(name);
    let actual = Picture::new(width, height, rgba.to_vec());
    let result = match env::var_os(BLESS_VARIABLE) {
        Some(folder) => {
            let path = Path::new(&folder).join(topic).join(format!("{name}.png"));
            actual.write(&path).map_err(|error| format!("{}: {error}", path.display()))
        }
        None => check_in(&golden_folder(), &difference_folder(), topic, name, &actual),
    };
    if let Err(message) = result {
        panic!("{message}");
    }
}

/// Where the pictures of failed comparisons go: `golden-diff` in cargo's target folder.
pub fn difference_folder() -> PathBuf {
    let target = env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    workspace_root().join(target).join("golden-diff")
}

fn check_in(
    golden: &Path,
    differences: &Path,
    topic: &str,
    name: &str,
    actual: &Picture,
) -> Result<(), String> {
    let golden_path = golden.join(topic).join(format!("{name}.png"));
    let expected = golden_path
        .is_file()
        .then(|| Picture::read(&golden_path))
        .transpose()
        .map_err(|error| format!("golden picture {}: {error}", golden_path.display()))?;
    if expected.as_ref() == Some(actual) {
        return Ok(());
    }
    let write = |kind: &str, picture: &Picture| {
        let path = differences.join(topic).join(format!("{name}.{kind}.png"));
        match picture.write(&path) {
            Ok(()) => format!("\n  {kind}: {}", path.display()),
            Err(error) => format!("\n  {kind} could not be written to {}: {error}", path.display()),
        }
    };
    let mut message = match &expected {
        None => format!("there is no golden picture {topic}/{name} yet"),
        Some(expected) => {
            format!("{topic}/{name} is not as its golden picture: {}", describe(expected, actual))
        }
    };
    message += &write("actual", actual);
    if let Some(expected) = &expected {
        message += &write("diff", &expected.side_by_side(actual));
    }
    message += &format!(
        "\nif the new picture is right: `cargo xtask bless` shows the difference, \
         `cargo xtask bless --accept {topic}/{name}` takes it"
    );
    Err(message)
}

/// One line about how `actual` differs from `expected`.
pub fn describe(expected: &Picture, actual: &Picture) -> String {
    let difference = expected.compare(actual);
    if (expected.width, expected.height) == (actual.width, actual.height) {
        return difference.to_string();
    }
    let Picture { width, height, .. } = expected;
    format!("{width}x{height} became {}x{}; {difference}", actual.width, actual.height)
}

/// Names become file names and arguments of `cargo xtask bless`.
#[track_caller]
fn assert_plain(name: &str) {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.@+".contains(&byte);
    assert!(!name.is_empty() && name.bytes().all(plain) && !name.starts_with('.'), "a file name: {name:?}");
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Folders(tempfile::TempDir);

    impl Folders {
        fn new() -> Self {
            Self(tempfile::tempdir().unwrap())
        }

        fn golden(&self) -> PathBuf {
            self.0.path().join("golden")
        }

        fn differences(&self) -> PathBuf {
            self.0.path().join("differences")
        }

        fn check(&self, picture: &Picture) -> Result<(), String> {
            check_in(&self.golden(), &self.differences(), "topic", "name", picture)
        }
    }

    #[test]
    fn the_same_picture_passes_and_leaves_nothing_behind() {
        let folders = Folders::new();
        let picture = Picture::new(2, 1, vec![1, 2, 3, 4, 5, 6, 7, 8]);
        picture.write(folders.golden().join("topic/name.png")).unwrap();
        folders.check(&picture).unwrap();
        assert!(!folders.differences().exists());
    }

    #[test]
    fn another_picture_fails_says_how_and_shows_it() {
        let folders = Folders::new();
        let expected = Picture::new(2, 1, vec![1, 2, 3, 4, 5, 6, 7, 8]);
        expected.write(folders.golden().join("topic/name.png")).unwrap();
        let mut actual = expected.clone();
        actual.rgba[7] = 18;
        let message = folders.check(&actual).unwrap_err();
        assert!(message.contains("1 of 2 pixels differ, by at most 10"), "{message}");
        assert!(message.contains("cargo xtask bless --accept topic/name"), "{message}");
        assert_eq!(Picture::read(folders.differences().join("topic/name.actual.png")).unwrap(), actual);
        assert!(folders.differences().join("topic/name.diff.png").is_file());
        assert_eq!(Picture::read(folders.golden().join("topic/name.png")).unwrap(), expected);
    }

    #[test]
    fn another_size_fails() {
        let folders = Folders::new();
        Picture::new(2, 1, vec![0; 8]).write(folders.golden().join("topic/name.png")).unwrap();
        let message = folders.check(&Picture::new(1, 2, vec![0; 8])).unwrap_err();
        assert!(message.contains("2x1 became 1x2; 2 of 4 pixels differ"), "{message}");
    }

    #[test]
    fn a_picture_without_golden_fails_and_is_kept_to_be_looked_at() {
        let folders = Folders::new();
        let actual = Picture::new(1, 1, vec![0; 4]);
        let message = folders.check(&actual).unwrap_err();
        assert!(message.contains("no golden picture topic/name"), "{message}");
        assert!(folders.differences().join("topic/name.actual.png").is_file());
        assert!(!folders.golden().exists());
    }

    #[test]
    #[should_panic(expected = "a file name")]
    fn a_name_cannot_leave_the_folder() {
        assert_plain("../name");
    }
}
