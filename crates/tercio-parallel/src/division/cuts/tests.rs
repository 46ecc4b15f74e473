use proptest::prelude::*;
use tercio_raster::TileSet;

use super::super::Division;
use super::*;

fn grid(columns: u32, rows: u32) -> TileGrid {
    TileGrid::new(columns * 16, rows * 16, 16, TileSet::ALL)
}

/// Checks that every rank has a tile, if there are enough, and none too much work.
fn check(owners: &[u32], load: &[u64], ranks: usize) -> Result<(), TestCaseError> {
    prop_assert_eq!(owners.len(), load.len());
    let (mut sums, mut counts) = (vec![0u64; ranks], vec![0usize; ranks]);
    for (&owner, &load) in owners.iter().zip(load) {
        sums[owner as usize] += load;
        counts[owner as usize] += 1;
    }
    let used = counts.iter().filter(|&&count| count > 0).count();
    prop_assert_eq!(used, ranks.min(load.len()));
    // Each cut may be off by half of the dearest tile, of which each of so many ranks has its part: with halves of 1, 2, 3, 5, 9
    // ranks and so on that is 1.13 of a tile. 1.134 is the limit of what is tolerated, and a tile counts a sixteenth of the
    // mean tile more.
    let mean = load.iter().sum::<u64>() as f64 / ranks as f64;
    let dearest = load.iter().max().copied().unwrap_or(0) as f64;
    let most = 1.3 * (mean + dearest) + 1.0;
    prop_assert!(sums.iter().all(|&sum| sum as f64 <= most), "{sums:?}, at most {most}");
    Ok(())
}

proptest! {
    #[test]
    fn every_rank_has_a_region_and_none_has_much_more_than_its_share(
        (columns, rows) in (1u32..24, 1u32..24), ranks in 1usize..40,
        frames in prop::collection::vec(
            prop_oneof![
                prop::collection::vec(0u64..1000, 576),
                prop::collection::vec(prop_oneof![20 => Just(0u64), 1 => 0u64..1 << 40], 576),
            ],
            1..5,
        ),
    ) {
        let grid = grid(columns, rows);
        let mut cuts = Cuts::default();
        for load in &frames {
            let load = &load[..grid.count()];
            let owners = cuts.owners(&grid, load, ranks);
            check(&owners, load, ranks)?;
            // The same work again: everything stays.
            prop_assert_eq!(cuts.clone().owners(&grid, load, ranks), owners);
        }
    }

    /// Each half of the ranks has one side of a cut: its tiles are consecutive in the order of columns or of rows.
    #[test]
    fn the_first_cut_has_at_most_one_step(
        (columns, rows) in (2u32..20, 2u32..20), ranks in 2usize..12,
        load in prop::collection::vec(0u64..1000, 400),
    ) {
        let grid = grid(columns, rows);
        prop_assume!(grid.count() >= ranks);
        let owners = Cuts::default().owners(&grid, &load[..grid.count()], ranks);
        let is_first = |tile: usize| (owners[tile] as usize) < ranks / 2;
        let (columns, rows) = (columns as usize, rows as usize);
        let down = (0..columns).flat_map(|x| (0..rows).map(move |y| y * columns + x)).map(is_first);
        let across = (0..columns * rows).map(is_first);
        let is_whole = down.collect::<Vec<_>>().is_sorted_by(|a, b| a >= b);
        prop_assert!(is_whole || across.is_sorted_by(|a, b| a >= b), "{owners:?}");
    }
}

#[test]
fn equal_work_is_divided_into_rectangles() {
    let owners = Cuts::default().owners(&grid(4, 4), &[5; 16], 4);
    assert_eq!(owners, [0, 0, 2, 2, 0, 0, 2, 2, 1, 1, 3, 3, 1, 1, 3, 3]);
    let owners = Cuts::default().owners(&grid(6, 2), &[5; 12], 3);
    assert_eq!(owners, [0, 0, 1, 1, 2, 2, 0, 0, 1, 1, 2, 2]);
    // More ranks than tiles.
    assert_eq!(Cuts::default().owners(&grid(3, 1), &[5, 0, 1], 5), [0, 1, 2]);
    assert_eq!(Cuts::default().owners(&grid(1, 1), &[5], 1), [0]);
}

#[test]
fn a_cut_moves_only_if_a_half_has_much_more_than_its_share() {
    let grid = grid(16, 1);
    let mut cuts = Cuts::default();
    let mut owned =
        |load: [u64; 16]| cuts.owners(&grid, &load, 2).iter().filter(|&&owner| owner == 0).count();
    assert_eq!(owned([100; 16]), 8);
    // 900 and 800, or 800 and 900: a ninth of the share more is no reason.
    let with = |tile: usize, load: u64| std::array::from_fn(|t| if t == tile { load } else { 100 });
    assert_eq!(owned(with(0, 200)), 8);
    assert_eq!(owned(with(15, 200)), 8);
    // 1200 and 800 are: 900 and 1100, or 1000 each.
    assert_eq!(owned(with(0, 500)), 6);
    // And it stays there.
    assert_eq!(owned(with(0, 350)), 6);
    assert_eq!(owned([100; 16]), 8);
}

/// A round model that moves across the picture by a fifth of a tile a frame.
fn moving(frame: u32) -> Vec<u64> {
    let of_tile = |tile: u32| {
        let [x, y] = [tile % 48, tile / 48].map(|c| f64::from(c) + 0.5);
        let apart = ((x - 14.0 - f64::from(frame) * 0.2).powi(2) + (y - 13.5).powi(2)) / 60.0;
        (1e5 * (-apart).exp()) as u64
    };
    (0..48 * 27).map(of_tile).collect()
}

#[test]
fn regions_change_little_from_frame_to_frame() {
    let grid = grid(48, 27);
    const FRAMES: u32 = 60;
    // The part of the tiles that gets another owner, in the mean of the frames.
    let moved = |owners: &mut dyn FnMut(&[u64]) -> Vec<u32>| {
        let frames: Vec<Vec<u32>> = (0..FRAMES).map(|frame| owners(&moving(frame))).collect();
        let of_two = |pair: &[Vec<u32>]| pair[0].iter().zip(&pair[1]).filter(|(a, b)| a != b).count();
        frames.windows(2).map(of_two).sum::<usize>() as f64 / f64::from(FRAMES - 1) / grid.count() as f64
    };
    for ranks in [2, 7, 16] {
        let mut cuts = Cuts::default();
        let kept = moved(&mut |load| cuts.owners(&grid, load, ranks));
        let [anew, balanced] = [Division::Adaptive, Division::Balanced]
            .map(|division| moved(&mut |load| division.owners(&grid, load, ranks)));
        assert!(kept > 0.0, "{ranks} ranks: the model has left its regions");
        assert!(kept < anew && kept < balanced / 20.0, "{ranks} ranks: {kept} {anew} {balanced}");
    }
}
