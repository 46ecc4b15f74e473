//! Converts tables to a mesh.

use std::collections::HashSet;
use std::path::Path;
use std::sync::atomic::AtomicU64;

use crate::loops::prelude::*;

use super::Job;
use super::faces::{Triangles, from_faces, from_strips};
use super::header::Header;
use super::plan::{Plan, Role};
use super::table::{Column, Table};
use super::wedges;
use crate::doubles::{Doubles, all_stored};
use crate::error::{ReadError, counted, ignored_empty_faces};
use crate::io::{ReadModel, ReadReport, companions};
use crate::mesh::{MAX_ELEMENTS, localize_at, localize_single_at};
use crate::strokes::Strokes;
use crate::{Aabb, Attribute, AttributeDomain, FileMaterial, FileTexture, FileTextures, Mesh};

/// Assembles the mesh.
pub(super) fn model(
    job: &Job,
    header: &Header,
    plans: Vec<Plan>,
    tables: Vec<Table>,
    folder: Option<&Path>,
) -> Result<ReadModel, ReadError> {
    let (mut mesh, mut report, mut coordinates) = (Mesh::default(), ReadReport::default(), Aabb::EMPTY);
    let of_role = |wanted: Role, tables: &mut Vec<(Plan, Table)>| {
        tables.iter().position(|(p, _)| p.role == wanted).map(|i| tables.swap_remove(i))
    };
    let mut tables: Vec<(Plan, Table)> = plans.into_iter().zip(tables).collect();
    let edges = header.elements.iter().filter(|e| e.name == "edge").map(|e| e.count);
    report.not_drawn.lines = edges.fold(0, u64::saturating_add);
    if let Some(folder) = folder {
        companions::note(&mut report.companions, folder, header.textures.iter());
    }

    if let Some((plan, table)) = of_role(Role::Vertices, &mut tables) {
        coordinates = vertices(job, &mut mesh, &plan, table)?;
    }
    let mut triangles = Triangles::default();
    let mut faces = 0;
    if let Some((plan, mut table)) = of_role(Role::Faces, &mut tables) {
        if table.lists.iter().any(|l| !l.wedges.is_empty()) {
            split_wedges(job, &mut mesh, &mut table)?;
        }
        faces = plan.rows as u32;
        report.faces = plan.rows as u64;
        triangles = from_faces(job, &mesh.positions, &mut table)?;
        let columns = std::mem::take(&mut table.columns);
        face_columns(job, &mut mesh, &plan, columns, &triangles)?;
        let [empty, points, lines] = triangles.small;
        report.not_drawn.points += points;
        report.not_drawn.lines = report.not_drawn.lines.saturating_add(lines);
        report.faces -= empty + points + lines;
        if empty > 0 {
            job.warn(ignored_empty_faces(empty));
        }
    }
    if let Some((_, table)) = of_role(Role::Strips, &mut tables) {
        let before = triangles.list.len();
        from_strips(job, &table, &mut triangles.list)?;
        let added = triangles.list.len() - before;
        report.faces += added as u64;
        if let Some(ids) = &mut triangles.face_of_triangle {
            ids.extend((0..added as u32).map(|i| faces.saturating_add(i)));
        }
        // Strips carry no values of their own.
        if let Some(colors) = &mut mesh.face_colors {
            colors.resize(triangles.list.len(), [255; 4]);
        }
        for attribute in mesh.attributes.iter_mut().filter(|a| a.domain == AttributeDomain::Triangle) {
            attribute.values.resize(triangles.list.len(), 0.0);
        }
    }
    if triangles.list.len() as u64 > MAX_ELEMENTS {
        let count = triangles.list.len() as u64;
        return Err(ReadError::TooMany { file: job.file.into(), what: "triangles", count });
    }
    mesh.triangles = triangles.list;
    mesh.face_of_triangle = triangles.face_of_triangle;
    materials(job, header, &mut mesh)?;
    if mesh.materials.is_empty() {
        // Without texture coordinates they cannot be drawn.
        report.not_drawn.textures = header.textures.iter().collect::<HashSet<_>>().len() as u64;
    }
    let mut strokes = Strokes::default();
    if let Some((_, table)) = of_role(Role::Lines, &mut tables) {
        strokes = lines(job, &mesh, table)?;
    }
    Ok(ReadModel { mesh, strokes, coordinates, report })
}

/// The lines of an edge element.
fn lines(job: &Job, mesh: &Mesh, table: Table) -> Result<Strokes, ReadError> {
    let vertices = mesh.positions.len();
    let number = |v: f64| Some(v as u32).filter(|&n| f64::from(n) == v && (n as usize) < vertices);
    let mut segments = Vec::new();
    for column in table.columns {
        let Column::Points64(rows) = column else { continue };
        job.reserve("edges", 8 * rows.len() as u64 + 20 * vertices as u64)?;
        let all = rows.len();
        segments.extend(rows.into_iter().filter_map(|[a, b, _]| Some([number(a)?, number(b)?])));
        let broken = (all - segments.len()) as u64;
        if broken > 0 {
            let name = if broken == 1 {
                "names a vertex that does not exist"
            } else {
                "name vertices that do not exist"
            };
            job.warn(format!("ignored {}, which {name}", counted(broken, "edge")));
        }
    }
    Ok(Strokes::of_vertices(mesh, segments, Vec::new()))
}

/// Returns the bounds of the coordinates.
fn vertices(job: &Job, mesh: &mut Mesh, plan: &Plan, table: Table) -> Result<Aabb, ReadError> {
    let (mut coordinates, origin) = (Aabb::EMPTY, job.options.origin);
    for (field, column) in plan.fields.iter().zip(table.columns) {
        match column {
            Column::Points32(points) => {
                (coordinates, mesh.origin, mesh.positions) = localize_single_at(points, origin);
            }
            Column::Points64(points) => {
                job.reserve("positions", 12 * points.len() as u64)?;
                (coordinates, mesh.origin, mesh.positions) = localize_at(&points, origin);
            }
            Column::Normals(normals) => mesh.normals = Some(normals),
            Column::Colors(colors, broken) => {
                warn_of_colors(job, broken, "vertices");
                mesh.vertex_colors = Some(colors);
            }
            Column::Texcoords(texcoords) => mesh.texcoords = Some(texcoords),
            Column::Attribute(values) => {
                let name = field.name.clone();
                mesh.attributes.push(Attribute {
                    name,
                    domain: AttributeDomain::Vertex,
                    values,
                    offset: 0.0,
                    component: None,
                });
            }
            Column::Attribute64(values) => {
                let (values, offset) = narrow(job, &field.name, values)?;
                let name = field.name.clone();
                mesh.attributes.push(Attribute {
                    name,
                    domain: AttributeDomain::Vertex,
                    values,
                    offset,
                    component: None,
                });
            }
        }
    }
    Ok(coordinates)
}

/// Values as `f32`, and their offset.
fn narrow(job: &Job, name: &str, values: Vec<f64>) -> Result<(Vec<f32>, f64), ReadError> {
    job.reserve("values", 4 * values.len() as u64)?;
    let doubles = Doubles::of(&values);
    doubles.warning(name, false).into_iter().for_each(|warning| job.warn(warning));
    let (offset, warning) = doubles.offset_for(name, job.options.is_part);
    warning.into_iter().for_each(|warning| job.warn(warning));
    Ok((all_stored(&values, offset), offset))
}

fn warn_of_colors(job: &Job, broken: AtomicU64, whose: &str) {
    let broken = broken.into_inner();
    if broken > 0 {
        job.warn(format!("set {} of {whose} that were not finite to white", counted(broken, "colour")));
    }
}

fn split_wedges(job: &Job, mesh: &mut Mesh, table: &mut Table) -> Result<(), ReadError> {
    fn repeat<T: Copy>(values: &mut Vec<T>, copied: &[u32]) {
        let copies: Vec<T> = copied.iter().filter_map(|&v| values.get(v as usize).copied()).collect();
        values.extend(copies);
    }
    let vertices = mesh.positions.len();
    // In the worst case every corner is a copy.
    let corners: u64 = table.lists.iter().map(|l| l.corners.len() as u64).sum();
    job.reserve("texture coordinates at corners", 12 * vertices as u64 + 16 * corners)?;
    let Some(split) = wedges::split(&mut table.lists, vertices) else {
        let count = vertices as u64 + corners;
        return Err(ReadError::TooMany { file: job.file.into(), what: "vertices", count });
    };
    let without = split.faces_without;
    if without > 0 {
        let (have, their) = if without == 1 { ("has", "its") } else { ("have", "their") };
        let faces = counted(without, "face");
        job.warn(format!("{faces} {have} no texture coordinates at {their} corners"));
    }
    let of_one = 32 + 8 * mesh.attributes.len() as u64;
    job.reserve("vertices copied at texture seams", of_one.saturating_mul(split.copied.len() as u64))?;
    repeat(&mut mesh.positions, &split.copied);
    mesh.normals.iter_mut().for_each(|v| repeat(v, &split.copied));
    mesh.vertex_colors.iter_mut().for_each(|v| repeat(v, &split.copied));
    mesh.attributes.iter_mut().for_each(|a| repeat(&mut a.values, &split.copied));
    mesh.texcoords = Some(split.texcoords);
    Ok(())
}

/// Values of faces, repeated for each of their triangles.
fn face_columns(
    job: &Job,
    mesh: &mut Mesh,
    plan: &Plan,
    columns: Vec<Column>,
    triangles: &Triangles,
) -> Result<(), ReadError> {
    fn spread<T: Copy + Send + Sync>(values: Vec<T>, triangles: &Triangles) -> Vec<T> {
        match &triangles.face_of_triangle {
            Some(faces) => faces.par_iter().filter_map(|&f| values.get(f as usize).copied()).collect(),
            None => values,
        }
    }
    if triangles.face_of_triangle.is_some() {
        job.reserve("values of faces", 4 * columns.len() as u64 * triangles.list.len() as u64)?;
    }
    let attributes = &mut mesh.attributes;
    let mut add = |name: &str, (values, offset): (Vec<f32>, f64)| {
        let (name, values) = (name.to_owned(), spread(values, triangles));
        attributes.push(Attribute {
            name,
            domain: AttributeDomain::Triangle,
            values,
            offset,
            component: None,
        });
    };
    for (field, column) in plan.fields.iter().zip(columns) {
        match column {
            Column::Colors(colors, broken) => {
                warn_of_colors(job, broken, "faces");
                mesh.face_colors = Some(spread(colors, triangles));
            }
            Column::Attribute(values) => add(&field.name, (values, 0.0)),
            Column::Attribute64(values) => add(&field.name, narrow(job, &field.name, values)?),
            _ => {}
        }
    }
    Ok(())
}

/// MeshLab names textures in comments, and if there are several, gives each face the number of its texture.
fn materials(job: &Job, header: &Header, mesh: &mut Mesh) -> Result<(), ReadError> {
    if mesh.texcoords.is_none() {
        return Ok(());
    }
    warn_of_numbers(job, header, mesh);
    if header.textures.is_empty() {
        return Ok(());
    }
    job.reserve("materials", 4 * mesh.triangles.len() as u64)?;
    let material = |file: &String| FileMaterial {
        name: file.clone(),
        diffuse: [1.0; 3],
        textures: FileTextures { diffuse: Some(FileTexture::new(file)), ..FileTextures::default() },
        ..FileMaterial::default()
    };
    mesh.materials = header.textures.iter().map(material).collect();
    let numbers = texture_numbers(mesh);
    let of_triangle = |i: usize| match numbers.and_then(|n| n.get(i)) {
        Some(&number) => texture_of(number, &mesh.materials).unwrap_or(Mesh::NO_MATERIAL),
        None => 0,
    };
    mesh.triangle_materials = Some((0..mesh.triangles.len()).map(of_triangle).collect());
    Ok(())
}

/// The numbers of the textures of triangles.
fn texture_numbers(mesh: &Mesh) -> Option<&[f32]> {
    let is_number = |a: &&Attribute| a.domain == AttributeDomain::Triangle && a.name == "texnumber";
    mesh.attributes.iter().find(is_number).map(|a| a.values.as_slice())
}

/// Which of some textures a number means.
fn texture_of<T>(number: f32, textures: &[T]) -> Option<u32> {
    let index = number as u32;
    (f64::from(number) == f64::from(index) && (index as usize) < textures.len()).then_some(index)
}

/// Faces without a texture have a negative number.
fn warn_of_numbers(job: &Job, header: &Header, mesh: &Mesh) {
    let numbers = texture_numbers(mesh).unwrap_or_default();
    let is_missing = |&&number: &&f32| !(number < 0.0) && texture_of(number, &header.textures).is_none();
    let missing = numbers.par_iter().filter(is_missing).count() as u64;
    if missing > 0 {
        let (triangles, named) =
            (counted(missing, "triangle"), counted(header.textures.len() as u64, "texture"));
        job.warn(format!("did not draw textures of {triangles}: the file names {named}, and their texnumber is none of these"));
    }
}
