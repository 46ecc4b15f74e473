//! Shadow maps, and where a point of an instance is in them. [`crate::shadows`] draws them.

use glam::DVec3;
use tercio_scene::{Camera, Instance, Light};

use crate::view::ObjectView;

/// The shadows of a scene's directional, point and spot lights, for one camera if any of these lights moves with it or the maps have
/// only what it sees ([`ShadowArea`]).
///
/// Everything casts shadows except instances whose [`opacity`](tercio_scene::Surface::opacity) is below 1, and points whose
/// alpha is 0. A surface that is blended because of its own alpha, whatever it is, casts the shadow of an opaque one; of one
/// that is cut out, what is visible casts shadows.
#[derive(Debug, PartialEq)]
pub struct ShadowMaps {
    /// Of directional lights, in the order of the scene.
    pub(crate) distant: Vec<ShadowMap>,
    /// Of point and spot lights, in the order of the scene.
    pub(crate) near: Vec<NearMaps>,
    /// What they are the shadows of.
    pub(crate) made_for: MadeFor,
}

/// What shadow maps of directional lights have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShadowArea {
    /// All of the scene. The maps are those of any camera if no light moves with it.
    #[default]
    Scene,
    /// What of the scene's bounds the picture can show, if that is less than half as wide: then texels are up to 64 times as small, but
    /// the maps are those of this camera and size of the picture alone. What is drawn beside the bounds, such as tubes that are
    /// made for a camera, is lit.
    Picture,
}

/// What shadow maps are for.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MadeFor {
    pub lights: Vec<Light>,
    /// If a light moves with it, or a map has only what it sees.
    pub camera: Option<Camera>,
    /// Width and height in pixels of a picture, if a map has only what that shows.
    pub picture: Option<(u32, u32)>,
}

/// Is a spot light's cone, given by half of its opening in radians, so wide that its shadow maps are those of a point light?
pub(crate) fn is_wide(angle: f64) -> bool {
    angle > std::f64::consts::FRAC_PI_4
}

/// The shadow maps of a point light or a wide spot light: six, or of another spot light: one.
#[derive(Debug, PartialEq)]
pub(crate) struct NearMaps {
    /// Towards +x, -x, +y, -y, +z and -z, or only one.
    pub faces: Vec<ShadowMap>,
}

/// The scene's depth as seen from a light.
#[derive(Debug, PartialEq)]
pub(crate) struct ShadowMap {
    /// The point that positions are relative to, in world space: for point and spot lights the light itself.
    pub eye: DVec3,
    /// To the right, downwards, and away from the light.
    pub axes: [DVec3; 3],
    pub perspective: bool,
    /// Texels per world unit; for point and spot lights at a distance of 1.
    pub scale: f64,
    /// Texels along an edge.
    pub size: u32,
    /// How near to the light the nearest surface is: the negative distance along the light's direction, in world units; for
    /// point and spot lights one over the distance. Negative infinity, or 0, where there is none.
    pub nearness: Vec<f32>,
}

impl ShadowMaps {
    /// Bytes that the maps of these lights take, and the picture while one is drawn.
    pub fn needed_bytes(lights: &[Light], size: u32) -> u64 {
        let square = |size: u32| u64::from(size) * u64::from(size) * size_of::<f32>() as u64;
        let maps = lights.iter().map(|light| match light {
            Light::Ambient { .. } | Light::Wide { .. } => 0,
            Light::Directional { .. } => square(size),
            Light::Spot { angle, .. } if !is_wide(*angle) => square(size),
            Light::Point { .. } | Light::Spot { .. } => 6 * square(Self::size_of_face(size)),
        });
        maps.sum::<u64>() + square(size)
    }

    /// The texels of all maps, in an order that depends on nothing but the lights: how near to the light the nearest surface is,
    /// the larger the nearer. The maps of a scene are the maxima of those of its parts, if these have the bounds of the whole.
    pub fn nearness_mut(&mut self) -> impl Iterator<Item = &mut [f32]> {
        let near = self.near.iter_mut().flat_map(|maps| &mut maps.faces);
        self.distant.iter_mut().chain(near).map(|map| &mut map.nearness[..])
    }

    /// Texels along the edge of a face of a point light's cube.
    pub(crate) fn size_of_face(size: u32) -> u32 {
        size.div_ceil(2).max(128)
    }

    /// Bytes that the maps take.
    pub fn bytes(&self) -> usize {
        let near = self.near.iter().flat_map(|maps| &maps.faces);
        self.distant.iter().chain(near).map(|map| size_of_val(&map.nearness[..])).sum()
    }
}

/// A shadow map as seen from an instance: what the kernels need to find a point in it.
#[derive(Clone, Debug)]
pub(crate) struct ObjectShadow {
    /// From positions relative to the instance's [`ObjectView::pivot`] to the map's axes: texels to the right and downwards
    /// from its middle, and the distance; in world units of distance, and for point and spot lights texels times the
    /// distance.
    pub rows: [[f32; 4]; 3],
    /// From world axes to the map's axes.
    pub axes: [[f32; 3]; 3],
    /// Distance of two texels in world units; for point and spot lights at a distance of 1.
    pub texel: f32,
}

/// Which light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightNumber {
    /// A directional one, by its number among these.
    Distant(usize),
    /// A point or spot light, likewise.
    Near(usize),
    /// One without shadows.
    Wide,
}

/// How far nearer to the light than a point's plane something must be to shadow it, in texels; more is allowed to texels
/// aside of the point.
const TOLERANCE: f32 = 0.5;

/// The steepest plane that is compared, in texels of distance per texel.
const STEEPEST: f32 = 32.0;

impl ObjectShadow {
    /// The view that `map` gives of an instance.
    pub fn new(map: &ShadowMap, instance: &Instance, object: &ObjectView) -> Self {
        let mesh = &*instance.mesh;
        let linear = instance.world_from_object.matrix3 * mesh.unit();
        let pivot = linear * DVec3::from(object.pivot.map(f64::from))
            + (instance.world_from_object.transform_point3(mesh.origin) - map.eye);
        let scales = [map.scale, map.scale, 1.0];
        let row = |k: usize| {
            let axis = map.axes[k] * scales[k];
            let r = linear.transpose() * axis;
            [r.x as f32, r.y as f32, r.z as f32, axis.dot(pivot) as f32]
        };
        Self {
            rows: [row(0), row(1), row(2)],
            axes: map.axes.map(|axis| axis.as_vec3().to_array()),
            texel: (1.0 / map.scale) as f32,
        }
    }

    /// The share of the light that reaches a point, relative to the pivot, of a triangle with this normal in world axes, of
    /// any length.
    fn lit(&self, map: &ShadowMap, p: [f32; 3], normal: [f32; 3]) -> f32 {
        let [x, y, z] = self.rows.map(|r| ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + r[3]);
        let n = self.axes.map(|a| (normal[0] * a[0] + normal[1] * a[1]) + normal[2] * a[2]);
        // On a plane, how near the light is changes by the same amount from texel to texel.
        let (x, y, nearness, texel, [right, down]) = if map.perspective {
            // Behind the light.
            if !(z > 0.0) {
                return 1.0;
            }
            let inverse = 1.0 / z;
            let (x, y) = (x * inverse, y * inverse);
            let from_light = ((n[0] * x + n[1] * y) * self.texel + n[2]) * z;
            let slope = [n[0], n[1]].map(|n| n * self.texel / from_light);
            (x, y, inverse, self.texel * inverse, slope)
        } else {
            (x, y, -z, self.texel, [n[0], n[1]].map(|c| c * self.texel / n[2]))
        };
        let steepest = STEEPEST * texel;
        let limited = |slope: f32| match slope {
            slope if slope.abs() <= steepest => slope,
            slope if slope > 0.0 => steepest,
            slope if slope < 0.0 => -steepest,
            _ => 0.0,
        };
        let (right, down) = (limited(right), limited(down));
        // Beyond an inward corner is a surface that is nearer than the plane, the more the farther away and the steeper.
        // At most five texels, so that flat things on a floor keep their shadows in low light.
        let steepness = (right.abs() + down.abs()) / texel;
        let per_texel = 1.0 + 0.5 * if steepness < 8.0 { steepness } else { 8.0 };
        let middle = 0.5 * map.size as f32;
        let (x, y) = (x + middle, y + middle);
        let is_near = |c: f32| (-2.0..map.size as f32 + 2.0).contains(&c);
        if !is_near(x) || !is_near(y) {
            return 1.0;
        }
        let (first_x, first_y) = ((x - 1.5).floor(), (y - 1.5).floor());
        let shares = |share: f32| [1.0 - share, 1.0, 1.0, share];
        let (of_columns, of_rows) = (shares(x - 1.5 - first_x), shares(y - 1.5 - first_y));
        let mut dark = 0.0;
        for (j, of_row) in of_rows.into_iter().enumerate() {
            for (i, of_column) in of_columns.into_iter().enumerate() {
                let [column, row] = [first_x as i64 + i as i64, first_y as i64 + j as i64];
                let size = i64::from(map.size);
                if !(0..size).contains(&column) || !(0..size).contains(&row) {
                    continue;
                }
                let (to_right, to_down) = (column as f32 + 0.5 - x, row as f32 + 0.5 - y);
                let plane = (nearness + right * to_right) + down * to_down;
                let aside = if to_right.abs() > to_down.abs() { to_right.abs() } else { to_down.abs() };
                let tolerance = (TOLERANCE + aside * per_texel) * texel;
                if map.nearness[(row * size + column) as usize] > plane + tolerance {
                    dark += of_row * of_column;
                }
            }
        }
        1.0 - dark / 9.0
    }
}

/// The shadow maps as seen from one instance, in the order of [`ShadowMaps`].
#[derive(Clone, Debug, Default)]
pub(crate) struct ObjectShadows {
    pub distant: Vec<ObjectShadow>,
    pub near: Vec<Vec<ObjectShadow>>,
}

impl ObjectShadows {
    /// Of all maps.
    pub fn new(maps: &ShadowMaps, instance: &Instance, object: &ObjectView) -> Self {
        let seen = |map: &ShadowMap| ObjectShadow::new(map, instance, object);
        Self {
            distant: maps.distant.iter().map(seen).collect(),
            near: maps.near.iter().map(|maps| maps.faces.iter().map(seen).collect()).collect(),
        }
    }

    /// The share of a light that reaches a point, relative to the pivot, of a triangle with this normal in world axes, of any
    /// length.
    pub fn lit(&self, maps: &ShadowMaps, light: LightNumber, p: [f32; 3], normal: [f32; 3]) -> f32 {
        match light {
            LightNumber::Wide => 1.0,
            LightNumber::Distant(number) => self.distant[number].lit(&maps.distant[number], p, normal),
            LightNumber::Near(number) => {
                let (seen, faces) = (&self.near[number], &maps.near[number].faces);
                let face = if faces.len() == 1 { 0 } else { face_of(seen, p) };
                seen[face].lit(&faces[face], p, normal)
            }
        }
    }
}

/// The face of a point light's cube in which a point is.
fn face_of(faces: &[ObjectShadow], p: [f32; 3]) -> usize {
    let along = |face: usize| {
        let r = faces[face].rows[2];
        ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + r[3]
    };
    let [x, y, z] = [along(0), along(2), along(4)];
    let (axis, along) = if x.abs() >= y.abs() && x.abs() >= z.abs() {
        (0, x)
    } else if y.abs() >= z.abs() {
        (2, y)
    } else {
        (4, z)
    };
    axis + usize::from(along < 0.0)
}
