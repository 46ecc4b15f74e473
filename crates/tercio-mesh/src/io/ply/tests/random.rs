//! Random meshes: all encodings and all ways of reading give the same result.

use proptest::prelude::*;

use super::*;

fn any_points() -> impl Strategy<Value = Vec<[f32; 3]>> {
    let number = prop_oneof![-10f32..10.0, any::<f32>().prop_filter("finite", |v| v.is_finite())];
    prop::collection::vec(prop::array::uniform3(number), 4..40)
}

fn any_mesh() -> impl Strategy<Value = (Sheet, Sheet)> {
    (any_points(), 0usize..60, any::<u64>(), prop::bool::ANY).prop_map(|(points, count, seed, triangles)| {
        let mut state = seed | 1;
        let mut next = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        let polygons: Vec<Vec<u32>> = (0..count)
            .map(|_| {
                let corners = if triangles { 3 } else { next(7) };
                (0..corners).map(|_| next(points.len() as u64) as u32).collect()
            })
            .collect();
        let (mut v, mut f) = (vertices(&points), faces(&polygons));
        if next(2) == 0 {
            v.properties.splice(0..0, ["float nx", "float ny", "float nz"]);
            for row in &mut v.rows {
                row.splice(0..0, one(&[next(9) as f64 - 4.0, 0.25, -1.0]));
            }
        }
        if next(2) == 0 {
            v.properties.extend(["uchar red", "uchar green", "uchar blue", "uchar alpha", "double w"]);
            v.rows.iter_mut().for_each(|row| row.extend(one(&[255.0, 3.0, next(256) as f64, 7.0, 0.1])));
        }
        if next(2) == 0 {
            f.properties.insert(0, "short label");
            f.rows.iter_mut().for_each(|row| row.insert(0, Value::One(next(1000) as f64 - 500.0)));
        }
        (v, f)
    })
}

proptest! {
    #[test]
    fn encodings_agree((v, f) in any_mesh()) {
        let models: Vec<_> = ENCODINGS.iter().map(|e| read_ok(encode(e, &[v.clone(), f.clone()]))).collect();
        assert_same(&models[0], &models[1]);
        assert_same(&models[1], &models[2]);
        let turned = read_ok(encode(ENCODINGS[1], &[f, v]));
        assert_same(&turned, &models[1]);
    }

    #[test]
    fn stride_and_walk_agree((v, f) in any_mesh(), flip in prop::bool::ANY) {
        let encoding = ENCODINGS[1 + usize::from(flip)];
        let fast = read_ok(encode(encoding, &[v.clone(), f.clone()]));
        // A list of varying length forces the walk.
        let ragged = |mut sheet: Sheet| {
            sheet.properties.push("list uchar uchar padding");
            sheet.rows.iter_mut().enumerate().for_each(|(i, row)| row.push(list(&vec![1; i % 3])));
            sheet
        };
        assert_same(&fast, &read_ok(encode(encoding, &[ragged(v), ragged(f)])));
    }

    #[test]
    fn lines_and_free_text_agree((v, f) in any_mesh(), seed in any::<u32>()) {
        let bytes = encode("ascii", &[v, f]);
        let lines = read_ok(bytes.clone());
        let header = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let mut free = bytes;
        let mut state = seed;
        for b in &mut free[header..] {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if b.is_ascii_whitespace() && state >> 30 == 0 {
                *b = if *b == b'\n' { b'\t' } else { b'\n' };
            }
        }
        assert_same(&lines, &read_ok(free));
    }
}

/// Long enough for several threads and blocks.
#[test]
fn long_files_in_all_ways() {
    let n = 40_000u32;
    let points: Vec<[f32; 3]> = (0..n).map(|i| [i as f32, (i % 100) as f32, (i % 7) as f32]).collect();
    let mut polygons: Vec<Vec<u32>> = (0..n - 4).map(|i| vec![i, i + 1, i + 2]).collect();
    for _ in 0..2 {
        let sheets = [vertices(&points), faces(&polygons)];
        let models: Vec<_> = ENCODINGS.iter().map(|e| read_ok(encode(e, &sheets))).collect();
        assert_eq!(models[0].mesh.positions.len(), n as usize);
        assert_same(&models[0], &models[1]);
        assert_same(&models[1], &models[2]);
        let mut text = encode("ascii", &sheets);
        let end = text.len() - 2;
        text[end] = b'x';
        let lines = text.iter().filter(|&&b| b == b'\n').count();
        let error = try_read(text).unwrap_err().to_string();
        assert!(error.contains(&format!("line {lines}: ")), "{error}");
        polygons.iter_mut().step_by(3).for_each(|p| p.push(0));
    }
}
