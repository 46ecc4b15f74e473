//! Colours of the visible pixels, 16 at a time, each pixel once.
//!
//! The visible pixels of a tile are packed without gaps; each lane fetches the corners of its triangle,
//! projects them again as the front end did, and interpolates between them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, mask32x16, u32x16};
use tercio_mesh::cluster::MAX_TRIANGLES;
use tercio_scene::Instance;

use super::cluster::ClusterPass;
use super::corners::{ColorSource, Corners, Fragments, to_world};
use super::encode::opaque;
use super::interpolate::Interpolation;
use super::light::{Vec3x16, bend, beside, diffuse, normalize, reflect, towards_viewer};
use super::memory::TileMemory;
use super::output::{Planes, TilePixels};
use super::plain;
use super::table::ClusterTable;
use crate::color::encode16;
use crate::context::{FrameContext, NO_SLOT};
use crate::conventions::{SAMPLE, SUBPIXELS};
use crate::frame::visibility_key;
use crate::frontend::transform::relative;
use crate::settings::Shading;
use crate::simd::{LANES, cross, dot, each3, part, row, splat};
use crate::stats::BackEndCounts;
use crate::view::ObjectView;

/// Shades every visible pixel of a tile that is not shaded yet.
#[inline(always)]
pub fn tile<S: Simd>(
    simd: S,
    context: &FrameContext,
    memory: &TileMemory,
    pixels: &mut TilePixels,
    planes: &Planes,
    counts: &mut BackEndCounts,
) {
    let mut fragments = Fragments::default();
    let mut instance = 0;
    let mut whole = WholeBlocks::new(simd);
    for places in memory.blocks(simd) {
        let corner = places[0];
        let slots = memory.slots_of_block(simd, corner);
        let empty = slots.simd_eq(u32x16::splat(simd, NO_SLOT)).to_bitmask() as u32;
        let mut left = !(empty | memory.shaded_of_block(corner)) & 0xffff;
        let slots = slots.to_array();
        if left == 0xffff && slots == [slots[0]; LANES] {
            whole.shade(simd, context, memory, places, slots[0], pixels, planes);
            counts.pixels_shaded += LANES as u64;
            continue;
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let (slot, place) = (slots[lane], places[lane]);
            counts.pixels_shaded += 1;
            let (own, _) = context.locate(slot / MAX_TRIANGLES as u32);
            if own != instance {
                flush(simd, context, instance, &mut fragments, memory, pixels, planes);
                instance = own;
            }
            if fragments.push(place, slot, memory.depth[place as usize]) {
                flush(simd, context, instance, &mut fragments, memory, pixels, planes);
            }
        }
    }
    flush(simd, context, instance, &mut fragments, memory, pixels, planes);
}

/// Blocks of 4x4 samples that show one triangle: of a large one there are many in a row, and its corners are fetched once.
struct WholeBlocks<S: Simd> {
    slot: Option<u32>,
    instance: usize,
    corners: Corners<S>,
}

impl<S: Simd> WholeBlocks<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        Self { slot: None, instance: 0, corners: Corners::new(simd) }
    }

    /// Shades a block, given by the places of its samples.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    fn shade(
        &mut self,
        simd: S,
        context: &FrameContext,
        memory: &TileMemory,
        places: [i32; LANES],
        slot: u32,
        pixels: &mut TilePixels,
        planes: &Planes,
    ) {
        let mut fragments =
            Fragments { count: LANES, place: places, slot: [slot; LANES], ..Fragments::default() };
        if self.slot != Some(slot) {
            self.slot = Some(slot);
            (self.instance, _) = context.locate(slot / MAX_TRIANGLES as u32);
            self.corners = fetch(simd, context, self.instance, &fragments);
        }
        let look = Look::of(context, self.instance, false, planes);
        if look.more {
            for lane in 0..LANES {
                fragments.depth[lane] = memory.depth[places[lane] as usize];
            }
        }
        let at = At::in_picture(context, memory);
        shade(simd, context, self.instance, look, &fragments, at, &self.corners, pixels, planes);
    }
}

/// Fetches the corners of 16 pixels of one instance. Not inlined, so that it is compiled once a level.
#[inline(never)]
fn fetch<S: Simd>(simd: S, context: &FrameContext, instance: usize, fragments: &Fragments) -> Corners<S> {
    let Instance { mesh, surface, .. } = &context.scene.instances[instance];
    let colors = ColorSource::of(mesh, surface);
    simd.vectorize(
        #[inline(always)]
        || Corners::fetch(simd, context, instance, &fragments.slot, colors),
    )
}

/// Shades the pixels gathered so far. Not inlined, so that the kernel is compiled once a level, not three
/// times.
#[inline(never)]
fn flush<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    fragments: &mut Fragments,
    memory: &TileMemory,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    if fragments.count == 0 {
        return;
    }
    fragments.fill_up();
    let look = Look::of(context, instance, false, planes);
    let corners = fetch(simd, context, instance, fragments);
    let at = At::in_picture(context, memory);
    shade(simd, context, instance, look, fragments, at, &corners, pixels, planes);
    fragments.count = 0;
}

/// What [`winners`] keeps from cluster to cluster.
#[derive(Debug, Default)]
pub struct WinnerScratch {
    table: ClusterTable,
    fragments: Fragments,
}

/// Shades the samples that cluster `number` of the frame won.
#[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
#[inline(never)]
pub fn winners<S: Simd>(
    simd: S,
    context: &FrameContext,
    number: u32,
    pass: &mut ClusterPass,
    memory: &TileMemory,
    scratch: &mut WinnerScratch,
    pixels: &mut TilePixels,
    planes: &Planes,
    counts: &mut BackEndCounts,
) {
    if pass.winners.is_empty() {
        return;
    }
    simd.vectorize(
        #[inline(always)]
        || {
            let (instance, cluster) = context.cluster(number);
            let Instance { mesh, surface, .. } = &context.scene.instances[instance];
            let look = Look::of(context, instance, cluster.head().normals_agree(), planes);
            let WinnerScratch { table, fragments } = scratch;
            table.load_normals(simd, context, &context.objects[instance], &cluster, &pass.vertices);
            if look.position {
                table.load_positions(simd, &cluster);
            }
            if look.colors == ColorSource::Vertex {
                table.load_colors(&cluster);
            }
            let count = pass.winners.len();
            counts.pixels_shaded += count as u64;
            if look == Look::PLAIN && !pass.vertices.is_wide {
                return plain::winners(simd, context, instance, pass, memory, table, pixels);
            }
            let at = At {
                memory,
                first_sample: pass.vertices.sample_of(memory.corner),
                from_middle: pass.vertices.from_middle(&context.lights.sight),
            };
            for first in (0..count).step_by(LANES) {
                let (places, triangles) = pass.winners.sixteen(first);
                fragments.count = (count - first).min(LANES);
                fragments.place = *places;
                let (numbers, mut corners) = table.look_up(simd, &pass.vertices, &pass.corners, triangles);
                if look.position {
                    table.look_up_positions(simd, &numbers, &mut corners);
                }
                let of = (&**mesh, &cluster, surface);
                table.look_up_colors(simd, of, triangles, &numbers, look.colors, &mut corners);
                for lane in 0..LANES {
                    fragments.slot[lane] = number * MAX_TRIANGLES as u32 + u32::from(triangles[lane]);
                    fragments.depth[lane] = memory.depth[places[lane] as usize];
                }
                shade(simd, context, instance, look, fragments, at, &corners, pixels, planes);
            }
        },
    );
}

/// Where 16 pixels are.
#[derive(Clone, Copy)]
struct At<'a> {
    memory: &'a TileMemory,
    /// The tile's first sample, in the coordinates of the corners.
    first_sample: [i32; 2],
    /// What is added to these coordinates to count them from the middle of the picture.
    from_middle: [i32; 2],
}

impl<'a> At<'a> {
    /// With coordinates that are counted from the picture's corner.
    fn in_picture(context: &FrameContext, memory: &'a TileMemory) -> Self {
        let first_sample = memory.corner.map(|c| c * SUBPIXELS + SAMPLE);
        Self { memory, first_sample, from_middle: context.lights.sight.middle.map(|c| -c) }
    }
}

/// Shades 16 pixels of any look. Not inlined, so that the kernel is compiled once a level.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(never)]
fn shade<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    look: Look,
    fragments: &Fragments,
    at: At,
    corners: &Corners<S>,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let surface = &context.scene.instances[instance].surface;
            let object = &context.objects[instance];
            let sample = at.memory.samples(simd, &fragments.place, at.first_sample);
            let to_viewer = towards_viewer(simd, &context.lights, sample, at.from_middle);
            let at = Interpolation::new(simd, object, sample, corners);
            let zero = [splat(simd, 0.0); 3];

            let side =
                Side { plane: look.plane.then(|| seen_plane(simd, object, corners.position, at.clockwise)) };
            let normal = match side.plane {
                Some(plane) if look.shading == Shading::Flat || !look.normals => plane,
                _ => at.normal(corners.normal),
            };
            let normal = side.unit_normal(simd, context, normal, to_viewer);

            let albedo: Vec3x16<S> = match look.colors {
                ColorSource::Base => each3!(C => splat(simd, surface.base_color[C])),
                _ => at.mix(corners.color),
            };
            let lit: Vec3x16<S> = match look.shading {
                Shading::Unlit => albedo,
                Shading::Flat | Shading::Phong if look.diffuse => {
                    let light = diffuse(simd, &context.lights, normal);
                    each3!(C => albedo[C] * light[C])
                }
                Shading::Flat | Shading::Phong => {
                    let mut position = zero;
                    if look.near_lights {
                        let relative = each3!(K => relative(simd, object, corners.position[K]));
                        position = to_eye(simd, object, at.mix(relative));
                    }
                    let to_viewer = normalize(simd, to_viewer, beside(simd, &context.lights));
                    let light = reflect(simd, &context.lights, surface, &normal, &to_viewer, &position);
                    each3!(C => albedo[C] * light.diffuse[C] + light.specular[C])
                }
                Shading::Gouraud => {
                    let at_corner = each3!(K => {
                        let position = to_eye(simd, object, relative(simd, object, corners.position[K]));
                        let mut to_viewer = beside(simd, &context.lights);
                        if object.perspective {
                            to_viewer = normalize(simd, each3!(A => -position[A]), to_viewer);
                        }
                        let normal = match side.plane {
                            Some(plane) if !look.normals => plane,
                            _ => as_seen(simd, corners.normal[K], at.clockwise),
                        };
                        let normal = side.unit_normal(simd, context, normal, to_viewer);
                        reflect(simd, &context.lights, surface, &normal, &to_viewer, &position)
                    });
                    let diffuse = at.mix(each3!(K => at_corner[K].diffuse));
                    let specular = at.mix(each3!(K => at_corner[K].specular));
                    each3!(C => albedo[C] * diffuse[C] + specular[C])
                }
            };
            if look.color {
                write_color(simd, fragments, lit, pixels);
            }
            if look.more {
                write_color16(fragments, lit, pixels, planes);
                write_geometry(context, fragments, normal, pixels, planes);
            }
        },
    );
}

/// What decides how pixels are shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Look {
    shading: Shading,
    /// Where the colour comes from.
    colors: ColorSource,
    /// The vertices have normals.
    normals: bool,
    /// Positions of corners are needed.
    position: bool,
    /// The triangles' planes are needed.
    plane: bool,
    /// Light depends on where a point is.
    near_lights: bool,
    /// Lights are distant and leave no highlights.
    diffuse: bool,
    /// 8-bit colours are asked for.
    color: bool,
    /// Something else is asked for.
    more: bool,
}

impl Look {
    /// The look of most pictures, which has a kernel of its own: [`plain`].
    const PLAIN: Self = Self {
        shading: Shading::Phong,
        colors: ColorSource::Base,
        normals: true,
        position: false,
        plane: false,
        near_lights: false,
        diffuse: true,
        color: true,
        more: false,
    };

    /// Of pixels of an instance; `normals_agree` as in [`Cluster::NORMALS_AGREE`](tercio_mesh::cluster::Cluster::NORMALS_AGREE).
    #[inline(always)]
    fn of(context: &FrameContext, instance: usize, normals_agree: bool, planes: &Planes) -> Self {
        let Instance { mesh, surface, .. } = &context.scene.instances[instance];
        let (shading, lights) = (context.settings.shading, &context.lights);
        let normals = mesh.layout().normals;
        // Where not all directions are scaled alike, normals may change sides on the way to world space.
        let agree = normals_agree && context.objects[instance].similarity.is_some();
        let plane = shading == Shading::Flat || !normals || !agree;
        let highlights = surface.specular > 0.0;
        let near_lights = !lights.near.is_empty();
        Self {
            shading,
            colors: ColorSource::of(mesh, surface),
            normals,
            position: plane || near_lights || shading == Shading::Gouraud,
            plane,
            near_lights,
            diffuse: !highlights && !near_lights,
            color: planes.color.is_wanted(),
            more: planes.color16.is_wanted()
                || planes.depth.is_wanted()
                || planes.ids.is_wanted()
                || planes.keys.is_wanted()
                || planes.normals.is_wanted(),
        }
    }
}

/// The normals of 16 triangles by their winding, in world space, of any length, on the side that is seen.
#[inline(always)]
fn seen_plane<S: Simd>(simd: S, object: &ObjectView, p: Corners16<S>, clockwise: mask32x16<S>) -> Vec3x16<S> {
    let edge_1 = each3!(A => (p[1][A] - p[0][A]) * object.edge_scale);
    let edge_2 = each3!(A => (p[2][A] - p[0][A]) * object.edge_scale);
    as_seen(simd, to_world(simd, object, cross(edge_1, edge_2)), clockwise)
}

/// Negates what belongs to triangles that appear clockwise.
#[inline(always)]
fn as_seen<S: Simd>(simd: S, n: Vec3x16<S>, clockwise: mask32x16<S>) -> Vec3x16<S> {
    part(
        simd,
        #[inline(always)]
        || each3!(A => clockwise.select(-n[A], n[A])),
    )
}

/// A vector at each of the three corners.
type Corners16<S> = [Vec3x16<S>; 3];

/// From positions relative to the pivot to world axes relative to the eye.
#[inline(always)]
fn to_eye<S: Simd>(simd: S, object: &ObjectView, q: Vec3x16<S>) -> Vec3x16<S> {
    let r = &object.eye_from_local;
    each3!(K => row(simd, &[r[K][0], r[K][1], r[K][2], object.eye_from_pivot[K]], q))
}

/// Which side of its triangle a pixel shows.
#[derive(Clone, Copy)]
struct Side<S: Simd> {
    /// [`seen_plane`]; `None` if the corners' normals are known to point to the same side as the triangle's winding.
    plane: Option<Vec3x16<S>>,
}

impl<S: Simd> Side<S> {
    /// A unit normal, turned to the side of the triangle that is seen, whatever its winding, and bent where it still
    /// points away from the viewer.
    #[inline(always)]
    fn unit_normal(
        &self,
        simd: S,
        context: &FrameContext,
        mut n: Vec3x16<S>,
        to_viewer: Vec3x16<S>,
    ) -> Vec3x16<S> {
        if let Some(plane) = self.plane {
            n = as_seen(simd, n, dot(n, plane).simd_lt(splat(simd, 0.0)));
        }
        bend(simd, normalize(simd, n, beside(simd, &context.lights)), to_viewer)
    }
}

#[inline(always)]
fn write_color<S: Simd>(simd: S, fragments: &Fragments, linear: Vec3x16<S>, pixels: &mut TilePixels) {
    let levels = opaque(simd, linear).to_array();
    // Lanes without a pixel repeat another.
    for lane in 0..LANES {
        pixels.color[fragments.place[lane] as usize] = (levels[lane] as u32).to_le_bytes();
    }
}

fn write_color16<S: Simd>(
    fragments: &Fragments,
    linear: Vec3x16<S>,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    if planes.color16.is_wanted() {
        for lane in 0..fragments.count {
            let [r, g, b] = each3!(C => encode16(linear[C][lane]));
            pixels.color16[fragments.place[lane] as usize] = [r, g, b, 65535];
        }
    }
}

#[inline(always)]
fn write_geometry<S: Simd>(
    context: &FrameContext,
    fragments: &Fragments,
    normal: Vec3x16<S>,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    let lanes = 0..fragments.count;
    if planes.depth.is_wanted() {
        for lane in lanes.clone() {
            pixels.depth[fragments.place[lane] as usize] = context.view.distance(fragments.depth[lane]);
        }
    }
    if planes.ids.is_wanted() {
        for lane in lanes.clone() {
            pixels.ids[fragments.place[lane] as usize] = context.face(fragments.slot[lane]);
        }
    }
    if planes.keys.is_wanted() {
        for lane in lanes.clone() {
            let primitive = context.primitive(fragments.slot[lane]) as u32;
            pixels.keys[fragments.place[lane] as usize] = visibility_key(fragments.depth[lane], primitive);
        }
    }
    if planes.normals.is_wanted() {
        let normal = each3!(A => normal[A].to_array());
        for lane in lanes {
            pixels.normals[fragments.place[lane] as usize] = [0, 1, 2].map(|k| normal[k][lane]);
        }
    }
}
