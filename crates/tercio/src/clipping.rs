//! Clipping of a model while it is loaded.

use serde::Serialize;
use tercio_mesh::clip::{self, Clip, ClipPlane};
use tercio_mesh::io::input::Input;
use tercio_mesh::strokes::Strokes;
use tercio_mesh::{Aabb, Mesh, Place, ReadError};
use tercio_scene::framing::Extent;

use crate::{LoadError, LoadOptions, prepared};

/// Where a model is clipped, and whether cuts are closed.
#[derive(Clone, Copy, Debug)]
pub struct Clipping<'a> {
    /// What is on the other side of any of these planes is cut away. Fractions refer to the bounds of all vertices of
    /// the whole model.
    pub planes: &'a [Clip],
    /// Whether cuts of closed parts of the model are capped.
    pub caps: bool,
}

impl Clipping<'_> {
    /// The part of a model's lines and points that is kept. Fractions refer to `bounds`. Where a line is cut, it gets a vertex with a
    /// colour and values between those of its ends.
    ///
    /// # Errors
    /// [`LoadError`] if a plane cannot be placed in these bounds.
    pub fn clip_strokes(&self, strokes: &Strokes, bounds: &Aabb, model: &str) -> Result<Strokes, LoadError> {
        let mut kept = strokes.clone();
        if bounds.is_empty() {
            return Ok(kept);
        }
        for clip in self.planes {
            let plane = clip.plane(bounds);
            let plane =
                plane.ok_or_else(|| unsupported(model, "a clip plane across a model of this size".into()))?;
            cut_strokes(&mut kept, &plane);
        }
        Ok(kept)
    }
}

/// Removes what is on the other side of a plane.
fn cut_strokes(strokes: &mut Strokes, plane: &ClipPlane) {
    let distance = |strokes: &Strokes, v: u32| plane.distance(strokes.position(v));
    // What is not a number stays: it is not drawn anyway.
    let is_kept = |distance: f64| !(distance < 0.0);
    let points = std::mem::take(&mut strokes.points);
    strokes.points = points.into_iter().filter(|&v| is_kept(distance(strokes, v))).collect();
    for mut ends in std::mem::take(&mut strokes.segments) {
        let [a, b] = ends.map(|v| distance(strokes, v));
        match (is_kept(a), is_kept(b)) {
            (true, true) => {}
            (false, false) => continue,
            (keeps_first, _) => {
                let end = usize::from(keeps_first);
                ends[end] = vertex_between(strokes, ends, a / (a - b));
            }
        }
        strokes.segments.push(ends);
    }
}

/// Adds a vertex at a share of the way between two others.
fn vertex_between(strokes: &mut Strokes, [a, b]: [u32; 2], share: f64) -> u32 {
    let (a, b) = (a as usize, b as usize);
    let mix = |a: f32, b: f32| (f64::from(a) + (f64::from(b) - f64::from(a)) * share) as f32;
    let position = [0, 1, 2].map(|k: usize| mix(strokes.positions[a][k], strokes.positions[b][k]));
    strokes.positions.push(position);
    if let Some(colors) = &mut strokes.colors {
        // Both ends of a line have a colour, or none.
        let mixed = colors[a]
            .zip(colors[b])
            .map(|(a, b)| [0, 1, 2, 3].map(|k: usize| mix(f32::from(a[k]), f32::from(b[k])).round() as u8));
        colors.push(mixed);
    }
    for attribute in &mut strokes.attributes {
        let value = mix(attribute.values[a], attribute.values[b]);
        attribute.values.push(value);
    }
    (strokes.positions.len() - 1) as u32
}

/// What was cut away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct ClipReport {
    /// Triangles of which nothing is left.
    pub removed: u64,
    /// Triangles of which a part is left.
    pub cut: u64,
    /// Triangles of the caps.
    pub cap_triangles: u64,
    /// Outlines that were capped, of all planes.
    pub outlines: u64,
    /// Outlines that were not capped because they are not closed.
    pub open_outlines: u64,
}

/// A clipped model besides its mesh.
pub(crate) struct Parts {
    pub caps: Option<Mesh>,
    pub whole: Extent,
    pub report: ClipReport,
}

/// Bytes of memory that clipping takes besides the mesh.
pub(crate) fn needed_bytes(mesh: &Mesh) -> u64 {
    // The positions of the whole model are kept for the camera.
    clip::needed_bytes(mesh) + size_of_val(mesh.positions.as_slice()) as u64
}

/// Clips a mesh that has its normals.
pub(crate) fn clip(mesh: &mut Mesh, clipping: &Clipping, model: &str) -> Result<Parts, LoadError> {
    let whole = Extent::of_mesh(mesh);
    let bounds = mesh.bounds();
    if bounds.is_empty() {
        return Ok(Parts { caps: None, whole, report: ClipReport::default() });
    }
    let planes: Option<Vec<_>> = clipping.planes.iter().map(|clip| clip.plane(&bounds)).collect();
    let planes =
        planes.ok_or_else(|| unsupported(model, "a clip plane across a model of this size".into()))?;
    let clipped = clip::clip(mesh, &planes, clipping.caps)
        .map_err(|error| LoadError::Clip { model: model.to_owned(), error })?;
    let report = ClipReport {
        removed: clipped.removed,
        cut: clipped.cut,
        cap_triangles: clipped.caps.as_ref().map_or(0, |caps| caps.triangles.len() as u64),
        outlines: clipped.outlines,
        open_outlines: clipped.open_outlines,
    };
    Ok(Parts { caps: clipped.caps, whole, report })
}

/// A prepared model has no mesh that can be clipped.
pub(crate) fn check_prepared(input: &Input, options: &LoadOptions) -> Result<(), LoadError> {
    if options.clip.is_none() {
        return Ok(());
    }
    let loaded = prepared::load(input, &LoadOptions { clip: None, ..*options }, std::time::Instant::now())?;
    let origin = loaded.report.prepared.map(|origin| origin.model).unwrap_or_default();
    let what = format!(
        "clipping of a prepared model, which is cut into clusters: clip what it was made from, {origin}"
    );
    Err(unsupported(&input.name, what))
}

fn unsupported(model: &str, what: String) -> LoadError {
    ReadError::Unsupported { file: model.to_owned(), place: Place::File, what }.into()
}

#[cfg(test)]
mod tests {
    use tercio_mesh::clip::Axis;
    use tercio_scene::{Framing, Scene};

    use super::*;
    use crate::{LoadedMesh, Model, Normals};

    const HALF: Clip = Clip::Fraction { axis: Axis::X, fraction: 0.5, keeps_lower: false };

    fn options(planes: &[Clip]) -> LoadOptions<'_> {
        LoadOptions { clip: Some(Clipping { planes, caps: true }), ..LoadOptions::default() }
    }

    #[test]
    fn a_clipped_model_has_caps_and_the_camera_of_the_whole_one() {
        let whole = crate::load("builtin:sphere@5k").expect("a sphere");
        let half = options(&[HALF]).load("builtin:sphere@5k").expect("half of it");
        let report = half.report.clipped.expect("a report");
        assert!(report.removed > 2000 && report.cut > 50 && report.cap_triangles > 50);
        assert_eq!((report.outlines, report.open_outlines), (1, 0));
        let bounds = half.mesh.bounds;
        // Positions are 32-bit numbers.
        let middle = whole.mesh.bounds.center().x;
        let is_cut = |x: f64| (x - middle).abs() < 1e-6;
        assert!(is_cut(bounds.min.x) && bounds.max == whole.mesh.bounds.max, "{bounds:?}, {middle}");
        let caps = half.caps.expect("a cap");
        assert_eq!(caps.triangle_count() as u64, report.cap_triangles);
        assert!(is_cut(caps.bounds.min.x) && is_cut(caps.bounds.max.x), "{:?}", caps.bounds);
        let extent = half.whole.expect("the extent of the whole sphere");
        assert_eq!(extent.bounds(), whole.mesh.bounds);
        let scene = Scene::from_mesh(whole.mesh);
        for fov_y in [Some(30.0), None] {
            let framing = Framing { fov_y, azimuth: 33.0, ..Framing::new(300, 200) };
            assert_eq!(framing.camera_for_extent(&extent), framing.camera_for_scene(&scene));
        }
    }

    #[test]
    fn normals_are_those_of_the_whole_model() {
        let planes = [HALF];
        for normals in [Normals::default(), Normals::FileOrMade { crease_angle: None }] {
            let load = |clip| LoadOptions { normals, clip, ..LoadOptions::default() };
            let soup = "builtin:soup@100";
            let LoadedMesh { mesh: whole, .. } = load(None).load_mesh(soup).expect("a mesh");
            let clip = Some(Clipping { planes: &planes, caps: false });
            let loaded = load(clip).load_mesh(soup).expect("a part");
            let all: std::collections::HashSet<_> = whole
                .positions
                .iter()
                .zip(whole.normals.iter().flatten())
                .map(|(p, n)| (p.map(f32::to_bits), *n))
                .collect();
            let mesh = loaded.mesh;
            let old = mesh.positions.iter().zip(mesh.normals.iter().flatten()).filter(|(p, _)| p[0] > 1e-6);
            assert!(old.clone().count() > 50);
            let kept = old.filter(|(p, n)| all.contains(&(p.map(f32::to_bits), **n))).count();
            assert!(kept > 50, "{kept}");
        }
    }

    #[test]
    fn lines_are_cut_and_points_kept_or_not() {
        let positions = vec![[0.0, 0.0, 0.0], [4.0, 2.0, 0.0], [4.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]];
        let attribute = tercio_mesh::Attribute {
            name: "t".into(),
            domain: tercio_mesh::AttributeDomain::Vertex,
            values: vec![0.0, 8.0, 8.0, 1.0],
            offset: 0.0,
            component: None,
        };
        let strokes = Strokes {
            origin: glam::DVec3::X,
            positions,
            colors: Some(vec![Some([0, 0, 0, 255]), Some([200, 100, 0, 255]), Some([0; 4]), None]),
            attributes: vec![attribute],
            segments: vec![[0, 1], [1, 0], [1, 2], [0, 0]],
            points: vec![0, 1, 2, 3],
            materials: Vec::new(),
        };
        let bounds = Aabb { min: glam::DVec3::X, max: glam::DVec3::new(5.0, 2.0, 0.0) };
        let planes = [Clip::Fraction { axis: Axis::X, fraction: 0.25, keeps_lower: false }];
        let kept =
            Clipping { planes: &planes, caps: false }.clip_strokes(&strokes, &bounds, "a").expect("planes");
        assert_eq!(kept.points, [1, 2, 3]);
        assert_eq!(kept.segments, [[4, 1], [1, 5], [1, 2]]);
        for v in [4, 5] {
            assert_eq!(kept.positions[v], [1.0, 0.5, 0.0]);
            assert_eq!(kept.attributes[0].values[v], 2.0);
            assert_eq!(kept.colors.as_ref().expect("colours")[v], Some([50, 25, 0, 255]));
        }
        let none =
            Clipping { planes: &planes, caps: false }.clip_strokes(&Strokes::default(), &Aabb::EMPTY, "a");
        assert!(none.expect("nothing").is_empty());
    }

    #[test]
    fn nothing_is_clipped_without_planes_and_prepared_models_say_what_to_clip() {
        let none = options(&[]).load("builtin:sphere@1k").expect("a sphere");
        let plain = crate::load("builtin:sphere@1k").expect("a sphere");
        assert_eq!(none.report.mesh.triangles, plain.report.mesh.triangles);
        assert_eq!(none.report.clipped, Some(ClipReport::default()));
        assert!(plain.report.clipped.is_none() && plain.whole.is_none() && plain.caps.is_none());
        let file = tempfile::NamedTempFile::new().expect("a file");
        plain.write_prepared("builtin:sphere@1k", &mut &file).expect("room");
        for error in [
            options(&[HALF]).load(&file).map(drop),
            options(&[HALF]).open(&file).map(|model: Model| drop(model)),
        ] {
            let error = error.expect_err("no mesh").to_string();
            assert!(error.contains("clip what it was made from, builtin:sphere@1k"), "{error}");
        }
        assert!(crate::load(&file).is_ok());
    }
}
