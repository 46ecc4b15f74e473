//! One index per vertex: OBJ indexes positions, texture coordinates and normals separately, a mesh does not.
//!
//! The first combination found at a position keeps the position's number; every further one becomes a new vertex
//! after all others. Numbers depend only on the order in the file.

use std::collections::HashMap;

use crate::loops::prelude::*;

use crate::mesh::MAX_ELEMENTS;

use super::faces::NONE;
use super::parse::Chunk;

/// No corner has used the vertex yet. Never a valid index: those are below [`MAX_ELEMENTS`].
const UNUSED: u32 = NONE - 1;

/// Combinations at one position after the first `CHAIN` are looked up by hash, so that a hostile file in which all
/// corners share a position does not take quadratic time.
const CHAIN: usize = 32;

/// Texture coordinate and normal of each vertex of the mesh.
#[derive(Default)]
pub struct Vertices {
    /// Texture coordinate and normal of the vertices of the file.
    first: Vec<[u32; 2]>,
    /// Further vertices: position, texture coordinate, normal, next vertex in the position's chain.
    extra: Vec<[u32; 4]>,
    /// Head of each position's chain.
    heads: Vec<u32>,
    overflow: HashMap<[u32; 3], u32>,
}

/// True if every corner uses the same index for all its elements: nothing has to be split.
pub fn is_unified(chunks: &[Chunk], with_vt: bool, with_vn: bool) -> bool {
    chunks
        .par_iter()
        .all(|c| (!with_vt || c.corners.vt == c.corners.v) && (!with_vn || c.corners.vn == c.corners.v))
}

impl Vertices {
    /// Replaces the position index of every corner by the number of its vertex.
    ///
    /// # Errors
    /// The number of vertices, if there are more than can be numbered.
    pub fn unify(positions: usize, chunks: &mut [Chunk], with_vt: bool, with_vn: bool) -> Result<Self, u64> {
        let mut all =
            Self { first: vec![[UNUSED; 2]; positions], heads: vec![NONE; positions], ..Self::default() };
        let pick = |values: &[u32], i: usize, with: bool| {
            if with { values.get(i).copied().unwrap_or(NONE) } else { NONE }
        };
        for chunk in chunks {
            let corners = &mut chunk.corners;
            for (i, v) in corners.v.iter_mut().enumerate() {
                let key = [*v, pick(&corners.vt, i, with_vt), pick(&corners.vn, i, with_vn)];
                *v = all.vertex(key);
            }
            let count = (positions + all.extra.len()) as u64;
            if count > MAX_ELEMENTS {
                return Err(count);
            }
            corners.vt = Vec::new();
            corners.vn = Vec::new();
        }
        Ok(all)
    }

    fn vertex(&mut self, [v, vt, vn]: [u32; 3]) -> u32 {
        let first = &mut self.first[v as usize];
        if first[0] == UNUSED {
            *first = [vt, vn];
        }
        if *first == [vt, vn] {
            return v;
        }
        let mut link = self.heads[v as usize];
        for _ in 0..CHAIN {
            let Some(&[_, t, n, next]) = self.extra.get(link as usize) else { return self.add([v, vt, vn]) };
            if [t, n] == [vt, vn] {
                return self.number(link);
            }
            link = next;
        }
        match self.overflow.get(&[v, vt, vn]) {
            Some(&link) => self.number(link),
            None => {
                let link = self.extra.len() as u32;
                self.overflow.insert([v, vt, vn], link);
                // Not part of the chain, which would get longer than what is searched.
                self.extra.push([v, vt, vn, NONE]);
                self.number(link)
            }
        }
    }

    /// The caller stops soon after the numbers overflow, so wrapped ones are never used.
    fn number(&self, extra: u32) -> u32 {
        (self.first.len() as u32).wrapping_add(extra)
    }

    fn add(&mut self, [v, vt, vn]: [u32; 3]) -> u32 {
        let link = self.extra.len() as u32;
        // New ones are inserted at the front: files tend to use a combination again soon.
        self.extra.push([v, vt, vn, self.heads[v as usize]]);
        self.heads[v as usize] = link;
        self.number(link)
    }

    /// Number of vertices after those of the file.
    pub fn extra(&self) -> usize {
        self.extra.len()
    }

    /// Appends the values of split vertices.
    pub fn extend<T: Copy>(&self, values: &mut Vec<T>) {
        values.reserve_exact(self.extra.len());
        for &[v, ..] in &self.extra {
            if let Some(&value) = values.get(v as usize) {
                values.push(value);
            }
        }
    }

    /// The texture-coordinate index of every vertex; out of range where there is none.
    pub fn texcoords(&self) -> impl Loop<Item = u32> {
        self.first.par_iter().map(|f| f[0]).chain(self.extra.par_iter().map(|e| e[1]))
    }

    /// The normal index of every vertex; out of range where there is none.
    pub fn normals(&self) -> impl Loop<Item = u32> {
        self.first.par_iter().map(|f| f[1]).chain(self.extra.par_iter().map(|e| e[2]))
    }
}
