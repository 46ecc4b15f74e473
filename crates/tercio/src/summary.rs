//! Counts and bounds of a mesh.

use serde::{Deserialize, Serialize};
use tercio_mesh::loops::prelude::*;
use tercio_mesh::strokes::Strokes;
use tercio_mesh::{Aabb, Attribute, AttributeDomain, BlockedMesh, FileMaterial, Mesh};

/// The contents of a mesh in numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MeshSummary {
    /// Vertices, used by a triangle or not.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// World-space bounds of all vertices.
    #[serde(skip, default = "nothing")]
    pub bounds: Aabb,
    /// Whether there is a normal per vertex.
    pub normals: bool,
    /// Whether there is a colour per vertex.
    pub vertex_colors: bool,
    /// Whether there is a colour per triangle.
    pub face_colors: bool,
    /// Whether there is a pair of texture coordinates per vertex.
    pub texcoords: bool,
    /// Materials that the file names.
    pub materials: u64,
    /// Number of named scalar arrays.
    pub attributes: u64,
    /// Bytes of memory that the arrays take.
    #[serde(skip)]
    pub bytes: u64,
}

impl Default for MeshSummary {
    fn default() -> Self {
        Self::from_mesh(&Mesh::default())
    }
}

impl MeshSummary {
    /// The summary of a mesh.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        Self {
            vertices: mesh.positions.len() as u64,
            triangles: mesh.triangles.len() as u64,
            bounds: mesh.bounds(),
            normals: mesh.normals.is_some(),
            vertex_colors: mesh.vertex_colors.is_some(),
            face_colors: mesh.face_colors.is_some(),
            texcoords: mesh.texcoords.is_some(),
            materials: mesh.materials.len() as u64,
            attributes: mesh.attributes.iter().filter(|a| !Attribute::is_polygon(&a.name, a.domain)).count()
                as u64,
            bytes: bytes(mesh),
        }
    }

    /// Bytes of memory that the arrays of a mesh take.
    pub(crate) fn bytes_of(mesh: &Mesh) -> u64 {
        bytes(mesh)
    }

    /// The summary of a mesh in blocks, with the values that it has as an indexed mesh.
    pub(crate) fn from_blocks(blocks: &BlockedMesh) -> Self {
        let triangles = blocks.triangle_count() as u64;
        let rest = Self::from_mesh(blocks.mesh());
        Self { triangles, bytes: rest.bytes + triangles * size_of::<[u32; 3]>() as u64, ..rest }
    }
}

fn bytes(mesh: &Mesh) -> u64 {
    fn of<T>(array: &[T]) -> u64 {
        size_of_val(array) as u64
    }
    fn of_option<T>(array: &Option<Vec<T>>) -> u64 {
        array.as_deref().map_or(0, of)
    }
    of(&mesh.positions)
        + of(&mesh.triangles)
        + of_option(&mesh.normals)
        + of_option(&mesh.vertex_colors)
        + of_option(&mesh.face_colors)
        + of_option(&mesh.texcoords)
        + of_option(&mesh.triangle_materials)
        + of_option(&mesh.face_of_triangle)
        + mesh.attributes.iter().map(|a| of(&a.values)).sum::<u64>()
}

/// The bounds of no vertices: JSON has no infinite numbers, so bounds are not written.
fn nothing() -> Aabb {
    Aabb::EMPTY
}

/// Numbers as their bits, because JSON has no infinite ones.
mod bits {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(range: &Option<(f32, f32)>, to: S) -> Result<S::Ok, S::Error> {
        range.map(|(min, max)| (min.to_bits(), max.to_bits())).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<(f32, f32)>, D::Error> {
        let range: Option<(u32, u32)> = Deserialize::deserialize(from)?;
        Ok(range.map(|(min, max)| (f32::from_bits(min), f32::from_bits(max))))
    }
}

/// The range of an attribute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct AttributeSummary {
    /// The name in the file.
    pub name: String,
    /// The [name of the component](Attribute::component), if the file has one.
    #[serde(default)]
    pub component: Option<String>,
    /// Whether the values belong to vertices or to triangles.
    pub domain: AttributeDomain,
    /// Smallest and largest value that is not NaN, less `offset`; `None` if there is none.
    #[serde(with = "bits")]
    pub range: Option<(f32, f32)>,
    /// The attribute's [offset](Attribute::offset).
    pub offset: f64,
    /// Number of values that are NaN.
    pub nans: u64,
}

impl AttributeSummary {
    /// The summary of an attribute.
    pub fn from_attribute(attribute: &Attribute) -> Self {
        let empty = (f32::INFINITY, f32::NEG_INFINITY, 0);
        let (min, max, nans) = attribute
            .values
            .par_chunks(1 << 16)
            .map(|chunk| {
                // `min` and `max` of f32 ignore NaN.
                chunk.iter().fold(empty, |(min, max, nans), &v| {
                    (v.min(min), v.max(max), nans + u64::from(v.is_nan()))
                })
            })
            .reduce(|| empty, |a, b| (a.0.min(b.0), a.1.max(b.1), a.2 + b.2));
        Self {
            name: attribute.name.clone(),
            component: attribute.component.clone(),
            domain: attribute.domain,
            range: (nans < attribute.values.len() as u64).then_some((min, max)),
            nans,
            offset: attribute.offset,
        }
    }
}

/// The contents of the lines and points of a model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StrokesSummary {
    /// Object-space bounds of their vertices with finite coordinates.
    pub bounds: Aabb,
    /// Whether there is a colour per vertex.
    pub colors: bool,
    /// Their attributes, which are of vertices.
    pub attributes: Vec<AttributeSummary>,
    /// Materials that the file names for them.
    pub materials: Vec<FileMaterial>,
}

impl StrokesSummary {
    /// The summary of lines and points; `None` if there are none.
    pub fn from_strokes(strokes: &Strokes) -> Option<Self> {
        (!strokes.is_empty()).then(|| Self {
            bounds: strokes.bounds(),
            colors: strokes.colors.is_some(),
            attributes: strokes.attributes.iter().map(AttributeSummary::from_attribute).collect(),
            materials: strokes.materials.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_ignores_nan() {
        let summary = |values: Vec<f32>| {
            let a = AttributeSummary::from_attribute(&Attribute {
                name: "quality".into(),
                domain: AttributeDomain::Vertex,
                values,
                offset: 0.0,
                component: None,
            });
            (a.range, a.nans)
        };
        assert_eq!(summary(vec![3.0, f32::NAN, -1.0]), (Some((-1.0, 3.0)), 1));
        assert_eq!(summary(vec![f32::NAN]), (None, 1));
        assert_eq!(summary(vec![]), (None, 0));
    }
}
