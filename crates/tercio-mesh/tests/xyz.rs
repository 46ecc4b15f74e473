//! Point clouds as text in many dialects, written here, and what is wrong with files that are cut or changed.

use std::fmt::Write as _;

use tercio_mesh::ReadError;
use tercio_mesh::io::input::Input;
use tercio_mesh::io::{Format, ReadModel, ReadOptions, read_input, sniff};

fn try_read(text: &[u8]) -> Result<ReadModel, ReadError> {
    let options = ReadOptions { memory_limit: Some(256 << 20), ..ReadOptions::default() };
    read_input(&Input::from_bytes("a", text.to_vec(), &options)?, &options)
}

fn read(text: &str) -> ReadModel {
    try_read(text.as_bytes()).unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn attributes(model: &ReadModel) -> Vec<(&str, &[f32])> {
    model.strokes.attributes.iter().map(|a| (a.name.as_str(), &a.values[..])).collect()
}

const POSITIONS: [[f32; 3]; 3] = [[0.5, -1.0, 2.0], [1.0, 2.0, 3.0], [4.0, 5.0, -6.0]];

#[test]
fn delimiters_comments_and_line_ends() {
    for text in [
        "0.5 -1 2\n1 2 3\n4 5 -6\n",
        "# a cloud\n\n0.5\t-1\t2\n// between\n1\t2\t3\n4\t5\t-6",
        "0.5, -1, 2\r\n1,2,3\r\n4 ,5 ,-6\r\n",
        "0.5;-1;2;\n1;2;3;\n4;5;-6;\n",
        "  0.5   -1\t2\n 1 2e0 +3 \n4 5 -6\n",
        "3\n0.5 -1 2\n1 2 3\n4 5 -6\n",
        "x,y,z\n0.5,-1,2\n1,2,3\n4,5,-6\n",
        "//X Y Z\n0.5 -1 2\n1 2 3\n4 5 -6\n",
        "\u{feff}0.5 -1 2\n1 2 3\n4 5 -6\n",
    ] {
        let model = read(text);
        assert_eq!(model.strokes.positions, POSITIONS, "{text}");
        assert_eq!(model.strokes.points, [0, 1, 2]);
        assert!(model.strokes.colors.is_none() && model.strokes.attributes.is_empty(), "{text}");
        assert_eq!(model.report.not_drawn.points, 3);
        let packed = {
            let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            std::io::Write::write_all(&mut encoder, text.as_bytes()).unwrap();
            encoder.finish().unwrap()
        };
        assert_eq!(try_read(&packed).unwrap().strokes.positions, POSITIONS);
    }
}

#[test]
fn columns_without_names_mean_what_their_number_and_values_say() {
    let colors = |text: &str| read(text).strokes.colors;
    let rgb = Some([[255, 0, 1, 255], [2, 3, 4, 255], [5, 6, 7, 255]].map(Some).to_vec());
    let lines = |rows: [&str; 3]| format!("0 0 0 {}\n1 0 0 {}\n0 1 0 {}\n", rows[0], rows[1], rows[2]);
    assert_eq!(colors(&lines(["255 0 1", "2 3 4", "5 6 7"])), rgb);
    assert_eq!(colors(&lines(["-99 255 0 1", "1 2 3 4", "2.5 5 6 7"])), rgb);
    assert_eq!(colors(&lines(["255 0 1 0 0 1", "2 3 4 0 1 0", "5 6 7 1 0 0"])), rgb);
    let model = read(&lines(["-99 255 0 1", "1 2 3 4", "2.5 5 6 7"]));
    assert_eq!(attributes(&model), [("value", &[-99.0, 1.0, 2.5][..])]);
    let model = read(&lines(["7.5", "nan", "-1"]));
    let values = &model.strokes.attributes[0];
    assert!(values.name == "value" && values.values[0] == 7.5 && values.values[1].is_nan());
    let model = read(&lines(["0 0.6 0.8", "-1 0 0", "0 0 1"]));
    let normal =
        [("normal:0", &[0.0, -1.0, 0.0][..]), ("normal:1", &[0.6, 0.0, 0.0]), ("normal:2", &[0.8, 0.0, 1.0])];
    assert_eq!((model.strokes.colors.is_none(), attributes(&model)), (true, normal.to_vec()));
    // Numbers that are stored less an offset.
    let model = read(&lines(["1700000000 2 3", "1700000001 3 4", "1700000100 2 5"]));
    assert_eq!((model.strokes.colors.is_none(), attributes(&model)[0].0), (true, "value:0"));
    let model = read(&lines(["5.3 7.1 9.9"; 3]));
    assert_eq!(attributes(&model)[0].0, "value:0");
    let model = read(&lines(["0.6 0.64 0.48"; 3]));
    assert_eq!(attributes(&model)[0].0, "normal:0");
    // Along the axes.
    let model = read(&lines(["0 0 1", "0 1 0", "1 0 0"]));
    assert_eq!((model.strokes.colors.is_none(), attributes(&model)[0].0), (true, "normal:0"));
    let model = read(&lines(["255 0 1 0 0 1", "2 3 4 0 1 0", "5 6 7 1 0 0"]));
    assert_eq!(attributes(&model)[2], ("normal:2", &[1.0, 0.0, 0.0][..]));
    let model = read(&lines(["1 2.5", "3 4", "5 6"]));
    assert_eq!(attributes(&model), [("value:0", &[1.0, 3.0, 5.0][..]), ("value:1", &[2.5, 4.0, 6.0])]);
}

#[test]
fn columns_with_names() {
    let text =
        "id;\"X\";Y;z;Red;green;BLUE;intensity;note\n7;1;2;3;255;128;0;0.25;tree\n8;4;5;6;0;0;9;;house\n";
    let model = read(text);
    assert_eq!(model.strokes.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(model.strokes.colors, Some(vec![Some([255, 128, 0, 255]), Some([0, 0, 9, 255])]));
    assert_eq!(attributes(&model)[0], ("id", &[7.0, 8.0][..]));
    let intensity = &model.strokes.attributes[1];
    assert!(intensity.name == "intensity" && intensity.values[0] == 0.25 && intensity.values[1].is_nan());
    assert_eq!(model.report.warnings, ["left out columns that are not numbers: note"]);
    // The last name may have blanks.
    for text in
        ["//X Y Z R G B Scalar field\n1 2 3 9 8 7 0.5\n", "#X Y Z R G B Scalar field\n1 2 3 9 8 7 0.5\n"]
    {
        let model = read(text);
        assert_eq!(model.strokes.colors, Some(vec![Some([9, 8, 7, 255])]), "{text}");
        assert_eq!(attributes(&model), [("Scalar field", &[0.5][..])]);
    }
    // Empty fields are no numbers, also the last ones of a line, as tables of pandas have them.
    let model = read("x,y,z,a,b\n1,2,3,4,\n5,6,7,,\n,8,9,1,2\n");
    let [a, b] = [0, 1].map(|k| &model.strokes.attributes[k].values);
    assert!(a[0] == 4.0 && a[1].is_nan() && a[2] == 1.0 && b[0].is_nan() && b[1].is_nan() && b[2] == 2.0);
    let place = model.strokes.positions[2];
    assert!(place[0].is_nan() && model.strokes.positions[1] == [5.0, 6.0, 7.0], "{place:?}");
    // A line of names says what the columns are, also if the first point has no place; without one it is no cloud.
    let model = read("x,y,z,a\n,,,1\n5,6,7,2\n");
    assert_eq!((model.strokes.points.len(), model.strokes.origin.to_array()), (2, [5.0, 6.0, 7.0]));
    assert_eq!(attributes(&model), [("a", &[1.0, 2.0][..])]);
    assert!(try_read(b",,,1\n5,6,7,2\n8,9,1,3\n4,5,6,7\n").is_err());
    // A delimiter at the end of all lines is no column.
    let model = read("x,y,z,a,\n1,2,3,4,\n5,6,7,8,\n");
    assert_eq!(attributes(&model), [("a", &[4.0, 8.0][..])]);
    // Fractions, and 16 bits.
    let of = |rgb: &str| read(&format!("x y z r g b\n0 0 0 {rgb}\n")).strokes.color(0).unwrap();
    assert_eq!([of("0.5 1 0"), of("65535 0 32768")], [[128, 255, 0, 255], [255, 0, 128, 255]]);
}

#[test]
fn georeferenced_coordinates_keep_their_millimetres() {
    let mut text = String::new();
    let at =
        |i: u32| [690_000.0 + f64::from(i) * 0.001, 5_335_000.0 - f64::from(i) * 0.002, 500.5 + f64::from(i)];
    (0..1000).for_each(|i| {
        let [x, y, z] = at(i);
        writeln!(text, "{x:.4} {y:.4} {z:.4}").unwrap();
    });
    let model = read(&text);
    for i in 0..1000 {
        let p = model.strokes.position(i).to_array();
        let off = (0..3).map(|k| (p[k] - at(i)[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-4, "{i}: {off}");
    }
}

#[test]
fn large_files_are_parsed_in_pieces_that_find_their_lines() {
    // Far more than a piece.
    let mut text = String::new();
    let count = 600_000;
    (0..count).for_each(|i| writeln!(text, "{i} {} {}.5 {}", i % 1000, i % 7, i % 256).unwrap());
    assert!(text.len() > 8 << 20);
    let model = read(&text);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let again = one.install(|| read(&text));
    assert_eq!(model.strokes.positions, again.strokes.positions);
    for i in [0usize, 1, 123_456, 400_001, count - 1] {
        let p = model.strokes.positions[i];
        assert_eq!(p, [i as f32, (i % 1000) as f32, (i % 7) as f32 + 0.5]);
        assert_eq!(model.strokes.attributes[0].values[i], (i % 256) as f32);
    }
    let broken = text.replacen("\n500000 ", "\n500000x ", 1);
    let error = try_read(broken.as_bytes()).unwrap_err().to_string();
    assert_eq!(error, "a: line 500001: expected number 1 of 4, found \"500000x\"");
}

#[test]
fn damaged_files_say_where() {
    let wrong = |text: &str| try_read(text.as_bytes()).unwrap_err().to_string();
    let good: String = (0..300).map(|i| format!("{i} 0 1\n")).collect();
    let with = |line: &str| wrong(&format!("{good}{line}\n{good}"));
    assert_eq!(with("1 2"), "a: line 301: expected number 3 of 3, found the end of the line");
    assert_eq!(with("1 2 3 4"), "a: line 301: expected 3 numbers in the line, found \"4\"");
    assert_eq!(with("1 two 3"), "a: line 301: expected number 2 of 3, found \"two\"");
    // Near the beginning, too: after ten points, names or a number of points.
    let few: String = good.lines().take(10).map(|line| format!("{line}\n")).collect();
    assert_eq!(wrong(&format!("{few}1 2 x\n")), "a: line 11: expected number 3 of 3, found \"x\"");
    assert_eq!(wrong("x,y,z\n1,2,3\n1,2\n"), "a: line 3: expected number 3 of 3, found the end of the line");
    assert_eq!(wrong("2\n1 2 3\n1 2 3 4\n"), "a: line 3: expected 3 numbers in the line, found \"4\"");
    assert_eq!(wrong("4\n1 2 3\n4 5 6\n"), "a: expected 4 points, found 2 of them");
    let limit = ReadOptions { memory_limit: Some(20_000), ..ReadOptions::default() };
    let input = Input::from_bytes("a", good.repeat(10).into_bytes(), &ReadOptions::default()).unwrap();
    assert!(matches!(read_input(&input, &limit), Err(ReadError::MemoryLimit { .. })));
}

#[test]
fn other_texts_are_no_clouds() {
    for text in [
        "1 2 3\n4 5 6\n",
        "1 2 3\n4 5 6\n7 8\n",
        "1 2\n3 4\n5 6\n",
        "name,a,b\nx,1,2\ny,3,4\n",
        "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 5 6\n",
        "a b c\n1 2 3\n1 2 3\n1 2 3\n",
        "3\n",
        "x y z\n",
        "P1\n1 2 3\n",
        &"1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17\n".repeat(17),
    ] {
        let input = Input::from_bytes("a", text.as_bytes().to_vec(), &ReadOptions::default()).unwrap();
        assert_eq!(sniff(&input), None, "{text}");
    }
    let cloud = Input::from_bytes("a", b"x y z\n1 2 3\n".to_vec(), &ReadOptions::default()).unwrap();
    assert_eq!(sniff(&cloud), Some(Format::Xyz));
}
