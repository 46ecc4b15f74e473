//! Loops against sequential iterators.

use std::sync::atomic::{AtomicUsize, Ordering};

use proptest::prelude::*;

use super::divide::{Lengths, gather};
use super::prelude::*;

/// What a function gives on 1, 2 and 5 threads.
fn on_threads<T: Send>(work: impl Fn() -> T + Sync) -> Vec<T> {
    [1, 2, 5]
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(&work)
        })
        .into()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn loops_are_sequential_iterators(
        list in prop::collection::vec(0u32..1000, 0..700),
        other in prop::collection::vec(0u32..1000, 0..700),
        min in 1usize..200,
        max in 1usize..200,
        limit in 0u32..1000,
    ) {
        let odd = |&v: &u32| v % 2 == 1;
        let several = |v: u32| (0..v % 4).map(move |k| (v, k));
        let even = |v: u32| (v < limit).then_some(v);
        let checked = |v: u32| if v < limit { Ok(v) } else { Err(v) };
        let expected = (
            list.iter().map(|v| v * 2).collect::<Vec<_>>(),
            list.iter().copied().filter(odd).collect::<Vec<_>>(),
            list.iter().copied().flat_map(several).collect::<Vec<_>>(),
            list.iter().copied().map(even).collect::<Option<Vec<_>>>(),
            list.iter().copied().map(checked).collect::<Result<Vec<_>, _>>(),
            list.iter().zip(&other).enumerate().map(|(k, (a, b))| (k as u32 * a) ^ b).collect::<Vec<_>>(),
            list.iter().chain(&other).copied().collect::<Vec<_>>(),
            list.chunks(7).map(|c| c.to_vec()).collect::<Vec<_>>(),
            list.iter().map(|&v| (v, u64::from(v) + 1)).unzip::<_, _, Vec<_>, Vec<_>>(),
        );
        let found = on_threads(|| (
            list.par_iter().with_min_len(min).map(|v| v * 2).collect::<Vec<_>>(),
            list.par_iter().copied().with_max_len(max).filter(odd).collect::<Vec<_>>(),
            list.par_iter().with_min_len(min).with_max_len(max).copied().flat_map_iter(several).collect::<Vec<_>>(),
            list.par_iter().copied().map(even).collect::<Option<Vec<_>>>(),
            list.par_iter().copied().with_max_len(max).map(checked).collect::<Result<Vec<_>, _>>(),
            list.par_iter().zip(&other).enumerate().map(|(k, (a, b))| (k as u32 * a) ^ b).collect::<Vec<_>>(),
            list.par_iter().chain(&other).copied().collect::<Vec<_>>(),
            list.par_chunks(7).map(|c| c.to_vec()).collect::<Vec<_>>(),
            list.par_iter().map(|&v| (v, u64::from(v) + 1)).unzip(),
        ));
        for found in found {
            prop_assert_eq!(&found, &expected);
        }
    }

    #[test]
    fn results_are_sequential_ones(
        list in prop::collection::vec(0u32..1000, 0..700),
        limit in 0u32..1000,
        max in 1usize..200,
    ) {
        let above = |v: &u32| (*v > limit).then_some(*v);
        let expected = (
            list.iter().position(|v| *v > limit),
            list.iter().find_map(above),
            list.contains(&limit),
            list.iter().all(|v| *v < limit),
            list.iter().filter(|v| **v < limit).count(),
            list.iter().map(|&v| u64::from(v)).sum::<u64>(),
            list.iter().fold(u32::MAX, |a, &b| a.min(b)),
            list.iter().enumerate().max_by_key(|(_, v)| **v),
            list.iter().try_for_each(|&v| if v > limit { Err(v) } else { Ok(()) }),
        );
        let found = on_threads(|| (
            list.par_iter().with_max_len(max).position_first(|v| *v > limit),
            list.par_iter().with_max_len(max).find_map_first(above),
            list.par_iter().any(|v| *v == limit),
            list.par_iter().all(|v| *v < limit),
            list.par_iter().with_max_len(max).filter(|v| **v < limit).count(),
            list.par_iter().map(|&v| u64::from(v)).sum::<u64>(),
            list.par_iter().with_max_len(max).copied().reduce(|| u32::MAX, u32::min),
            list.par_iter().with_max_len(max).enumerate().max_by(|a, b| a.1.cmp(b.1)),
            list.par_iter().with_max_len(max).try_for_each(|&v| if v > limit { Err(v) } else { Ok(()) }),
        ));
        for found in found {
            prop_assert_eq!(&found, &expected);
        }
        // Folded piece by piece, in order.
        for pieces in on_threads(|| list.par_iter().with_max_len(max).fold(Vec::new, |mut all, &v| {
            all.push(v);
            all
        }).collect::<Vec<Vec<u32>>>()) {
            prop_assert!(pieces.iter().all(|piece| (1..=max).contains(&piece.len())));
            prop_assert_eq!(&pieces.concat(), &list);
        }
    }

    #[test]
    fn everything_is_visited_once(len in 0usize..900, chunk in 1usize..50, min in 1usize..99) {
        let threefold: Vec<usize> = (0..len).map(|k| 3 * k).collect();
        for list in on_threads(|| {
            let mut list = vec![0; len];
            list.par_chunks_mut(chunk).enumerate().for_each(|(number, chunk_of)| {
                chunk_of.iter_mut().zip(number * chunk..).for_each(|(v, k)| *v += k);
            });
            list.par_iter_mut().with_min_len(min).for_each(|v| *v *= 3);
            let mut from_one = vec![7];
            from_one.par_extend(list.clone().into_par_iter().map(Box::new).map(|v| *v));
            assert_eq!(from_one[1..], list);
            from_one.par_extend((0..len).into_par_iter().filter(|v| v % 2 == 0));
            assert_eq!(from_one.len(), 1 + len + len.div_ceil(2));
            list
        }) {
            prop_assert_eq!(&list, &threefold);
        }
        let (made, sum) = (AtomicUsize::new(0), AtomicUsize::new(0));
        (0..len).into_par_iter().with_max_len(1).for_each_init(
            || made.fetch_add(1, Ordering::Relaxed),
            |_, k| {
                sum.fetch_add(k, Ordering::Relaxed);
            },
        );
        prop_assert_eq!((made.into_inner(), sum.into_inner()), (len, (0..len).sum::<usize>()));
        let numbered = (0..len as u32).into_par_iter().map_init(|| 0, |calls, k| {
            *calls += 1;
            (k, *calls)
        });
        let numbered: Vec<(u32, i32)> = numbered.with_max_len(1).collect();
        prop_assert_eq!(numbered, (0..len as u32).map(|k| (k, 1)).collect::<Vec<_>>());
    }
}

#[test]
fn pieces_keep_their_lengths() {
    let ranges = |len, lengths| on_threads(|| gather(len, lengths, |_, range| range));
    for (lengths, len) in [(Lengths { min: 40, max: usize::MAX }, 1000), (Lengths { min: 1, max: 3 }, 100)] {
        for ranges in ranges(len, lengths) {
            assert!(ranges.iter().all(|r| r.len() >= lengths.min && r.len() <= lengths.max), "{ranges:?}");
            assert!(ranges.iter().flat_map(|r| r.clone()).eq(0..len));
        }
    }
    assert!(ranges(0, Lengths::ANY).iter().all(Vec::is_empty));
    assert!(ranges(9, Lengths::ANY)[0].iter().eq([&(0..9)]), "one thread has one piece");
    // The least length gives way.
    assert!(ranges(10, Lengths { min: 5, max: 2 }).iter().all(|r| r.len() == 5));
}

/// Counts how many are dropped.
struct Counted<'a>(&'a AtomicUsize);

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn elements_are_dropped_once() {
    let dropped = AtomicUsize::new(0);
    let list: Vec<_> = (0..1000).map(|_| Counted(&dropped)).collect();
    let kept: Vec<_> = list.into_par_iter().enumerate().filter(|(k, _)| k % 4 == 0).collect();
    assert_eq!((kept.len(), dropped.load(Ordering::Relaxed)), (250, 750));
    drop(kept);
    assert_eq!(dropped.load(Ordering::Relaxed), 1000);
}

#[test]
fn elements_that_nobody_asks_for_are_dropped() {
    let dropped = AtomicUsize::new(0);
    let list = || (0..100).map(|_| Counted(&dropped)).collect::<Vec<_>>();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        assert!(list().into_par_iter().enumerate().any(|(k, _)| k == 3));
        let failed: Result<Vec<_>, usize> =
            list().into_par_iter().enumerate().map(|(k, v)| if k == 50 { Err(k) } else { Ok(v) }).collect();
        assert_eq!(failed.err(), Some(50));
    });
    assert_eq!(dropped.load(Ordering::Relaxed), 200);
}

#[test]
fn chunks_of_elements_without_size() {
    let list = [(); usize::MAX];
    let lengths: Vec<usize> = list.par_chunks(usize::MAX - 1).map(<[()]>::len).collect();
    assert_eq!(lengths, [usize::MAX - 1, 1]);
}

#[test]
fn a_panic_reaches_the_caller() {
    let list: Vec<String> = (0..100).map(|k| k.to_string()).collect();
    let result = std::panic::catch_unwind(|| {
        list.clone()
            .into_par_iter()
            .map(|text| if text == "63" { panic!("63") } else { text })
            .collect::<Vec<_>>()
    });
    assert_eq!(result.unwrap_err().downcast_ref::<&str>(), Some(&"63"));
}
