//! Checks that clusters from outside of this process have the properties that a renderer relies on.

use super::{Cluster, ClusterView, Line, MAX_TRIANGLES, MAX_VERTICES};
use crate::FileMaterial;

/// Do the counts of a head describe a cluster? Then [`super::Layout::lines`] is the number of its lines.
pub fn has_valid_counts(head: &Cluster) -> bool {
    (1..=MAX_VERTICES).contains(&usize::from(head.vertices))
        && (1..=MAX_TRIANGLES).contains(&usize::from(head.triangles))
        && head.number_bits <= 32
}

/// Describes what is not as it has to be in a cluster whose memory has the lines that its head asks for, if anything is: it has
/// to begin with its head, vertices have to be inside of the box, corners have to exist, and primitive numbers
/// have to be below `triangles`.
pub fn cluster(
    view: &ClusterView,
    head: &Cluster,
    triangles: u64,
    materials: &[FileMaterial],
) -> Result<(), &'static str> {
    let line = view.first_line()[0];
    if line.0[..size_of::<Cluster>()] != *bytemuck::bytes_of(head)
        || line.0[size_of::<Cluster>()..] != [0; Line::BYTES - size_of::<Cluster>()]
    {
        return Err("the head");
    }
    for (axis, values) in view.positions().into_iter().enumerate() {
        let (least, most) = (head.min[axis], head.max[axis]);
        // False for NaN, too.
        let inside = values.iter().fold(true, |all, &v| all & (v >= least) & (v <= most));
        if !inside || !least.is_finite() || !most.is_finite() {
            return Err("vertices inside of the box");
        }
    }
    let most = view.corners().into_iter().flatten().fold(0, |most, &corner| most.max(corner));
    if most >= head.vertices {
        return Err("corners that are vertices");
    }
    if head.is_translucent() != view.is_translucent(materials) {
        return Err("the flag of translucent colours");
    }
    if view.greatest_primitive() >= triangles {
        return Err("primitive numbers below the number of triangles");
    }
    Ok(())
}
