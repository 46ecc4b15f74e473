//! Which properties of an element are kept, and as what.

use super::header::{Element, Encoding, Header, Scalar, Shape};
use super::malformed;
use crate::error::{Place, ReadError, counted, expected_vertex};
use crate::mesh::MAX_ELEMENTS;

/// The role of an element in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Vertices,
    Faces,
    /// Triangle strips; -1 begins a new one.
    Strips,
    /// Edges: lines between two vertices.
    Lines,
    /// Skipped.
    Skipped,
}

/// The meaning of scalar properties.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Positions that `f32` holds without loss.
    Points32,
    Points64,
    Normals,
    Colors,
    Texcoords,
    Attribute,
    /// Values of which `f32` may not hold all.
    Attribute64,
}

impl Kind {
    /// Bytes of one value in memory.
    pub(super) fn size(self) -> u64 {
        match self {
            Self::Points32 => 12,
            Self::Points64 => 24,
            Self::Normals | Self::Colors | Self::Attribute => 4,
            Self::Texcoords | Self::Attribute64 => 8,
        }
    }
}

/// Scalar properties that are kept together.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub(super) kind: Kind,
    pub(super) name: String,
    /// Their indices among the element's properties.
    pub(super) properties: Vec<usize>,
    /// Factor that scales a colour to 0 to 255; 1 for everything else.
    pub(super) scale: f64,
}

impl Field {
    /// Values of one instance before its properties are filled in: a missing alpha is opaque.
    #[inline]
    pub(super) fn blank(&self) -> [f64; 4] {
        [0.0, 0.0, 0.0, 255.0 / self.scale]
    }
}

/// What is kept of one element.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) role: Role,
    pub(super) rows: usize,
    pub(super) fields: Vec<Field>,
    /// Index of the list of vertex numbers.
    pub(super) corners: Option<usize>,
    /// Index of the list of texture coordinates, a pair per corner.
    pub(super) wedges: Option<usize>,
    /// Number of vertices, the upper bound of vertex numbers.
    pub(super) vertices: u32,
}

impl Plan {
    /// The vertex number of a value; `u32::MAX` for the restart of a strip.
    #[inline]
    pub(super) fn vertex(&self, value: f64) -> Option<u32> {
        // The cast saturates, so a negative, fractional, NaN or too large value does not compare equal after the
        // conversion back.
        let number = value as u32;
        if f64::from(number) == value && number < self.vertices {
            Some(number)
        } else if value == -1.0 && self.role == Role::Strips {
            Some(u32::MAX)
        } else {
            None
        }
    }

    /// Describes the vertex numbers that [`Plan::vertex`] accepts, for errors.
    pub(super) fn expected_vertex(&self) -> String {
        expected_vertex(self.vertices.into())
    }

    /// Bytes of memory for the scalar properties.
    pub(super) fn field_bytes(&self) -> u64 {
        self.rows as u64 * self.fields.iter().map(|f| f.kind.size()).sum::<u64>()
    }
}

pub(super) const INDEX_LISTS: [&str; 3] = ["vertex_indices", "vertex_index", "vertex_indexes"];
const COLORS: [[&str; 4]; 3] = [
    ["red", "green", "blue", "alpha"],
    ["diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"],
    ["r", "g", "b", "a"],
];
const TEXCOORDS: [[&str; 2]; 4] =
    [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];

/// Plans all elements and checks their counts against the limits and the bytes left in the file.
pub(super) fn make(
    file: &str,
    header: &Header,
    bytes: &[u8],
    warnings: &mut Vec<String>,
) -> Result<Vec<Plan>, ReadError> {
    let vertices = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut left = (bytes.len() - header.body) as u64;
    if header.encoding == Encoding::Ascii {
        // The last number needs no separator after it.
        left += 1;
    }
    let mut plans: Vec<Plan> = Vec::new();
    let (mut elements, mut lists) = (Ignored::default(), Ignored::default());
    for element in &header.elements {
        let role = match element.name.as_str() {
            "vertex" => Role::Vertices,
            "face" => Role::Faces,
            "tristrips" => Role::Strips,
            "edge" if lines(element).is_some() && plans.iter().all(|p| p.role != Role::Lines) => Role::Lines,
            _ => Role::Skipped,
        };
        let place = Place::Line(element.line);
        if role != Role::Skipped && plans.iter().any(|p| p.role == role) {
            let found = format!("a second element {}", element.name);
            return Err(malformed(file, place, "each element once", found));
        }
        let what = match role {
            Role::Vertices => "vertices",
            Role::Strips => "triangle strips",
            Role::Lines => "edges",
            _ => "faces",
        };
        if role != Role::Skipped && element.count > MAX_ELEMENTS {
            return Err(ReadError::TooMany { file: file.into(), what, count: element.count });
        }
        let least = element.least_bytes(header.encoding);
        match least.checked_mul(element.count).and_then(|needed| left.checked_sub(needed)) {
            Some(rest) => left = rest,
            None => {
                let expected = format!(
                    "at least {least} bytes for each of {} instances of element {}",
                    element.count, element.name
                );
                return Err(malformed(file, place, expected, format!("{left} bytes left for them")));
            }
        }
        let mut plan = Plan {
            role,
            // Bounded by the bytes left, so it fits; instances without bytes need no rows.
            rows: if least == 0 { 0 } else { element.count as usize },
            fields: Vec::new(),
            corners: None,
            wedges: None,
            vertices: vertices as u32,
        };
        match role {
            Role::Vertices => plan.fields = vertex_fields(file, element)?,
            Role::Faces => {
                plan.corners = element.list(&INDEX_LISTS);
                plan.wedges = element.list(&["texcoord"]);
                plan.fields = face_fields(element);
            }
            Role::Strips => plan.corners = element.list(&INDEX_LISTS),
            Role::Lines => plan.fields.extend(lines(element)),
            // Edges that name no vertices are counted as ignored lines.
            Role::Skipped if element.name != "edge" && element.count > 0 => {
                elements.warn(warnings, || {
                    format!("ignored {} of element {}", counted(element.count, "instance"), element.name)
                });
            }
            Role::Skipped => {}
        }
        if matches!(role, Role::Faces | Role::Strips) && plan.corners.is_none() && element.count > 0 {
            let expected = format!("a list property vertex_indices in element {}", element.name);
            return Err(malformed(file, place, expected, "none"));
        }
        if role != Role::Skipped && element.count > 0 {
            for (i, property) in element.properties.iter().enumerate() {
                let kept = plan.corners == Some(i) || plan.wedges == Some(i);
                if matches!(property.shape, Shape::List { .. }) && !kept {
                    lists.warn(warnings, || {
                        format!("the list property {} of {} is ignored", property.name, element.name)
                    });
                }
            }
        }
        plans.push(plan);
    }
    elements.finish(warnings, ["element", "elements"]);
    lists.finish(warnings, ["list property", "list properties"]);
    Ok(plans)
}

fn vertex_fields(file: &str, element: &Element) -> Result<Vec<Field>, ReadError> {
    let mut fields = Vec::new();
    let Some(points) = field(element, Kind::Points32, &["x", "y", "z"], 3) else {
        if element.count == 0 {
            return Ok(fields);
        }
        let place = Place::Line(element.line);
        return Err(malformed(file, place, "the properties x, y and z in element vertex", "not all of them"));
    };
    let wide = |&i: &usize| matches!(element.properties.get(i).map(|p| p.shape), Some(Shape::One(scalar)) if is_wide(scalar));
    let kind = if points.properties.iter().any(wide) { Kind::Points64 } else { Kind::Points32 };
    fields.push(Field { kind, ..points });
    fields.extend(field(element, Kind::Normals, &["nx", "ny", "nz"], 3));
    fields.extend(colors(element));
    fields.extend(TEXCOORDS.iter().find_map(|names| field(element, Kind::Texcoords, names, 2)));
    add_attributes(element, &mut fields);
    Ok(fields)
}

/// Does `f32` not hold all numbers of a type?
fn is_wide(scalar: Scalar) -> bool {
    matches!(scalar, Scalar::F64 | Scalar::I32 | Scalar::U32)
}

/// Both vertex numbers of an edge, as a field of two numbers.
fn lines(element: &Element) -> Option<Field> {
    field(element, Kind::Points64, &["vertex1", "vertex2"], 2)
}

fn face_fields(element: &Element) -> Vec<Field> {
    let mut fields = Vec::from_iter(colors(element));
    add_attributes(element, &mut fields);
    fields
}

/// The properties of these names, if the first `needed` of them exist.
fn field(element: &Element, kind: Kind, names: &[&str], needed: usize) -> Option<Field> {
    let found: Vec<usize> =
        names.iter().map_while(|name| element.scalar(name)).map(|(index, _)| index).collect();
    let name = names.first().map_or("", |n| *n).into();
    (found.len() >= needed).then_some(Field { kind, name, properties: found, scale: 1.0 })
}

fn colors(element: &Element) -> Option<Field> {
    let mut colors = COLORS.iter().find_map(|names| field(element, Kind::Colors, names, 3))?;
    let first = colors.properties.first().and_then(|&i| element.properties.get(i))?;
    colors.scale = match first.shape {
        Shape::One(Scalar::F32 | Scalar::F64) => 255.0,
        Shape::One(Scalar::U16 | Scalar::I16) => 255.0 / 65535.0,
        _ => 1.0,
    };
    Some(colors)
}

/// Keeps every scalar that has no other meaning as an attribute.
fn add_attributes(element: &Element, fields: &mut Vec<Field>) {
    let mut used = vec![false; element.properties.len()];
    for &i in fields.iter().flat_map(|f| &f.properties) {
        if let Some(used) = used.get_mut(i) {
            *used = true;
        }
    }
    for ((i, property), used) in element.properties.iter().enumerate().zip(used) {
        let Shape::One(scalar) = property.shape else { continue };
        if !used {
            let kind = if is_wide(scalar) { Kind::Attribute64 } else { Kind::Attribute };
            fields.push(Field { kind, name: property.name.clone(), properties: vec![i], scale: 1.0 });
        }
    }
}

/// Warnings about ignored items: the first few by name, the others as a number.
#[derive(Default)]
struct Ignored {
    reported: usize,
    more: u64,
}

impl Ignored {
    fn warn(&mut self, warnings: &mut Vec<String>, text: impl FnOnce() -> String) {
        const MOST: usize = 8;
        if self.reported < MOST {
            self.reported += 1;
            warnings.push(text());
        } else {
            self.more += 1;
        }
    }

    fn finish(self, warnings: &mut Vec<String>, [one, many]: [&str; 2]) {
        if self.more > 0 {
            let what = if self.more == 1 { one } else { many };
            warnings.push(format!("ignored {} more {what}", self.more));
        }
    }
}
