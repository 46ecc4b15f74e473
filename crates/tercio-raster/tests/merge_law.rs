//! What is seen of fragments that several ranks have drawn is the same before and after they are merged as bytes.

use std::collections::BTreeMap;

use proptest::prelude::*;
use tercio_raster::Outputs;
use tercio_raster::frame::fragments::{FragmentHead, TileFragment, write_fragment};
use tercio_raster::frame::{FragmentError, FragmentLayout, FragmentMerger, wide_key};

const SAMPLES: usize = 4;
/// Two blocks across, in rows of 16 pixels.
const STRIDE_BITS: u32 = 4;

fn merger(layout: FragmentLayout) -> FragmentMerger {
    FragmentMerger { layout, stride_bits: STRIDE_BITS, blocks_across: 2 }
}

/// Place, mask, depths, alpha.
type Sketch = (u16, u16, [u8; SAMPLES], u8);

/// A fragment whose number is that of its primitive; bytes.
fn write(layout: FragmentLayout, number: u64, (place, mask, depths, alpha): Sketch, out: &mut Vec<u8>) {
    let color = [number as f32, 0.5, 0.25, [1.0, 0.5, 0.0][usize::from(alpha)]];
    let head = FragmentHead { primitive: number as u32, place, mask, color };
    let begin = out.len();
    out.resize(begin + layout.bytes(mask.count_ones() as usize), 0);
    let depth = |sample: usize| f32::from(depths[sample]) / 4.0;
    let (normal, face) = (|| [number as f32, 1.0, 2.0], || number as u32 + 7);
    write_fragment(layout, &head, number, normal, face, depth, &mut out[begin..]);
}

/// The record of a run of finished blocks.
fn write_finished(layout: FragmentLayout, first: usize, count: usize, out: &mut Vec<u8>) {
    let head = FragmentHead { primitive: count as u32, place: first as u16, ..FragmentHead::default() };
    let begin = out.len();
    out.resize(begin + layout.bytes(0), 0);
    write_fragment(layout, &head, 0, || [0.0; 3], || 0, |_| 0.0, &mut out[begin..]);
}

/// What is seen at a sample: key, colour, normal and face of fragments, the nearest first, to the first that is opaque.
type Seen = Vec<(u128, [u32; 4], [u32; 3], u32)>;

/// What is seen at each sample of fragments that are not in finished blocks, which come second.
fn seen(layout: FragmentLayout, bytes: &[&[u8]]) -> (BTreeMap<(u16, usize), Seen>, Vec<bool>) {
    let (mut at, mut finished) = (BTreeMap::<_, Seen>::new(), vec![false; 4]);
    for mut rest in bytes.iter().copied() {
        while !rest.is_empty() {
            let (fragment, behind) = TileFragment::read(layout, rest).expect("a fragment");
            rest = behind;
            let FragmentHead { place, mask, color, primitive } = fragment.head;
            if mask == 0 {
                finished[usize::from(place)..][..primitive as usize].fill(true);
            }
            for (sample, depth) in fragment.samples() {
                let key = wide_key(depth, fragment.primitive);
                let of = (key, color.map(f32::to_bits), fragment.normal.map(f32::to_bits), fragment.face);
                at.entry((place, sample)).or_default().push(of);
            }
        }
    }
    at.retain(|(place, _), _| !finished[usize::from(place >> 7 << 1 | place >> 3 & 1)]);
    for of in at.values_mut() {
        // Of one key, what is opaque hides the others; what was drawn first comes first.
        let is_opaque = |color: [u32; 4]| color[3] == 1f32.to_bits();
        of.sort_by_key(|of| (std::cmp::Reverse(of.0), !is_opaque(of.1)));
        let last = of.iter().position(|of| is_opaque(of.1)).map_or(of.len(), |opaque| opaque + 1);
        of.truncate(last);
    }
    (at, finished)
}

fn fragments(bytes: &[u8], layout: FragmentLayout) -> Vec<TileFragment<'_>> {
    let (mut found, mut rest) = (Vec::new(), bytes);
    while let Some((fragment, behind)) = TileFragment::read(layout, rest) {
        found.push(fragment);
        rest = behind;
    }
    assert!(rest.is_empty());
    found
}

/// Fragments in few places, with few depths; most are opaque.
fn some() -> impl Strategy<Value = Sketch> {
    let depths = [1..5u8, 1..5u8, 1..5u8, 1..5u8];
    (prop_oneof![0..3u16, 0..256u16], 1..16u16, depths, prop_oneof![3 => Just(0u8), 1 => 0..3u8])
}

proptest! {
    /// The same is seen of merged parts as of all of them, in any order and however they are merged; nothing is left that is not seen
    /// where several parts have something.
    #[test]
    fn the_same_is_seen_of_merged_parts(
        of_parts in prop::collection::vec(prop::collection::vec(some(), 0..40), 1..5),
        // The opaque ones come in order, as ranks write them, or all as they are.
        is_sorted in any::<bool>(), is_opaque in any::<bool>(), is_same_number in any::<bool>(), wide in any::<bool>(),
        finished in prop::collection::vec((0..4usize, 1..3usize, 0..5usize), 0..3),
    ) {
        let layout = FragmentLayout::new(&if wide { Outputs::ALL } else { Outputs::default() }, wide);
        let (merger, mut number) = (merger(layout), 0);
        let mut parts: Vec<Vec<u8>> = Vec::new();
        for (at, mut of) in of_parts.into_iter().enumerate() {
            let mut bytes = Vec::new();
            for (first, count, _) in finished.iter().filter(|of| of.2 == at) {
                write_finished(layout, *first, *count.min(&(4 - first)), &mut bytes);
            }
            of.iter_mut().filter(|_| is_opaque).for_each(|of| of.3 = 0);
            if is_sorted {
                of.sort_by_key(|of| (of.3 == 0, if of.3 == 0 { of.0 } else { 0 }));
            }
            for some in of {
                // Numbers that are not in order, of which the upper half matters; or the same of all.
                number += 1;
                let high = if wide { (number % 3) << 32 } else { 0 };
                write(layout, if is_same_number { 3 } else { high | (number * 7 % 1021) }, some, &mut bytes);
            }
            parts.push(bytes);
        }
        let all: Vec<&[u8]> = parts.iter().map(|part| &part[..]).collect();
        let mut merged = vec![9];
        merger.merge(5, &all, &mut merged).unwrap();
        let merged = &merged[1..];
        let expected = seen(layout, &all);
        let compare = |found: &[u8]| {
            let found = seen(layout, &[found]);
            prop_assert_eq!(&found.1, &expected.1);
            // Where all have one number, those of one depth are any of them.
            if !is_same_number {
                prop_assert_eq!(&found.0, &expected.0);
            }
            let depths = |of: &BTreeMap<_, Seen>| -> Vec<_> {
                of.iter().map(|(at, of)| (*at, of.last().map(|of| of.0 >> 64))).collect()
            };
            prop_assert_eq!(depths(&found.0), depths(&expected.0));
            Ok(())
        };
        compare(merged)?;
        prop_assert!(merged.len() <= parts.iter().map(Vec::len).sum::<usize>());
        // One after the other, as in a ring, and in reverse.
        for order in [false, true] {
            let mut chain: Vec<&[u8]> = all.clone();
            if order {
                chain.reverse();
            }
            let mut sum: Vec<u8> = Vec::new();
            for part in chain {
                let mut both = Vec::new();
                merger.merge(5, &[&sum, part], &mut both).unwrap();
                sum = both;
            }
            compare(&sum)?;
        }
        // What is merged is in order, and stays as it is; with opaque fragments, each sample of a pixel of several parts has one.
        let mut again = Vec::new();
        merger.merge(5, &[merged, &[]], &mut again).unwrap();
        prop_assert_eq!(&again[..], merged);
        let of_merged = fragments(merged, layout);
        let is_record = |of: &TileFragment| of.head.mask == 0;
        let records = of_merged.iter().take_while(|of| is_record(of)).count();
        prop_assert!(of_merged[records..].is_sorted_by_key(|of| of.head.place));
        prop_assert!(!of_merged[records..].iter().any(is_record));
        if is_opaque && !is_same_number {
            let mut of_place = BTreeMap::<u16, Vec<usize>>::new();
            for (at, part) in all.iter().enumerate() {
                for of in fragments(part, layout).iter().filter(|of| of.head.mask != 0) {
                    of_place.entry(of.head.place).or_default().push(at);
                }
            }
            let is_of_several = |of: &&TileFragment| {
                let parts = &of_place[&of.head.place];
                parts.iter().any(|at| *at != parts[0])
            };
            let mut samples = BTreeMap::<(u16, usize), usize>::new();
            for of in of_merged[records..].iter().filter(is_of_several) {
                of.samples().for_each(|(sample, _)| *samples.entry((of.head.place, sample)).or_default() += 1);
            }
            prop_assert!(samples.values().all(|&count| count == 1), "{:?}", samples);
        }
    }

    #[test]
    fn arbitrary_bytes_are_merged_or_refused(
        parts in prop::collection::vec(prop::collection::vec(prop_oneof![0..3u8, any::<u8>()], 0..120), 1..4),
    ) {
        let parts: Vec<&[u8]> = parts.iter().map(|part| &part[..]).collect();
        for layout in [FragmentLayout::default(), FragmentLayout::new(&Outputs::ALL, true)] {
            let _ = merger(layout).merge(0, &parts, &mut Vec::new());
        }
    }
}

/// The bytes of merged fragments, by hand.
#[test]
fn hidden_samples_and_fragments_are_left_out() {
    let layout = FragmentLayout::default();
    let of = |those: &[(u64, Sketch)]| {
        let mut bytes = Vec::new();
        those.iter().for_each(|&(number, some)| write(layout, number, some, &mut bytes));
        bytes
    };
    // In pixel 2 everything of 1 is hidden, and 5 is hidden at one sample; 3 and 4 are as near at another, where 3 is seen.
    let first = of(&[(1, (2, 0b0011, [1; 4], 0)), (3, (2, 0b1000, [2; 4], 0)), (6, (9, 0b1111, [1; 4], 0))]);
    let second = of(&[(4, (2, 0b1011, [3, 3, 3, 2], 0)), (5, (4, 0b1, [1; 4], 0))]);
    let expected = of(&[
        (3, (2, 0b1000, [2; 4], 0)),
        (4, (2, 0b0011, [3; 4], 0)),
        (5, (4, 0b1, [1; 4], 0)),
        (6, (9, 0b1111, [1; 4], 0)),
    ]);
    let mut merged = Vec::new();
    merger(layout).merge(0, &[&first, &second], &mut merged).unwrap();
    assert_eq!(merged, expected);
    // What is not opaque is left in front of what is, and hides nothing.
    let first = of(&[(1, (0, 0b0011, [2; 4], 1)), (2, (0, 0b0010, [2; 4], 1)), (3, (0, 0b0100, [4; 4], 1))]);
    let second = of(&[(4, (0, 0b0101, [3; 4], 0)), (5, (0, 0b0010, [1; 4], 0))]);
    let expected = of(&[
        (1, (0, 0b0010, [2; 4], 1)),
        (2, (0, 0b0010, [2; 4], 1)),
        (3, (0, 0b0100, [4; 4], 1)),
        (4, (0, 0b0101, [3; 4], 0)),
        (5, (0, 0b0010, [1; 4], 0)),
    ]);
    merged.clear();
    merger(layout).merge(0, &[&first, &second], &mut merged).unwrap();
    assert_eq!(merged, expected);
}

#[test]
fn finished_blocks_are_told_once() {
    let layout = FragmentLayout::default();
    let record = |first, count| {
        let mut bytes = Vec::new();
        write_finished(layout, first, count, &mut bytes);
        bytes
    };
    let fragment = |place: u16| {
        let mut bytes = Vec::new();
        write(layout, 1, (place, 1, [1; 4], 0), &mut bytes);
        bytes
    };
    // Places 0, 8 and 128 are in blocks 0, 1 and 2.
    let first = [record(0, 1), fragment(8), fragment(128)].concat();
    let second = [record(1, 1), fragment(0), fragment(129)].concat();
    let mut merged = Vec::new();
    merger(layout).merge(0, &[&first, &second], &mut merged).unwrap();
    assert_eq!(merged, [record(0, 2), fragment(128), fragment(129)].concat());
    let beyond = record(3, 2);
    let error = merger(layout).merge(7, &[&first, &beyond], &mut Vec::new());
    assert_eq!(error, Err(FragmentError::Blocks { tile: 7, at: 0, first: 3 }));
    let error = merger(layout).merge(7, &[&first[..first.len() - 1]], &mut Vec::new());
    assert_eq!(error, Err(FragmentError::Short { tile: 7, at: layout.bytes(0) + layout.bytes(1) }));
}
