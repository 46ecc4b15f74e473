//! What part of a directional light's rays reaches what a camera can see: a shadow map of a large scene need not have the rest.

use glam::{DVec2, DVec3};
use tercio_mesh::Aabb;

use crate::conventions::SUBPIXELS;
use crate::view::View;

/// Texels are at least two 2^17ths of the scene's radius: `f32` distances of up to four radii then have steps of a 64th of a texel.
const FINEST: f64 = (1u64 << 17) as f64;

/// A half-space: points whose product with the normal is at least a number.
#[derive(Clone, Copy, Debug)]
struct Half {
    normal: DVec3,
    least: f64,
}

impl Half {
    fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.least
    }
}

/// The centre, from that of a sphere around the scene, and half the edge of a square of a light's map, along two axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    pub center: DVec2,
    pub half: f64,
}

impl Window {
    /// The smallest square that has all that `view` sees of a scene with these bounds, of those whose edge is a power of two of that of
    /// the whole scene, and whose centre is a corner of texels: so shadows do not change as the camera moves a little, except where
    /// that takes it to the next size.
    /// `None` if the half of the whole map would not do, or the view sees nothing.
    pub fn of(view: &View, bounds: &Aabb, axes: [DVec3; 2], size: u32) -> Option<Self> {
        let radius = bounds.radius();
        let seen = corners_of_seen(view, bounds);
        let along = |p: &DVec3| DVec2::from(axes.map(|axis| axis.dot(*p)));
        let (low, high) = seen
            .iter()
            .map(along)
            .fold((DVec2::splat(f64::INFINITY), DVec2::splat(f64::NEG_INFINITY)), |(low, high), p| {
                (low.min(p), high.max(p))
            });
        let needed = (high - low).max_element() * 0.5;
        if seen.is_empty() || !needed.is_finite() || !radius.is_normal() {
            return None;
        }
        let finest = radius * f64::from(size) / FINEST;
        let mut half = radius;
        while half * 0.5 >= needed.max(finest) {
            half *= 0.5;
        }
        if half == radius {
            return None;
        }
        let texel = 2.0 * half / f64::from(size);
        let center = ((low + high) * 0.5 / texel).round() * texel;
        Some(Self { center, half })
    }
}

/// The half-spaces between the sides of a view's picture, for points relative to `origin`.
fn sides(view: &View, origin: DVec3) -> [Half; 4] {
    let basis = &view.basis;
    let [width, height] = [view.width, view.height].map(|n| f64::from(n) * f64::from(SUBPIXELS));
    // Of the corners of the picture: directions to them, or points in their rays.
    let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]].map(|[x, y]| {
        let [x, y] = [x - f64::from(view.middle[0]), y - f64::from(view.middle[1])].map(|c| c / view.scale);
        basis.right * x - basis.up * y
    });
    let middle = corners.iter().sum::<DVec3>() * 0.25;
    let eye = view.eye - origin;
    std::array::from_fn(|side| {
        let (a, b) = (corners[side], corners[(side + 1) % 4]);
        let (normal, at) = match view.perspective {
            true => ((a + basis.forward).cross(b + basis.forward), eye),
            false => ((b - a).cross(basis.forward), eye + a),
        };
        let inside = if view.perspective { middle + basis.forward } else { middle - a };
        let normal = if normal.dot(inside) < 0.0 { -normal } else { normal };
        Half { normal, least: normal.dot(at) }
    })
}

/// Points of which the convex hull is what a view's sides leave of a box, from the middle of the box.
fn corners_of_seen(view: &View, bounds: &Aabb) -> Vec<DVec3> {
    let (middle, reach) = (bounds.center(), bounds.size() * 0.5);
    let sides = sides(view, middle);
    let mut seen = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            // A side of the box.
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let corner = |(x, y): (f64, f64)| {
                let mut p = DVec3::ZERO;
                (p[axis], p[u], p[v]) = (sign * reach[axis], x * reach[u], y * reach[v]);
                p
            };
            let mut polygon: Vec<DVec3> =
                [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).into();
            sides.iter().for_each(|half| polygon = cut(&polygon, half));
            seen.extend(polygon);
        }
    }
    let eye = view.eye - middle;
    let is_inside = eye.abs().cmple(reach).all();
    seen.extend((view.perspective && is_inside).then_some(eye));
    seen
}

/// What of a convex polygon is in a half-space.
fn cut(polygon: &[DVec3], half: &Half) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let (here, there) = (half.height(p), half.height(next));
        if here >= 0.0 {
            kept.push(p);
        }
        if (here >= 0.0) != (there >= 0.0) {
            kept.push(p + (next - p) * (here / (here - there)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use tercio_scene::{Camera, Projection};

    use super::*;

    const SIZE: u32 = 2048;

    fn floor() -> Aabb {
        Aabb { min: DVec3::new(-1000.0, 0.0, -1000.0), max: DVec3::new(1000.0, 4.0, 1000.0) }
    }

    fn window(eye: DVec3, target: DVec3, projection: Projection) -> Option<Window> {
        let camera = Camera { eye, target, up: DVec3::Z, projection, near: None, shift: [0.0; 2] };
        let view = View::new(&camera, &floor(), 400, 200).unwrap();
        // Light from above.
        Window::of(&view, &floor(), [DVec3::X, DVec3::Z], SIZE)
    }

    #[test]
    fn a_window_has_what_is_seen_and_little_more() {
        let at = DVec3::new(300.0, 0.0, -200.0);
        let angle = 0.6f64;
        // From above: at the height of the floor, 2 * 100 * tan(0.3) high, twice as wide.
        let perspective = window(at + DVec3::Y * 100.0, at, Projection::Perspective { fov_y: angle });
        let orthographic = window(at + DVec3::Y * 100.0, at, Projection::Orthographic { height: 70.0 });
        for (found, half) in [(perspective, 200.0 * 0.3f64.tan()), (orthographic, 70.0)] {
            let found = found.expect("a small part");
            assert!(found.half >= half && found.half < 2.0 * half, "{found:?} {half}");
            assert!((found.center - DVec2::new(300.0, -200.0)).abs().max_element() < 0.1, "{found:?}");
        }
        // As narrow as the precision of distances allows.
        let closest = window(at + DVec3::Y * 5.0, at, Projection::Orthographic { height: 0.01 }).unwrap();
        assert!(closest.half >= floor().radius() / 64.0 && closest.half < floor().radius() / 31.0);
    }

    #[test]
    fn what_may_be_anywhere_has_the_whole_map() {
        let high = DVec3::Y * 3000.0;
        assert_eq!(window(high, DVec3::ZERO, Projection::Perspective { fov_y: 0.9 }), None);
        // Along the floor to its far end.
        let along = window(
            DVec3::new(-990.0, 2.0, 0.0),
            DVec3::new(0.0, 1.9, 0.0),
            Projection::Perspective { fov_y: 0.9 },
        );
        assert_eq!(along, None);
        // Past the scene.
        let past = window(high, high * 2.0, Projection::Perspective { fov_y: 0.9 });
        assert_eq!(past, None);
    }

    #[test]
    fn a_small_step_of_the_camera_moves_it_by_whole_texels() {
        let of = |x: f64| {
            let at = DVec3::new(x, 0.0, 0.0);
            window(at + DVec3::Y * 20.0, at, Projection::Perspective { fov_y: 0.5 }).expect("a small part")
        };
        let first = of(10.0);
        for step in 1..50 {
            let next = of(10.0 + f64::from(step) * 0.013);
            assert_eq!(next.half, first.half);
            let texels = (next.center - first.center) * f64::from(SIZE) / (2.0 * first.half);
            assert!((texels - texels.round()).abs().max_element() < 1e-6, "{texels}");
        }
    }
}
