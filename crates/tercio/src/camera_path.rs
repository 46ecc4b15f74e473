//! Files with the keyframes of a camera: CSV, JSON or TOML, recognised by content.

use glam::DVec3;
use serde::Deserialize;

/// Coordinates whose squares do not overflow.
const FARTHEST: f64 = 1e100;
/// The columns of CSV.
const COLUMNS: [&str; 11] =
    ["time", "eye_x", "eye_y", "eye_z", "target_x", "target_y", "target_z", "up_x", "up_y", "up_z", "fov"];

/// A keyframe as a file holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileKeyframe {
    /// When, in seconds.
    pub time: f64,
    /// Position of the camera.
    pub eye: DVec3,
    /// What it looks at; `None` for the middle of the model.
    pub target: Option<DVec3>,
    /// What points upwards in the picture; `None` for the up axis.
    pub up: Option<DVec3>,
    /// Full vertical angle of view in degrees; `None` for that of the other options.
    pub fov: Option<f64>,
}

/// Why a file has no keyframes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CameraPathFileError {
    /// The text is not of its format.
    #[error("{format}: {reason}")]
    Malformed {
        /// CSV, JSON or TOML.
        format: &'static str,
        /// What is wrong, and where.
        reason: String,
    },
    /// A keyframe is not possible.
    #[error("keyframe {number}: {reason}")]
    Keyframe {
        /// Counted from 1.
        number: usize,
        /// What is wrong.
        reason: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    keyframes: Vec<Key>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    time: f64,
    eye: [f64; 3],
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    fov: Option<f64>,
}

/// Reads keyframes:
///
/// - CSV with a header: the columns `time`, `eye_x`, `eye_y`, `eye_z` and, as far as they are needed, `target_x` ...,
///   `up_x` ... and `fov`, in any order; cells may be empty; lines that begin with # are comments;
/// - JSON: the list of keyframes alone, or `{"keyframes": [{"time": 0, "eye": [1, 2, 3], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 30}, ...]}`;
/// - TOML: the same, each keyframe after `[[keyframes]]`.
///
/// ```
/// let text = b"time,eye_x,eye_y,eye_z,fov\n0,0,0,5,30\n1.5,5,0,0,\n";
/// let keys = tercio::camera_path::read(text)?;
/// assert_eq!((keys[1].time, keys[1].eye.x, keys[0].fov, keys[1].fov), (1.5, 5.0, Some(30.0), None));
/// # Ok::<(), tercio::camera_path::CameraPathFileError>(())
/// ```
///
/// # Errors
/// [`CameraPathFileError`].
pub fn read(bytes: &[u8]) -> Result<Vec<FileKeyframe>, CameraPathFileError> {
    let malformed = |format, reason: String| CameraPathFileError::Malformed { format, reason };
    let text = std::str::from_utf8(bytes).map_err(|e| malformed("not a text", e.to_string()))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let significant = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    let keys = match significant {
        Some(line) if line.starts_with('{') => {
            let read: Result<Document, _> = serde_json::from_str(text);
            read.map_err(|e| malformed("JSON", e.to_string()))?.keyframes
        }
        // A list; in TOML a letter follows.
        Some(line) if line.starts_with('[') && !is_table(line) => {
            let read: Result<Vec<Key>, _> = serde_json::from_str(text);
            read.map_err(|e| malformed("JSON", e.to_string()))?
        }
        // "[[keyframes]]" or "keyframes = [".
        Some(line) if line.starts_with('[') || line.starts_with("keyframes") => {
            let read: Result<Document, _> = toml::from_str(text);
            let reason = |e: toml::de::Error| {
                let line = e.span().map(|s| text[..s.start.min(text.len())].matches('\n').count() + 1);
                line.map_or_else(String::new, |line| format!("line {line}: ")) + e.message()
            };
            read.map_err(|e| malformed("TOML", reason(e)))?.keyframes
        }
        _ => read_csv(text).map_err(|reason| malformed("CSV", reason))?,
    };
    keys.into_iter().enumerate().map(|(number, key)| checked(number + 1, key)).collect()
}

/// Does a line begin with the name of a TOML table?
fn is_table(line: &str) -> bool {
    let name = line.trim_start_matches('[').trim_start();
    name.starts_with(|c: char| c.is_alphabetic() || matches!(c, '_' | '"' | '\''))
}

fn read_csv(text: &str) -> Result<Vec<Key>, String> {
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| e.to_string())?.clone();
    if let Some(unknown) = header.iter().find(|name| !COLUMNS.contains(name)) {
        return Err(format!("there is no column \"{unknown}\": expected {}", COLUMNS.join(", ")));
    }
    let mut columns = [None; COLUMNS.len()];
    for (number, name) in COLUMNS.iter().enumerate() {
        let mut places =
            header.iter().enumerate().filter(|(_, column)| column == name).map(|(place, _)| place);
        columns[number] = places.next();
        if places.next().is_some() {
            return Err(format!("there are two columns {name}"));
        }
        if number < 4 && columns[number].is_none() {
            return Err(format!(
                "the column {name} is missing: expected time, eye_x, eye_y and eye_z at least"
            ));
        }
    }
    let mut keys = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| e.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut values = [None; COLUMNS.len()];
        for (value, (column, name)) in values.iter_mut().zip(columns.iter().zip(COLUMNS)) {
            let cell = column.and_then(|place| record.get(place)).filter(|cell| !cell.is_empty());
            *value = match cell {
                None => None,
                Some(cell) => Some(
                    cell.parse::<f64>()
                        .map_err(|_| format!("line {line}, {name}: expected a number, found \"{cell}\""))?,
                ),
            };
        }
        let vector = |first: usize| match [values[first], values[first + 1], values[first + 2]] {
            [Some(x), Some(y), Some(z)] => Ok(Some([x, y, z])),
            [None, None, None] => Ok(None),
            _ => Err(format!(
                "line {line}: {} has one or two numbers of three",
                COLUMNS[first].trim_end_matches("_x")
            )),
        };
        let missing = |name: &str| format!("line {line}: {name} is empty");
        keys.push(Key {
            time: values[0].ok_or_else(|| missing("time"))?,
            eye: vector(1)?.ok_or_else(|| missing("eye"))?,
            target: vector(4)?,
            up: vector(7)?,
            fov: values[10],
        });
    }
    Ok(keys)
}

fn checked(number: usize, key: Key) -> Result<FileKeyframe, CameraPathFileError> {
    let wrong = |reason| Err(CameraPathFileError::Keyframe { number, reason });
    let is_good = |v: &[f64; 3]| v.iter().all(|c| c.abs() <= FARTHEST);
    if !key.time.is_finite() {
        return wrong(format!("the time must be finite, is {}", key.time));
    }
    let vectors = [("eye", Some(key.eye)), ("target", key.target), ("up", key.up)];
    if let Some((name, _)) = vectors.iter().find(|(_, v)| v.is_some_and(|v| !is_good(&v))) {
        return wrong(format!("{name} needs numbers of at most {FARTHEST:e}"));
    }
    if let Some(fov) = key.fov.filter(|fov| !(0.01..=179.0).contains(fov)) {
        return wrong(format!("fov must be 0.01 to 179 degrees, is {fov}"));
    }
    Ok(FileKeyframe {
        time: key.time,
        eye: key.eye.into(),
        target: key.target.map(DVec3::from),
        up: key.up.map(DVec3::from),
        fov: key.fov,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_formats_say_the_same() {
        let csv = "# a comment\ntime, eye_x, eye_y, eye_z, fov, target_x, target_y, target_z\n\
                   0, 1, 2, 3, 30, 0, 0, 0.5\n2.5, -1, 2e1, 3, , , , \n";
        let json = r#"{"keyframes": [{"time": 0, "eye": [1, 2, 3], "fov": 30, "target": [0, 0, 0.5]},
                   {"time": 2.5, "eye": [-1, 20.0, 3]}]}"#;
        let toml = "[[keyframes]]\ntime = 0.0\neye = [1, 2, 3]\nfov = 30\ntarget = [0, 0, 0.5]\n\
                   [[keyframes]]\ntime = 2.5\neye = [-1, 20.0, 3]\n";
        let first = read(csv.as_bytes()).unwrap();
        assert_eq!((first.len(), first[1].eye, first[1].target), (2, DVec3::new(-1.0, 20.0, 3.0), None));
        assert_eq!(first[0].target, Some(DVec3::new(0.0, 0.0, 0.5)));
        assert_eq!(read(json.as_bytes()).unwrap(), first);
        assert_eq!(read(toml.as_bytes()).unwrap(), first);
        let list = json.replace(r#"{"keyframes": ["#, "[\n").replace("]}]}", "]}]");
        assert_eq!(read(list.as_bytes()).unwrap(), first);
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        for (text, parts) in [
            ("", &["CSV", "time"][..]),
            ("time,eye_x,eye_y\n0,1,2\n", &["eye_z is missing"]),
            ("time,eye_x,eye_y,eye_z,zoom\n", &["\"zoom\"", "expected time, eye_x"]),
            ("time,time,eye_x,eye_y,eye_z\n", &["two columns time"]),
            ("time,eye_x,eye_y,eye_z\n0,1,2,3\n1,1,x,3\n", &["line 3, eye_y", "found \"x\""]),
            ("time,eye_x,eye_y,eye_z\n0,1,2\n", &["CSV"]),
            ("time,eye_x,eye_y,eye_z\n,1,2,3\n", &["line 2: time is empty"]),
            ("time,eye_x,eye_y,eye_z,up_x,up_y,up_z\n0,1,2,3,0,1,\n", &["up has one or two"]),
            ("time,eye_x,eye_y,eye_z\n0,nan,2,3\n", &["keyframe 1", "eye"]),
            ("time,eye_x,eye_y,eye_z,fov\n0,1,2,3,180\n", &["keyframe 1", "179"]),
            ("{\"keyframes\": [{\"time\": 0}]}", &["JSON", "eye"]),
            ("{\"keyframes\": [], \"more\": 1}", &["JSON", "more"]),
            ("[\n{\"time\": 0}]", &["JSON", "eye"]),
            ("[[keyframes]]\ntime = 0\neye = [1, 2]\n", &["TOML", "line 3"]),
        ] {
            let error = read(text.as_bytes()).unwrap_err().to_string();
            parts.iter().for_each(|part| assert!(error.contains(part), "{part:?} is not in {error}"));
        }
        assert!(read(b"\xff\xfe").is_err());
    }
}
