//! Removes triangles from a mesh.

use crate::loops::prelude::*;

use super::CHUNK;
use crate::{AttributeDomain, Mesh};

/// Removes the triangles with the given numbers, which are in ascending order, from a mesh.
pub(super) fn drop_triangles(mesh: &mut Mesh, drops: &[u32]) {
    match &mut mesh.face_of_triangle {
        Some(faces) => drop_elements(faces, drops),
        None => mesh.face_of_triangle = Some(numbers_without(mesh.triangles.len(), drops)),
    }
    drop_elements(&mut mesh.triangles, drops);
    mesh.face_colors.iter_mut().for_each(|a| drop_elements(a, drops));
    mesh.triangle_materials.iter_mut().for_each(|a| drop_elements(a, drops));
    for a in &mut mesh.attributes {
        if a.domain == AttributeDomain::Triangle {
            drop_elements(&mut a.values, drops);
        }
    }
}

/// The numbers below `count` without the given ones, which are in ascending order.
fn numbers_without(count: usize, drops: &[u32]) -> Vec<u32> {
    let mut numbers = vec![0; count - drops.len()];
    numbers.par_chunks_mut(CHUNK).enumerate().for_each(|(n, numbers)| {
        // `gone` is the number of drops that precede the number at this position.
        let first = n * CHUNK;
        let mut gone = first_place(drops, |k| drops[k] as usize - k > first);
        for (place, number) in (first..).zip(numbers) {
            while gone < drops.len() && drops[gone] as usize == place + gone {
                gone += 1;
            }
            *number = (place + gone) as u32;
        }
    });
    numbers
}

/// The first index for which `holds` is true; precondition: it is false before and true from there on.
fn first_place(list: &[u32], holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, list.len());
    while low < high {
        let middle = (low + high) / 2;
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

/// Removes the elements with the given numbers, which are in ascending order.
fn drop_elements<T: Copy>(array: &mut Vec<T>, drops: &[u32]) {
    let mut to = drops[0] as usize;
    for (i, &d) in drops.iter().enumerate() {
        let end = drops.get(i + 1).map_or(array.len(), |&n| n as usize);
        array.copy_within(d as usize + 1..end, to);
        to += end - (d as usize + 1);
    }
    array.truncate(to);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_without_some_are_the_others() {
        let count = 3 * CHUNK + 5;
        for drops in
            [vec![0], vec![0, 1, 2], (0..count as u32).filter(|d| d % 5 < 2 || d / 20_000 == 2).collect()]
        {
            let expected: Vec<u32> = (0..count as u32).filter(|d| drops.binary_search(d).is_err()).collect();
            assert_eq!(numbers_without(count, &drops), expected);
        }
    }
}
