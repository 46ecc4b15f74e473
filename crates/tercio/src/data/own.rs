//! Names of what a mesh holds in a form of its own, not as attributes: coordinates, normals, texture coordinates and colours.

use glam::DVec3;
use tercio_mesh::AttributeDomain;
use tercio_mesh::cluster::Layout;
use tercio_scene::DataSource;

use super::DataError;
use super::name::Found;

/// Names that files and other programs have for it, and what they mean where no attribute of the file has the name.
const PLAIN: [(&str, &str); 28] = [
    ("x", "@x"),
    ("y", "@y"),
    ("z", "@z"),
    ("nx", "@normal:x"),
    ("ny", "@normal:y"),
    ("nz", "@normal:z"),
    ("normal_x", "@normal:x"),
    ("normal_y", "@normal:y"),
    ("normal_z", "@normal:z"),
    ("r", "@color:red"),
    ("g", "@color:green"),
    ("b", "@color:blue"),
    ("red", "@color:red"),
    ("green", "@color:green"),
    ("blue", "@color:blue"),
    ("alpha", "@color:alpha"),
    ("rgb", "@color"),
    ("rgba", "@color:rgba"),
    ("u", "@texcoord:u"),
    ("v", "@texcoord:v"),
    ("s", "@texcoord:u"),
    ("t", "@texcoord:v"),
    ("texture_u", "@texcoord:u"),
    ("texture_v", "@texcoord:v"),
    ("texture_s", "@texcoord:u"),
    ("texture_t", "@texcoord:v"),
    ("s0", "@texcoord:u"),
    ("t0", "@texcoord:v"),
];

/// Components of colours.
const CHANNELS: [&str; 4] = ["red", "green", "blue", "alpha"];

/// What a plain name means.
pub fn meaning(name: &str) -> Option<&'static str> {
    PLAIN.iter().find(|(plain, _)| plain.eq_ignore_ascii_case(name)).map(|(_, meaning)| *meaning)
}

/// What a mesh has of it, in words.
pub fn available(layout: &Layout) -> impl Iterator<Item = &'static str> {
    let has_colors = layout.vertex_colors || layout.face_colors;
    let colors = has_colors.then_some("@color (red, green, blue, alpha)");
    let texcoords = layout.texcoords.then_some("@texcoord (u, v)");
    ["@x", "@y", "@z"].into_iter().chain(colors).chain(texcoords)
}

/// The data of a name without and with its component; `None` if it is none of these, or the mesh has no such data.
///
/// # Errors
/// [`DataError::Component`], [`DataError::WhichComponent`].
pub fn find(
    array: &str,
    component: Option<&str>,
    domain: Option<AttributeDomain>,
    layout: &Layout,
) -> Result<Option<Found>, DataError> {
    let no_component = |there: &[&str]| DataError::Component {
        name: array.into(),
        component: component.unwrap_or_default().into(),
        available: there.iter().map(|&c| c.into()).collect(),
    };
    let value = |source| Ok(Some(Found::Values(source)));
    match (array, component) {
        ("@x" | "@y" | "@z", Some(_)) => Err(no_component(&[])),
        ("@x", None) => value(DataSource::Coordinate(0)),
        ("@y", None) => value(DataSource::Coordinate(1)),
        ("@z", None) => value(DataSource::Coordinate(2)),
        ("@texcoord", _) if !layout.texcoords => Ok(None),
        ("@texcoord", Some("u" | "s" | "0")) => value(DataSource::Texcoord(0)),
        ("@texcoord", Some("v" | "t" | "1")) => value(DataSource::Texcoord(1)),
        ("@texcoord", None) => Err(DataError::WhichComponent {
            name: array.into(),
            available: ["@texcoord:u", "@texcoord:v"].map(String::from).to_vec(),
        }),
        ("@texcoord", Some(_)) => Err(no_component(&["u", "v"])),
        ("@color", _) => {
            let has = |of: AttributeDomain| match of {
                AttributeDomain::Vertex => layout.vertex_colors,
                AttributeDomain::Triangle => layout.face_colors,
            };
            let wanted = match domain {
                Some(domain) => vec![domain],
                None => vec![AttributeDomain::Vertex, AttributeDomain::Triangle],
            };
            let Some(domain) = wanted.into_iter().find(|&of| has(of)) else { return Ok(None) };
            color(component, domain).map(Some).ok_or_else(|| {
                no_component(&["red", "green", "blue", "alpha", "r", "g", "b", "a", "rgb", "rgba"])
            })
        }
        _ => Ok(None),
    }
}

/// Colours, or one of their components.
fn color(component: Option<&str>, domain: AttributeDomain) -> Option<Found> {
    let all = |count: usize| Found::Colors {
        components: (0..count).map(|k| DataSource::Color(k, domain)).collect(),
        kind: super::name::ColorKind::Bytes,
    };
    match component {
        None | Some("rgb") => Some(all(3)),
        Some("rgba") => Some(all(4)),
        Some(component) => {
            let is_it = |(k, name): (usize, &&str)| {
                *name == component || name[..1] == *component || k.to_string() == component
            };
            let number = CHANNELS.iter().enumerate().position(is_it)?;
            Some(Found::Values(DataSource::Color(number, domain)))
        }
    }
}

/// What values along an axis are best kept less: the origin of the mesh, beside which its vertices are.
pub fn offset(source: &DataSource, origin: DVec3) -> Option<f64> {
    match source {
        DataSource::Coordinate(axis) => Some(origin[*axis]),
        _ => None,
    }
}
