//! Compares binary files with the same models as text.

use proptest::prelude::*;

use super::*;
use crate::error::Place;

/// A model that can be written in every layout.
#[derive(Clone, Debug)]
struct Model {
    letters: &'static str,
    /// All numbers of each vertex.
    vertices: Vec<Vec<f32>>,
    /// Corners and colour.
    faces: Vec<(Vec<u32>, Vec<f32>)>,
}

/// Numbers of a vertex in each dialect.
const DIALECTS: [(&str, usize); 8] =
    [("", 3), ("C", 7), ("N", 6), ("ST", 5), ("CN", 10), ("STCN", 12), ("4", 4), ("STCN4", 13)];

impl Model {
    fn as_text(&self) -> Vec<u8> {
        let mut text = format!("{}OFF\n{} {} 0\n", self.letters, self.vertices.len(), self.faces.len());
        let words =
            |numbers: &[f32]| numbers.iter().map(|&x| f64::from(x).to_string()).collect::<Vec<_>>().join(" ");
        for vertex in &self.vertices {
            text += &format!("{}\n", words(vertex));
        }
        for (corners, color) in &self.faces {
            let corners: Vec<String> = corners.iter().map(u32::to_string).collect();
            text += &format!("{} {} {}\n", corners.len(), corners.join(" "), words(color));
        }
        text.into_bytes()
    }

    fn as_binary(&self, big_endian: bool, with_colors: bool) -> Vec<u8> {
        let mut words: Vec<u32> = vec![self.vertices.len() as u32, self.faces.len() as u32, 99];
        words.extend(self.vertices.iter().flatten().map(|x| x.to_bits()));
        for (corners, color) in &self.faces {
            words.push(corners.len() as u32);
            words.extend(corners);
            if with_colors {
                words.push(color.len() as u32);
                words.extend(color.iter().map(|x| x.to_bits()));
            }
        }
        let bytes = |word: u32| if big_endian { word.to_be_bytes() } else { word.to_le_bytes() };
        [
            format!("{}OFF BINARY\n", self.letters).as_bytes(),
            &words.into_iter().flat_map(bytes).collect::<Vec<_>>(),
        ]
        .concat()
    }

    fn without_colors(mut self) -> Self {
        self.faces.iter_mut().for_each(|f| f.1.clear());
        self
    }
}

fn try_read(bytes: Vec<u8>) -> Result<ReadModel, ReadError> {
    let options = ReadOptions::default();
    read(&Input::from_bytes("a.off", bytes, &options)?, &options)
}

fn read_ok(bytes: Vec<u8>) -> ReadModel {
    assert!(looks_like(&bytes));
    try_read(bytes).unwrap_or_else(|e| panic!("{e}"))
}

/// Everything that was read except the name of the format and the warnings.
fn content(model: &ReadModel) -> String {
    let mesh = &model.mesh;
    format!("{mesh:?} {} {:?}", model.report.faces, model.report.not_drawn)
}

fn square() -> Model {
    Model {
        letters: "",
        vertices: [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(Vec::from).into(),
        faces: vec![(vec![0, 1, 2], vec![]), (vec![0, 1, 2, 3], vec![0.5, 0.25, 1.0])],
    }
}

#[test]
fn a_square_in_all_orders() {
    let text = read_ok(square().as_text());
    let plain = read_ok(square().as_binary(true, true));
    assert_eq!(content(&plain), content(&text));
    assert_eq!((plain.report.format.as_str(), plain.report.warnings.len()), ("OFF, binary", 0));
    let little = read_ok(square().as_binary(false, true));
    assert_eq!(content(&little), content(&text));
    assert_eq!(little.report.format, "OFF, binary little-endian");
    assert_eq!(little.report.warnings, ["the numbers are little-endian, which OFF does not know"]);
    let text = read_ok(square().without_colors().as_text());
    let short = read_ok(square().as_binary(false, false));
    assert_eq!(content(&short), content(&text));
    assert_eq!(short.report.warnings.len(), 2, "{:?}", short.report.warnings);
    let named =
        read_ok(Model { letters: "N", vertices: vec![vec![1.0; 6]; 4], ..square() }.as_binary(true, true));
    assert_eq!(named.report.format, "OFF, NOFF, binary");
}

#[test]
fn what_surrounds_it_is_skipped() {
    let binary = square().as_binary(true, true);
    let plain = content(&read_ok(binary.clone()));
    let windows = [b"OFF BINARY\r\n", &binary["OFF BINARY\n".len()..]].concat();
    let appearance = [b"# c\nappearance {\n+edge }\n", &binary[..]].concat();
    for bytes in [windows, appearance] {
        let model = read_ok(bytes);
        assert_eq!((content(&model), model.report.warnings.len()), (plain.clone(), 0));
    }
    let marked = [b"\xef\xbb\xbf", &binary[..]].concat();
    let stray = [b"made by hand\n", &binary[..]].concat();
    let padded = [&binary[..], &[0; 100]].concat();
    let more = [&binary[..], b"more"].concat();
    for bytes in [marked, stray, padded, more] {
        let model = read_ok(bytes);
        assert_eq!((content(&model), model.report.warnings.len()), (plain.clone(), 1), "{:?}", model.report);
    }
}

#[test]
fn errors_state_the_byte_and_come_before_memory_is_taken() {
    let change = |at: usize, value: u32| {
        let mut bytes = square().as_binary(true, true);
        let at = "OFF BINARY\n".len() + 4 * at;
        bytes[at..at + 4].copy_from_slice(&value.to_be_bytes());
        match try_read(bytes) {
            Err(ReadError::Malformed { place: Place::Byte(byte), expected, found, .. }) => {
                assert_eq!(byte as usize, at, "{expected} {found}");
                (expected, found)
            }
            other => panic!("{other:?}"),
        }
    };
    // After 3 counts and 12 coordinates follow 3 0 1 2 0, 4 0 1 2 3 3.
    let (expected, found) = change(0, 0x7000_0000);
    assert!(expected.starts_with("1879048192 vertices and 2 faces") && found.starts_with("only 104 bytes"));
    assert_eq!(change(16, 4), ("a vertex number from 0 to 3".into(), "4".into()));
    assert_eq!(change(16, u32::MAX), ("a vertex number from 0 to 3".into(), "-1".into()));
    assert_eq!(change(15, 1000).1, "1000 and 52 bytes after it");
    assert_eq!(change(19, 2), ("0, 1, 3 or 4 components of a face's colour".into(), "2".into()));
    assert_eq!(change(25, 5).1, "5");
    assert!(try_read(b"OFF BINARY\n".to_vec()).is_err());
    let options = ReadOptions { memory_limit: Some(300), progress: None, ..ReadOptions::default() };
    let input = Input::from_bytes("a.off", square().as_binary(true, true), &options).unwrap();
    assert!(matches!(read(&input, &options), Err(ReadError::MemoryLimit { .. })));
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    for (letters, numbers) in DIALECTS {
        let model = Model { letters, vertices: vec![vec![0.5; numbers]; 4], ..square() };
        for whole in [model.as_binary(true, true), model.as_binary(false, true), model.as_binary(true, false)]
        {
            for n in 0..whole.len() {
                assert!(try_read(whole[..n].to_vec()).is_err(), "{letters} {n} of {}", whole.len());
            }
        }
    }
}

fn models() -> impl Strategy<Value = Model> {
    let number = prop_oneof![4 => -9f32..9.0, 1 => Just(0.0), 1 => any::<f32>().prop_filter("a number", |x| x.is_finite())];
    let sizes = (0..DIALECTS.len(), 1usize..20, 0usize..12);
    sizes.prop_flat_map(move |(dialect, vertices, faces)| {
        let (letters, numbers) = DIALECTS[dialect];
        let vertex = prop::collection::vec(number.clone(), numbers);
        // A single number: the text would not know whether it is a colour.
        let color = prop_oneof![Just(0usize), Just(3), Just(4)]
            .prop_flat_map(|n| prop::collection::vec(0f32..1.0, n));
        let face = (prop::collection::vec(0..vertices as u32, 1..7), color);
        (prop::collection::vec(vertex, vertices), prop::collection::vec(face, faces))
            .prop_map(move |(vertices, faces)| Model { letters, vertices, faces })
    })
}

proptest! {
    #[test]
    fn binary_equals_text(model in models()) {
        let text = try_read(model.as_text()).unwrap();
        prop_assert_eq!(content(&try_read(model.as_binary(true, true)).unwrap()), content(&text));
    }

    #[test]
    fn arbitrary_bytes_never_panic(front in "(ST|C|N|4){0,2}OFF BINARY\n", bytes in prop::collection::vec(0u8..5, 0..200)) {
        let _ = try_read([front.as_bytes(), &bytes].concat());
    }
}
