//! Objects divided into partitions of at most 500 triangles.
//!
//! The thesis uses MeTiS (document 001, 3.3.3); here triangles are halved along the longest side of their centroids'
//! bounding box until they are few enough (recursive coordinate bisection), which gives as many partitions of as even a
//! size: 139 for the bunny's 69,451 triangles.

use std::collections::HashSet;

use tercio_mesh::Mesh;

/// Maximum number of triangles of a partition (document 001, 3.3.3).
pub const PARTITION: usize = 500;

/// Triangle numbers of each partition; every triangle is in exactly one. Sizes of partitions differ by at most one.
pub fn partitions(mesh: &Mesh, at_most: usize) -> Vec<Vec<u32>> {
    let centres: Vec<[f32; 3]> = mesh.triangles.iter().map(|t| centre(mesh, t)).collect();
    let mut numbers: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let count = numbers.len().div_ceil(at_most.max(1));
    let mut out = Vec::with_capacity(count);
    bisect(&centres, &mut numbers, count, &mut out);
    out
}

fn centre(mesh: &Mesh, triangle: &[u32; 3]) -> [f32; 3] {
    let p = triangle.map(|v| mesh.positions[v as usize]);
    [0, 1, 2].map(|k| (p[0][k] + p[1][k] + p[2][k]) / 3.0)
}

fn bisect(centres: &[[f32; 3]], numbers: &mut [u32], count: usize, out: &mut Vec<Vec<u32>>) {
    if count <= 1 {
        if !numbers.is_empty() {
            out.push(numbers.to_vec());
        }
        return;
    }
    let extent = |k: usize| {
        let values = numbers.iter().map(|&n| centres[n as usize][k]);
        let (low, high) =
            values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        high - low
    };
    let axis = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    let left = count / 2;
    let middle = numbers.len() * left / count;
    // Ties are broken by number, so that the split does not depend on the sorting algorithm.
    let key = |n: &u32| centres[*n as usize][axis];
    numbers.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    let (low, high) = numbers.split_at_mut(middle);
    bisect(centres, low, left, out);
    bisect(centres, high, count - left, out);
}

/// Number of different vertices of these triangles.
pub fn vertices(mesh: &Mesh, triangles: &[u32]) -> u32 {
    let all: HashSet<u32> = triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    all.len() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet of squares, two triangles each.
    fn sheet(side: u32) -> Mesh {
        let at = |x: u32, y: u32| y * (side + 1) + x;
        let positions = (0..=side).flat_map(|y| (0..=side).map(move |x| [x as f32, y as f32, 0.0])).collect();
        let square = |x, y| {
            let (a, b, c, d) = (at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1));
            [[a, b, c], [a, c, d]]
        };
        let triangles = (0..side).flat_map(|y| (0..side).flat_map(move |x| square(x, y))).collect();
        Mesh { positions, triangles, ..Default::default() }
    }

    #[test]
    fn every_triangle_is_in_one_partition_of_an_even_size() {
        let mesh = sheet(60);
        let parts = partitions(&mesh, PARTITION);
        assert_eq!(parts.len(), 7200usize.div_ceil(500));
        let (least, most) = (parts.iter().map(Vec::len).min(), parts.iter().map(Vec::len).max());
        assert!(most.unwrap() - least.unwrap() <= 1 && most.unwrap() <= 500, "{least:?} {most:?}");
        let mut all = parts.concat();
        all.sort_unstable();
        assert_eq!(all, (0..7200).collect::<Vec<u32>>());
    }

    #[test]
    fn partitions_share_vertices_about_as_well_as_a_mesh() {
        let mesh = sheet(60);
        let corners: u32 = partitions(&mesh, PARTITION).iter().map(|p| vertices(&mesh, p)).sum();
        // 3,721 vertices without any split; a split duplicates those on its line.
        assert!((3_721..4_500).contains(&corners), "{corners}");
    }
}
