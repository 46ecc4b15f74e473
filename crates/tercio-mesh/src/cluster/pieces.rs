//! Packs pieces of a mesh that share no vertices into clusters, in a given order.

use std::ops::Range;

use super::partition::{Cut, Limits, finish};
use super::{ClusteredMesh, MAX_TRIANGLES, MAX_VERTICES, PartitionOptions, gather};
use crate::Mesh;

/// A part of a mesh with vertices of its own: no other piece's triangle has one of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The numbers of its vertices.
    pub vertices: Range<u32>,
    /// The numbers of its triangles, which have these corners.
    pub triangles: Range<u32>,
}

/// Most vertices of the clusters of one [`Cut`], which has 16 bits for their numbers.
const BLOCK: usize = 1 << 16;

/// As [`partition`](super::partition()), for a mesh of small pieces, such as quadrilaterals for lines: clusters are made of consecutive
/// pieces, which should be near each other. A piece is divided only if it has more vertices or triangles than a cluster. Triangles keep their
/// numbers; the vertices of a piece are stored even if none of its triangles has them.
///
/// # Panics
/// As `partition`, if a triangle has a corner that is none of the vertices of its piece, or if the pieces have not as many triangles as the mesh.
pub fn partition_pieces(mesh: Mesh, pieces: impl IntoIterator<Item = Piece>) -> ClusteredMesh {
    let limits = Limits { vertices: MAX_VERTICES as u32, triangles: MAX_TRIANGLES as u32 };
    let triangles = mesh.triangles.len();
    let mut packer = Packer {
        triangles: &mesh.triangles,
        limits,
        cuts: vec![Cut::default()],
        numbers: Vec::with_capacity(triangles),
        used: 0,
        count: 0,
        members: Vec::new(),
    };
    pieces.into_iter().for_each(|piece| packer.add(&piece));
    packer.close();
    let Packer { cuts, numbers, .. } = packer;
    assert_eq!(numbers.len(), triangles, "all triangles are in one piece each");
    finish(mesh, &cuts, Some(&numbers), &PartitionOptions::default())
}

struct Packer<'a> {
    triangles: &'a [[u32; 3]],
    limits: Limits,
    /// The last one is not full.
    cuts: Vec<Cut>,
    /// The triangles of all clusters, one after the other.
    numbers: Vec<u32>,
    /// Vertices and triangles of the open cluster.
    used: u32,
    count: u32,
    /// Of a piece that is divided, for each vertex: the number of the last cluster that contains it, from 1, times 256, plus its number
    /// in that cluster.
    members: Vec<u32>,
}

impl Packer<'_> {
    fn add(&mut self, piece: &Piece) {
        let (vertices, triangles) = (piece.vertices.len() as u32, piece.triangles.len() as u32);
        if triangles == 0 {
            return;
        }
        if vertices > self.limits.vertices || triangles > self.limits.triangles {
            self.divide(piece);
            return;
        }
        if self.used + vertices > self.limits.vertices || self.count + triangles > self.limits.triangles {
            self.close();
        }
        let base = self.used;
        self.add_vertices(piece.vertices.clone());
        for number in piece.triangles.clone() {
            self.add_triangle(piece, number, |place| base + place);
        }
    }

    /// Divides a piece that is too large for one cluster.
    fn divide(&mut self, piece: &Piece) {
        let mut members = std::mem::take(&mut self.members);
        members.clear();
        members.resize(piece.vertices.len(), 0);
        let mut cluster = 1;
        for number in piece.triangles.clone() {
            let places = self.triangles[number as usize].map(|v| place_in(piece, v));
            let missing =
                |members: &[u32]| places.iter().filter(|&&p| members[p as usize] >> 8 != cluster).count();
            let is_full = self.used + missing(&members) as u32 > self.limits.vertices;
            if is_full || self.count == self.limits.triangles {
                self.close();
                cluster += 1;
            }
            for place in places {
                if members[place as usize] >> 8 != cluster {
                    members[place as usize] = cluster << 8 | self.used;
                    let vertex = piece.vertices.start + place;
                    self.add_vertices(vertex..vertex + 1);
                }
            }
            self.add_triangle(piece, number, |place| members[place as usize] & 0xff);
        }
        self.members = members;
    }

    fn add_vertices(&mut self, vertices: Range<u32>) {
        let count = vertices.len() as u32;
        let Some(cut) = self.cuts.last_mut() else { unreachable!("there is always an open one") };
        let first = cut.names.len() as u32;
        cut.vertices.extend((first..first + count).map(|v| v as u16));
        cut.names.extend(vertices);
        self.used += count;
    }

    /// `number_of` is the number in the open cluster of a vertex with this place in the piece.
    fn add_triangle(&mut self, piece: &Piece, number: u32, number_of: impl Fn(u32) -> u32) {
        let Some(cut) = self.cuts.last_mut() else { unreachable!("there is always an open one") };
        let corners = Mesh::canonical(self.triangles[number as usize]);
        for (list, corner) in cut.corners.iter_mut().zip(corners) {
            list.push(number_of(place_in(piece, corner)) as u8);
        }
        self.numbers.push(number);
        self.count += 1;
    }

    /// Ends the open cluster, unless it is empty.
    fn close(&mut self) {
        if self.count == 0 {
            return;
        }
        let Some(cut) = self.cuts.last_mut() else { unreachable!("there is always an open one") };
        let own = &self.numbers[self.numbers.len() - self.count as usize..];
        cut.clusters.push(gather::head(self.used as u8, own.iter().copied()));
        if cut.names.len() + MAX_VERTICES > BLOCK {
            self.cuts.push(Cut::default());
        }
        (self.used, self.count) = (0, 0);
    }
}

fn place_in(piece: &Piece, vertex: u32) -> u32 {
    assert!(piece.vertices.contains(&vertex), "vertex {vertex} is not in the piece {:?}", piece.vertices);
    vertex - piece.vertices.start
}
