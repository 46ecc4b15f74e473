//! Triangles of other ranks, with their vertices, as messages.

use std::ops::Range;

use bytemuck::{AnyBitPattern, NoUninit, Pod, Zeroable, cast_slice, pod_collect_to_vec};
use tercio_mesh::{AttributeDomain, Mesh, OctNormal};

use super::malformed;
use super::seam::Numbers;
use crate::ParallelError;

/// Counts at the front of a message.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Head {
    vertices: u64,
    triangles: u64,
}

/// Appends some triangles, whose numbers are ascending, with the numbers of triangles and vertices in the whole model.
pub fn write(mesh: &Mesh, numbers: &Numbers, triangles: &[u32], out: &mut Vec<u8>) {
    let mut vertices: Vec<u32> = triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let head = Head { vertices: vertices.len() as u64, triangles: triangles.len() as u64 };
    out.extend_from_slice(bytemuck::bytes_of(&head));
    extend(out, triangles.iter().map(|&t| numbers.first_triangle + u64::from(t)));
    extend(out, vertices.iter().map(|&v| numbers.vertex(v)));
    let place = |v: u32| vertices.partition_point(|&other| other < v) as u32;
    extend(out, triangles.iter().map(|&t| mesh.triangles[t as usize].map(place)));
    append(out, &mesh.positions, &vertices);
    mesh.normals.iter().for_each(|a| append(out, a, &vertices));
    mesh.vertex_colors.iter().for_each(|a| append(out, a, &vertices));
    mesh.texcoords.iter().for_each(|a| append(out, a, &vertices));
    let of_vertices = mesh.attributes.iter().filter(|a| a.domain == AttributeDomain::Vertex);
    of_vertices.for_each(|a| append(out, &a.values, &vertices));
}

fn extend<T: NoUninit>(out: &mut Vec<u8>, values: impl Iterator<Item = T>) {
    values.for_each(|value| out.extend_from_slice(bytemuck::bytes_of(&value)));
}

fn append<T: NoUninit>(out: &mut Vec<u8>, array: &[T], vertices: &[u32]) {
    vertices.iter().for_each(|&v| out.extend_from_slice(bytemuck::bytes_of(&array[v as usize])));
}

/// Triangles of other ranks. All arrays have one element for each vertex or triangle, several times if messages repeat them.
#[derive(Default)]
pub struct Ghosts {
    /// Numbers of the triangles in the whole model.
    triangle_numbers: Vec<u64>,
    /// Corners, as indices of the vertices here.
    triangles: Vec<[u32; 3]>,
    /// Numbers of the vertices in the whole model.
    vertex_numbers: Vec<u64>,
    /// Positions, normals, colours, texture coordinates and attributes, as the part has them; no triangles.
    vertices: Mesh,
}

impl Ghosts {
    /// None, with the arrays that a part has.
    pub fn of(mesh: &Mesh) -> Self {
        let attributes =
            mesh.attributes.iter().map(|a| tercio_mesh::Attribute { values: Vec::new(), ..a.clone() });
        let vertices = Mesh {
            normals: mesh.normals.as_ref().map(|_| Vec::new()),
            vertex_colors: mesh.vertex_colors.as_ref().map(|_| Vec::new()),
            texcoords: mesh.texcoords.as_ref().map(|_| Vec::new()),
            attributes: attributes.collect(),
            ..Mesh::default()
        };
        Self { vertices, ..Self::default() }
    }

    /// Adds those of a message.
    ///
    /// # Errors
    /// A message that is not as [`write`] makes it for a mesh with the same arrays.
    pub fn read(&mut self, from: usize, message: &[u8]) -> Result<(), ParallelError> {
        if message.is_empty() {
            return Ok(());
        }
        let mut reader = Reader { from, rest: message };
        let head: Head = reader.take(1)?[0];
        let first = self.vertices.positions.len();
        let most = u64::from(u32::MAX) - first as u64;
        if head.vertices >= most || head.triangles >= u64::from(u32::MAX) {
            return Err(malformed(from, format!("{} vertices at a seam", head.vertices)));
        }
        let (vertices, triangles) = (head.vertices as usize, head.triangles as usize);
        self.triangle_numbers.extend(reader.take::<u64>(triangles)?);
        self.vertex_numbers.extend(reader.take::<u64>(vertices)?);
        let corners = reader.take::<[u32; 3]>(triangles)?;
        if corners.as_flattened().iter().any(|&v| v as usize >= vertices) {
            return Err(malformed(from, "a corner at a seam that is no vertex"));
        }
        self.triangles.extend(corners.iter().map(|t| t.map(|v| v + first as u32)));
        let mesh = &mut self.vertices;
        mesh.positions.extend(reader.take::<[f32; 3]>(vertices)?);
        reader.extend::<OctNormal>(&mut mesh.normals, vertices)?;
        reader.extend::<[u8; 4]>(&mut mesh.vertex_colors, vertices)?;
        reader.extend::<[f32; 2]>(&mut mesh.texcoords, vertices)?;
        for attribute in mesh.attributes.iter_mut().filter(|a| a.domain == AttributeDomain::Vertex) {
            attribute.values.extend(reader.take::<f32>(vertices)?);
        }
        if !reader.rest.is_empty() {
            return Err(malformed(
                from,
                format!("{} bytes after the triangles at a seam", reader.rest.len()),
            ));
        }
        Ok(())
    }

    /// Adds the triangles to a part: all vertices and triangles are then in the order of the whole model. Returns which
    /// triangles are the part's own.
    ///
    /// # Errors
    /// [`ParallelError`], if there are too many to number.
    pub fn join(self, mesh: &mut Mesh, numbers: &Numbers) -> Result<Range<usize>, ParallelError> {
        let own = mesh.triangles.len();
        let mut triangles: Vec<u32> = (0..self.triangles.len() as u32).collect();
        triangles.sort_unstable_by_key(|&t| self.triangle_numbers[t as usize]);
        triangles.dedup_by_key(|t| self.triangle_numbers[*t as usize]);
        if triangles.is_empty() {
            return Ok(0..own);
        }
        // Vertices that the part does not have, each once.
        let mut ghosts: Vec<u32> = (0..self.vertex_numbers.len() as u32).collect();
        ghosts.sort_unstable_by_key(|&v| self.vertex_numbers[v as usize]);
        ghosts.dedup_by_key(|v| self.vertex_numbers[*v as usize]);
        ghosts.retain(|&v| numbers.find(self.vertex_numbers[v as usize], mesh.positions.len()).is_none());
        let count = mesh.positions.len();
        if count as u64 + ghosts.len() as u64 > tercio_mesh::mesh::MAX_ELEMENTS {
            return Err(malformed(0, "more vertices in a part than can be numbered"));
        }
        // For each vertex that is added, the number of own ones before it.
        let before: Vec<u32> =
            ghosts.iter().map(|&v| numbers.before(self.vertex_numbers[v as usize], count)).collect();
        let place_of_own = |v: u32| v + before.partition_point(|&before| before <= v) as u32;
        let place = |ghost: u32| {
            let number = self.vertex_numbers[ghost as usize];
            match numbers.find(number, count) {
                Some(own) => place_of_own(own),
                None => {
                    let k = ghosts.partition_point(|&v| self.vertex_numbers[v as usize] < number);
                    before[k] + k as u32
                }
            }
        };
        let moved = |t: u32| self.triangles[t as usize].map(place);
        let low = triangles.partition_point(|&t| self.triangle_numbers[t as usize] < numbers.first_triangle);
        let mut all = Vec::with_capacity(own + triangles.len());
        all.extend(triangles[..low].iter().map(|&t| moved(t)));
        all.extend(mesh.triangles.iter().map(|t| t.map(place_of_own)));
        all.extend(triangles[low..].iter().map(|&t| moved(t)));
        mesh.triangles = all;

        let merge = Merge { ghosts: &ghosts, before: &before };
        let from = &self.vertices;
        merge.arrays(&mut mesh.positions, &from.positions);
        merge.optional(&mut mesh.normals, &from.normals);
        merge.optional(&mut mesh.vertex_colors, &from.vertex_colors);
        merge.optional(&mut mesh.texcoords, &from.texcoords);
        let high = triangles.len() - low;
        mesh.face_colors.iter_mut().for_each(|a| pad(a, low, high));
        mesh.triangle_materials.iter_mut().for_each(|a| pad(a, low, high));
        mesh.face_of_triangle.iter_mut().for_each(|a| pad(a, low, high));
        for (attribute, from) in mesh.attributes.iter_mut().zip(&from.attributes) {
            match attribute.domain {
                AttributeDomain::Vertex => merge.arrays(&mut attribute.values, &from.values),
                AttributeDomain::Triangle => pad(&mut attribute.values, low, high),
            }
        }
        Ok(low..low + own)
    }
}

/// Puts as many values as there are triangles of other ranks before and behind those of a part. They are not used.
fn pad<T: Copy + Default>(array: &mut Vec<T>, low: usize, high: usize) {
    let mut all = vec![T::default(); low];
    all.extend_from_slice(array);
    all.resize(all.len() + high, T::default());
    *array = all;
}

/// How vertices of other ranks are put between those of a part.
struct Merge<'a> {
    ghosts: &'a [u32],
    /// For each of them, the number of own ones before it.
    before: &'a [u32],
}

impl Merge<'_> {
    fn arrays<T: Copy>(&self, own: &mut Vec<T>, ghosts: &[T]) {
        if self.ghosts.is_empty() {
            return;
        }
        let (mut all, mut done) = (Vec::with_capacity(own.len() + self.ghosts.len()), 0);
        for (&ghost, &before) in self.ghosts.iter().zip(self.before) {
            all.extend_from_slice(&own[done..before as usize]);
            done = before as usize;
            all.push(ghosts[ghost as usize]);
        }
        all.extend_from_slice(&own[done..]);
        *own = all;
    }

    fn optional<T: Copy>(&self, own: &mut Option<Vec<T>>, ghosts: &Option<Vec<T>>) {
        if let (Some(own), Some(ghosts)) = (own, ghosts) {
            self.arrays(own, ghosts);
        }
    }
}

/// Reads a message from front to back.
struct Reader<'a> {
    from: usize,
    rest: &'a [u8],
}

impl Reader<'_> {
    fn take<T: NoUninit + AnyBitPattern>(&mut self, count: usize) -> Result<Vec<T>, ParallelError> {
        let bytes = count.checked_mul(size_of::<T>());
        let Some((first, rest)) = bytes.and_then(|bytes| self.rest.split_at_checked(bytes)) else {
            let left = self.rest.len();
            let reason = format!("{left} bytes left at a seam, expected {count} of {}", size_of::<T>());
            return Err(malformed(self.from, reason));
        };
        self.rest = rest;
        Ok(pod_collect_to_vec::<u8, T>(cast_slice(first)))
    }

    fn extend<T: NoUninit + AnyBitPattern>(
        &mut self,
        array: &mut Option<Vec<T>>,
        count: usize,
    ) -> Result<(), ParallelError> {
        if let Some(array) = array {
            array.extend(self.take::<T>(count)?);
        }
        Ok(())
    }
}
