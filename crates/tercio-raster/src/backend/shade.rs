//! Colours of the visible pixels, 16 at a time, each pixel once.
//!
//! The visible pixels of a tile are packed without gaps; each lane fetches the corners of its triangle,
//! projects them again as the front end did, and interpolates between them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::fetch::{ColorSource, CornerLanes, Fragments};
use super::light::{Vec3x16, normalize, reflect};
use super::output::{Planes, TilePixels};
use super::visibility::{BLOCK_BITS, LANE_X, LANE_Y, TileMemory};
use crate::color::{ENCODE, ENCODE_STEPS, encode16};
use crate::context::{FrameContext, NO_SLOT};
use crate::conventions::{SAMPLE, SUBPIXELS};
use crate::frontend::clip::barycentrics_unclipped;
use crate::frontend::transform::{Projected, project};
use crate::settings::Shading;
use crate::simd::{LANES, cross, dot, load, row, splat, splat_i};
use crate::stats::BackEndCounts;
use crate::view::ObjectView;

/// Shades every visible pixel of a tile.
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
            if slot == NO_SLOT || beyond {
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

/// Shades the pixels gathered so far.
#[inline(always)]
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
    simd.vectorize(
        #[inline(always)]
        || shade_16(simd, context, instance, fragments, corners, pixels, planes),
    );
    fragments.count = 0;
}

#[inline(always)]
fn shade_16<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    fragments: &Fragments,
    corners: &mut CornerLanes,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    let scene_instance = &context.scene.instances[instance];
    let (object, surface) = (&context.objects[instance], &scene_instance.surface);
    let mesh = &*scene_instance.mesh;
    let source = ColorSource::of(mesh, surface);
    corners.fetch(context, instance, &fragments.slot, source);

    let p: [Vec3x16<S>; 3] = [0, 1, 2].map(|k| [0, 1, 2].map(|a| load(simd, &corners.position[k][a])));
    let weight = barycentrics(simd, object, fragments, corners, p);
    let mix = |v: [f32x16<S>; 3]| (weight[0] * v[0] + weight[1] * v[1]) + weight[2] * v[2];

    // The plane of the triangle, on the side from which it is seen.
    let edge = |k: usize| -> Vec3x16<S> { [0, 1, 2].map(|a| (p[k][a] - p[0][a]) * object.inverse_size) };
    let plane = cross(edge(1), edge(2));
    let viewer = object.viewer.map(|v| splat(simd, v));
    let sight = if object.perspective { [0, 1, 2].map(|a| viewer[a] - p[0][a]) } else { viewer };
    let seen_from_back = dot(plane, sight).simd_lt(splat(simd, 0.0));

    // A normal is turned to the side of the triangle that is seen, whatever its winding is.
    let world = |n: Vec3x16<S>| object.normal_matrix.map(|r| dot(n, r.map(|c| splat(simd, c))));
    let to_world = object.world_from_local;
    let position_of = |q: Vec3x16<S>| -> Vec3x16<S> {
        [0, 1, 2].map(|k| {
            let r = to_world[k];
            row(simd, &[r[0], r[1], r[2], object.eye_from_local[k]], q)
        })
    };
    let to_viewer_from = |q: Vec3x16<S>| -> Vec3x16<S> {
        let distant = context.lights.to_viewer.map(|c| splat(simd, c));
        if object.perspective { normalize(simd, q.map(|c| -c), distant) } else { distant }
    };
    let facing = |n: Vec3x16<S>, to_viewer: Vec3x16<S>| -> Vec3x16<S> {
        let against = dot(n, plane).simd_lt(splat(simd, 0.0));
        let turn = (against & !seen_from_back) | (seen_from_back & !against);
        let n = world(n.map(|c| turn.select(-c, c)));
        normalize(simd, n, to_viewer)
    };
    let corner_normal = |k: usize| -> Vec3x16<S> {
        if mesh.normals.is_some() { decode_normal(simd, &corners.normal[k]) } else { plane }
    };

    let position = position_of([0, 1, 2].map(|a| mix([p[0][a], p[1][a], p[2][a]])));
    let to_viewer = to_viewer_from(position);
    let smooth = || -> Vec3x16<S> {
        let n = [0, 1, 2].map(corner_normal);
        [0, 1, 2].map(|a| mix([n[0][a], n[1][a], n[2][a]]))
    };
    let flat = context.settings.shading == Shading::Flat;
    let normal = facing(if flat { plane } else { smooth() }, to_viewer);

    let albedo: Vec3x16<S> = match source {
        ColorSource::Base => surface.base_color.map(|c| splat(simd, c)),
        _ => [0, 1, 2].map(|c| mix([0, 1, 2].map(|k| load(simd, &corners.color[k][c])))),
    };
    let lit: Vec3x16<S> = match context.settings.shading {
        Shading::Unlit => albedo,
        Shading::Flat | Shading::Phong => {
            let light = reflect(simd, &context.lights, surface, normal, to_viewer, position);
            [0, 1, 2].map(|k| albedo[k] * light.diffuse[k] + light.specular[k])
        }
        Shading::Gouraud => {
            let at_corner = [0, 1, 2].map(|k| {
                let position = position_of(p[k]);
                let to_viewer = to_viewer_from(position);
                let normal = facing(corner_normal(k), to_viewer);
                reflect(simd, &context.lights, surface, normal, to_viewer, position)
            });
            let [a, b, c] = &at_corner;
            [0, 1, 2].map(|k| {
                let diffuse = mix([a.diffuse[k], b.diffuse[k], c.diffuse[k]]);
                let specular = mix([a.specular[k], b.specular[k], c.specular[k]]);
                albedo[k] * diffuse + specular
            })
        }
    };
    write_color(simd, fragments, lit, pixels, planes);
    write_geometry(context, fragments, normal, pixels, planes);
}

/// Perspective barycentric coordinates of each pixel's sample in its triangle: not negative, adding up to 1.
#[inline(always)]
fn barycentrics<S: Simd>(
    simd: S,
    object: &ObjectView,
    fragments: &Fragments,
    corners: &CornerLanes,
    p: [Vec3x16<S>; 3],
) -> [f32x16<S>; 3] {
    let zero = splat(simd, 0.0);
    let v: [Projected<S>; 3] = p.map(|p| project(simd, object, p));
    let sample = |pixel: &[i32; LANES]| i32x16::load_array_ref(simd, pixel) * SUBPIXELS + SAMPLE;
    let (sx, sy) = (sample(&fragments.x), sample(&fragments.y));
    // Corners as seen from the sample: whole numbers below 2^24, exact in `f32`.
    let x = [0, 1, 2].map(|k: usize| (v[k].x - sx).to_float::<f32x16<S>>());
    let y = [0, 1, 2].map(|k: usize| (v[k].y - sy).to_float::<f32x16<S>>());
    let weigh = |k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let area = x[i] * y[j] - y[i] * x[j];
        if object.perspective { area * v[k].d } else { area }
    };
    let b = [weigh(0), weigh(1), weigh(2)];
    let negative = ((b[0] + b[1]) + b[2]).simd_lt(zero);
    let b = b.map(|b| {
        let b = negative.select(-b, b);
        b.simd_gt(zero).select(b, zero)
    });
    let sum = (b[0] + b[1]) + b[2];
    let good = sum.simd_gt(zero);
    let inverse = splat(simd, 1.0) / sum;
    let one_corner = [splat(simd, 1.0), zero, zero];
    let mut weight = [0, 1, 2].map(|k| good.select(b[k] * inverse, one_corner[k]));

    let inside = (v[0].inside & v[1].inside & v[2].inside).to_bitmask() as u32;
    if inside & 0xffff != 0xffff {
        let offset = object.offset.map(f64::from);
        for lane in (0..LANES).filter(|lane| inside >> lane & 1 == 0) {
            let positions = [0, 1, 2].map(|k| [0, 1, 2].map(|a| corners.position[k][a][lane]));
            let at = |pixel: i32, offset: f64| f64::from(pixel * SUBPIXELS + SAMPLE) - offset;
            let sample = [at(fragments.x[lane], offset[0]), at(fragments.y[lane], offset[1])];
            let exact = barycentrics_unclipped(object, positions, sample);
            (0..3).for_each(|k| weight[k][lane] = exact[k]);
        }
    }
    weight
}

/// [`tercio_mesh::OctNormal::decode`], lane by lane.
#[inline(always)]
fn decode_normal<S: Simd>(simd: S, packed: &[u32; LANES]) -> Vec3x16<S> {
    let bits = i32x16::from_fn(simd, |lane| packed[lane] as i32);
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let unit = splat(simd, 1.0 / 32767.0);
    let u = ((bits << 16) >> 16).to_float::<f32x16<S>>() * unit;
    let v = (bits >> 16).to_float::<f32x16<S>>() * unit;
    let z = (one - u.abs()) - v.abs();
    let fold = z.simd_lt(zero).select(-z, zero);
    let unfold = |c: f32x16<S>| c.simd_ge(zero).select(c - fold, c + fold);
    [unfold(u), unfold(v), z]
}

#[inline(always)]
fn write_color<S: Simd>(
    simd: S,
    fragments: &Fragments,
    linear: Vec3x16<S>,
    pixels: &mut TilePixels,
    planes: &Planes,
) {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let linear = linear.map(|c| {
        let c = c.simd_gt(zero).select(c, zero);
        c.simd_lt(one).select(c, one)
    });
    if planes.color.is_wanted() {
        let table = &**ENCODE;
        let index = linear.map(|c| (c * (ENCODE_STEPS - 1) as f32 + 0.5).to_int::<i32x16<S>>());
        let index = index.map(|i| i.min(splat_i(simd, ENCODE_STEPS as i32 - 1)).to_array());
        for lane in 0..fragments.count {
            let [r, g, b] = [0, 1, 2].map(|k| table[index[k][lane] as usize % ENCODE_STEPS]);
            pixels.color[fragments.place[lane] as usize] = [r, g, b, 255];
        }
    }
    if planes.color16.is_wanted() {
        let linear = linear.map(|c| c.to_array());
        for lane in 0..fragments.count {
            let [r, g, b] = [0, 1, 2].map(|k| encode16(linear[k][lane]));
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
    if planes.normals.is_wanted() {
        let normal = normal.map(|c| c.to_array());
        for lane in lanes {
            pixels.normals[fragments.place[lane] as usize] = [0, 1, 2].map(|k| normal[k][lane]);
        }
    }
}
