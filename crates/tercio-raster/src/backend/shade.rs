//! Colours of the visible pixels, 16 at a time, each pixel once.
//!
//! The visible pixels of a tile are packed without gaps; each lane fetches the corners of its triangle,
//! projects them again as the front end did, and interpolates between them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, i32x16, mask32x16, u32x16};
use tercio_mesh::cluster::MAX_TRIANGLES;
use tercio_scene::Instance;

use super::cluster::ClusterPass;
use super::corners::{ColorSource, CornerLanes, Fragments};
use super::interpolate::Barycentric;
use super::light::{Vec3x16, beside, normalize, reflect};
use super::output::{Planes, TilePixels};
use super::table::ClusterTable;
use super::visibility::{BLOCK_BITS, LANE_X, LANE_Y, TileMemory};
use crate::color::{ENCODE, ENCODE_STEPS, encode16};
use crate::context::{FrameContext, NO_SLOT};
use crate::frame::visibility_key;
use crate::settings::Shading;
use crate::simd::{LANE_NUMBERS, LANES, cross, dot, each3, load, part, row, splat};
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
    let mut corners = CornerLanes::default();
    let mut instance = 0;
    let mut whole = WholeBlocks::default();
    for (block, slots) in memory.slot.chunks_exact(LANES).enumerate() {
        let slots = u32x16::from_slice(simd, slots);
        let empty = slots.simd_eq(u32x16::splat(simd, NO_SLOT)).to_bitmask() as u32;
        let mut left = !(empty | u32::from(memory.shaded[block])) & 0xffff;
        let (bx, by) = (block % memory.blocks, block / memory.blocks);
        if left == 0xffff && !memory.is_cut {
            let slot = slots[0];
            if slots.simd_eq(u32x16::splat(simd, slot)).all_true() {
                whole.shade(simd, context, memory, block, slot, pixels, planes);
                counts.pixels_shaded += LANES as u64;
                continue;
            }
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let slot = slots[lane];
            let x = ((bx << BLOCK_BITS) as i32) + LANE_X[lane];
            let y = ((by << BLOCK_BITS) as i32) + LANE_Y[lane];
            // Blocks at the border of the picture hold samples beyond it.
            if memory.corner[0] + x > memory.last[0] || memory.corner[1] + y > memory.last[1] {
                continue;
            }
            counts.pixels_shaded += 1;
            let (own, _) = context.locate(slot / MAX_TRIANGLES as u32);
            if own != instance {
                flush(simd, context, instance, &mut fragments, &mut corners, pixels, planes);
                instance = own;
            }
            let place = (y as usize * pixels.width + x as usize) as u32;
            let depth = memory.depth[block * LANES + lane];
            if fragments.push(memory.corner[0] + x, memory.corner[1] + y, place, slot, depth) {
                flush(simd, context, instance, &mut fragments, &mut corners, pixels, planes);
            }
        }
    }
    flush(simd, context, instance, &mut fragments, &mut corners, pixels, planes);
}

/// Blocks that show one triangle: of a large one there are many in a row, and its corners are fetched once.
#[derive(Default)]
struct WholeBlocks {
    slot: Option<u32>,
    instance: usize,
    corners: CornerLanes,
}

impl WholeBlocks {
    /// Shades a block of the tile.
    #[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
    #[inline(always)]
    fn shade<S: Simd>(
        &mut self,
        simd: S,
        context: &FrameContext,
        memory: &TileMemory,
        block: usize,
        slot: u32,
        pixels: &mut TilePixels,
        planes: &Planes,
    ) {
        let first = block * LANES;
        let mut fragments = Fragments { count: LANES, slot: [slot; LANES], ..Fragments::default() };
        fragments.depth.copy_from_slice(&memory.depth[first..first + LANES]);
        let places = i32x16::load_array(simd, LANE_NUMBERS) + first as i32;
        fragments.at_places(simd, memory, places.to_array(), pixels.width);
        if self.slot != Some(slot) {
            self.slot = Some(slot);
            (self.instance, _) = context.locate(slot / MAX_TRIANGLES as u32);
            fetch(simd, context, self.instance, &fragments, &mut self.corners);
        }
        let look = Look::of(context, self.instance);
        shade(simd, context, self.instance, look, &fragments, &self.corners, pixels, planes);
    }
}

/// Fetches the corners of 16 pixels of one instance. Not inlined, so that it is compiled once a level.
#[inline(never)]
fn fetch<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    fragments: &Fragments,
    corners: &mut CornerLanes,
) {
    let colors = Look::of(context, instance).colors;
    simd.vectorize(
        #[inline(always)]
        || corners.fetch(simd, context, instance, &fragments.slot, colors),
    );
}

/// Shades the pixels gathered so far. Not inlined, so that the kernel is compiled once a level, not three
/// times.
#[inline(never)]
fn flush<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    fragments: &mut Fragments,
    corners: &mut CornerLanes,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    if fragments.count == 0 {
        return;
    }
    fragments.fill_up();
    let look = Look::of(context, instance);
    fetch(simd, context, instance, fragments, corners);
    shade(simd, context, instance, look, fragments, corners, pixels, planes);
    fragments.count = 0;
}

/// What [`winners`] keeps from cluster to cluster.
#[derive(Debug, Default)]
pub struct WinnerScratch {
    table: ClusterTable,
    fragments: Fragments,
    corners: CornerLanes,
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
            let (instance, index) = context.locate(number);
            let Instance { mesh, surface, .. } = &context.scene.instances[instance];
            let cluster = &mesh.clusters[index];
            let look = Look::of(context, instance);
            let WinnerScratch { table, fragments, corners } = scratch;
            table.load_normals(simd, mesh, cluster);
            let positions = !table.normals_agree || look.position;
            if positions {
                table.load_positions(simd, mesh, cluster);
            }
            let count = pass.winners.len();
            counts.pixels_shaded += count as u64;
            for first in (0..count).step_by(LANES) {
                let (places, triangles) = pass.winners.sixteen(first);
                fragments.count = (count - first).min(LANES);
                fragments.at_places(simd, memory, places, pixels.width);
                if planes.depth.is_wanted() || planes.ids.is_wanted() || planes.keys.is_wanted() {
                    for lane in 0..LANES {
                        fragments.slot[lane] = number * MAX_TRIANGLES as u32 + u32::from(triangles[lane]);
                        fragments.depth[lane] = memory.depth[places[lane] as usize];
                    }
                }
                table.look_up(
                    simd,
                    (mesh, surface),
                    &pass.vertices,
                    &pass.corners,
                    &triangles,
                    look.colors,
                    positions,
                    corners,
                );
                shade(simd, context, instance, look, fragments, corners, pixels, planes);
            }
        },
    );
}

/// Shades 16 pixels. Not inlined, so that the kernel is compiled once a level.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(never)]
fn shade<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    look: Look,
    fragments: &Fragments,
    corners: &CornerLanes,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    simd.vectorize(
        #[inline(always)]
        || shade_16(simd, context, instance, look, fragments, corners, pixels, planes),
    );
}

#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(always)]
fn shade_16<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    look: Look,
    fragments: &Fragments,
    corners: &CornerLanes,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    let Instance { mesh, surface, .. } = &context.scene.instances[instance];
    let object = &context.objects[instance];
    let at = Barycentric::new(simd, object, fragments, corners);
    let zero = [splat(simd, 0.0); 3];

    let mut p: Corners16<S> = [zero; 3];
    if look.position || !corners.normals_agree {
        p = each3!(K => load3(simd, &corners.position[K]));
    }
    let mut side = Side { plane: None, from_back: at.clockwise };
    if object.mirrored {
        side.from_back = !side.from_back;
    }
    if look.plane || !corners.normals_agree {
        side.plane = Some(plane_of(object, p));
    }
    let plane = side.plane.unwrap_or(zero);
    let normals: Corners16<S> =
        if mesh.normals.is_some() { each3!(K => load3(simd, &corners.normal[K])) } else { [plane; 3] };

    let (mut position, mut to_viewer) = (zero, beside(simd, &context.lights));
    if look.lit_from_position {
        position = to_eye(simd, object, at.mix(p));
        to_viewer = towards_viewer(simd, context, object, position);
    }
    let flat = context.settings.shading == Shading::Flat;
    let normal = side.turn(simd, context, object, if flat { plane } else { at.mix(normals) });

    let albedo: Vec3x16<S> = match look.colors {
        ColorSource::Base => each3!(C => splat(simd, surface.base_color[C])),
        _ => at.mix(each3!(K => load3(simd, &corners.color[K]))),
    };
    let lit: Vec3x16<S> = match context.settings.shading {
        Shading::Unlit => albedo,
        Shading::Flat | Shading::Phong => {
            let light = reflect(simd, &context.lights, surface, &normal, &to_viewer, &position);
            each3!(C => albedo[C] * light.diffuse[C] + light.specular[C])
        }
        Shading::Gouraud => {
            let at_corner = each3!(K => {
                let (mut position, mut to_viewer) = (zero, to_viewer);
                if look.lit_from_position {
                    position = to_eye(simd, object, p[K]);
                    to_viewer = towards_viewer(simd, context, object, position);
                }
                let normal = side.turn(simd, context, object, normals[K]);
                reflect(simd, &context.lights, surface, &normal, &to_viewer, &position)
            });
            let diffuse = at.mix(each3!(K => at_corner[K].diffuse));
            let specular = at.mix(each3!(K => at_corner[K].specular));
            each3!(C => albedo[C] * diffuse[C] + specular[C])
        }
    };
    write_color(simd, fragments, lit, pixels, planes);
    write_geometry(context, fragments, normal, pixels, planes);
}

/// What decides how the pixels of an instance are shaded.
#[derive(Clone, Copy, Debug)]
struct Look {
    /// Where its colour comes from.
    colors: ColorSource,
    /// Positions of corners are needed.
    position: bool,
    /// The triangles' planes are needed.
    plane: bool,
    /// Light depends on where a point is.
    lit_from_position: bool,
}

impl Look {
    #[inline(always)]
    fn of(context: &FrameContext, instance: usize) -> Self {
        let Instance { mesh, surface, .. } = &context.scene.instances[instance];
        let plane = context.settings.shading == Shading::Flat || mesh.normals.is_none();
        let highlights = surface.specular > 0.0 && context.view.perspective;
        let lit_from_position = highlights || !context.lights.near.is_empty();
        let colors = ColorSource::of(mesh, surface);
        Self { colors, position: plane || lit_from_position, plane, lit_from_position }
    }
}

/// The normals of 16 triangles by their winding, in object space, of any length.
#[inline(always)]
fn plane_of<S: Simd>(object: &ObjectView, p: Corners16<S>) -> Vec3x16<S> {
    let edge_1 = each3!(A => (p[1][A] - p[0][A]) * object.inverse_size);
    let edge_2 = each3!(A => (p[2][A] - p[0][A]) * object.inverse_size);
    cross(edge_1, edge_2)
}

/// A vector at each of the three corners.
type Corners16<S> = [Vec3x16<S>; 3];

/// Loads three components.
#[inline(always)]
fn load3<S: Simd>(simd: S, from: &[[f32; LANES]; 3]) -> Vec3x16<S> {
    each3!(A => load(simd, &from[A]))
}

/// From local coordinates to world axes relative to the eye.
#[inline(always)]
fn to_eye<S: Simd>(simd: S, object: &ObjectView, q: Vec3x16<S>) -> Vec3x16<S> {
    let r = &object.world_from_local;
    each3!(K => row(simd, &[r[K][0], r[K][1], r[K][2], object.eye_from_local[K]], q))
}

/// Unit vectors towards the viewer from positions relative to the eye.
#[inline(always)]
fn towards_viewer<S: Simd>(
    simd: S,
    context: &FrameContext,
    object: &ObjectView,
    position: Vec3x16<S>,
) -> Vec3x16<S> {
    let distant = each3!(A => splat(simd, context.lights.to_viewer[A]));
    if object.perspective { normalize(simd, each3!(A => -position[A]), distant) } else { distant }
}

/// Which side of its triangle a pixel shows.
#[derive(Clone, Copy)]
struct Side<S: Simd> {
    /// The triangle's normal by its winding, in object space, any length; `None` if the corners' normals are
    /// known to point to the same side.
    plane: Option<Vec3x16<S>>,
    /// It is seen from behind.
    from_back: mask32x16<S>,
}

impl<S: Simd> Side<S> {
    /// A unit normal in world space, turned to the side of the triangle that is seen, whatever its winding.
    #[inline(always)]
    fn turn(&self, simd: S, context: &FrameContext, object: &ObjectView, n: Vec3x16<S>) -> Vec3x16<S> {
        part(
            simd,
            #[inline(always)]
            || {
                let mut turn = self.from_back;
                if let Some(plane) = self.plane {
                    let against = dot(n, plane).simd_lt(splat(simd, 0.0));
                    turn = (against & !self.from_back) | (self.from_back & !against);
                }
                let n = each3!(A => turn.select(-n[A], n[A]));
                let m = &object.normal_matrix;
                let world = each3!(K => (n[0] * m[K][0] + n[1] * m[K][1]) + n[2] * m[K][2]);
                normalize(simd, world, beside(simd, &context.lights))
            },
        )
    }
}

#[inline(always)]
fn write_color<S: Simd>(
    simd: S,
    fragments: &Fragments,
    linear: Vec3x16<S>,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    part(
        simd,
        #[inline(always)]
        || {
            let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
            let linear = each3!(C => linear[C].simd_gt(zero).select(linear[C], zero));
            let linear = each3!(C => linear[C].simd_lt(one).select(linear[C], one));
            if planes.color.is_wanted() {
                let table = &**ENCODE;
                let index = each3!(C => (linear[C] * (ENCODE_STEPS - 1) as f32 + 0.5).to_int::<i32x16<S>>().to_array());
                for lane in 0..fragments.count {
                    let [r, g, b] = each3!(C => table[index[C][lane] as usize % ENCODE_STEPS]);
                    pixels.color[fragments.place[lane] as usize] = [r, g, b, 255];
                }
            }
            if planes.color16.is_wanted() {
                let linear = each3!(C => linear[C].to_array());
                for lane in 0..fragments.count {
                    let [r, g, b] = [0, 1, 2].map(|k| encode16(linear[k][lane]));
                    pixels.color16[fragments.place[lane] as usize] = [r, g, b, 65535];
                }
            }
        },
    )
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
