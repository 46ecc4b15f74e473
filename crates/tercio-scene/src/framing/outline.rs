//! The outline of models that are not in memory at the same time.

use glam::{DAffine3, DVec3};
use tercio_mesh::{Aabb, trig};

use super::Extent;

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
    pub fn add(&mut self, bounds: &Aabb, farthest: impl Fn(DVec3) -> Option<DVec3>) {
        self.bounds = self.bounds.union(*bounds);
        for (most, direction) in self.farthest.iter_mut().zip(directions()) {
            let own = farthest(direction).filter(|p| p.is_finite());
            // The first of equal ones, so that the order of models is the only one that counts.
            *most = match (*most, own) {
                (Some(most), Some(own)) => Some(if direction.dot(own - most) > 0.0 { own } else { most }),
                (most, own) => most.or(own),
            };
        }
    }

    /// Adds an extent at a place.
    pub fn add_extent(&mut self, extent: &Extent, world_from_object: &DAffine3) {
        let mut bounds = Aabb::EMPTY;
        if !extent.bounds().is_empty() {
            let corners = extent.bounds().corners();
            corners.into_iter().for_each(|corner| bounds.add(world_from_object.transform_point3(corner)));
        }
        self.add(&bounds, |direction| {
            let farthest = extent.farthest(world_from_object.matrix3.transpose() * direction)?;
            Some(world_from_object.transform_point3(farthest))
        });
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

#[cfg(test)]
mod tests {
    use tercio_mesh::builtin;
    use tercio_mesh::cluster::{PartitionOptions, partition};

    use super::*;
    use crate::Instance;

    #[test]
    fn an_outline_reaches_as_far_as_the_models() {
        let of = |name: &str, at: DVec3| {
            let mesh = partition(builtin::make(name).unwrap(), &PartitionOptions::default());
            Instance { world_from_object: DAffine3::from_translation(at), ..Instance::new(mesh) }
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
