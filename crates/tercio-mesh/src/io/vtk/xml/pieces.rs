//! Points and cells of a piece.

use super::Reader;
use super::arrays::{self, Type};
use super::tree::Element;
use crate::ReadError;
use crate::io::vtk::build;
use crate::io::vtk::dataset::{CellList, Cells, Ends, Points};
use crate::io::vtk::extents::Extent;
use crate::io::vtk::numbers::Numbers;
use crate::mesh::MAX_ELEMENTS;

impl<'a> Reader<'_, 'a> {
    /// Points and cells of a piece; `None` if it holds none.
    pub fn geometry(
        &self,
        kind: &str,
        data: &Element,
        piece: &Element,
    ) -> Result<Option<(Points<'a>, Cells)>, ReadError> {
        Ok(Some(match kind {
            "PolyData" => {
                let Some((points, count)) = self.points(piece)? else { return Ok(None) };
                let list = |element, count_name| self.list(piece, element, count_name, count);
                let verts = list("Verts", "NumberOfVerts")?;
                let lines = list("Lines", "NumberOfLines")?;
                let polygons = list("Polys", "NumberOfPolys")?;
                let strips = list("Strips", "NumberOfStrips")?;
                (points, Cells::Poly([verts, lines, polygons, strips]))
            }
            "UnstructuredGrid" => {
                let Some((points, count)) = self.points(piece)? else { return Ok(None) };
                let list = self.list(piece, "Cells", "NumberOfCells", count)?;
                let Some(types) = self.array(piece, "Cells", "types")? else {
                    let place = self.job.line(piece.at);
                    return Err(self.job.malformed(place, "an array \"types\" of its cells", "none"));
                };
                let faces = self.polyhedra(piece, list.len(), count)?;
                (points, build::unstructured(self.job, &types, list, faces, count)?)
            }
            "ImageData" => {
                let (from, dims) = self.extent(piece)?;
                let numbers = |name: &str, default: &[f64]| self.attribute_numbers(data, name, default);
                let first = numbers("Origin", &[0.0; 3])?;
                let spacing = numbers("Spacing", &[1.0; 3])?;
                let direction = numbers("Direction", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])?;
                let axes = [0, 1, 2].map(|k| [0, 1, 2].map(|c| direction[3 * c + k] * spacing[k]));
                let first = [first[0], first[1], first[2]];
                (Points::Uniform { axes, first, from, dims }, Cells::Structured(dims))
            }
            "StructuredGrid" => {
                let (_, dims) = self.extent(piece)?;
                let Some(numbers) = self.first_array(piece, "Points")? else { return Ok(None) };
                self.check_points(piece, &numbers, dims.iter().fold(1, |n: u64, &d| n.saturating_mul(d)))?;
                (Points::Listed(numbers), Cells::Structured(dims))
            }
            _ => {
                let (_, dims) = self.extent(piece)?;
                let mut axes = Vec::new();
                let coordinates = piece.child("Coordinates");
                for element in coordinates.into_iter().flat_map(|c| c.children_named("DataArray")).take(3) {
                    axes.extend(self.numbers(element)?);
                }
                let axes: Result<[Numbers; 3], _> = axes.try_into();
                match axes {
                    Ok(axes) if [0, 1, 2].map(|k: usize| axes[k].len() as u64) == dims => {
                        (Points::Rectilinear { axes }, Cells::Structured(dims))
                    }
                    _ => {
                        let expected =
                            format!("{}, {} and {} coordinates for Extent", dims[0], dims[1], dims[2]);
                        return Err(self.job.malformed(
                            self.job.line(piece.at),
                            expected,
                            "other numbers of them",
                        ));
                    }
                }
            }
        }))
    }

    fn numbers(&self, element: &Element) -> Result<Option<Numbers<'a>>, ReadError> {
        let Type::Numbers(scalar) = arrays::kind(self.job, element)? else { return Ok(None) };
        arrays::numbers(self.job, &self.encoding, element, scalar).map(Some)
    }

    fn first_array(&self, piece: &Element, parent: &str) -> Result<Option<Numbers<'a>>, ReadError> {
        let element = piece.child(parent).and_then(|p| p.child("DataArray"));
        element.map_or(Ok(None), |element| self.numbers(element))
    }

    fn array(&self, piece: &Element, parent: &str, name: &str) -> Result<Option<Numbers<'a>>, ReadError> {
        let arrays = piece.children_named(parent).flat_map(|p| p.children_named("DataArray"));
        let element = { arrays }.find(|e| e.attribute("Name") == Some(name));
        element.map_or(Ok(None), |element| self.numbers(element))
    }

    /// A count that an attribute holds.
    fn count(&self, piece: &Element, name: &str) -> Result<Option<u64>, ReadError> {
        let Some(text) = piece.attribute(name) else { return Ok(None) };
        text.trim().parse().map(Some).map_err(|_| {
            self.job.malformed(self.job.line(piece.at), format!("a count as {name}"), format!("{text:?}"))
        })
    }

    fn points(&self, piece: &Element) -> Result<Option<(Points<'a>, u64)>, ReadError> {
        let count = self.count(piece, "NumberOfPoints")?;
        let numbers = self.first_array(piece, "Points")?;
        match (count, numbers) {
            (Some(0), _) | (None, None) => Ok(None),
            (count, Some(numbers)) => {
                let count = count.unwrap_or(numbers.len() as u64 / 3);
                self.check_points(piece, &numbers, count)?;
                Ok(Some((Points::Listed(numbers), count)))
            }
            (Some(count), None) => {
                let place = self.job.line(piece.at);
                Err(self.job.malformed(
                    place,
                    format!("{count} points, as NumberOfPoints says"),
                    "no array of points",
                ))
            }
        }
    }

    fn check_points(&self, piece: &Element, numbers: &Numbers, count: u64) -> Result<(), ReadError> {
        if count.checked_mul(3) == Some(numbers.len() as u64) {
            return Ok(());
        }
        let expected = format!("{count} points, as stated by the piece of {}", self.line_words(piece));
        let found = format!("{} numbers, {} points", numbers.len(), numbers.len() as f64 / 3.0);
        Err(self.job.malformed(numbers.place(0), expected, found))
    }

    fn line_words(&self, element: &Element) -> String {
        self.job.line(element.at).to_string().trim_end_matches(": ").to_owned()
    }

    fn list(&self, piece: &Element, parent: &str, count: &str, points: u64) -> Result<CellList, ReadError> {
        let wanted = self.count(piece, count)?;
        let offsets = self.array(piece, parent, "offsets")?;
        let connectivity = self.array(piece, parent, "connectivity")?;
        let (Some(offsets), Some(connectivity)) = (offsets, connectivity) else {
            return match wanted {
                None | Some(0) => Ok(CellList::default()),
                Some(n) => {
                    let expected = format!("{n} cells in {parent}, as {count} says");
                    Err(self.job.malformed(
                        self.job.line(piece.at),
                        expected,
                        "no offsets or no connectivity",
                    ))
                }
            };
        };
        if wanted.is_some_and(|n| n != offsets.len() as u64) {
            let expected = format!("{} cells in {parent}, as {count} says", wanted.unwrap_or_default());
            return Err(self.job.malformed(offsets.place(0), expected, offsets.len().to_string()));
        }
        build::offset_list(self.job, parent, &offsets, &connectivity, false, points)
    }

    /// The faces of polyhedra, in either of the two forms that there are.
    fn polyhedra(&self, piece: &Element, cells: usize, points: u64) -> Result<Option<CellList>, ReadError> {
        let array = |name| self.array(piece, "Cells", name);
        if let (Some(faces), Some(offsets)) = (array("faces")?, array("faceoffsets")?) {
            if faces.len() == 0 {
                return Ok(None);
            }
            self.job.reserve("the faces of polyhedra", 4 * faces.len() as u64 + 8 * cells as u64)?;
            let all = faces.len() as u64;
            let connectivity = faces.indices(u32::MAX.into()).map_err(|at| {
                self.job.malformed(
                    faces.place(at),
                    "a number of points, or a point",
                    faces.double(at).to_string(),
                )
            })?;
            let (mut ends, mut before) = (Vec::with_capacity(cells), 0u64);
            for cell in 0..cells {
                // Cells without faces have -1.
                let end = if cell < offsets.len() { offsets.index(cell) } else { None };
                match end {
                    Some(end) if (before..=all).contains(&end) => before = end,
                    None => {}
                    Some(end) => {
                        let expected = format!("an offset of faces from {before} to {all}");
                        return Err(self.job.malformed(offsets.place(cell), expected, end.to_string()));
                    }
                }
                ends.push(before);
            }
            return Ok(Some(CellList { ends: Ends::Each(ends), connectivity }));
        }
        let (Some(connectivity), Some(offsets)) = (array("face_connectivity")?, array("face_offsets")?)
        else {
            return Ok(None);
        };
        let (Some(to_faces), Some(cell_offsets)) =
            (array("polyhedron_to_faces")?, array("polyhedron_offsets")?)
        else {
            return Ok(None);
        };
        let faces =
            build::offset_list(self.job, "face_connectivity", &offsets, &connectivity, false, points)?;
        let list = build::offset_list(
            self.job,
            "polyhedron_to_faces",
            &cell_offsets,
            &to_faces,
            false,
            faces.len() as u64,
        )?;
        // A face may be listed by several cells.
        let size = |face: &u32| faces.get(*face as usize).len() as u64 + 1;
        let needed = list.connectivity.iter().map(size).sum::<u64>() + cells as u64;
        if needed > MAX_ELEMENTS {
            let what = "points of faces of polyhedra";
            return Err(ReadError::TooMany { file: self.job.file().into(), what, count: needed });
        }
        self.job.reserve("the faces of polyhedra", 4 * needed + 8 * cells as u64)?;
        let mut stream = Vec::with_capacity(needed as usize);
        let mut ends = Vec::with_capacity(cells);
        for cell in 0..cells {
            let of_cell = if cell < list.len() { list.get(cell) } else { &[] };
            if !of_cell.is_empty() {
                stream.push(of_cell.len() as u32);
            }
            for &face in of_cell {
                let nodes = faces.get(face as usize);
                stream.push(nodes.len() as u32);
                stream.extend_from_slice(nodes);
            }
            ends.push(stream.len() as u64);
        }
        Ok(Some(CellList { ends: Ends::Each(ends), connectivity: stream }))
    }

    /// First numbers and counts of the points of a piece along the axes.
    fn extent(&self, piece: &Element) -> Result<([i64; 3], [u64; 3]), ReadError> {
        let text = piece.attribute("Extent").unwrap_or_default();
        if let Some((extent, points)) = Extent::parse(text).and_then(|e| Some((e, e.points()?))) {
            return Ok((extent.0.map(|[first, _]| first), points));
        }
        let expected = "Extent with the first and the last point along three axes";
        Err(self.job.malformed(self.job.line(piece.at), expected, format!("{text:?}")))
    }

    fn attribute_numbers(
        &self,
        element: &Element,
        name: &str,
        default: &[f64],
    ) -> Result<Vec<f64>, ReadError> {
        let Some(text) = element.attribute(name) else { return Ok(default.to_vec()) };
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|n| n.parse().ok()).collect();
        if numbers.len() == default.len() {
            return Ok(numbers);
        }
        let expected = format!("{} numbers as {name}", default.len());
        Err(self.job.malformed(self.job.line(element.at), expected, format!("{text:?}")))
    }
}
