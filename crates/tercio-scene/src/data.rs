//! Surfaces that show data: [`SurfaceData`].

use std::sync::Arc;

use glam::{DMat3, DVec3};
use tercio_mesh::cluster::{ClusterView, Layout};
use tercio_mesh::{AttributeDomain, ClusteredMesh, OctNormal};

use crate::{DataColors, Instance};

/// What the colours of a surface show instead of its own.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceData {
    /// Values, interpolated over each triangle before they become colours.
    Mapped {
        /// The values.
        source: DataSource,
        /// Their colours.
        colors: Arc<DataColors>,
    },
    /// Colours themselves: `value * scale + offset` are sRGB components, 0 to 1, and linear alpha.
    Direct {
        /// Red, green, blue and, if there are four, alpha; all of them at vertices, or all of them at triangles.
        components: Vec<DataSource>,
        /// What values are multiplied by.
        scale: f32,
        /// What is added then.
        offset: f32,
    },
}

/// A number at each vertex or triangle of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum DataSource {
    /// An attribute by its number in [`Layout::attributes`].
    Attribute(usize),
    /// The length of the vector whose components are these attributes, all at vertices, or all at triangles.
    Magnitude(Vec<usize>),
    /// The world-space coordinate of the vertices along a unit vector.
    Along(DVec3),
    /// The component of the vertices' unit normals along a unit vector of world space. The mesh has normals.
    Normal(DVec3),
    /// The number of the input face that a triangle came from, counted from the first of the model.
    Face,
    /// The coordinate of the vertices along an axis (0 for x) as the file has it: the instance's place does not count.
    Coordinate(usize),
    /// A texture coordinate of the vertices: 0 for u, 1 for v. The mesh has them.
    Texcoord(usize),
    /// A component of the mesh's own colours, 0 to 255: 0 for red to 3 for alpha, of its vertices or of its triangles. The mesh has them.
    Color(usize, AttributeDomain),
}

/// What a mesh holds of a vertex besides its attributes. A [`DataReader`] needs the position, and what its source names.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vertex {
    /// In mesh coordinates.
    pub position: [f32; 3],
    /// The unit normal.
    pub normal: Option<[f32; 3]>,
    /// Texture coordinates.
    pub texcoord: Option<[f32; 2]>,
    /// sRGB colour and linear alpha.
    pub color: Option<[u8; 4]>,
}

impl SurfaceData {
    /// May it be less than opaque anywhere?
    pub fn is_translucent(&self) -> bool {
        match self {
            Self::Mapped { colors, .. } => colors.is_translucent(),
            Self::Direct { components, .. } => components.len() > 3,
        }
    }

    /// Where its values are; that of its first source if they should differ.
    pub fn domain(&self, layout: &Layout) -> AttributeDomain {
        match self {
            Self::Mapped { source, .. } => source.domain(layout),
            Self::Direct { components, .. } => {
                components.first().map_or(AttributeDomain::Vertex, |source| source.domain(layout))
            }
        }
    }
}

impl DataSource {
    /// Does a mesh have what it names, in one domain?
    pub fn fits(&self, layout: &Layout) -> bool {
        match self {
            Self::Attribute(number) => *number < layout.attributes.len(),
            Self::Magnitude(numbers) => {
                let domain = |n: &usize| layout.attributes.get(*n).map(|a| a.1);
                let first = numbers.first().and_then(domain);
                first.is_some() && numbers.iter().all(|n| domain(n) == first)
            }
            Self::Normal(_) => layout.normals,
            Self::Along(_) | Self::Face => true,
            Self::Coordinate(axis) => *axis < 3,
            Self::Texcoord(k) => layout.texcoords && *k < 2,
            Self::Color(k, AttributeDomain::Vertex) => layout.vertex_colors && *k < 4,
            Self::Color(k, AttributeDomain::Triangle) => layout.face_colors && *k < 4,
        }
    }

    /// What its values are best kept less: the [offset](tercio_mesh::Attribute::offset) of the attribute.
    pub fn offset(&self, layout: &Layout) -> f64 {
        match self {
            Self::Attribute(number) => layout.offset(*number),
            Self::Magnitude(numbers) => length(numbers.iter().map(|&n| layout.offset(n))),
            _ => 0.0,
        }
    }

    /// Whether its values are at vertices or at triangles.
    ///
    /// # Panics
    /// If there is no such attribute.
    pub fn domain(&self, layout: &Layout) -> AttributeDomain {
        match self {
            Self::Attribute(number) => layout.attributes[*number].1,
            Self::Magnitude(numbers) => layout.attributes[numbers[0]].1,
            Self::Along(_) | Self::Normal(_) | Self::Coordinate(_) | Self::Texcoord(_) => {
                AttributeDomain::Vertex
            }
            Self::Face => AttributeDomain::Triangle,
            Self::Color(_, domain) => *domain,
        }
    }
}

/// The length of a vector.
fn length(components: impl Iterator<Item = f64>) -> f64 {
    components.map(|c| c * c).sum::<f64>().sqrt()
}

/// A [`DataSource`] made ready to be read, cluster by cluster, for one instance.
#[derive(Clone, Debug)]
pub struct DataReader {
    source: DataSource,
    /// Of the coordinate along a direction or an axis: its value at the mesh's origin, and its change along the axes of the mesh's positions.
    base: f64,
    slope: DVec3,
    /// Brings normals to world space.
    normals: DMat3,
    /// Of the whole model.
    first_face: u64,
    /// What values are less.
    offset: f64,
    /// What is added to the stored values of an attribute, or of the components of a vector, for the full ones, which are then less
    /// `offset`; none if the stored values are used as they are.
    own: Vec<f64>,
}

impl DataReader {
    /// For the mesh of an instance. Values are less the offset: [`DataSource::offset`], or the
    /// [`DataColors::offset`] of their colours. Attributes that have this offset are not rounded again.
    pub fn new(source: &DataSource, instance: &Instance, offset: f64) -> Self {
        let layout = instance.mesh.layout();
        let own = match source {
            DataSource::Attribute(n) if layout.offset(*n) != offset => vec![layout.offset(*n)],
            DataSource::Magnitude(all) if offset != 0.0 || all.iter().any(|&n| layout.offset(n) != 0.0) => {
                all.iter().map(|&n| layout.offset(n)).collect()
            }
            _ => Vec::new(),
        };
        let to_world = instance.world_from_object;
        let (mut base, mut slope) = (0.0, DVec3::ZERO);
        match source {
            DataSource::Along(direction) => {
                base = direction.dot(to_world.transform_point3(instance.mesh.origin)) - offset;
                slope = to_world.matrix3.transpose() * *direction * instance.mesh.unit();
            }
            DataSource::Coordinate(axis) => {
                base = instance.mesh.origin[*axis] - offset;
                slope[*axis] = instance.mesh.unit();
            }
            _ => {}
        }
        let m = to_world.matrix3;
        let normals = if m == DMat3::IDENTITY { m } else { m.inverse().transpose() };
        let first_face = instance.share.map_or(0, |share| share.first_face);
        Self { source: source.clone(), base, slope, normals, first_face, offset, own }
    }

    /// The value of a vertex of which a mesh holds this, and these attributes.
    pub fn of_vertex(&self, vertex: &Vertex, attribute: impl Fn(usize) -> f32) -> f32 {
        match &self.source {
            DataSource::Along(_) | DataSource::Coordinate(_) => {
                let [x, y, z] = vertex.position.map(f64::from);
                (self.base + ((x * self.slope.x + y * self.slope.y) + z * self.slope.z)) as f32
            }
            DataSource::Normal(axis) => {
                let Some(n) = vertex.normal else { return f32::NAN };
                let n = self.normals * DVec3::from(n.map(f64::from));
                (axis.dot(n) / n.length() - self.offset) as f32
            }
            DataSource::Texcoord(k) => vertex.texcoord.map_or(f32::NAN, |uv| self.less_offset(uv[*k])),
            DataSource::Color(k, _) => self.of_color(*k, vertex.color),
            _ => self.of_attributes(attribute),
        }
    }

    /// The value of a triangle of this input face of the mesh, with this colour of its own and these attributes.
    pub fn of_triangle(&self, face: u32, color: Option<[u8; 4]>, attribute: impl Fn(usize) -> f32) -> f32 {
        match &self.source {
            DataSource::Face => self.of_face(face),
            DataSource::Color(k, _) => self.of_color(*k, color),
            _ => self.of_attributes(attribute),
        }
    }

    fn less_offset(&self, value: f32) -> f32 {
        if self.offset == 0.0 { value } else { (f64::from(value) - self.offset) as f32 }
    }

    fn of_color(&self, component: usize, color: Option<[u8; 4]>) -> f32 {
        color.map_or(f32::NAN, |color| self.less_offset(color[component].into()))
    }

    #[inline]
    fn of_face(&self, face: u32) -> f32 {
        // Signed, which processors convert in one instruction.
        let number = (self.first_face + u64::from(face)) as i64;
        if self.offset == 0.0 { number as f32 } else { (number as f64 - self.offset) as f32 }
    }

    fn of_attributes(&self, attribute: impl Fn(usize) -> f32) -> f32 {
        match &self.source {
            DataSource::Attribute(number) => match self.own.first() {
                None => attribute(*number),
                Some(own) => (own + f64::from(attribute(*number)) - self.offset) as f32,
            },
            DataSource::Magnitude(numbers) if !self.own.is_empty() => {
                let full = numbers.iter().zip(&self.own).map(|(&n, own)| own + f64::from(attribute(n)));
                (length(full) - self.offset) as f32
            }
            DataSource::Magnitude(numbers) => {
                let square = |n: &usize| f64::from(attribute(*n)) * f64::from(attribute(*n));
                numbers.iter().map(square).sum::<f64>().sqrt() as f32
            }
            _ => f32::NAN,
        }
    }

    /// The values of the vertices of a cluster, not padded. Precondition: they are at vertices.
    pub fn read_vertices(&self, cluster: &ClusterView, to: &mut [f32]) {
        let count = cluster.vertices().min(to.len());
        if let (DataSource::Attribute(number), []) = (&self.source, &self.own[..]) {
            to[..count].copy_from_slice(&cluster.attribute(*number)[..count]);
            return;
        }
        let columns = Columns::new(&self.source, cluster);
        for (v, to) in to[..count].iter_mut().enumerate() {
            *to = self.of_vertex(&columns.vertex(v), |number| cluster.attribute(number)[v]);
        }
    }

    /// The value of one vertex of a cluster. Precondition: values are at vertices.
    pub fn vertex(&self, cluster: &ClusterView, v: usize) -> f32 {
        let vertex = Columns::new(&self.source, cluster).vertex(v);
        self.of_vertex(&vertex, |number| cluster.attribute(number)[v])
    }

    /// The value of a triangle, given by its number in a cluster, which has this number in the mesh. Precondition: values are at
    /// triangles.
    pub fn triangle(
        &self,
        mesh: &ClusteredMesh,
        number: usize,
        cluster: &ClusterView,
        triangle: usize,
    ) -> f32 {
        let face = if self.source == DataSource::Face { mesh.face(number, triangle) } else { 0 };
        let colors = cluster.face_colors().filter(|_| matches!(self.source, DataSource::Color(..)));
        self.of_triangle(face, colors.map(|c| c[triangle]), |number| cluster.attribute(number)[triangle])
    }

    /// The values of the triangles of a cluster, which has this number in the mesh, not padded. Precondition: they are at triangles.
    pub fn read_triangles(&self, mesh: &ClusteredMesh, number: usize, cluster: &ClusterView, to: &mut [f32]) {
        let count = cluster.triangles().min(to.len());
        if let (DataSource::Attribute(attribute), []) = (&self.source, &self.own[..]) {
            to[..count].copy_from_slice(&cluster.attribute(*attribute)[..count]);
            return;
        }
        if self.source == DataSource::Face {
            to[..count].iter_mut().zip(mesh.faces(number)).for_each(|(to, face)| *to = self.of_face(face));
            return;
        }
        for (triangle, to) in to[..count].iter_mut().enumerate() {
            *to = self.triangle(mesh, number, cluster, triangle);
        }
    }

    /// Whether vertices or triangles of a mesh have the values.
    pub fn domain(&self, mesh: &ClusteredMesh) -> AttributeDomain {
        self.source.domain(mesh.layout())
    }

    /// Calls `see` with the value of every vertex or triangle of a mesh, by cluster: vertices in several clusters are seen several
    /// times.
    pub fn each(&self, mesh: &ClusteredMesh, cluster: usize, mut see: impl FnMut(f32)) {
        let view = mesh.cluster(cluster);
        match self.domain(mesh) {
            AttributeDomain::Vertex => (0..view.vertices()).for_each(|v| see(self.vertex(&view, v))),
            AttributeDomain::Triangle => {
                (0..view.triangles()).for_each(|t| see(self.triangle(mesh, cluster, &view, t)));
            }
        }
    }
}

/// What a source needs of the vertices of a cluster besides attributes.
struct Columns<'a> {
    positions: [&'a [f32]; 3],
    normals: Option<&'a [OctNormal]>,
    texcoords: Option<[&'a [f32]; 2]>,
    colors: Option<&'a [[u8; 4]]>,
}

impl<'a> Columns<'a> {
    #[inline(always)]
    fn new(source: &DataSource, cluster: &ClusterView<'a>) -> Self {
        Self {
            positions: cluster.positions(),
            normals: cluster.normals().filter(|_| matches!(source, DataSource::Normal(_))),
            texcoords: cluster.texcoords().filter(|_| matches!(source, DataSource::Texcoord(_))),
            colors: cluster.vertex_colors().filter(|_| matches!(source, DataSource::Color(..))),
        }
    }

    #[inline(always)]
    fn vertex(&self, v: usize) -> Vertex {
        Vertex {
            position: self.positions.map(|axis| axis[v]),
            normal: self.normals.map(|n| n[v].decode()),
            texcoord: self.texcoords.map(|uv| uv.map(|k| k[v])),
            color: self.colors.map(|c| c[v]),
        }
    }
}
