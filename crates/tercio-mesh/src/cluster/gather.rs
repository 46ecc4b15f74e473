//! Writes the memory of the clusters.

use crate::loops::prelude::*;
use bytemuck::Zeroable;
use fearless_simd::{Level, dispatch};

use super::layout::padded;
use super::partition::Cut;
use super::{Buffer, Cluster, ClusterView, ClusteredMesh, Layout, Line, bounds};
use crate::{AttributeDomain, Mesh};

/// Splits `data` into consecutive pieces of the given lengths; what is left over is dropped.
pub(super) fn split<T>(mut data: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    lengths
        .map(|n| {
            let (piece, rest) = std::mem::take(&mut data).split_at_mut(n);
            data = rest;
            piece
        })
        .collect()
}

/// What the clusters of a mesh will store.
pub(super) fn layout(mesh: &Mesh) -> Layout {
    Layout {
        normals: mesh.normals.is_some(),
        vertex_colors: mesh.vertex_colors.is_some(),
        texcoords: mesh.texcoords.is_some(),
        face_colors: mesh.face_colors.is_some(),
        triangle_materials: mesh.triangle_materials.is_some(),
        attributes: mesh.attributes.iter().map(|a| (a.name.clone(), a.domain)).collect(),
        offsets: Layout::offsets_of(&mesh.attributes),
        components: Layout::components_of(&mesh.attributes),
    }
}

/// A block's part of the result.
struct Job<'a> {
    cut: &'a Cut,
    /// Mesh numbers of its triangles; `None` where they are consecutive.
    numbers: Option<&'a [u32]>,
    heads: &'a mut [Cluster],
    lines: &'a mut [Line],
}

/// Fills in the clusters. `order` holds the mesh numbers of all triangles, cluster after cluster.
pub(super) fn clusters(out: &mut ClusteredMesh, cuts: &[Cut], order: Option<&[u32]>, source: &Mesh) {
    let layout = layout(source);
    let lengths: Vec<usize> =
        cuts.iter().map(|cut| cut.clusters.iter().map(|head| layout.lines(head)).sum()).collect();
    let total: usize = lengths.iter().sum();
    assert!(u32::try_from(total).is_ok(), "clusters of more than 2^32 cache lines");
    let mut starts = Vec::with_capacity(cuts.iter().map(|c| c.clusters.len()).sum::<usize>() + 1);
    starts.push(0);
    let mut heads = Vec::with_capacity(starts.capacity() - 1);
    let mut end = 0;
    for head in cuts.iter().flat_map(|cut| &cut.clusters) {
        end += layout.lines(head) as u32;
        starts.push(end);
        heads.push(*head);
    }
    let mut lines = Buffer::zeroed(total + Layout::LINES_BEHIND);
    let mut rest = order;
    let numbers: Vec<Option<&[u32]>> = cuts
        .iter()
        .map(|cut| {
            let (own, after) = rest?.split_at(cut.triangles());
            rest = Some(after);
            Some(own)
        })
        .collect();
    let heads_of = split(&mut heads, cuts.iter().map(|c| c.clusters.len()));
    let lines_of = split(lines.as_mut_slice(), lengths.into_iter());
    let jobs = cuts.iter().zip(numbers).zip(heads_of).zip(lines_of);
    let jobs: Vec<Job> =
        jobs.map(|(((cut, numbers), heads), lines)| Job { cut, numbers, heads, lines }).collect();
    let level = Level::new();
    jobs.into_par_iter().with_max_len(1).for_each_init(Memory::default, |memory, job| {
        write(job, &layout, source, memory, level);
    });
    (out.layout, out.clusters, out.starts, out.lines) = (layout, heads.into(), starts.into(), lines);
}

/// Values of a block's vertices, in the order of the block. Clusters gather them in an order that the prefetcher
/// cannot predict; here they are read in the order of the mesh.
#[derive(Default)]
struct Memory {
    points: Vec<[f32; 3]>,
    words: Vec<u32>,
}

/// Writes the clusters of a block.
fn write(job: Job, layout: &Layout, source: &Mesh, memory: &mut Memory, level: Level) {
    let Job { cut, numbers, heads, lines } = job;
    let mut stretches: Vec<Stretch> = Vec::with_capacity(heads.len());
    let (mut rest, mut vertex, mut triangle) = (lines, 0, 0);
    for head in heads.iter() {
        let (lines, after) = std::mem::take(&mut rest).split_at_mut(layout.lines(head));
        rest = after;
        let vertices = vertex..vertex + usize::from(head.vertices);
        let triangles = triangle..triangle + usize::from(head.triangles);
        (vertex, triangle) = (vertices.end, triangles.end);
        stretches.push(Stretch { lines, vertices, triangles });
    }

    // Positions, corners and normals first: bounds are computed from them.
    memory.points.clear();
    memory.points.extend(cut.names.iter().map(|&v| source.positions[v as usize]));
    if let Some(normals) = &source.normals {
        memory.words.clear();
        memory.words.extend(cut.names.iter().map(|&v| normals[v as usize].0));
    }
    for (head, stretch) in heads.iter_mut().zip(&mut stretches) {
        let own = &cut.vertices[stretch.vertices.clone()];
        let each = padded(head.vertices);
        let floats: &mut [f32] = bytemuck::cast_slice_mut(stretch.lines);
        let [x, y, z] = axes(&mut floats[Layout::axis(head, 0)..], each);
        for (i, &v) in own.iter().enumerate() {
            [x[i], y[i], z[i]] = memory.points[usize::from(v)];
        }
        for axis in [x, y, z] {
            pad(axis, own.len());
        }
        if source.normals.is_some() {
            let first = Layout::normals(head);
            put(&mut bytemuck::cast_slice_mut(stretch.lines)[first..first + each], own, &memory.words);
        }
        let (first, each) = (layout.corners(head), padded(head.triangles));
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(stretch.lines);
        for (k, corner) in cut.corners.iter().enumerate() {
            let own = &corner[stretch.triangles.clone()];
            bytes[first + k * each..][..own.len()].copy_from_slice(own);
        }
        stretch.bound(head, layout, level);
        stretch.lines[0].0[..size_of::<Cluster>()].copy_from_slice(bytemuck::bytes_of(head));
        if let Some(numbers) = numbers {
            let bytes = bytemuck::cast_slice_mut(stretch.lines);
            write_numbers(bytes, head, layout, &numbers[stretch.triangles.clone()]);
        }
    }

    let mut values = Values { layout, cut, numbers, stretches, heads, place: [0; 2] };
    if let Some(colors) = &source.vertex_colors {
        values.of_vertices(memory, |v| u32::from_ne_bytes(colors[v]));
    }
    if let Some(texcoords) = &source.texcoords {
        values.of_vertices(memory, |v| texcoords[v][0].to_bits());
        values.of_vertices(memory, |v| texcoords[v][1].to_bits());
    }
    if let Some(colors) = &source.face_colors {
        values.of_triangles(|t| u32::from_ne_bytes(colors[t]));
    }
    if let Some(materials) = &source.triangle_materials {
        values.of_triangles(|t| materials[t]);
    }
    for attribute in &source.attributes {
        match attribute.domain {
            AttributeDomain::Vertex => values.of_vertices(memory, |v| attribute.values[v].to_bits()),
            AttributeDomain::Triangle => values.of_triangles(|t| attribute.values[t].to_bits()),
        }
    }
    let stretches = values.stretches;
    for (head, stretch) in heads.iter_mut().zip(stretches) {
        if ClusterView::new(stretch.lines, layout).is_translucent(&source.materials) {
            head.flags |= Cluster::TRANSLUCENT;
            stretch.lines[0].0[..size_of::<Cluster>()].copy_from_slice(bytemuck::bytes_of(head));
        }
    }
}

/// The memory of a cluster.
struct Stretch<'a> {
    lines: &'a mut [Line],
    /// Its range of the block's vertices, and of its triangles.
    vertices: std::ops::Range<usize>,
    triangles: std::ops::Range<usize>,
}

impl Stretch<'_> {
    /// Computes the bounds from positions, normals and corners.
    fn bound(&self, head: &mut Cluster, layout: &Layout, level: Level) {
        let (vertices, triangles) = (self.vertices.len(), self.triangles.len());
        let floats: &[f32] = bytemuck::cast_slice(self.lines);
        let points = [0, 1, 2].map(|axis| &floats[Layout::axis(head, axis)..][..vertices]);
        let first = Layout::normals(head);
        let normals = layout.normals.then(|| &bytemuck::cast_slice(self.lines)[first..first + vertices]);
        let bytes: &[u8] = bytemuck::cast_slice(self.lines);
        let (first, each) = (layout.corners(head), padded(head.triangles));
        let corners = [0, 1, 2].map(|k| &bytes[first + k * each..][..triangles]);
        dispatch!(level, _ => bounds::bound(head, points, normals, corners));
    }
}

/// Writes the primitive numbers of a cluster into the bytes of its stretch.
pub(super) fn write_numbers(stretch: &mut [u8], head: &Cluster, layout: &Layout, numbers: &[u32]) {
    let bits = u32::from(head.number_bits);
    let (mut at, mut pending, mut count) = (layout.numbers(head), 0u64, 0);
    if bits == 0 {
        return;
    }
    for number in numbers {
        // At most 7 bits are pending, so that 64 bits have room for them and another number.
        pending |= u64::from(number - head.first_primitive) << count;
        count += bits;
        while count >= 8 {
            stretch[at] = pending as u8;
            (at, pending, count) = (at + 1, pending >> 8, count - 8);
        }
    }
    if count > 0 {
        stretch[at] = pending as u8;
    }
}

/// Splits a buffer into three consecutive arrays.
fn axes(values: &mut [f32], each: usize) -> [&mut [f32]; 3] {
    let (x, rest) = values.split_at_mut(each);
    let (y, rest) = rest.split_at_mut(each);
    [x, y, &mut rest[..each]]
}

/// Fills the rest of an array with the last of its `count` values.
fn pad<T: Copy>(values: &mut [T], count: usize) {
    let last = values[count - 1];
    values[count..].fill(last);
}

/// Gathers the values of some vertices from those of their block.
fn put(to: &mut [u32], vertices: &[u16], of_block: &[u32]) {
    for (to, &v) in to.iter_mut().zip(vertices) {
        *to = of_block[usize::from(v)];
    }
    pad(to, vertices.len());
}

/// Values that are stored after the corners, written into the clusters of a block.
struct Values<'a, 'b, 'c> {
    layout: &'a Layout,
    cut: &'a Cut,
    numbers: Option<&'a [u32]>,
    heads: &'b [Cluster],
    stretches: Vec<Stretch<'c>>,
    /// How many arrays of vertex values and of triangle values have been written.
    place: [usize; 2],
}

impl Values<'_, '_, '_> {
    /// Writes the next vertex values; `value` takes vertex numbers in the mesh.
    fn of_vertices(&mut self, memory: &mut Memory, value: impl Fn(usize) -> u32) {
        memory.words.clear();
        memory.words.extend(self.cut.names.iter().map(|&v| value(v as usize)));
        for (head, stretch) in self.heads.iter().zip(&mut self.stretches) {
            let first = self.layout.vertex_values(head, self.place[0]);
            let to = &mut bytemuck::cast_slice_mut(stretch.lines)[first..first + padded(head.vertices)];
            put(to, &self.cut.vertices[stretch.vertices.clone()], &memory.words);
        }
        self.place[0] += 1;
    }

    /// Writes the next triangle values; `value` takes triangle numbers in the mesh.
    fn of_triangles(&mut self, value: impl Fn(usize) -> u32) {
        for (head, stretch) in self.heads.iter().zip(&mut self.stretches) {
            let first = self.layout.triangle_values(head, self.place[1]);
            let to: &mut [u32] = bytemuck::cast_slice_mut(stretch.lines);
            for (i, to) in to[first..first + stretch.triangles.len()].iter_mut().enumerate() {
                let number = match self.numbers {
                    Some(numbers) => numbers[stretch.triangles.start + i],
                    None => head.first_primitive + i as u32,
                };
                *to = value(number as usize);
            }
        }
        self.place[1] += 1;
    }
}

/// A head with the sizes of a cluster and the numbers of its triangles, without bounds.
pub(super) fn head(vertices: u8, numbers: impl Iterator<Item = u32> + Clone) -> Cluster {
    let (mut least, mut most, mut count) = (u32::MAX, 0, 0u32);
    let mut consecutive = true;
    let first = numbers.clone().next().unwrap_or(0);
    for number in numbers {
        (least, most) = (least.min(number), most.max(number));
        consecutive &= number == first.wrapping_add(count);
        count += 1;
    }
    let bits = u32::BITS - (most - least).leading_zeros();
    let number_bits = if consecutive { 0 } else { bits.max(1) };
    Cluster {
        vertices,
        triangles: count as u8,
        first_primitive: least,
        number_bits: number_bits as u8,
        ..Cluster::zeroed()
    }
}
