//! Types of cells, and the faces of those with a volume.
//!
//! Source: VTK, `vtkCellType.h` and the classes of the cells. Faces are wound counter-clockwise seen from outside.

/// What a cell is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Empty,
    /// Each node a point.
    Points,
    /// Nodes in the order of the line.
    Line,
    /// Nodes that belong between the ends, in their order along the line, come after them.
    CurvedLine,
    Strip,
    /// A polygon of any number of corners.
    Polygon,
    /// Four corners row by row.
    Pixel,
    /// A face with so many corners, and nodes between them.
    Face {
        corners: u8,
        nodes: u8,
    },
    /// As many nodes between corners as corners.
    QuadraticPolygon,
    Volume(&'static Volume),
    Polyhedron,
    /// Of a higher order, with the corners first: drawn as this type.
    HigherOrder(u8),
    Unsupported(&'static str),
}

/// A cell with a volume.
#[derive(Debug, PartialEq, Eq)]
pub struct Volume {
    pub nodes: u8,
    pub faces: &'static [Face],
}

/// Corners of a face, and all of its nodes: the corners, the nodes between them, and the one in the middle.
#[derive(Debug, PartialEq, Eq)]
pub struct Face {
    pub corners: u8,
    pub nodes: &'static [u8],
}

const fn face(corners: u8, nodes: &'static [u8]) -> Face {
    Face { corners, nodes }
}

macro_rules! volume {
    ($name:ident, $nodes:literal, $($corners:literal $face:expr),+ $(,)?) => {
        static $name: Volume = Volume { nodes: $nodes, faces: &[$(face($corners, &$face)),+] };
    };
}

volume!(TETRA, 4, 3 [0, 1, 3], 3 [1, 2, 3], 3 [2, 0, 3], 3 [0, 2, 1]);
volume!(VOXEL, 8, 4 [2, 0, 4, 6], 4 [1, 3, 7, 5], 4 [0, 1, 5, 4], 4 [3, 2, 6, 7], 4 [1, 0, 2, 3], 4 [4, 5, 7, 6]);
volume!(HEXAHEDRON, 8, 4 [0, 4, 7, 3], 4 [1, 2, 6, 5], 4 [0, 1, 5, 4], 4 [3, 7, 6, 2], 4 [0, 3, 2, 1], 4 [4, 5, 6, 7]);
volume!(WEDGE, 6, 3 [0, 1, 2], 3 [3, 5, 4], 4 [0, 3, 4, 1], 4 [1, 4, 5, 2], 4 [2, 5, 3, 0]);
volume!(PYRAMID, 5, 4 [0, 3, 2, 1], 3 [0, 1, 4], 3 [1, 2, 4], 3 [2, 3, 4], 3 [3, 0, 4]);
volume!(
    PENTAGONAL_PRISM, 10,
    5 [0, 4, 3, 2, 1], 5 [5, 6, 7, 8, 9], 4 [0, 1, 6, 5], 4 [1, 2, 7, 6], 4 [2, 3, 8, 7], 4 [3, 4, 9, 8], 4 [4, 0, 5, 9],
);
volume!(
    HEXAGONAL_PRISM, 12,
    6 [0, 5, 4, 3, 2, 1], 6 [6, 7, 8, 9, 10, 11], 4 [0, 1, 7, 6], 4 [1, 2, 8, 7], 4 [2, 3, 9, 8], 4 [3, 4, 10, 9],
    4 [4, 5, 11, 10], 4 [5, 0, 6, 11],
);
volume!(
    QUADRATIC_TETRA, 10,
    3 [0, 1, 3, 4, 8, 7], 3 [1, 2, 3, 5, 9, 8], 3 [2, 0, 3, 6, 7, 9], 3 [0, 2, 1, 6, 5, 4],
);
volume!(
    QUADRATIC_HEXAHEDRON, 20,
    4 [0, 4, 7, 3, 16, 15, 19, 11], 4 [1, 2, 6, 5, 9, 18, 13, 17], 4 [0, 1, 5, 4, 8, 17, 12, 16],
    4 [3, 7, 6, 2, 19, 14, 18, 10], 4 [0, 3, 2, 1, 11, 10, 9, 8], 4 [4, 5, 6, 7, 12, 13, 14, 15],
);
volume!(
    TRIQUADRATIC_HEXAHEDRON, 27,
    4 [0, 4, 7, 3, 16, 15, 19, 11, 20], 4 [1, 2, 6, 5, 9, 18, 13, 17, 21], 4 [0, 1, 5, 4, 8, 17, 12, 16, 22],
    4 [3, 7, 6, 2, 19, 14, 18, 10, 23], 4 [0, 3, 2, 1, 11, 10, 9, 8, 24], 4 [4, 5, 6, 7, 12, 13, 14, 15, 25],
);
volume!(
    BIQUADRATIC_QUADRATIC_HEXAHEDRON, 24,
    4 [0, 4, 7, 3, 16, 15, 19, 11, 20], 4 [1, 2, 6, 5, 9, 18, 13, 17, 21], 4 [0, 1, 5, 4, 8, 17, 12, 16, 22],
    4 [3, 7, 6, 2, 19, 14, 18, 10, 23], 4 [0, 3, 2, 1, 11, 10, 9, 8], 4 [4, 5, 6, 7, 12, 13, 14, 15],
);
volume!(
    QUADRATIC_WEDGE, 15,
    3 [0, 1, 2, 6, 7, 8], 3 [3, 5, 4, 11, 10, 9], 4 [0, 3, 4, 1, 12, 9, 13, 6], 4 [1, 4, 5, 2, 13, 10, 14, 7],
    4 [2, 5, 3, 0, 14, 11, 12, 8],
);
volume!(
    QUADRATIC_LINEAR_WEDGE, 12,
    3 [0, 1, 2, 6, 7, 8], 3 [3, 5, 4, 11, 10, 9], 4 [1, 0, 3, 4, 6, 9], 4 [2, 1, 4, 5, 7, 10], 4 [0, 2, 5, 3, 8, 11],
);
volume!(
    BIQUADRATIC_QUADRATIC_WEDGE, 18,
    3 [0, 1, 2, 6, 7, 8], 3 [3, 5, 4, 11, 10, 9], 4 [0, 3, 4, 1, 12, 9, 13, 6, 15], 4 [1, 4, 5, 2, 13, 10, 14, 7, 16],
    4 [2, 5, 3, 0, 14, 11, 12, 8, 17],
);
volume!(
    QUADRATIC_PYRAMID, 13,
    4 [0, 3, 2, 1, 8, 7, 6, 5], 3 [0, 1, 4, 5, 10, 9], 3 [1, 2, 4, 6, 11, 10], 3 [2, 3, 4, 7, 12, 11],
    3 [3, 0, 4, 8, 9, 12],
);
volume!(
    TRIQUADRATIC_PYRAMID, 19,
    4 [0, 3, 2, 1, 8, 7, 6, 5, 13], 3 [0, 1, 4, 5, 10, 9, 14], 3 [1, 2, 4, 6, 11, 10, 15],
    3 [2, 3, 4, 7, 12, 11, 16], 3 [3, 0, 4, 8, 9, 12, 17],
);

pub const VERTEX: u8 = 1;
pub const POLY_VERTEX: u8 = 2;
pub const LINE: u8 = 3;
pub const POLY_LINE: u8 = 4;
pub const TRIANGLE: u8 = 5;
pub const STRIP: u8 = 6;
pub const POLYGON: u8 = 7;
pub const PIXEL: u8 = 8;
pub const QUAD: u8 = 9;
pub const HEXAHEDRON_CELL: u8 = 12;
pub const POLYHEDRON: u8 = 42;

/// The shape of a type; `None` if VTK has no such type.
pub fn shape(cell_type: u8) -> Option<Shape> {
    use Shape::{
        CurvedLine, Empty, Face, HigherOrder, Line, Pixel, Points, Polygon, Polyhedron, QuadraticPolygon,
        Strip, Unsupported, Volume,
    };
    Some(match cell_type {
        0 => Empty,
        VERTEX | POLY_VERTEX => Points,
        LINE | POLY_LINE => Line,
        TRIANGLE => Face { corners: 3, nodes: 3 },
        STRIP => Strip,
        POLYGON => Polygon,
        PIXEL => Pixel,
        QUAD => Face { corners: 4, nodes: 4 },
        10 => Volume(&TETRA),
        11 => Volume(&VOXEL),
        HEXAHEDRON_CELL => Volume(&HEXAHEDRON),
        13 => Volume(&WEDGE),
        14 => Volume(&PYRAMID),
        15 => Volume(&PENTAGONAL_PRISM),
        16 => Volume(&HEXAGONAL_PRISM),
        21 | 35 => CurvedLine,
        22 => Face { corners: 3, nodes: 6 },
        23 => Face { corners: 4, nodes: 8 },
        24 => Volume(&QUADRATIC_TETRA),
        25 => Volume(&QUADRATIC_HEXAHEDRON),
        26 => Volume(&QUADRATIC_WEDGE),
        27 => Volume(&QUADRATIC_PYRAMID),
        28 => Face { corners: 4, nodes: 9 },
        29 => Volume(&TRIQUADRATIC_HEXAHEDRON),
        30 => Face { corners: 4, nodes: 6 },
        31 => Volume(&QUADRATIC_LINEAR_WEDGE),
        32 => Volume(&BIQUADRATIC_QUADRATIC_WEDGE),
        33 => Volume(&BIQUADRATIC_QUADRATIC_HEXAHEDRON),
        34 => Face { corners: 3, nodes: 7 },
        36 => QuadraticPolygon,
        37 => Volume(&TRIQUADRATIC_PYRAMID),
        41 => Unsupported("a convex point set"),
        POLYHEDRON => Polyhedron,
        51..=56 => Unsupported("a parametric curve, surface or region"),
        60..=67 => Unsupported("a higher-order cell without a known order of its nodes"),
        68 | 75 => HigherOrder(LINE),
        69 | 76 => HigherOrder(TRIANGLE),
        70 | 77 => HigherOrder(QUAD),
        71 | 78 => HigherOrder(10),
        72 | 79 => HigherOrder(HEXAHEDRON_CELL),
        73 | 80 => HigherOrder(13),
        74 | 81 => HigherOrder(14),
        _ => return None,
    })
}

impl Shape {
    /// Nodes of a cell, least and most.
    pub fn nodes(self) -> (usize, usize) {
        let exactly = |n: u8| (n.into(), n.into());
        match self {
            Self::Face { nodes, .. } => exactly(nodes),
            Self::Volume(volume) => exactly(volume.nodes),
            Self::Pixel => exactly(4),
            Self::HigherOrder(linear) => match shape(linear) {
                Some(Self::Line) => (2, usize::MAX),
                Some(linear) => (linear.nodes().0, usize::MAX),
                None => (0, usize::MAX),
            },
            Self::CurvedLine => (3, 4),
            _ => (0, usize::MAX),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every edge of a closed surface is walked once in each direction, and corners come before other nodes.
    #[test]
    fn faces_of_volumes_are_closed_and_wound_alike() {
        let mut volumes = 0;
        for cell_type in 0..=255 {
            let Some(Shape::Volume(volume)) = shape(cell_type) else { continue };
            volumes += 1;
            let mut edges = Vec::new();
            for face in volume.faces {
                let n = face.corners as usize;
                let (corners, between) = face.nodes.split_at(n);
                assert!(face.nodes.iter().all(|&node| node < volume.nodes), "{cell_type}");
                for i in 0..n {
                    let mid = match (between.len(), n) {
                        (0, _) => None,
                        // Only the first edge and the one opposite have a node.
                        (2, 4) => (i % 2 == 0).then(|| between[i / 2]),
                        _ => Some(between[i]),
                    };
                    edges.push((corners[i], corners[(i + 1) % n], mid));
                }
            }
            for &(a, b, mid) in &edges {
                let back = edges.iter().filter(|&&e| e == (b, a, mid)).count();
                let again = edges.iter().filter(|&&e| e == (a, b, mid)).count();
                assert_eq!((back, again), (1, 1), "{cell_type}: edge {a}-{b} by {mid:?}");
            }
        }
        assert_eq!(volumes, 16);
    }
}
