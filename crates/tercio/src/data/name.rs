//! From a name to the data that it means.

use glam::DVec3;
use tercio_mesh::cluster::Layout;
use tercio_mesh::{Attribute, AttributeDomain};
use tercio_scene::DataSource;

use super::{DataError, own};

/// What a name means.
#[derive(Debug, PartialEq)]
pub enum Found {
    /// Values.
    Values(DataSource),
    /// Colours.
    Colors { components: Vec<DataSource>, kind: ColorKind },
}

/// What the components of colours are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorKind {
    /// 0 to 1, or 0 to 255 if any is above 1.
    OfData,
    /// 0 to 255.
    Bytes,
    /// From -1 to 1.
    Signed,
}

/// Names of the components of a vector.
const AXES: [&str; 4] = ["x", "y", "z", "w"];

/// Does this name need normals?
pub fn needs_normals(name: &str) -> bool {
    let usual = component_first(name);
    let (name, _) = selected(usual.as_deref().unwrap_or(name));
    let name = own::meaning(name).unwrap_or(name);
    name == "@normal" || name.starts_with("@normal:")
}

/// What surfaces of a mesh can be coloured by, in words.
pub fn available(layout: &Layout) -> Vec<String> {
    let domain = |d: AttributeDomain| if d == AttributeDomain::Vertex { "vertices" } else { "triangles" };
    let mut all: Vec<String> = Vec::new();
    let made = ["@elevation"].into_iter().chain(own::available(layout));
    let made = made.chain(["@normal", "@face", "@curvature", "@component"]);
    for (name, d) in layout.attributes.iter().filter(|(name, d)| !Attribute::is_polygon(name, *d)) {
        // Of the components of a vector, the vector is named once.
        let array = name.strip_suffix(":0").filter(|array| vector(array, layout).len() > 1);
        let is_other = name.rsplit_once(':').is_some_and(|(array, n)| {
            n != "0" && n.parse::<usize>().is_ok_and(|n| n < vector(array, layout).len())
        });
        match array {
            Some(array) => {
                let components = vector(array, layout);
                let own: Vec<&str> = components.iter().filter_map(|&n| layout.component(n)).collect();
                let own = if own.is_empty() { String::new() } else { format!(": {}", own.join(", ")) };
                all.push(format!("{array} ({}, {} components{own})", domain(*d), components.len()));
            }
            None if is_other => {}
            None => all.push(format!("{name} ({})", domain(*d))),
        }
    }
    let is_new = |name: &&str| !layout.attributes.iter().any(|(other, _)| other == name);
    all.extend(made.filter(is_new).map(String::from));
    all
}

/// The attributes that are the components of a vector: `NAME:0`, `NAME:1` and so on, or `NAME_x`, `NAME_y`, or `NAMEx`, `NAMEy`.
fn vector(name: &str, layout: &Layout) -> Vec<usize> {
    vector_of(name, None, layout)
}

/// `NAME@point:COMPONENT` as `NAME:COMPONENT@point`, which means the same; `None` for other names.
fn component_first(name: &str) -> Option<String> {
    ["@point", "@cell"].into_iter().find_map(|place| {
        let (array, component) = name.rsplit_once(':')?;
        Some(format!("{}:{component}{place}", array.strip_suffix(place)?))
    })
}

/// The name without `@point` or `@cell`, and what these select.
fn selected(name: &str) -> (&str, Option<AttributeDomain>) {
    if let Some(name) = name.strip_suffix("@point") {
        (name, Some(AttributeDomain::Vertex))
    } else if let Some(name) = name.strip_suffix("@cell") {
        (name, Some(AttributeDomain::Triangle))
    } else {
        (name, None)
    }
}

/// The components of a vector in two or three dimensions, for glyphs.
///
/// # Errors
/// [`DataError::Unknown`], with a list of the vectors that there are.
pub fn direction(name: &str, layout: &Layout) -> Result<Vec<usize>, DataError> {
    let (array, domain) = selected(name);
    let all = vector_of(array, domain, layout);
    if (2..=3).contains(&all.len()) {
        return Ok(all);
    }
    let mut there: Vec<String> = Vec::new();
    for (attribute, _) in &layout.attributes {
        let ends = [":0", "_0", "_x", "x"];
        let arrays = ends.iter().filter_map(|end| attribute.strip_suffix(end));
        let is_vector = |array: &&str| (2..=3).contains(&vector(array, layout).len());
        let new = arrays.filter(is_vector).find(|array| !there.iter().any(|t| t == array));
        there.extend(new.map(String::from));
    }
    if layout.normals {
        there.push("@normal".into());
    }
    Err(DataError::NoVector { name: name.into(), available: there })
}

fn vector_of(name: &str, only: Option<AttributeDomain>, layout: &Layout) -> Vec<usize> {
    type Naming = fn(&str, usize) -> String;
    let namings: [Naming; 4] = [
        |name, k| format!("{name}:{k}"),
        |name, k| format!("{name}_{k}"),
        |name, k| format!("{name}_{}", AXES.get(k).unwrap_or(&"?")),
        |name, k| format!("{name}{}", AXES.get(k).unwrap_or(&"?")),
    ];
    let find = |wanted: String, domain: Option<AttributeDomain>| {
        let at =
            |of: AttributeDomain| layout.attributes.iter().position(|(name, d)| *name == wanted && of == *d);
        match domain.or(only) {
            Some(domain) => at(domain),
            None => at(AttributeDomain::Vertex).or_else(|| at(AttributeDomain::Triangle)),
        }
    };
    for naming in namings {
        let Some(first) = find(naming(name, 0), None) else { continue };
        let domain = Some(layout.attributes[first].1);
        let rest = (1..).map_while(|k| find(naming(name, k), domain));
        let all: Vec<usize> = std::iter::once(first).chain(rest).collect();
        if all.len() > 1 {
            return all;
        }
    }
    Vec::new()
}

/// The data of a name.
///
/// # Errors
/// [`DataError::Unknown`], [`DataError::Component`], [`DataError::WhichComponent`], [`DataError::NoNormals`].
pub fn find(name: &str, layout: &Layout, up: DVec3) -> Result<Found, DataError> {
    let is_whole =
        layout.attributes.iter().any(|(known, d)| known == name && !Attribute::is_polygon(known, *d));
    if let Some(usual) = component_first(name).filter(|_| !is_whole) {
        return find(&usual, layout, up);
    }
    let (whole, (name, domain)) = (name, if is_whole { (name, None) } else { selected(name) });
    let attribute = |wanted: &str| {
        let at = |of: AttributeDomain| {
            let is_it =
                |(n, d): &(String, AttributeDomain)| n == wanted && *d == of && !Attribute::is_polygon(n, of);
            layout.attributes.iter().position(is_it)
        };
        match domain {
            Some(domain) => at(domain),
            None => at(AttributeDomain::Vertex).or_else(|| at(AttributeDomain::Triangle)),
        }
    };
    // A name may have a colon in it.
    if let Some(number) = attribute(name) {
        return Ok(Found::Values(DataSource::Attribute(number)));
    }
    let (array, component) = match name.rsplit_once(':') {
        Some((array, component)) => (array, Some(component)),
        None => (name, None),
    };
    if array.starts_with('@') {
        let is_elsewhere = domain.is_some_and(|domain| !has_made(array, domain));
        if is_elsewhere {
            return Err(DataError::Unknown { name: whole.into(), available: available(layout) });
        }
        let of_own = own::find(array, component, domain, layout)?;
        return of_own.map_or_else(|| made(whole, array, component, layout, up), Ok);
    }
    let all = vector_of(array, domain, layout);
    let single = attribute(array);
    let unknown = || DataError::Unknown { name: whole.into(), available: available(layout) };
    let values = |number: usize| Ok(Found::Values(DataSource::Attribute(number)));
    match (component, single) {
        (None, None) if !all.is_empty() => Ok(Found::Values(DataSource::Magnitude(all))),
        // What files call so is no attribute, but the mesh holds it.
        (None, _) => match own::meaning(name) {
            Some(meaning) => {
                let suffix = whole.strip_prefix(name).unwrap_or_default();
                find(&format!("{meaning}{suffix}"), layout, up).map_err(|_| unknown())
            }
            None => Err(unknown()),
        },
        (Some("0" | "magnitude"), Some(number)) => values(number),
        (Some("magnitude"), None) if !all.is_empty() => Ok(Found::Values(DataSource::Magnitude(all))),
        (Some("rgb" | "rgba" | "direct"), None) if (3..=4).contains(&all.len()) => {
            let components = all.into_iter().map(DataSource::Attribute).collect();
            Ok(Found::Colors { components, kind: ColorKind::OfData })
        }
        (Some(component), single) => {
            let axes = &AXES[..all.len().min(AXES.len())];
            // Names of the file go first.
            let number = all.iter().position(|&n| layout.component(n) == Some(component));
            let number = number.or_else(|| component.parse().ok());
            let number = number.or_else(|| axes.iter().position(|axis| *axis == component));
            if let Some(&attribute) = number.and_then(|number: usize| all.get(number)) {
                return values(attribute);
            }
            if all.is_empty() && single.is_none() {
                return Err(unknown());
            }
            if single.is_some_and(|n| layout.component(n) == Some(component)) {
                return single.map_or_else(|| Err(unknown()), values);
            }
            let own = all.iter().copied().chain(single).filter_map(|n| layout.component(n));
            let mut there: Vec<String> = own.map(String::from).collect();
            there.extend((0..all.len().max(1)).map(|k| k.to_string()));
            there.extend(axes.iter().filter(|_| all.len() <= AXES.len()).map(|&axis| axis.into()));
            there.push("magnitude".into());
            if (3..=4).contains(&all.len()) {
                there.push("rgb".into());
            }
            Err(DataError::Component { name: array.into(), component: component.into(), available: there })
        }
    }
}

/// Whether data that are made of the mesh itself are at its vertices or its triangles. Curvature and components are made only if they
/// are asked for by their names alone.
fn has_made(array: &str, domain: AttributeDomain) -> bool {
    match array {
        // Where the mesh has them.
        "@color" => true,
        "@face" => domain == AttributeDomain::Triangle,
        "@curvature" | "@component" => false,
        _ => domain == AttributeDomain::Vertex,
    }
}

/// Data that are made of the mesh itself.
fn made(
    name: &str,
    array: &str,
    component: Option<&str>,
    layout: &Layout,
    up: DVec3,
) -> Result<Found, DataError> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let axis =
        |component: &str| AXES.iter().zip(axes).find(|(name, _)| **name == component).map(|(_, axis)| axis);
    let no_component = |there: &[&str]| DataError::Component {
        name: array.into(),
        component: component.unwrap_or_default().into(),
        available: there.iter().map(|&c| c.into()).collect(),
    };
    match (array, component) {
        ("@elevation", None) => Ok(Found::Values(DataSource::Along(up))),
        ("@face", None) => Ok(Found::Values(DataSource::Face)),
        ("@normal", _) if !layout.normals => Err(DataError::NoNormals),
        ("@normal", None | Some("rgb")) => {
            let components = axes.map(DataSource::Normal).to_vec();
            Ok(Found::Colors { components, kind: ColorKind::Signed })
        }
        ("@normal", Some(component)) => match axis(component) {
            Some(axis) => Ok(Found::Values(DataSource::Normal(axis))),
            None => Err(no_component(&["x", "y", "z", "rgb"])),
        },
        ("@elevation" | "@face", Some(_)) => Err(no_component(&[])),
        ("@curvature" | "@component", None) => Err(DataError::NotMade(array.into())),
        _ => Err(DataError::Unknown { name: name.into(), available: available(layout) }),
    }
}
