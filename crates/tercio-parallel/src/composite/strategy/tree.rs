//! A binomial tree.

use super::{Round, Shared, Strategy};
use crate::comm::{children, parent};

/// In round k the ranks with bit k as their lowest bit send everything to the rank without this bit; the first has it all in
/// the end.
pub struct Tree;

impl Strategy for Tree {
    fn rounds(&self, shared: &Shared, place: usize) -> Vec<Round> {
        let children = children(place, shared.ranks.len());
        let mut rounds: Vec<Round> =
            children.map(|child| Round { sends: Vec::new(), receives: vec![child] }).collect();
        if place > 0 {
            rounds.push(Round { sends: vec![(parent(place), shared.tiles.to_vec())], receives: Vec::new() });
        }
        rounds
    }

    fn owners(&self, shared: &Shared) -> Vec<usize> {
        vec![0; shared.tiles.len()]
    }
}
