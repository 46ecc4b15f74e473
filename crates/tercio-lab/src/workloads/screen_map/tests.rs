use proptest::prelude::*;

use super::*;

/// Figure A-2, its second line corrected: printed with (0,255), it would give row 255 to two processors.
const FIGURE_A2: &str =
    "0 (0, 0) (383, 255)\n1 (0, 256) (383, 511)\n2 (384, 0) (767, 255)\n3 (384, 256) (767, 511)\n";

fn overlap(map: &ScreenMap, first: [i32; 2], last: [i32; 2]) -> Vec<(u32, u64)> {
    let mut list = Vec::new();
    map.overlap(&PixelBox::new(first, last).unwrap(), &mut list);
    list
}

#[test]
fn the_map_of_figure_a2() {
    let map = ScreenMap::parse(FIGURE_A2).unwrap();
    assert_eq!((map.width(), map.height(), map.processors()), (768, 512, 4));
    assert_eq!(overlap(&map, [0, 0], [767, 511]), [(0, 98304), (1, 98304), (2, 98304), (3, 98304)]);
    assert_eq!(overlap(&map, [382, 254], [384, 255]), [(0, 4), (2, 2)]);
    assert_eq!(overlap(&map, [-5, 500], [2, 600]), [(1, 36)]);
    assert_eq!(overlap(&map, [768, 0], [800, 3]), []);
    assert_eq!((map.owner(0, 255), map.owner(0, 256), map.owner(768, 0)), (Some(0), Some(1), None));
}

#[test]
fn figure_a2_as_printed_is_refused() {
    let printed = FIGURE_A2.replace("(0, 256)", "(0, 255)");
    let error = ScreenMap::parse(&printed).unwrap_err();
    assert_eq!(error.line, 2);
    assert!(error.to_string().contains("pixel (0, 255), which already belongs to processor 0"), "{error}");
}

#[test]
fn mistakes_are_reported() {
    let hole = FIGURE_A2.replace("(767, 511)", "(766, 511)");
    assert!(
        ScreenMap::parse(&hole).unwrap_err().to_string().contains("no rectangle covers pixel (767, 256)")
    );
    for (text, line) in
        [("", 1), ("0 (0,0) (-1,3)", 1), ("0 (0,0) (1,1)\n1 (-3,0) (4,4)", 2), ("0 (0,0) (1,99999)", 1)]
    {
        assert_eq!(ScreenMap::parse(text).unwrap_err().line, line, "{text:?}");
    }
}

#[test]
fn columns_go_to_processors_in_order() {
    let map = ScreenMap::columns(768, 512, 1024);
    assert_eq!(map.processors(), 768);
    assert_eq!(overlap(&map, [5, 0], [8, 511]), [(5, 512), (6, 512), (7, 512), (8, 512)]);
    let map = ScreenMap::columns(10, 4, 3);
    assert_eq!(overlap(&map, [0, 0], [9, 3]), [(0, 12), (1, 12), (2, 16)]);
}

#[test]
fn tiles_are_assigned_round_robin() {
    let map = ScreenMap::tiles(70, 40, 32, 4);
    assert_eq!([0, 32, 64].map(|x| map.owner(x, 0)), [Some(0), Some(1), Some(2)]);
    assert_eq!([0, 32, 64].map(|x| map.owner(x, 39)), [Some(3), Some(0), Some(1)]);
    assert_eq!(overlap(&map, [0, 0], [69, 39]), [(0, 1024 + 256), (1, 1024 + 48), (2, 192), (3, 256)]);
}

proptest! {
    #[test]
    fn overlap_counts_the_pixels_of_each_owner(
        width in 1u32..60, height in 1u32..40, side in 1u32..20, processors in 1u32..9,
        x in -5i32..60, y in -5i32..40, w in 0i32..70, h in 0i32..50,
    ) {
        let map = ScreenMap::tiles(width, height, side, processors);
        let mut counted = vec![0u64; processors as usize];
        for py in y..=y + h {
            for px in x..=x + w {
                if let Some(owner) = map.owner(px, py) {
                    counted[owner as usize] += 1;
                }
            }
        }
        let expected: Vec<_> = (0..processors).zip(counted).filter(|&(_, pixels)| pixels > 0).collect();
        prop_assert_eq!(overlap(&map, [x, y], [x + w, y + h]), expected);
    }

    #[test]
    fn what_is_written_is_read(width in 1u32..60, height in 1u32..40, side in 1u32..20, processors in 1u32..9) {
        let map = ScreenMap::tiles(width, height, side, processors);
        prop_assert_eq!(ScreenMap::parse(&map.to_text()), Ok(map));
    }
}
