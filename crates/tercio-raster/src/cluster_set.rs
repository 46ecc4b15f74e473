//! Sets of clusters.

use std::ops::Range;
use std::sync::Arc;

/// A set of clusters of a scene, by their numbers over all instances.
///
/// ```
/// use tercio_raster::ClusterSet;
///
/// let some = ClusterSet::from_iter([8..10, 0..3, 2..5]);
/// assert_eq!(some.ranges(9), [0..5, 8..9]);
/// assert_eq!(ClusterSet::ALL.ranges(9), [0..9]);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ClusterSet(Option<Arc<[Range<u32>]>>);

impl ClusterSet {
    /// All clusters of any scene.
    pub const ALL: Self = Self(None);

    /// The clusters of the set in a scene of this many, as ranges that are not empty, ascending and apart from each other.
    pub fn ranges(&self, clusters: u32) -> Vec<Range<u32>> {
        let all = 0..clusters;
        let ranges = self.0.as_deref().unwrap_or(std::slice::from_ref(&all));
        let inside = ranges.iter().map(|range| range.start..range.end.min(clusters));
        inside.filter(|range| !range.is_empty()).collect()
    }
}

impl FromIterator<Range<u32>> for ClusterSet {
    /// The clusters that are in any of some ranges.
    fn from_iter<T: IntoIterator<Item = Range<u32>>>(ranges: T) -> Self {
        let mut ranges: Vec<_> = ranges.into_iter().filter(|range| !range.is_empty()).collect();
        ranges.sort_unstable_by_key(|range| range.start);
        let mut apart: Vec<Range<u32>> = Vec::new();
        for range in ranges {
            match apart.last_mut().filter(|last| range.start <= last.end) {
                Some(last) => last.end = last.end.max(range.end),
                None => apart.push(range),
            }
        }
        Self(Some(apart.into()))
    }
}

impl From<Range<u32>> for ClusterSet {
    fn from(range: Range<u32>) -> Self {
        Self::from_iter([range])
    }
}

/// Divides ranges into `parts` lists, at least 1, of about as many numbers; together they are the ranges in the same order.
pub fn divide(ranges: &[Range<u32>], parts: usize) -> Vec<Vec<Range<u32>>> {
    let all: u64 = ranges.iter().map(|range| range.len() as u64).sum();
    let begin = |part: usize| all * part as u64 / parts as u64;
    let mut divided = vec![Vec::new(); parts];
    let (mut part, mut at) = (0, 0);
    for range in ranges {
        let mut left = range.clone();
        while !left.is_empty() {
            while begin(part + 1) <= at {
                part += 1;
            }
            let taken = ((begin(part + 1) - at) as u32).min(left.len() as u32);
            divided[part].push(left.start..left.start + taken);
            (left.start, at) = (left.start + taken, at + u64::from(taken));
        }
    }
    divided
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn parts_of_a_set_are_the_set(
            ranges in prop::collection::vec((0u32..60, 0u32..9), 0..9),
            clusters in 0u32..70,
            parts in 1usize..9,
        ) {
            let ranges: Vec<_> = ranges.into_iter().map(|(start, count)| start..start + count).collect();
            let set = ClusterSet::from_iter(ranges.clone());
            let found = set.ranges(clusters);
            let expected: Vec<u32> =
                (0..clusters).filter(|number| ranges.iter().any(|range| range.contains(number))).collect();
            prop_assert_eq!(found.iter().cloned().flatten().collect::<Vec<_>>(), expected.clone());
            prop_assert!(found.windows(2).all(|pair| pair[0].end < pair[1].start));
            let parts = divide(&found, parts);
            let sizes: Vec<usize> = parts.iter().map(|part| part.iter().map(|range| range.len()).sum()).collect();
            prop_assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1);
            prop_assert!(parts.iter().flatten().all(|range| !range.is_empty()));
            prop_assert_eq!(parts.concat().into_iter().flatten().collect::<Vec<_>>(), expected);
        }
    }
}
