//! Clipping: a model cut at planes, and the cut of closed models capped.
//!
//! A cut is made in the mesh, before it is split into clusters, so that it is exact and does not depend on how the
//! picture is drawn. Triangles that are not cut keep their bits; where an edge meets a plane is computed once, from
//! positions alone, so that neighbours stay neighbours (`cut`, `vertices`). The edges along a plane are its outline
//! (`outline`); what is inside becomes triangles (`cap`).

mod cap;
mod cut;
mod outline;
mod plane;
#[cfg(test)]
mod tests;
mod vertices;

pub use plane::{Axis, Clip, ClipPlane};

use crate::weld::position_bits;
use crate::{Mesh, OctNormal};
use cut::Edge;
use outline::{Outline, Segment};
use plane::LocalPlane;

/// What clipping did to a mesh.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Clipped {
    /// Triangles of which nothing is left.
    pub removed: u64,
    /// Triangles of which a part is left.
    pub cut: u64,
    /// The caps, if they were requested and there are any: a mesh with the origin and the unit of the clipped one, with
    /// flat normals that point to what was cut away. What closes one plane is one face. In a scene in which the caps follow
    /// the mesh, the number of that face is the number of the plane, from 0, after those of all faces that the mesh had, also
    /// of those that were cut away.
    pub caps: Option<Mesh>,
    /// Outlines that were capped, of all planes; those that have a point in common count once.
    pub outlines: u64,
    /// Outlines that were not capped because they are not closed, as the mesh is not; and those of a plane in which
    /// they cross each other too often.
    pub open_outlines: u64,
}

/// Why a mesh could not be clipped.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ClipError {
    /// Cutting triangles makes more pieces or vertices than can be numbered.
    #[error("clipping makes {count} {what}, more than can be numbered")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many there would be.
        count: u64,
    },
}

/// Removes what is on the other side of the planes, all of them: triangles that are cut become smaller ones.
///
/// What is left keeps its order, and its vertices theirs; new vertices follow, with normals, colours (interpolated in
/// linear light, and rounded), texture coordinates and attributes between those of the edge's ends. Pieces keep
/// colour, material, attributes and face number of their triangle. A vertex nearer to a plane than its coordinates are
/// exact is in it. Vertices that no triangle uses are dropped. A mesh of which nothing is cut away is not changed.
///
/// If `capped`, cuts of closed parts of the mesh are closed by [`Clipped::caps`]; several planes cut each other's caps.
/// What is inside follows from the direction of the triangles: solids inside one another, cavities, and solids that
/// penetrate each other are right. If triangles do not all run the same way round, it is what an odd number of surfaces
/// encloses. A triangle in a plane that faces the side which is kept ends a solid that was cut away, and is removed with
/// it; without caps, all triangles in a plane are kept.
///
/// Takes linear time, up to a logarithm. The result does not depend on the number of threads.
///
/// # Errors
/// [`ClipError`] if there are too many pieces; the mesh is then of no use.
pub fn clip(mesh: &mut Mesh, planes: &[ClipPlane], capped: bool) -> Result<Clipped, ClipError> {
    let before = (mesh.triangles.len(), mesh.positions.len() as u32);
    let faces = faces(mesh);
    let mut sources = None;
    let mut caps = Caps::new(mesh);
    for (number, plane) in (0..).zip(planes) {
        let local = LocalPlane::new(plane, mesh);
        let of_mesh = cut::cut(mesh, &local, capped)?;
        let of_caps = cut::cut(&mut caps.mesh, &local, capped)?;
        let mut edges = Vec::new();
        if let Some(cut) = of_mesh {
            edges.extend(cut.outline);
            compose(&mut sources, cut.sources);
        }
        if let Some(cut) = of_caps {
            let weighted = |edge: Edge| {
                let segment = Segment { weight: caps.weights[edge.triangle as usize], ..edge.segment };
                Edge { segment, ..edge }
            };
            edges.extend(cut.outline.into_iter().map(weighted));
            caps.inherit(&cut.sources);
        }
        if !edges.is_empty() {
            caps.add(&outline(edges, [mesh, &caps.mesh], &local), plane, &local, number);
        }
    }
    let mut clipped =
        Clipped { outlines: caps.outlines, open_outlines: caps.open_outlines, ..Clipped::default() };
    if let Some(sources) = sources {
        (clipped.removed, clipped.cut) = count(mesh, &sources, before);
        vertices::inherit(mesh, &sources);
        vertices::drop_unused(mesh);
    }
    clipped.caps = caps.finish(faces.saturating_sub(self::faces(mesh)));
    Ok(clipped)
}

/// How many faces a mesh has, up to the last one of which something is left.
fn faces(mesh: &Mesh) -> u32 {
    match &mesh.face_of_triangle {
        Some(faces) => faces.last().map_or(0, |&last| last.saturating_add(1)),
        None => mesh.triangles.len() as u32,
    }
}

/// Bytes of memory that clipping takes besides the mesh, approximately; caps come on top.
pub fn needed_bytes(mesh: &Mesh) -> u64 {
    let (vertices, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
    // A side and a new number a vertex; the new triangles twice, with their sources.
    6 * vertices + 40 * triangles
}

/// The numbers that triangles had before two cuts.
fn compose(sources: &mut Option<Vec<u32>>, then: Vec<u32>) {
    *sources = Some(match sources.take() {
        Some(first) => then.into_iter().map(|s| first[s as usize]).collect(),
        None => then,
    });
}

/// Triangles of which nothing, and of which a part is left: all pieces have a new vertex.
fn count(mesh: &Mesh, sources: &[u32], (triangles, vertices): (usize, u32)) -> (u64, u64) {
    let (mut left, mut cut) = (0, 0);
    let mut rest = mesh.triangles.as_slice();
    for pieces in sources.chunk_by(|a, b| a == b) {
        let (these, others) = rest.split_at(pieces.len());
        rest = others;
        left += 1;
        cut += u64::from(these.as_flattened().iter().any(|&v| v >= vertices));
    }
    (triangles as u64 - left, cut)
}

/// The outline of a solid that these meshes enclose, from the edges at which they end.
fn outline(edges: Vec<Edge>, meshes: [&Mesh; 2], plane: &LocalPlane) -> Outline {
    // An edge of a triangle of which nothing is left counts only where something else is left.
    let rims = if edges.iter().any(|edge| !edge.is_cut) {
        meshes.map(|m| cut::rim(m, plane))
    } else {
        Default::default()
    };
    let is_left = |p| rims.iter().any(|rim| rim.contains(&position_bits(p)));
    let counts = |e: &Edge| e.is_cut || is_left(e.segment.from) && is_left(e.segment.to);
    let segments: Vec<Segment> = edges.iter().filter(|e| counts(e)).map(|e| e.segment).collect();
    Outline::new(&segments, plane)
}

/// The caps of all planes so far.
struct Caps {
    mesh: Mesh,
    /// Of each triangle.
    weights: Vec<i32>,
    outlines: u64,
    open_outlines: u64,
}

impl Caps {
    fn new(of: &Mesh) -> Self {
        let mesh = Mesh {
            origin: of.origin,
            exponent: of.exponent,
            normals: Some(Vec::new()),
            face_of_triangle: Some(Vec::new()),
            ..Mesh::default()
        };
        Self { mesh, weights: Vec::new(), outlines: 0, open_outlines: 0 }
    }

    fn inherit(&mut self, sources: &[u32]) {
        self.weights = sources.iter().map(|&s| self.weights[s as usize]).collect();
        vertices::inherit(&mut self.mesh, sources);
    }

    fn add(&mut self, outline: &Outline, plane: &ClipPlane, local: &LocalPlane, number: u32) {
        self.open_outlines += outline.open;
        let Some(cap) = cap::cap(outline, local) else {
            self.open_outlines += outline.closed;
            return;
        };
        self.outlines += outline.closed;
        let mesh = &mut self.mesh;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&cap.points);
        let normal = OctNormal::from_vector((-plane.normal()).to_array());
        mesh.normals.get_or_insert_default().resize(mesh.positions.len(), normal);
        mesh.triangles.extend(cap.triangles.iter().map(|t| t.map(|v| first + v)));
        mesh.face_of_triangle.get_or_insert_default().resize(mesh.triangles.len(), number);
        self.weights.extend(cap.weights);
    }

    /// The caps, whose faces are numbered from `first`.
    fn finish(mut self, first: u32) -> Option<Mesh> {
        self.mesh.face_of_triangle.iter_mut().flatten().for_each(|face| *face = face.saturating_add(first));
        vertices::drop_unused(&mut self.mesh);
        (!self.mesh.triangles.is_empty()).then_some(self.mesh)
    }
}
