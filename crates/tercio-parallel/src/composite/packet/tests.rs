use proptest::prelude::*;
use tercio_scene::Background;

use super::*;

const EVERYTHING: Outputs = Outputs::ALL;

fn frame(width: u32, keys: Vec<u64>) -> Frame {
    let of = |key: &u64| *key as u32;
    let mut frame = Frame::default();
    (frame.width, frame.height) = (width, keys.len() as u32 / width);
    frame.planes.ties = keys.iter().map(|k| of(k) ^ 3).collect();
    frame.planes.color = keys.iter().map(|k| of(k).to_le_bytes()).collect();
    frame.planes.color16 = keys.iter().map(|k| [of(k) as u16; 4]).collect();
    frame.planes.depth = keys.iter().map(|k| of(k) as f32).collect();
    frame.planes.ids = keys.iter().map(of).collect();
    frame.planes.linear = keys.iter().map(|k| [of(k) as f32; 4]).collect();
    frame.planes.normals = keys.iter().map(|k| [of(k) as f32, 1.0, 2.0]).collect();
    frame.planes.keys = keys;
    frame
}

fn all(frame: &Frame) -> PixelRect {
    PixelRect { x0: 0, x1: frame.width as i32 - 1, y0: 0, y1: frame.height as i32 - 1 }
}

#[test]
fn the_bytes_of_a_packet() {
    let frame = frame(4, vec![0, 7, 9, 0, 0, 0, 0, 5]);
    let planes = Outputs { ids: true, keys: true, ..Outputs::NONE };
    let mut bytes = Vec::new();
    assert_eq!(pack_drawn(&frame, all(&frame), &planes, &mut bytes), 3);
    let mut expected = vec![1, 0, 0, 0, 2, 0];
    expected.extend([7, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0]);
    expected.extend([7, 0, 0, 0, 9, 0, 0, 0]);
    expected.extend([7, 0, 0, 0, 1, 0, 5, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0]);
    assert_eq!(bytes, expected);
    assert_eq!(bytes.len(), 2 * SPAN_HEAD + 3 * planes.pixel_bytes());
    assert_eq!(count_pixels(&bytes, &planes), Ok(3));
    let mut bare = vec![9];
    let only_ids = Outputs { ids: true, ..Outputs::NONE };
    assert_eq!(without_keys(&bytes, &planes, &only_ids, &mut bare), Ok(3));
    assert_eq!(bare, [9, 1, 0, 0, 0, 2, 0, 7, 0, 0, 0, 9, 0, 0, 0, 7, 0, 0, 0, 1, 0, 5, 0, 0, 0]);
}

#[test]
fn keys_and_ties_are_left_out_unless_they_are_wanted() {
    let frame = frame(4, vec![0, 7, 9, 0, 0, 0, 0, 5]);
    let packed = |planes: &Outputs| {
        let mut bytes = Vec::new();
        pack_drawn(&frame, all(&frame), planes, &mut bytes);
        bytes
    };
    let rest = Outputs { ids: true, normals: true, ..Outputs::NONE };
    for ties in [false, true] {
        let planes = Outputs { keys: true, ties, ..rest };
        for wanted in [rest, Outputs { keys: true, ..rest }, Outputs { ties, ..rest }, planes] {
            let mut bare = Vec::new();
            assert_eq!(without_keys(&packed(&planes), &planes, &wanted, &mut bare), Ok(3));
            assert_eq!(bare, packed(&wanted), "{wanted:?} of {planes:?}");
        }
    }
}

#[test]
fn of_equal_keys_the_larger_tie_is_seen() {
    let of = |ties: [u32; 4], colors: u8| {
        let mut frame = frame(4, vec![0, 1 << 40, 1 << 40, 1 << 41]);
        (frame.planes.ties, frame.planes.color) = (ties.to_vec(), vec![[colors; 4]; 4]);
        frame
    };
    let planes = Outputs { keys: true, ties: true, ..Outputs::default() };
    let packed = |frame: &Frame| {
        let mut bytes = Vec::new();
        pack_drawn(frame, all(frame), &planes, &mut bytes);
        bytes
    };
    let [ours, theirs] = [of([9, 5, u32::MAX, 0], 1), of([9, 6, 7, 1], 2)].map(|frame| packed(&frame));
    let mut expected = of([9, 6, u32::MAX, 1], 2);
    expected.planes.color[2] = [1; 4];
    for (packets, won) in [([&ours, &theirs], 2), ([&theirs, &ours], 1)] {
        let merged = merge(packets[0], packets[1], &planes, 4);
        assert_eq!(merged, Ok((packed(&expected), Merged { pixels: 3, won })));
    }
}

#[test]
fn of_all_pixels_those_that_are_drawn_remain() {
    let frame = frame(4, vec![0, 7, 9, 0, 3, 0, 0, 5]);
    for planes in [Outputs { ids: true, keys: true, ..Outputs::NONE }, EVERYTHING] {
        let (mut whole, mut drawn) = (Vec::new(), Vec::new());
        pack_all(&frame, all(&frame), &planes, &mut whole);
        assert_eq!(whole.len(), 2 * SPAN_HEAD + 8 * planes.pixel_bytes());
        assert_eq!(count_pixels(&whole, &planes), Ok(8));
        assert_eq!(pack_drawn(&frame, all(&frame), &planes, &mut drawn), 4);
        assert_eq!(only_drawn(&whole, &planes).as_ref(), Ok(&drawn));
        assert_eq!(only_drawn(&drawn, &planes).as_ref(), Ok(&drawn));
        assert!(only_drawn(&whole[..whole.len() - 1], &planes).is_err());
    }
    // A tile of one column, in which nothing is drawn.
    let (mut whole, planes) = (Vec::new(), EVERYTHING);
    pack_all(&frame, PixelRect { x0: 2, x1: 2, y0: 1, y1: 1 }, &planes, &mut whole);
    assert_eq!((whole.len(), only_drawn(&whole, &planes)), (SPAN_HEAD + planes.pixel_bytes(), Ok(vec![])));
}

#[test]
fn tiles_cut_spans() {
    let frame = frame(4, vec![1; 8]);
    let mut bytes = Vec::new();
    let tile = PixelRect { x0: 1, x1: 2, y0: 1, y1: 1 };
    assert_eq!(pack_drawn(&frame, tile, &EVERYTHING, &mut bytes), 2);
    assert_eq!(bytes[..SPAN_HEAD], [5, 0, 0, 0, 2, 0]);
}

#[test]
fn what_differs_from_the_background_is_shown() {
    let background = Background::Solid([0.0, 0.0, 0.0, 1.0]);
    let rows = Pixel::of_background_rows(&background, 0..2, 2, true);
    let mut picture = frame(4, vec![0; 8]);
    picture.planes.color = vec![[0, 0, 0, 255]; 8];
    let planes = Outputs { ids: true, ..Outputs::default() };
    picture.planes.ids = vec![u32::MAX; 8];
    let shown = |picture: &Frame, tile: PixelRect| {
        let mut bytes = Vec::new();
        pack_shown(picture, tile, &rows, &planes, &mut bytes);
        spans(&bytes, &planes, 8).map(|span| span.map(|s| (s.first, s.count)).unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(shown(&picture, all(&picture)), []);
    // Black, but of the model; and a colour.
    picture.planes.ids[2] = 0;
    picture.planes.color[3] = [0, 0, 1, 255];
    picture.planes.color[4] = [0, 0, 0, 254];
    assert_eq!(shown(&picture, all(&picture)), [(2, 2), (4, 1)]);
    assert_eq!(shown(&picture, PixelRect { x0: 0, x1: 2, y0: 0, y1: 0 }), [(2, 1)]);
}

proptest! {
    #[test]
    fn the_first_key_is_found(nothing in 0usize..70, rest in prop::collection::vec(0u64..3, 0..40)) {
        let keys: Vec<u64> = [vec![0; nothing], rest].concat();
        prop_assert_eq!(first_drawn(&keys), keys.iter().position(|&key| key != 0));
    }

    /// A merged packet has the bytes of the packed composite.
    #[test]
    fn the_larger_key_is_seen(
        keys in prop::collection::vec((0u64..4, 0u64..4), 1..60), width in 1u32..9, planes in 0u32..128,
    ) {
        let keys = &keys[..keys.len() / width as usize * width as usize];
        let wants = |bit: u32| planes >> bit & 1 == 1;
        let planes = Outputs {
            keys: true, color: wants(0), color16: wants(1), depth: wants(2), linear: wants(3), ids: wants(4),
            normals: wants(5), ties: wants(6),
        };
        // Two ranks never have the same key at the same pixel, except 0.
        let ours: Vec<u64> = keys.iter().map(|k| k.0 * 2).collect();
        let theirs: Vec<u64> = keys.iter().map(|k| if k.1 == 0 { 0 } else { k.1 * 2 + 1 }).collect();
        let both: Vec<u64> = ours.iter().zip(&theirs).map(|(a, b)| *a.max(b)).collect();
        let won = both.iter().filter(|key| *key % 2 == 1).count() as u64;
        let [ours, theirs, both] = [ours, theirs, both].map(|keys| frame(width, keys));
        let packed = |frame: &Frame| {
            let mut bytes = Vec::new();
            let pixels = pack_drawn(frame, all(frame), &planes, &mut bytes);
            (bytes, pixels)
        };
        let ((ours, _), (theirs, sent), (expected, shown)) = (packed(&ours), packed(&theirs), packed(&both));
        let (merged, counts) = merge(&ours, &theirs, &planes, width).unwrap();
        prop_assert_eq!(counts, Merged { pixels: sent, won });
        prop_assert_eq!(count_pixels(&merged, &planes), Ok(shown));
        prop_assert_eq!(&merged, &expected);
        // In the other order, too.
        prop_assert_eq!(&merge(&theirs, &ours, &planes, width).unwrap().0, &merged);
        let mut found = frame(width, vec![0; both.planes.keys.len()]);
        unpack(&merged, &planes, &mut found).unwrap();
        let drawn = |frame: &Frame| {
            let mut bytes = Vec::new();
            pack_drawn(frame, all(frame), &planes, &mut bytes);
            bytes
        };
        prop_assert_eq!(drawn(&found), expected);
    }

    #[test]
    fn arbitrary_bytes_never_panic(
        bytes in prop::collection::vec(0u8..5, 0..90), other in prop::collection::vec(0u8..5, 0..90),
    ) {
        let planes = Outputs { keys: true, ..Outputs::default() };
        let _ = unpack(&bytes, &planes, &mut frame(4, vec![0; 16]));
        let _ = merge(&bytes, &other, &planes, 4);
        let wide = Outputs { ties: true, ..planes };
        let _ = merge(&bytes, &other, &wide, 4);
        for planes in [planes, wide] {
            let _ = without_keys(&bytes, &planes, &Outputs::default(), &mut Vec::new());
        }
    }
}

#[test]
fn malformed_packets_are_errors() {
    let planes = Outputs { keys: true, ..Outputs::default() };
    let told = |bytes: &[u8]| unpack(bytes, &planes, &mut frame(4, vec![0; 8])).unwrap_err();
    assert_eq!(told(&[0, 0, 0]), PacketError::Short { at: 0 });
    assert_eq!(told(&[0, 0, 0, 0, 1, 0, 0]), PacketError::Short { at: 0 });
    assert_eq!(told(&[0, 0, 0, 0, 0, 0]), PacketError::Span { at: 0, place: 0, count: 0 });
    assert_eq!(told(&[8, 0, 0, 0, 1, 0]), PacketError::Span { at: 0, place: 8, count: 1 });
    assert_eq!(told(&[7, 0, 0, 0, 2, 0]), PacketError::Span { at: 0, place: 7, count: 2 });
    let span = |place: u8| [&[place, 0, 0, 0, 2, 0][..], &[1; 24]].concat();
    let twice = [span(3), span(4)].concat();
    assert_eq!(merge(&twice, &[], &planes, 9), Err(PacketError::Order { place: 4 }));
    assert_eq!(merge(&[], &twice, &planes, 9), Err(PacketError::Order { place: 4 }));
    assert_eq!(merge(&[1], &[], &planes, 9), Err(PacketError::Short { at: 0 }));
}
