use proptest::prelude::*;

use super::*;

const EVERYTHING: Outputs = Outputs::ALL;

fn frame(width: u32, keys: Vec<u64>) -> Frame {
    let of = |key: &u64| *key as u32;
    let mut frame = Frame::default();
    (frame.width, frame.height) = (width, keys.len() as u32 / width);
    frame.planes.color = keys.iter().map(|k| of(k).to_le_bytes()).collect();
    frame.planes.color16 = keys.iter().map(|k| [of(k) as u16; 4]).collect();
    frame.planes.depth = keys.iter().map(|k| of(k) as f32).collect();
    frame.planes.ids = keys.iter().map(of).collect();
    frame.planes.linear = keys.iter().map(|k| [of(k) as f32; 4]).collect();
    frame.planes.normals = keys.iter().map(|k| [of(k) as f32, 1.0, 2.0]).collect();
    frame.planes.keys = keys;
    frame
}

fn all(frame: &Frame) -> Region {
    Region { x: 0..frame.width, y: 0..frame.height }
}

#[test]
fn the_bytes_of_a_packet() {
    let frame = frame(4, vec![0, 7, 9, 0, 0, 0, 0, 5]);
    let planes = Outputs { ids: true, keys: true, color: false, ..EVERYTHING };
    let planes = Outputs { color16: false, depth: false, linear: false, normals: false, ..planes };
    let mut bytes = Vec::new();
    assert_eq!(pack(&frame, &all(&frame), &planes, &mut bytes), 3);
    let mut expected = vec![1, 0, 0, 0, 2, 0];
    expected.extend([7, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0]);
    expected.extend([7, 0, 0, 0, 9, 0, 0, 0]);
    expected.extend([7, 0, 0, 0, 1, 0, 5, 0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0]);
    assert_eq!(bytes, expected);
    assert_eq!(bytes.len(), 2 * SPAN_HEAD + 3 * planes.pixel_bytes());
}

#[test]
fn regions_cut_spans() {
    let frame = frame(4, vec![1; 8]);
    let mut bytes = Vec::new();
    let region = Region { x: 1..3, y: 1..2 };
    assert_eq!(pack(&frame, &region, &EVERYTHING, &mut bytes), 2);
    assert_eq!(bytes[..SPAN_HEAD], [5, 0, 0, 0, 2, 0]);
}

proptest! {
    #[test]
    fn the_first_key_is_found(nothing in 0usize..70, rest in prop::collection::vec(0u64..3, 0..40)) {
        let keys: Vec<u64> = [vec![0; nothing], rest].concat();
        prop_assert_eq!(first_shown(&keys), keys.iter().position(|&key| key != 0));
    }

    #[test]
    fn the_larger_key_is_seen(
        keys in prop::collection::vec((0u64..4, 0u64..4), 1..60), width in 1u32..9,
    ) {
        let keys = &keys[..keys.len() / width as usize * width as usize];
        // Two ranks never have the same key at the same pixel, except 0.
        let ours: Vec<u64> = keys.iter().map(|k| k.0 * 2).collect();
        let theirs: Vec<u64> = keys.iter().map(|k| if k.1 == 0 { 0 } else { k.1 * 2 + 1 }).collect();
        let expected = ours.iter().zip(&theirs).map(|(a, b)| *a.max(b)).collect();
        let (mut frame_of_ours, theirs) = (frame(width, ours), frame(width, theirs));
        let mut bytes = Vec::new();
        let sent = pack(&theirs, &all(&theirs), &EVERYTHING, &mut bytes);
        let done = unpack(&bytes, &EVERYTHING, true, &mut frame_of_ours).unwrap();
        prop_assert_eq!(&frame_of_ours, &frame(width, expected));
        prop_assert_eq!(done.pixels, sent);
        prop_assert_eq!(done.written, frame_of_ours.planes.keys.iter().filter(|k| *k % 2 == 1).count() as u64);
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(0u8..5, 0..90), composed: bool) {
        let planes = Outputs { keys: true, ..Outputs::default() };
        let _ = unpack(&bytes, &planes, composed, &mut frame(4, vec![0; 16]));
    }
}

#[test]
fn malformed_packets_are_errors() {
    let planes = Outputs { keys: true, ..Outputs::default() };
    let told = |bytes: &[u8]| unpack(bytes, &planes, true, &mut frame(4, vec![0; 8])).unwrap_err();
    assert_eq!(told(&[0, 0, 0]), PacketError::Short { at: 0 });
    assert_eq!(told(&[0, 0, 0, 0, 1, 0, 0]), PacketError::Short { at: 0 });
    assert_eq!(told(&[0, 0, 0, 0, 0, 0]), PacketError::Span { at: 0, place: 0, count: 0 });
    assert_eq!(told(&[8, 0, 0, 0, 1, 0]), PacketError::Span { at: 0, place: 8, count: 1 });
    assert_eq!(told(&[7, 0, 0, 0, 2, 0]), PacketError::Span { at: 0, place: 7, count: 2 });
}
