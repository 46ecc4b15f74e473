//! Colours of the visible pixels, 16 at a time, each pixel once.
//!
//! The visible pixels of a tile are packed without gaps; each lane fetches the corners of its triangle,
//! projects them again as the front end did, and interpolates between them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, u32x16};
use tercio_mesh::cluster::MAX_TRIANGLES;
use tercio_scene::Instance;

use super::cluster::Winners;
use super::fetch::{ClusterTable, ColorSource, CornerLanes, Fragments};
use super::light::{Vec3x16, normalize, reflect};
use super::output::{Planes, TilePixels};
use super::visibility::{BLOCK_BITS, LANE_X, LANE_Y, TileMemory};
use crate::color::{ENCODE, ENCODE_STEPS, encode16};
use crate::context::{FrameContext, NO_SLOT};
use crate::conventions::{SAMPLE, SUBPIXELS};
use crate::frontend::clip::barycentrics_unclipped;
use crate::frontend::transform::{CornerTable, Projected, project};
use crate::settings::Shading;
use crate::simd::{LANES, cross, dot, each3, load, part, row, splat};
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
    for (block, slots) in memory.slot.chunks_exact(LANES).enumerate() {
        let (bx, by) = (block % memory.blocks, block / memory.blocks);
        for (lane, &slot) in slots.iter().enumerate() {
            let x = ((bx << BLOCK_BITS) as i32) + LANE_X[lane];
            let y = ((by << BLOCK_BITS) as i32) + LANE_Y[lane];
            // Blocks at the border of the picture hold samples beyond it.
            let beyond = memory.corner[0] + x > memory.last[0] || memory.corner[1] + y > memory.last[1];
            if slot == NO_SLOT || beyond || memory.shaded[block] >> lane & 1 == 1 {
                continue;
            }
            counts.pixels_shaded += 1;
            let (own, _, _) = context.locate_slot(slot);
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
    let scene_instance = &context.scene.instances[instance];
    let source = ColorSource::of(&scene_instance.mesh, &scene_instance.surface);
    corners.fetch(context, instance, &fragments.slot, source);
    shade(simd, context, instance, fragments, corners, pixels, planes);
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
    corner_table: &CornerTable,
    winners: &mut Winners,
    memory: &TileMemory,
    scratch: &mut WinnerScratch,
    pixels: &mut TilePixels,
    planes: &Planes,
    counts: &mut BackEndCounts,
) {
    if winners.place.is_empty() {
        return;
    }
    simd.vectorize(
        #[inline(always)]
        || {
            let (instance, index) = context.locate(number);
            let Instance { mesh, surface, .. } = &context.scene.instances[instance];
            let source = ColorSource::of(mesh, surface);
            let WinnerScratch { table, fragments, corners } = scratch;
            table.load(simd, mesh, &mesh.clusters[index]);
            let count = winners.fill_up();
            counts.pixels_shaded += count as u64;
            for first in (0..count).step_by(LANES) {
                let triangles: &[u8; LANES] =
                    (&winners.triangle[first..]).first_chunk().unwrap_or(&[0; LANES]);
                fragments.count = (count - first).min(LANES);
                fragments.of_winners(simd, memory, &winners.place[first..], pixels.width);
                if planes.depth.is_wanted() || planes.ids.is_wanted() {
                    for lane in 0..LANES {
                        fragments.slot[lane] = number * MAX_TRIANGLES as u32 + u32::from(triangles[lane]);
                        fragments.depth[lane] = memory.depth[winners.place[first + lane] as usize];
                    }
                }
                corners.look_up(simd, mesh, surface, table, corner_table, triangles, source);
                shade(simd, context, instance, fragments, corners, pixels, planes);
            }
        },
    );
}

/// Shades 16 pixels. Not inlined, so that the kernel is compiled once a level.
#[inline(never)]
fn shade<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    fragments: &Fragments,
    corners: &CornerLanes,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    simd.vectorize(
        #[inline(always)]
        || shade_16(simd, context, instance, fragments, corners, pixels, planes),
    );
}

#[inline(always)]
fn shade_16<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    fragments: &Fragments,
    corners: &CornerLanes,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    let scene_instance = &context.scene.instances[instance];
    let (object, surface) = (&context.objects[instance], &scene_instance.surface);
    let mesh = &*scene_instance.mesh;
    let source = ColorSource::of(mesh, surface);

    let p: Corners16<S> = each3!(K => load3(simd, &corners.position[K]));
    let weight = barycentrics(simd, object, fragments, corners, p);

    // The plane of the triangle, and the side from which it is seen.
    let edge_1 = each3!(A => (p[1][A] - p[0][A]) * object.inverse_size);
    let edge_2 = each3!(A => (p[2][A] - p[0][A]) * object.inverse_size);
    let plane = cross(edge_1, edge_2);
    let viewer = each3!(A => splat(simd, object.viewer[A]));
    let sight = if object.perspective { each3!(A => viewer[A] - p[0][A]) } else { viewer };
    let side = Side { plane, from_back: dot(plane, sight).simd_lt(splat(simd, 0.0)) };

    let normals: Corners16<S> = if mesh.normals.is_some() {
        each3!(K => decode_normal(simd, &corners.normal[K]))
    } else {
        [plane; 3]
    };
    let position = to_eye(simd, object, mix3(weight, p));
    let to_viewer = towards_viewer(simd, context, object, position);
    let flat = context.settings.shading == Shading::Flat;
    let normal = side.turn(simd, object, if flat { plane } else { mix3(weight, normals) }, to_viewer);

    let albedo: Vec3x16<S> = match source {
        ColorSource::Base => each3!(C => splat(simd, surface.base_color[C])),
        _ => mix3(weight, each3!(K => load3(simd, &corners.color[K]))),
    };
    let lit: Vec3x16<S> = match context.settings.shading {
        Shading::Unlit => albedo,
        Shading::Flat | Shading::Phong => {
            let light = reflect(simd, &context.lights, surface, &normal, &to_viewer, &position);
            each3!(C => albedo[C] * light.diffuse[C] + light.specular[C])
        }
        Shading::Gouraud => {
            let at_corner = each3!(K => {
                let position = to_eye(simd, object, p[K]);
                let to_viewer = towards_viewer(simd, context, object, position);
                let normal = side.turn(simd, object, normals[K], to_viewer);
                reflect(simd, &context.lights, surface, &normal, &to_viewer, &position)
            });
            let diffuse = mix3(weight, each3!(K => at_corner[K].diffuse));
            let specular = mix3(weight, each3!(K => at_corner[K].specular));
            each3!(C => albedo[C] * diffuse[C] + specular[C])
        }
    };
    write_color(simd, fragments, lit, pixels, planes);
    write_geometry(context, fragments, normal, pixels, planes);
}

/// A vector at each of the three corners.
type Corners16<S> = [Vec3x16<S>; 3];

/// Loads three components.
#[inline(always)]
fn load3<S: Simd>(simd: S, from: &[[f32; LANES]; 3]) -> Vec3x16<S> {
    each3!(A => load(simd, &from[A]))
}

/// Interpolates a vector between the corners.
#[inline(always)]
fn mix3<S: Simd>(weight: [f32x16<S>; 3], v: Corners16<S>) -> Vec3x16<S> {
    part(
        weight[0].simd,
        #[inline(always)]
        || each3!(A => (weight[0] * v[0][A] + weight[1] * v[1][A]) + weight[2] * v[2][A]),
    )
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
    /// The triangle's normal by its winding, in object space, any length.
    plane: Vec3x16<S>,
    /// It is seen from behind.
    from_back: mask32x16<S>,
}

impl<S: Simd> Side<S> {
    /// A unit normal in world space, turned to the side of the triangle that is seen, whatever its winding.
    #[inline(always)]
    fn turn(&self, simd: S, object: &ObjectView, n: Vec3x16<S>, to_viewer: Vec3x16<S>) -> Vec3x16<S> {
        part(
            simd,
            #[inline(always)]
            || {
                let against = dot(n, self.plane).simd_lt(splat(simd, 0.0));
                let turn = (against & !self.from_back) | (self.from_back & !against);
                let n = each3!(A => turn.select(-n[A], n[A]));
                let m = &object.normal_matrix;
                let world = each3!(K => (n[0] * m[K][0] + n[1] * m[K][1]) + n[2] * m[K][2]);
                normalize(simd, world, to_viewer)
            },
        )
    }
}

/// Perspective barycentric coordinates of each pixel's sample in its triangle: not negative, adding up to 1.
#[inline(always)]
fn barycentrics<S: Simd>(
    simd: S,
    object: &ObjectView,
    fragments: &Fragments,
    corners: &CornerLanes,
    p: Corners16<S>,
) -> [f32x16<S>; 3] {
    part(
        simd,
        #[inline(always)]
        || {
            let zero = splat(simd, 0.0);
            let v: [Projected<S>; 3] = each3!(K => project(simd, object, p[K]));
            let sample_x = i32x16::load_array_ref(simd, &fragments.x) * SUBPIXELS + SAMPLE;
            let sample_y = i32x16::load_array_ref(simd, &fragments.y) * SUBPIXELS + SAMPLE;
            // Corners as seen from the sample: whole numbers of at most 2^24, exact in `f32`.
            let x: [f32x16<S>; 3] = each3!(K => (v[K].x - sample_x).to_float());
            let y: [f32x16<S>; 3] = each3!(K => (v[K].y - sample_y).to_float());
            let mut b = each3!(K => {
                let (i, j) = ((K + 1) % 3, (K + 2) % 3);
                x[i] * y[j] - y[i] * x[j]
            });
            if object.perspective {
                b = each3!(K => b[K] * v[K].d);
            }
            let negative = ((b[0] + b[1]) + b[2]).simd_lt(zero);
            let b = each3!(K => negative.select(-b[K], b[K]));
            let b = each3!(K => b[K].simd_gt(zero).select(b[K], zero));
            let sum = (b[0] + b[1]) + b[2];
            let good = sum.simd_gt(zero);
            let inverse = splat(simd, 1.0) / sum;
            let one_corner = [splat(simd, 1.0), zero, zero];
            let mut weight = each3!(K => good.select(b[K] * inverse, one_corner[K]));

            let inside = (v[0].inside & v[1].inside & v[2].inside).to_bitmask() as u32;
            if inside & 0xffff != 0xffff {
                for lane in 0..LANES {
                    if inside >> lane & 1 == 0 {
                        let exact = unclipped(object, fragments, corners, lane);
                        (weight[0][lane], weight[1][lane], weight[2][lane]) = (exact[0], exact[1], exact[2]);
                    }
                }
            }
            weight
        },
    )
}

/// [`barycentrics_unclipped`] of one lane.
#[cold]
#[inline(never)]
fn unclipped(object: &ObjectView, fragments: &Fragments, corners: &CornerLanes, lane: usize) -> [f32; 3] {
    let positions = corners.position.map(|corner| corner.map(|axis| axis[lane]));
    let pixel = [fragments.x[lane], fragments.y[lane]];
    let at = |k: usize| f64::from(pixel[k] * SUBPIXELS + SAMPLE) - f64::from(object.offset[k]);
    barycentrics_unclipped(object, positions, [at(0), at(1)])
}

/// [`tercio_mesh::OctNormal::decode`], lane by lane.
#[inline(always)]
fn decode_normal<S: Simd>(simd: S, packed: &[u32; LANES]) -> Vec3x16<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let bits: i32x16<S> = u32x16::load_array_ref(simd, packed).bitcast();
            let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
            let unit = splat(simd, 1.0 / 32767.0);
            let u = ((bits << 16) >> 16).to_float::<f32x16<S>>() * unit;
            let v = (bits >> 16).to_float::<f32x16<S>>() * unit;
            let z = (one - u.abs()) - v.abs();
            let fold = z.simd_lt(zero).select(-z, zero);
            let x = u.simd_ge(zero).select(u - fold, u + fold);
            let y = v.simd_ge(zero).select(v - fold, v + fold);
            [x, y, z]
        },
    )
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
    if planes.normals.is_wanted() {
        let normal = each3!(A => normal[A].to_array());
        for lane in lanes {
            pixels.normals[fragments.place[lane] as usize] = [0, 1, 2].map(|k| normal[k][lane]);
        }
    }
}
