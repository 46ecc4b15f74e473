use proptest::prelude::*;

use super::*;

fn bytes(map: &str, position: f64) -> [u8; 3] {
    rounded(ColorMap::named(map).expect("a known map").at(position))
}

/// Computed with matplotlib 3.11: `matplotlib.colormaps[name](index, bytes=True)`, index/255 being the position.
#[test]
fn colors_are_those_of_matplotlib() {
    let expected: [(&str, [[u8; 3]; 4]); 12] = [
        ("viridis", [[68, 1, 84], [59, 82, 139], [68, 191, 112], [253, 231, 37]]),
        ("magma", [[0, 0, 4], [81, 18, 124], [247, 112, 92], [252, 253, 191]]),
        ("inferno", [[0, 0, 4], [87, 16, 110], [243, 120, 25], [252, 255, 164]]),
        ("plasma", [[13, 8, 135], [126, 3, 168], [242, 132, 75], [240, 249, 33]]),
        ("cividis", [[0, 34, 78], [67, 78, 108], [174, 163, 113], [254, 232, 56]]),
        ("turbo", [[48, 18, 59], [40, 188, 235], [254, 164, 49], [122, 4, 3]]),
        ("coolwarm", [[59, 76, 192], [141, 176, 254], [247, 172, 142], [180, 4, 38]]),
        ("jet", [[0, 0, 128], [0, 129, 255], [255, 196, 0], [128, 0, 0]]),
        ("gray", [[0, 0, 0], [64, 64, 64], [179, 179, 179], [255, 255, 255]]),
        ("RdBu", [[103, 0, 31], [229, 131, 104], [144, 196, 221], [5, 48, 97]]),
        ("hot", [[11, 0, 0], [179, 0, 0], [255, 225, 0], [255, 255, 255]]),
        ("twilight", [[226, 217, 226], [98, 117, 186], [159, 60, 80], [226, 217, 226]]),
    ];
    for (map, colors) in expected {
        for (index, color) in [0.0, 64.0, 179.0, 255.0].into_iter().zip(colors) {
            let got = bytes(map, index / 255.0);
            let is_close = got.iter().zip(color).all(|(&a, b)| a.abs_diff(b) <= 1);
            assert!(is_close, "{map} {index}: {got:?}, expected {color:?}");
        }
    }
    assert_eq!(bytes("Set1", 0.0), [228, 26, 28]);
    assert_eq!(bytes("Set1", 0.5), [255, 127, 0]);
    assert_eq!(bytes("tab10", 0.999), [23, 190, 207]);
}

#[test]
fn every_map_exists_and_can_be_reversed() {
    let names: Vec<&str> = ColorMap::names().collect();
    assert!(names.len() > 70);
    for name in names {
        let map = ColorMap::named(name).expect("a listed name is known");
        let reversed = ColorMap::named(&format!("{name}_r")).expect("reversed");
        assert_eq!((map.name(), reversed.name()), (name, &*format!("{name}_r")));
        for i in 0..=64 {
            // Not at the borders of categories.
            let t = (f64::from(i) + 0.37) / 65.0;
            let (a, b) = (map.at(t), reversed.at(1.0 - t));
            assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-9), "{name} {t}");
        }
        assert_eq!(reversed.reversed().name(), name);
    }
}

#[test]
fn names_of_other_programs_are_known() {
    for (name, same) in [
        ("Viridis", "viridis"),
        ("Viridis (matplotlib)", "viridis"),
        ("Cool to Warm", "coolwarm"),
        ("grey_r", "gray_r"),
        ("set1", "Set1"),
        ("Rainbow Desaturated", "rainbow_desaturated"),
        ("nipy-spectral", "nipy_spectral"),
        ("X Ray", "gray_r"),
    ] {
        assert_eq!(ColorMap::named(name), ColorMap::named(same), "{name}");
        assert!(ColorMap::named(name).is_some(), "{name}");
    }
    for name in ["Fast", "Rainbow Uniform", "twilight_shifted_r", "vanimo"] {
        assert!(ColorMap::named(name).is_some(), "{name}");
    }
    // The ends and the middle of ParaView's list, in 8 bits.
    let fast = ColorMap::named("Fast").expect("known");
    assert_eq!([0.0, 0.5, 1.0].map(|t| rounded(fast.at(t))), [[14, 14, 120], [229, 241, 196], [150, 20, 30]]);
    assert_eq!([ColorMap::named("viridi"), ColorMap::named(""), ColorMap::named("_r")], [None, None, None]);
}

#[test]
fn lists_of_colors_are_read() {
    let hex = ColorMap::parse("m", b"#000000\n#ff0000\n\n#ffffff\n").expect("a list");
    for text in [
        "# a comment\n0 0 0\n255 0 0\n255 255 255",
        "r,g,b\n0, 0, 0\n1.0, 0, 0\n1, 1, 1\n",
        "0 0 0 0\n50 1 0 0\n100 1 1 1",
        r#"[{"Name": "m", "RGBPoints": [-1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 1, 1]}]"#,
    ] {
        assert_eq!(ColorMap::parse("m", text.as_bytes()).as_ref(), Ok(&hex), "{text}");
    }
    assert_eq!(rounded(hex.at(0.25)), [128, 0, 0]);
}

#[test]
fn maps_of_paraview_have_colors_of_what_is_not_in_the_range() {
    let parse = |more: &str| {
        let text = format!("[{{\"RGBPoints\":[0,0,0,0,1,1,1,1]{more}}}]");
        ColorMap::parse("mine", text.as_bytes())
    };
    assert_eq!(parse("").map(|map| map.special()), Ok(Special::default()));
    let all = ",\"NanColor\":[1,1,0],\"NanOpacity\":0.5,\"UseBelowRangeColor\":1,\"BelowRangeColor\":[1,0,0],\
        \"UseAboveRangeColor\":0,\"AboveRangeColor\":[0,0,1]";
    let map = parse(all).expect("a map");
    let special = Special { nan: Some([255, 255, 0, 128]), below: Some([255, 0, 0, 255]), above: None };
    assert_eq!(map.special(), special);
    assert_eq!(map.reversed().special(), Special { below: None, above: special.below, ..special });
    for wrong in [",\"NanColor\":[1,1]", ",\"NanColor\":\"red\"", ",\"NanColor\":[1,1,2]"] {
        assert!(parse(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn categorical_maps_of_paraview_are_lists_of_colors() {
    let parse = |text: &str| ColorMap::parse("mine", text.as_bytes());
    let colors = "\"IndexedColors\":[1,0,0,0,1,0,0,0,1]";
    let named = ",\"Annotations\":[\"4\",\"bone\",\"a\",\"text\",1.5,\"\",\"7\",\"the first again\"],\"NanColor\":[1,1,0]";
    let map = parse(&format!("[{{{colors}{named}}}]")).expect("a map");
    assert_eq!((map.len(), map.is_categorical()), (3, true));
    assert_eq!(
        [0, 1, 2, 3].map(|n| rounded(map.category(n))),
        [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 0, 0]]
    );
    let annotations: Vec<_> = map.annotations().iter().map(|a| (a.value, &*a.label)).collect();
    // Beyond the last colour they begin again, as in ParaView.
    let expected = [(Some(4.0), "bone"), (None, "text"), (Some(1.5), ""), (Some(7.0), "the first again")];
    assert_eq!(annotations, expected);
    assert!(map.idle_annotations().map(|a| &*a.label).eq(["text"]));
    let twice =
        parse(&format!("{{{colors},\"Annotations\":[\"0\",\"a\",\"-0\",\"b\",\"1\",\"c\",\"1.0\",\"d\"]}}"));
    assert!(twice.expect("a map").idle_annotations().map(|a| &*a.label).eq(["b", "d"]));
    assert_eq!(map.special().nan, Some([255, 255, 0, 255]));
    // A map that has both says which counts.
    let both = |more: &str| {
        parse(&format!("{{{colors},\"RGBPoints\":[0,0,0,0,1,1,1,1]{more}}}")).map(|map| map.is_categorical())
    };
    assert_eq!(
        [both(""), both(",\"IndexedLookup\":1"), both(",\"IndexedLookup\":false")],
        [Ok(false), Ok(true), Ok(false)]
    );
    for (text, expected) in [
        ("{\"IndexedColors\":[1,0]}", "three numbers"),
        ("{\"IndexedColors\":[1,0,\"a\"]}", "not all numbers"),
        ("{\"IndexedColors\":[1,0,2]}", "components"),
        ("{\"IndexedColors\":[]}", "`IndexedColors`: there are none"),
        ("{\"IndexedColors\":[1,0,0],\"Annotations\":[\"1\"]}", "pairs"),
        ("{\"IndexedColors\":[1,0,0],\"Annotations\":[1,[]]}", "pairs"),
        ("{\"IndexedColors\":[1,0,0],\"Annotations\":7}", "pairs"),
    ] {
        let error = parse(text).expect_err(text).to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn levels_have_the_color_of_their_middle() {
    let map = ColorMap::named("gray").expect("a known map");
    let mut colors = DataColors::new("x", map, [0.0, 1.0]);
    // Not in order, twice, and beyond the range.
    colors.levels = vec![0.5, 0.2, 0.5, 7.0, -1.0];
    assert_eq!(colors.boundaries(), [0.0, 0.2, 0.5, 1.0]);
    let gray = |value: f64| colors.color(value)[0];
    assert_eq!([0.0, 0.19, 0.21, 0.49, 0.51, 1.0].map(gray), [26, 26, 89, 89, 191, 191]);
    let categorical = ColorMap::from_colors("c", &[[1, 0, 0], [2, 0, 0]], true).expect("a map");
    let colors = DataColors { map: categorical, ..colors };
    assert_eq!([0.1, 0.3, 0.9].map(|value| colors.color(value)[0]), [1, 2, 1]);
    let banded = DataColors { bands: Some(1), ..colors };
    assert_eq!(banded.boundaries(), [0.0, 1.0]);
    // 0.3 is the end of values in `f32` up to 0.3, and no band is between.
    let ends = [0.1f32, 0.3f32].map(f64::from);
    let at_ends = DataColors { bands: None, levels: vec![0.3, 0.2], range: ends, ..banded };
    assert_eq!(at_ends.boundaries(), [ends[0], 0.2, ends[1]]);
    // Less an offset they are apart.
    let offset = 4e6 + 0.1;
    let range = [offset, offset + 0.25];
    let far = DataColors { levels: vec![offset + 0.125], range, offset, ..at_ends };
    assert_eq!(far.boundaries(), [range[0], offset + 0.125, range[1]]);
}

#[test]
fn what_is_not_a_color_map_is_refused() {
    for (text, expected) in [
        ("", "no colour"),
        ("hello\nworld", "no colour"),
        ("#000000\nred", "line 2"),
        ("1 2\n", "line 1"),
        ("0 0 0\n-1 0 0", "components"),
        ("3 0 0 0\n1 1 1 1", "ascend"),
        ("300 0 0", "components"),
        ("[{\"RGBPoints\": [1, 2]}]", "four numbers"),
        ("{", "JSON"),
    ] {
        let error = ColorMap::parse("m", text.as_bytes()).expect_err(text).to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

proptest! {
    #[test]
    fn scales_go_back_and_forth(value in -1e6f64..1e6, threshold in 1e-3f64..10.0) {
        let symmetric = Scale::SymmetricLog { threshold };
        for (scale, value) in [(Scale::Linear, value), (symmetric, value), (Scale::Log, value.abs().max(1e-9))] {
            let back = scale.back(scale.forward(value));
            prop_assert!((back - value).abs() <= 1e-12 * value.abs().max(threshold), "{scale:?} {value} {back}");
        }
        // As `matplotlib.colors.SymLogNorm(threshold, linscale=1, base=10)`.
        let s = (value / threshold).abs();
        let expected = if s > 1.0 { s.log10() + 10.0 / 9.0 } else { s * 10.0 / 9.0 };
        prop_assert!((symmetric.forward(value).abs() - expected).abs() < 1e-12);
    }

    #[test]
    fn any_text_is_a_map_or_an_error(text in "[#0-9a-f .,\n-]{0,60}") {
        if let Ok(map) = ColorMap::parse("m", text.as_bytes()) {
            let color = map.at(0.3);
            prop_assert!(color.iter().all(|c| (0.0..=1.0).contains(c)));
        }
    }
}

#[test]
fn bands_have_one_color_each() {
    let mut colors = DataColors::new("x", ColorMap::named("gray").expect("known"), [0.0, 8.0]);
    colors.bands = Some(4);
    assert_eq!(colors.boundaries(), [0.0, 2.0, 4.0, 6.0, 8.0]);
    let of = |value| colors.color(value)[0];
    assert_eq!(
        [of(-1.0), of(0.0), of(1.99), of(2.0), of(4.0), of(7.9), of(8.0), of(9.0)],
        [0, 0, 0, 85, 170, 255, 255, 255]
    );
    colors.map = ColorMap::named("Set1").expect("known");
    assert_eq!(
        colors.color(7.0)[..3],
        ColorMap::named("Set1").map(|m| rounded(m.category(7))).expect("known")
    );
}

#[test]
fn values_out_of_range_have_their_colors() {
    let mut colors = DataColors::new("x", ColorMap::named("gray").expect("known"), [1.0, 100.0]);
    colors.scale = Scale::Log;
    assert_eq!(colors.color(10.0)[0], 128);
    assert_eq!([colors.color(-5.0)[0], colors.color(0.0)[0], colors.color(1e9)[0]], [0, 0, 255]);
    (colors.below, colors.above) = (Some([1, 2, 3, 255]), Some([4, 5, 6, 0]));
    assert_eq!([colors.color(0.0), colors.color(101.0)], [[1, 2, 3, 255], [4, 5, 6, 0]]);
    assert_eq!(colors.color(f64::NAN), DataColors::NAN);
    assert!(colors.is_translucent());
    let category = |value, label: &str, color| Category { value, label: label.into(), color };
    colors.categories = vec![category(1.0, "bone", [9, 9, 9, 255]), category(4.0, "skin", [8, 8, 8, 255])];
    assert_eq!([colors.color(4.0), colors.color(2.0)], [[8, 8, 8, 255], DataColors::NAN]);
}
