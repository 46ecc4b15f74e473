//! Clusters of models in parts that ranks have from each other since the last frame: they are not sent again while they are needed.
//!
//! A rank keeps what it gathered for a frame until the next one is gathered: meanwhile it holds the clusters of both, and between
//! frames those of the last one. Each sender knows what it has sent, in the order in which the receiver has it.

use std::ops::Range;
use std::sync::{Arc, Weak};

use tercio_mesh::ClusteredMesh;
use tercio_scene::{Instance, Share};

/// What a rank has of others of its group, and they of it, by instance of the scene.
#[derive(Debug, Default)]
pub struct Held {
    /// The group, whether clusters have the numbers of their faces, and whether numbers are those in the senders' parts.
    of: (Range<usize>, bool, bool),
    given: Vec<Given>,
    /// Of each instance: all in one mesh, or in one for each sender.
    pub gathered: Vec<Vec<Kept>>,
}

/// Clusters of this rank's part that ranks of the group have.
#[derive(Debug)]
struct Given {
    /// The part. It cannot change unnoticed: what a weak pointer refers to is neither written to nor another object.
    mesh: Weak<ClusteredMesh>,
    share: Share,
    /// Of each rank of the group, in the order in which it has them.
    of_ranks: Vec<Vec<u32>>,
}

/// Clusters that this rank gathered, those of a rank of the group behind each other.
#[derive(Debug)]
pub struct Kept {
    pub mesh: Arc<ClusteredMesh>,
    /// Each rank, and the number of clusters after its own.
    pub ends: Vec<(usize, usize)>,
}

impl Kept {
    /// The clusters of a rank.
    pub fn of(&self, rank: usize) -> Range<usize> {
        let place = self.ends.iter().position(|(from, _)| *from == rank);
        place.map_or(0..0, |place| {
            let before = place.checked_sub(1).map_or(0, |before| self.ends[before].1);
            before..self.ends[place].1
        })
    }
}

/// What is sent of an instance to a rank.
pub struct Migration {
    /// Of each cluster that the rank has, in its order: does it need it?
    pub is_kept: Vec<bool>,
    /// Clusters that it needs and has not.
    pub new: Vec<u32>,
}

impl Held {
    /// Begins a frame of a group, all of whose ranks do the same; also if it has one rank only. What another group had is forgotten.
    pub fn begin(&mut self, members: &Range<usize>, has_faces: bool, is_wide: bool) {
        let of = (members.clone(), has_faces, is_wide);
        if self.of != of {
            *self = Self { of, ..Self::default() };
        }
    }

    /// Forgets what is of instances that the scene has no more: an instance that takes their place later is gathered anew.
    pub fn keep_instances(&mut self, count: usize) {
        self.given.truncate(count);
    }

    /// What is to be sent of the instance with a number to a rank of the group that needs these clusters of it, in ascending order; it
    /// has them from now on.
    pub fn migrate(
        &mut self,
        number: usize,
        (instance, share): (&Instance, Share),
        to: usize,
        needed: &[u32],
    ) -> Migration {
        let is_same = |given: &Given| {
            std::ptr::eq(given.mesh.as_ptr(), Arc::as_ptr(&instance.mesh)) && given.share == share
        };
        if !self.given.get(number).is_some_and(is_same) {
            let mesh = Arc::downgrade(&instance.mesh);
            let given = Given { mesh, share, of_ranks: vec![Vec::new(); self.of.0.len()] };
            match self.given.get_mut(number) {
                Some(place) => *place = given,
                None => self.given.push(given),
            }
        }
        let has = &mut self.given[number].of_ranks[to];
        let is_kept: Vec<bool> = has.iter().map(|cluster| needed.binary_search(cluster).is_ok()).collect();
        let mut keeps = is_kept.iter();
        has.retain(|_| keeps.next() == Some(&true));
        let mut sorted = has.clone();
        sorted.sort_unstable();
        let new: Vec<u32> =
            needed.iter().copied().filter(|cluster| sorted.binary_search(cluster).is_err()).collect();
        has.extend(&new);
        Migration { is_kept, new }
    }
}

#[cfg(test)]
mod tests {
    use tercio_mesh::cluster::{PartitionOptions, partition};

    use super::*;

    const SHARE: Share = Share {
        first_triangle: 0,
        triangles: 1,
        first_face: 0,
        faces: 1,
        base: None,
        has_whole_numbers: false,
    };

    fn instance() -> Instance {
        let mesh = tercio_mesh::builtin::make("builtin:sphere@100").expect("a model");
        Instance::new(partition(mesh, &PartitionOptions::default()))
    }

    #[test]
    fn a_rank_gets_what_it_has_not() {
        let mut held = Held::default();
        held.begin(&(3..5), false, false);
        let mut first = instance();
        let needs = |held: &mut Held, instance: &Instance, share, needed: &[u32]| {
            let Migration { is_kept, new } = held.migrate(0, (instance, share), 1, needed);
            (is_kept, new)
        };
        assert_eq!(needs(&mut held, &first, SHARE, &[2, 5, 6]), (vec![], vec![2, 5, 6]));
        assert_eq!(needs(&mut held, &first, SHARE, &[1, 5, 6]), (vec![false, true, true], vec![1]));
        assert_eq!(needs(&mut held, &first, SHARE, &[1, 2]), (vec![false, false, true], vec![2]));
        // Ranks of the same group, with other triangles before these.
        let share = Share { first_triangle: 1, ..SHARE };
        assert_eq!(needs(&mut held, &first, share, &[1, 2]), (vec![], vec![1, 2]));
        held.begin(&(3..5), false, false);
        assert_eq!(needs(&mut held, &first, share, &[1, 2]), (vec![true, true], vec![]));
        // The mesh is another one, also if it gets the same memory, or if it is changed in its place.
        assert_eq!(needs(&mut held, &instance(), share, &[1]), (vec![], vec![1]));
        assert_eq!(needs(&mut held, &instance(), share, &[1]), (vec![], vec![1]));
        assert_eq!(needs(&mut held, &first, share, &[1]), (vec![], vec![1]));
        Arc::make_mut(&mut first.mesh).materials.clear();
        assert_eq!(needs(&mut held, &first, share, &[1]), (vec![], vec![1]));
        // Another group, faces, or other numbers.
        held.begin(&(3..5), true, false);
        assert_eq!(needs(&mut held, &first, share, &[1]), (vec![], vec![1]));
        held.begin(&(3..5), true, true);
        assert_eq!(needs(&mut held, &first, share, &[1]), (vec![], vec![1]));
        held.begin(&(2..5), true, true);
        assert_eq!(needs(&mut held, &first, share, &[1]), (vec![], vec![1]));
    }

    #[test]
    fn clusters_of_a_rank_are_behind_those_of_the_ranks_before() {
        let kept = Kept { mesh: instance().mesh, ends: vec![(2, 4), (0, 4), (1, 9)] };
        assert_eq!([2, 0, 1, 7].map(|rank| kept.of(rank)), [0..4, 4..4, 4..9, 0..0]);
    }
}
