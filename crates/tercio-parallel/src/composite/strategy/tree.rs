//! A binomial tree.

use super::{Round, Shared, Strategy};

/// In round k the ranks with bit k as their lowest bit send everything to the rank without this bit; the first has it all in
/// the end.
pub struct Tree;

impl Strategy for Tree {
    fn rounds(&self, shared: &Shared, place: usize) -> Vec<Round> {
        let bits = (0..usize::BITS).map(|bit| 1 << bit).take_while(|bit| place & bit == 0);
        let children = bits.map(|bit| place + bit).take_while(|&child| child < shared.ranks.len());
        let mut rounds: Vec<Round> =
            children.map(|child| Round { sends: Vec::new(), receives: vec![child] }).collect();
        if place > 0 {
            let parent = place & (place - 1);
            rounds.push(Round { sends: vec![(parent, shared.tiles.to_vec())], receives: Vec::new() });
        }
        rounds
    }

    fn owners(&self, shared: &Shared) -> Vec<usize> {
        vec![0; shared.tiles.len()]
    }
}
