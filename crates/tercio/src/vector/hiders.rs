//! The triangles that hide lines, and what they hide of a segment.
//!
//! The part of a segment that a triangle hides is bounded by linear functions of the place on the segment in space: the three
//! planes through the eye and a side of the triangle, the plane of the triangle, and the near plane. So it is one interval, whose
//! ends are found by dividing once, without projecting anything.

use glam::{DVec2, DVec3};
use tercio_mesh::loops::prelude::*;
use tercio_scene::{Instance, Scene};

use super::grid::Grids;
use crate::strokes::Eye;

/// What rounding of positions to `f32` can change of the distance between a point and a plane, relative to the size of the model:
/// half of the last bit of three coordinates, of the point and of the plane.
pub(super) const OF_POSITIONS: f64 = 1.0 / (1u32 << 23) as f64;
/// What `f64` can change of a position in eye space, relative to the largest coordinate.
const OF_EYE_SPACE: f64 = 1.0 / (1u64 << 49) as f64;
/// What is visible between two hidden parts and shorter than this, in pixels, is a crack in the surface, and left out.
const CRACK: f64 = 1.0 / 128.0;

/// A triangle in eye space.
#[derive(Clone, Copy, Debug)]
struct Hider {
    corners: [u32; 3],
    /// What is not farther behind its plane touches it.
    touch: f32,
}

/// The triangles of a scene that hide lines, for one camera.
#[derive(Debug)]
pub struct Hiders {
    eye: Eye,
    points: Vec<DVec3>,
    triangles: Vec<Hider>,
    /// The error of positions in eye space.
    grain: f64,
    grids: Option<Grids>,
}

/// Something linear on a segment: its values at both ends.
type Ends = [f64; 2];

impl Hiders {
    /// The triangles of all instances of a scene. Lines are hidden up to `margin` pixels beside the picture.
    ///
    /// Every surface hides, also one that is not opaque, and from both sides.
    pub fn of_scene(eye: &Eye, scene: &Scene, margin: f64) -> Self {
        let mut hiders = Self::empty(eye);
        scene.instances.iter().for_each(|instance| hiders.add(instance));
        hiders.finished(margin)
    }

    /// Triangles in world space. What is less than `touch` behind the plane of a triangle is not hidden by it.
    pub fn of_triangles(eye: &Eye, triangles: &[[DVec3; 3]], touch: f64, margin: f64) -> Self {
        let mut hiders = Self::empty(eye);
        for corners in triangles {
            let first = hiders.points.len() as u32;
            hiders.points.extend(corners.map(|p| eye.eye_space(p)));
            hiders.push([first, first + 1, first + 2], touch as f32);
        }
        hiders.finished(margin)
    }

    /// The most bytes that [`Hiders::of_scene`] takes.
    pub fn needed_bytes(scene: &Scene) -> u64 {
        let of_mesh = |instance: &Instance| {
            let (vertices, triangles) = (instance.mesh.vertex_count(), instance.mesh.triangle_count());
            // Corners, triangles, and about six cells each that are sorted, with those of their grids.
            vertices as u64 * 24 + triangles as u64 * (16 + 6 * 20 + 8)
        };
        scene.instances.iter().map(of_mesh).sum()
    }

    fn empty(eye: &Eye) -> Self {
        Self { eye: eye.clone(), points: Vec::new(), triangles: Vec::new(), grain: 0.0, grids: None }
    }

    fn add(&mut self, instance: &Instance) {
        let (mesh, place) = (&instance.mesh, &instance.world_from_object);
        let clusters = mesh.clusters().len();
        let eye = &self.eye;
        let of_cluster = |number: usize| {
            let cluster = mesh.cluster(number);
            let at = |v: usize| eye.eye_space(place.transform_point3(mesh.position(&cluster, v)));
            let largest =
                (0..cluster.vertices()).flat_map(|v| cluster.position(v)).fold(0.0f32, |m, c| m.max(c.abs()));
            let corners: Vec<[u32; 3]> =
                (0..cluster.triangles()).map(|t| cluster.corners_of(t).map(u32::from)).collect();
            ((0..cluster.vertices()).map(at).collect::<Vec<_>>(), corners, largest)
        };
        let parts: Vec<_> = (0..clusters).into_par_iter().map(of_cluster).collect();
        let largest = parts.iter().map(|part| part.2).fold(0.0, f32::max);
        let touch = f64::from(largest) * mesh.unit() * stretch(place) * OF_POSITIONS;
        for (points, corners, _) in parts {
            let first = self.points.len() as u32;
            self.points.extend(points);
            for corners in corners {
                self.push(corners.map(|c| first + c), touch as f32);
            }
        }
    }

    /// Adds a triangle, unless it cannot hide anything.
    fn push(&mut self, corners: [u32; 3], touch: f32) {
        let [a, b, c] = corners.map(|v| self.points[v as usize]);
        let normal = (b - a).cross(c - a);
        if normal.is_finite() && normal != DVec3::ZERO && a.is_finite() && touch.is_finite() {
            self.triangles.push(Hider { corners, touch });
        }
    }

    fn finished(mut self, margin: f64) -> Self {
        let largest = self.points.par_iter().map(|p| p.abs().max_element()).filter(|c| c.is_finite());
        let reach = largest.reduce(|| 0.0, f64::max) + self.eye.position().abs().max_element();
        self.grain = reach * OF_EYE_SPACE;
        self.grids = Some(Grids::new(&self, margin));
        self
    }

    /// The camera.
    pub fn eye(&self) -> &Eye {
        &self.eye
    }

    /// How many triangles there are.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Is there no triangle?
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    pub(super) fn corners(&self, number: u32) -> [DVec3; 3] {
        self.triangles[number as usize].corners.map(|v| self.points[v as usize])
    }

    /// What is visible of a segment in eye space, which is in front of the near plane: intervals of places on it, 0 at its first end
    /// and 1 at its second one, in order. A point (a segment without length) is visible from 0 to 1 or not at all.
    pub fn visible(&self, ends: [DVec3; 2]) -> Vec<Ends> {
        let mut hidden: Vec<Ends> = Vec::new();
        let screen = ends.map(|p| self.eye.screen(p));
        let [z0, z1] = ends.map(|p| p.z);
        // From shares of the length on the screen to places in space.
        let place = |u: f64| match u {
            u if u <= 0.0 => 0.0,
            u if u >= 1.0 => 1.0,
            u if self.eye.is_perspective() => u * z0 / (z1 + u * (z0 - z1)),
            u => u,
        };
        if let Some(grids) = &self.grids {
            grids.along(screen, |triangles, enters, leaves| {
                let (from, to) = (place(enters), place(leaves));
                let farthest = (z0 + from * (z1 - z0)).max(z0 + to * (z1 - z0));
                for &number in triangles {
                    if covers(&hidden, from, to) {
                        return;
                    }
                    let corners = self.corners(number);
                    let nearest = corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
                    // They are ordered by distances in `f32`.
                    if nearest - nearest.abs() * 2.5e-7 > farthest {
                        return;
                    }
                    if let Some([low, high]) = self.hidden_by(number, corners, ends) {
                        let part = [low.max(from), high.min(to)];
                        if part[0] < part[1] {
                            insert(&mut hidden, part);
                        }
                    }
                }
            });
        }
        let on_screen = |t: f64| {
            let p = ends[0].lerp(ends[1], t);
            if t >= 1.0 { screen[1] } else { self.eye.screen(p) }
        };
        complement(&hidden, |[a, b]: Ends| {
            a > 0.0 && b < 1.0 && DVec2::distance(on_screen(a), on_screen(b)) < CRACK
        })
    }

    /// The part of a segment that a triangle hides.
    fn hidden_by(&self, number: u32, [a, b, c]: [DVec3; 3], ends: [DVec3; 2]) -> Option<Ends> {
        let normal = (b - a).cross(c - a);
        let length = normal.length();
        // How far the eye is in front of the plane; an orthographic one is infinitely far.
        let towards = if self.eye.is_perspective() { normal.dot(a) } else { normal.z };
        if towards == 0.0 || !length.is_finite() || length == 0.0 {
            return None;
        }
        let sign = towards.signum();
        let snap = |value: f64, by: f64| if value.abs() <= by { 0.0 } else { value };
        let touch = f64::from(self.triangles[number as usize].touch).max(self.grain) * length;
        let behind = ends.map(|p| snap(sign * normal.dot(p - a), touch));
        if behind[0] <= 0.0 && behind[1] <= 0.0 {
            return None;
        }
        let mut part = [0.0, 1.0];
        limit(&mut part, behind)?;
        for [from, to] in [[a, b], [b, c], [c, a]] {
            // The same numbers for the triangle on the other side.
            let (from, to, turned) = if before(from, to) { (from, to, sign) } else { (to, from, -sign) };
            let side = if self.eye.is_perspective() {
                let plane = from.cross(to - from);
                let by = self.grain * plane.length();
                ends.map(|p| snap(turned * (p - from).dot(plane), by))
            } else {
                let along = (to - from).truncate();
                let by = self.grain * along.length();
                ends.map(|p| snap(turned * along.perp_dot((p - from).truncate()), by))
            };
            limit(&mut part, side)?;
        }
        let near = self.eye.near();
        if a.z.min(b.z).min(c.z) < near {
            // What is in front of the near plane is not drawn, and hides nothing.
            let full = towards.abs();
            let shown = ends.map(|p| {
                let beyond = sign * normal.dot(p - a);
                if self.eye.is_perspective() {
                    p.z * full - near * (full + beyond)
                } else {
                    (p.z - near) * full - beyond
                }
            });
            limit(&mut part, shown)?;
        }
        let depth = part.map(|t| behind[0] + t * (behind[1] - behind[0]));
        (depth[0].max(depth[1]) > touch).then_some(part)
    }
}

/// The most that a transform makes lengths longer, about.
pub(super) fn stretch(place: &glam::DAffine3) -> f64 {
    let m = place.matrix3;
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}

/// An order of points.
pub(super) fn before(a: DVec3, b: DVec3) -> bool {
    a.to_array() < b.to_array()
}

/// Limits an interval to where something is not negative; `None` if that is nowhere.
fn limit(part: &mut Ends, [from, to]: Ends) -> Option<()> {
    match (from >= 0.0, to >= 0.0) {
        (true, true) => {}
        (true, false) => part[1] = part[1].min(from / (from - to)),
        (false, true) => part[0] = part[0].max(from / (from - to)),
        // Also what is not a number.
        (false, false) => return None,
    }
    (part[0] <= part[1]).then_some(())
}

/// Is a part covered by one of the intervals?
fn covers(all: &[Ends], from: f64, to: f64) -> bool {
    let after = all.partition_point(|part| part[0] <= from);
    after > 0 && all[after - 1][1] >= to
}

/// Adds an interval to disjoint ones in order, and unites those that meet.
fn insert(all: &mut Vec<Ends>, mut part: Ends) {
    let from = all.partition_point(|other| other[1] < part[0]);
    let to = all.partition_point(|other| other[0] <= part[1]);
    if from < to {
        part = [part[0].min(all[from][0]), part[1].max(all[to - 1][1])];
    }
    all.splice(from..to, [part]);
}

/// What is between disjoint intervals in order, without what is dropped.
fn complement(hidden: &[Ends], drop: impl Fn(Ends) -> bool) -> Vec<Ends> {
    let mut visible = Vec::new();
    let mut from = 0.0;
    for &[a, b] in hidden {
        if a > from && !drop([from, a]) {
            visible.push([from, a]);
        }
        from = b;
    }
    if from < 1.0 {
        visible.push([from, 1.0]);
    }
    visible
}
