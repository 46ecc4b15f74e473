//! The outline of models that are not in memory at the same time.

use glam::DVec3;
use tercio_mesh::loops::prelude::*;
use tercio_mesh::{Aabb, trig};

/// Directions in which models are measured: two neighbours are about 6 degrees apart.
const DIRECTIONS: u32 = 1000;

/// The points of some models that are farthest in each of many directions, for a camera that frames all of them. A point
/// between two of these directions may be outside, by less than a hundredth of a smooth model's size.
#[derive(Clone, Debug)]
pub struct Outline {
    farthest: Vec<Option<DVec3>>,
    bounds: Aabb,
}

impl Default for Outline {
    fn default() -> Self {
        Self { farthest: vec![None; DIRECTIONS as usize], bounds: Aabb::EMPTY }
    }
}

impl Outline {
    /// Adds a model with these world-space bounds, of which `farthest` gives a point that reaches farthest in a direction.
    pub fn add(&mut self, bounds: &Aabb, farthest: impl Fn(DVec3) -> Option<DVec3> + Sync) {
        let directions: Vec<DVec3> = directions().collect();
        let farthest = directions.par_iter().map(|&d| farthest(d).filter(|p| p.is_finite())).collect();
        self.add_outline(&Self { farthest, bounds: *bounds });
    }

    /// Adds the models of another outline.
    pub fn add_outline(&mut self, other: &Self) {
        self.bounds = self.bounds.union(other.bounds);
        for ((most, own), direction) in self.farthest.iter_mut().zip(&other.farthest).zip(directions()) {
            *most = farther(direction, *most, *own);
        }
    }

    /// World-space bounds of all models.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// As [`Instance::reach`](crate::Instance::reach), of the points of the outline.
    pub fn reach(&self, direction: DVec3, from: DVec3) -> f64 {
        let points = self.farthest.iter().flatten();
        points.fold(f64::NEG_INFINITY, |most, p| most.max(direction.dot(*p - from)))
    }
}

/// Directions that are evenly spread over the sphere, on a spiral from pole to pole, those of the axes first: a box is exact.
fn directions() -> impl Iterator<Item = DVec3> {
    let golden = 180.0 * (3.0 - 5.0f64.sqrt());
    let spiral = (0..DIRECTIONS - 6).map(move |number| {
        let z = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(DIRECTIONS - 6);
        let (sin, cos) = trig::sin_cos_degrees(golden * f64::from(number));
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * cos, across * sin, z)
    });
    DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]).chain(spiral)
}

/// The one of two points that is farther in a direction; of equal ones the first.
fn farther(direction: DVec3, a: Option<DVec3>, b: Option<DVec3>) -> Option<DVec3> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if direction.dot(b - a) > 0.0 { b } else { a }),
        (a, b) => a.or(b),
    }
}

#[cfg(test)]
mod tests {
    use tercio_mesh::builtin;
    use tercio_mesh::cluster::{PartitionOptions, partition};

    use super::super::Extent;
    use super::*;
    use crate::Instance;

    #[test]
    fn an_outline_reaches_as_far_as_the_models() {
        let of = |name: &str, at: DVec3| {
            let mesh = partition(builtin::make(name).unwrap(), &PartitionOptions::default());
            Instance { world_from_object: glam::DAffine3::from_translation(at), ..Instance::new(mesh) }
        };
        let models =
            [of("builtin:teapot@20k", DVec3::ZERO), of("builtin:gyroid@20k", DVec3::new(1.0, 3.0, -2.0))];
        let mut outline = Outline::default();
        models.iter().for_each(|m| outline.add(&m.bounds(), |d| m.farthest(d)));
        let bounds = models[0].bounds().union(models[1].bounds());
        assert_eq!(outline.bounds(), bounds);
        let size = bounds.size().length();
        for direction in directions().map(|d| DVec3::new(d.z, d.x, -d.y)) {
            let exact = models.iter().map(|m| m.reach(direction, bounds.center())).fold(f64::MIN, f64::max);
            let found = outline.reach(direction, bounds.center());
            assert!(
                found <= exact + 1e-9 * size && found >= exact - 0.003 * size,
                "{direction}: {found}, {exact}"
            );
        }
        assert_eq!(Outline::default().reach(DVec3::X, DVec3::ZERO), f64::NEG_INFINITY);
    }

    #[test]
    fn cells_find_the_farthest_vertex() {
        let mesh = builtin::make("builtin:terrain@20k").unwrap();
        let extent = Extent::of_mesh(&mesh);
        let cells = extent.cells();
        for direction in directions().map(|d| DVec3::new(d.z, d.x, -d.y)) {
            let farthest = direction.dot(cells.farthest(direction).unwrap());
            assert!((farthest - extent.reach(direction, DVec3::ZERO)).abs() < 1e-9, "{direction}");
        }
        let nothing = Extent::of_mesh(&tercio_mesh::Mesh::default()).cells();
        assert_eq!(nothing.farthest(DVec3::X), None);
    }

    #[test]
    fn directions_are_spread_evenly() {
        let all: Vec<DVec3> = directions().collect();
        assert_eq!(all.len(), DIRECTIONS as usize);
        for (number, d) in all.iter().enumerate() {
            assert!((d.length() - 1.0).abs() < 1e-12);
            let others = all.iter().enumerate().filter(|(other, _)| *other != number);
            let nearest = others.map(|(_, other)| d.dot(*other)).fold(-1.0, f64::max).acos().to_degrees();
            assert!(nearest < 8.0, "{d}: {nearest}");
        }
    }
}
