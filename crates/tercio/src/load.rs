//! From a model file to what a renderer draws.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use tercio_mesh::arrays::ArraysError;
use tercio_mesh::builtin::{self, BuiltinError};
use tercio_mesh::clean::{self, Cleaned};
use tercio_mesh::cluster::{self, ClusteredMesh, Order, PartitionOptions};
use tercio_mesh::io::input::Input;
use tercio_mesh::io::prepared::is_prepared;
use tercio_mesh::io::{self, ReadOptions, ReadReport};
use tercio_mesh::loops::prelude::*;
use tercio_mesh::mesh::MAX_ELEMENTS;
use tercio_mesh::strokes::Strokes;
use tercio_mesh::topology::{self, Topology};
use tercio_mesh::{Attribute, BlockedMesh, FileMaterial, Mesh, Progress, ReadError, normals, weld};

use tercio_mesh::clip::ClipError;
use tercio_scene::framing::Extent;

use crate::clipping::{self, ClipReport, Clipping};
use crate::data::Made;
use crate::{AttributeSummary, MeshSummary, Origin, StrokesSummary, prepared};

/// Which normals a loaded mesh has.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Normals {
    /// Those of the file; if it has none, they are made. If only some of them are missing, zero or not finite, those
    /// are replaced one by one by the normals that would be made there, with the same crease angle.
    FileOrMade {
        /// Edges sharper than this many radians stay sharp; `None` smooths over all of them.
        crease_angle: Option<f64>,
    },
    /// Those of the file; if it has none, the mesh has none and is drawn with flat shading. Single ones that are
    /// missing, zero or not finite are replaced by smooth ones, without splitting vertices.
    File,
}

impl Default for Normals {
    fn default() -> Self {
        // Edges of machine parts stay sharp, scans and cylinders of more than a dozen sides are smooth.
        Self::FileOrMade { crease_angle: Some(std::f64::consts::FRAC_PI_6) }
    }
}

/// How a model is loaded.
#[derive(Clone, Copy, Debug, Default)]
pub struct LoadOptions<'a> {
    /// Most bytes that the model and its preparation may take; `None` for no limit.
    pub memory_limit: Option<u64>,
    /// Receives the progress of loading.
    pub progress: Option<&'a Progress>,
    /// Which normals the mesh shall have.
    pub normals: Normals,
    /// Whether to compute [`LoadReport::topology`] and [`LoadReport::attributes`], which takes about as long as
    /// reading.
    pub details: bool,
    /// Where the model is clipped, after its normals are made; `None` for the whole model.
    pub clip: Option<Clipping<'a>>,
    /// An attribute that is made of the mesh before it is clipped. A prepared model, and parts, have none.
    pub make: Option<Made>,
    /// Which of the times of a collection is loaded, counted from 0; the first one, with a warning, if it is `None`.
    pub step: Option<usize>,
}

/// Wall time of each stage in milliseconds; 0 for one that was not needed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LoadTimes {
    /// Reading the file, or making the built-in model.
    pub read: f64,
    /// Dropping what cannot be drawn.
    pub clean: f64,
    /// Joining the corners of a triangle soup.
    pub weld: f64,
    /// Analysing topology and attributes.
    pub topology: f64,
    /// Making normals.
    pub normals: f64,
    /// Clipping.
    #[serde(default)]
    pub clip: f64,
    /// Partitioning into clusters.
    pub partition: f64,
    /// Total time.
    pub total: f64,
}

/// What was found and done while a model was loaded.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LoadReport {
    /// What the reader found.
    pub read: ReadReport,
    /// Line segments of the file that are drawn.
    #[serde(skip)]
    pub lines: u64,
    /// Points of the file that are drawn.
    #[serde(skip)]
    pub points: u64,
    /// What was dropped because it cannot be drawn.
    pub cleaned: Cleaned,
    /// Vertices joined with others, if the model was a triangle soup.
    pub welded: Option<u64>,
    /// Whether the file has normals.
    pub file_normals: bool,
    /// Whether normals were made.
    pub made_normals: bool,
    /// Normals of the file that are missing, zero or not finite and were replaced.
    pub mended_normals: u64,
    /// Closed, consistently wound? If requested.
    pub topology: Option<Topology>,
    /// Ranges of the attributes, if requested.
    pub attributes: Vec<AttributeSummary>,
    /// Bounds and attributes of the lines and points, if requested and if there are any.
    #[serde(skip)]
    pub strokes: Option<StrokesSummary>,
    /// What was cut away, if clipping was requested.
    #[serde(skip)]
    pub clipped: Option<ClipReport>,
    /// The mesh after repair and clipping, before it was split into clusters.
    pub mesh: MeshSummary,
    /// Where the model came from, if it was prepared; the other fields are then those of the original loading.
    #[serde(skip)]
    pub prepared: Option<Origin>,
    /// Wall times.
    pub times: LoadTimes,
}

/// A mesh ready to be drawn.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Loaded {
    /// The mesh.
    pub mesh: Arc<ClusteredMesh>,
    /// The caps of a clipped model, to be drawn as an instance of their own; `None` if there are none.
    pub caps: Option<Arc<ClusteredMesh>>,
    /// The extent of the whole model, if it was clipped: for a camera that does not depend on that.
    pub whole: Option<Extent>,
    /// Lines and points of the file, which are not clipped; [`crate::strokes`] draws them. A prepared model, and a part of a
    /// model, has none.
    pub strokes: Strokes,
    /// What was found and done.
    pub report: LoadReport,
}

/// A mesh not yet split into clusters.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadedMesh {
    /// The mesh.
    pub mesh: Mesh,
    /// The caps of a clipped model; `None` if there are none.
    pub caps: Option<Mesh>,
    /// What was found and done.
    pub report: LoadReport,
}

/// A model as its file holds it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Model {
    /// A mesh that is not yet split into clusters.
    Mesh(Box<LoadedMesh>),
    /// A prepared model.
    Prepared(Box<Loaded>),
}

/// Information about a model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Inspection {
    /// What was found and done.
    pub report: LoadReport,
    /// Materials that the file names.
    pub materials: Vec<FileMaterial>,
}

/// Why a model could not be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// A file could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// There is no such built-in model.
    #[error(transparent)]
    Builtin(#[from] BuiltinError),
    /// Arrays of a program do not make a mesh.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// A model could not be clipped.
    #[error("{model}: {error}")]
    Clip {
        /// The name of the model.
        model: String,
        /// Why.
        error: ClipError,
    },
}

/// Loads a model for drawing with the default [`LoadOptions`]: a file, `-` for standard input, or
/// `builtin:NAME@COUNT`.
///
/// Reads, drops what cannot be drawn, joins the corners of triangle soups, makes missing normals, and splits the mesh
/// into clusters. Files are never trusted: a broken one gives an error or a repaired model, and the report lists what
/// was repaired.
///
/// # Errors
/// [`LoadError`], which names the file and the place in it.
pub fn load(model: impl AsRef<Path>) -> Result<Loaded, LoadError> {
    LoadOptions::default().load(model)
}

impl LoadOptions<'_> {
    /// Loads a model as the function [`load`] does, with these options.
    ///
    /// ```
    /// use tercio::{LoadOptions, Normals};
    ///
    /// let options = LoadOptions { normals: Normals::File, details: true, ..LoadOptions::default() };
    /// let model = options.load("builtin:sphere@1k")?;
    /// assert!(model.report.topology.is_some_and(|t| t.closed));
    /// # Ok::<(), tercio::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`LoadError`], which names the file and the place in it.
    pub fn load(&self, model: impl AsRef<Path>) -> Result<Loaded, LoadError> {
        load_path(model.as_ref(), self)
    }

    /// Loads a model as [`LoadOptions::load`] does, if `accept` returns `Ok` for what was found in the file; it is
    /// called after reading, before the work on the mesh begins.
    ///
    /// # Errors
    /// [`LoadError`], and errors of `accept`.
    pub fn load_if<E: From<LoadError>>(
        &self,
        model: impl AsRef<Path>,
        accept: impl FnOnce(&ReadReport) -> Result<(), E>,
    ) -> Result<Loaded, E> {
        let (model, start) = (model.as_ref(), Instant::now());
        let source = Source::open(model, self)?;
        if let Some(input) = source.prepared() {
            clipping::check_prepared(input, self)?;
            let loaded = prepared::load(input, self, start)?;
            accept(&loaded.report.read)?;
            return Ok(loaded);
        }
        cut(model, self, start, move || {
            let read = source.read(self)?;
            accept(&read.report)?;
            Ok(read)
        })
    }

    /// Loads a model as [`LoadOptions::load`] does, from a file that is open already or from bytes in memory.
    ///
    /// ```
    /// use tercio::mesh::io::ReadOptions;
    /// use tercio::mesh::io::input::Input;
    ///
    /// let obj = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    /// let input = Input::from_bytes("square.obj", obj.to_vec(), &ReadOptions::default())?;
    /// let model = tercio::LoadOptions::default().load_input(&input)?;
    /// assert_eq!(model.report.mesh.triangles, 2);
    /// # Ok::<(), tercio::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`LoadError`], which names the input and the place in it.
    pub fn load_input(&self, input: &Input) -> Result<Loaded, LoadError> {
        let start = Instant::now();
        if is_prepared(input.bytes()) {
            clipping::check_prepared(input, self)?;
            return prepared::load(input, self, start);
        }
        cut(input.name.as_ref(), self, start, || read_input(input, self))
    }

    /// Loads a model as [`LoadOptions::load`] does, but does not split it into clusters: for programs that want the
    /// [`Mesh`] itself.
    ///
    /// # Errors
    /// [`LoadError`], which names the file and the place in it; a prepared model has no such mesh.
    pub fn load_mesh(&self, model: impl AsRef<Path>) -> Result<LoadedMesh, LoadError> {
        load_mesh_path(model.as_ref(), self)
    }

    /// Loads a model as [`LoadOptions::load_input`] does, but does not split it into clusters.
    ///
    /// # Errors
    /// [`LoadError`], which names the input and the place in it.
    pub fn load_mesh_input(&self, input: &Input) -> Result<LoadedMesh, LoadError> {
        if is_prepared(input.bytes()) {
            // What is damaged is said first, as `load_mesh` does.
            self.load_input(input)?;
            return Err(prepared::no_mesh(&input.name));
        }
        uncut(input.name.as_ref(), self, Instant::now(), || read_input(input, self))
    }

    /// Loads a model as [`LoadOptions::load_mesh`] does, or a prepared one as it is.
    ///
    /// # Errors
    /// [`LoadError`], which names the file and the place in it.
    pub fn open(&self, model: impl AsRef<Path>) -> Result<Model, LoadError> {
        open_path(model.as_ref(), self)
    }

    /// Reports on a model as [`LoadOptions::load_mesh`] does, or on a prepared one, without keeping the mesh.
    ///
    /// # Errors
    /// [`LoadError`], which names the file and the place in it.
    pub fn inspect(&self, model: impl AsRef<Path>) -> Result<Inspection, LoadError> {
        Ok(match open_path(model.as_ref(), self)? {
            Model::Mesh(loaded) => Inspection { report: loaded.report, materials: loaded.mesh.materials },
            Model::Prepared(loaded) => {
                Inspection { report: loaded.report, materials: loaded.mesh.materials.clone() }
            }
        })
    }
}

fn load_path(model: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    options.load_if(model, |_| Ok(()))
}

fn load_mesh_path(model: &Path, options: &LoadOptions) -> Result<LoadedMesh, LoadError> {
    match open_path(model, options)? {
        Model::Mesh(loaded) => Ok(*loaded),
        Model::Prepared(_) => Err(prepared::no_mesh(&model.display().to_string())),
    }
}

fn open_path(model: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let start = Instant::now();
    let source = Source::open(model, options)?;
    Ok(match source.prepared() {
        Some(input) => {
            clipping::check_prepared(input, options)?;
            Model::Prepared(Box::new(prepared::load(input, options, start)?))
        }
        None => Model::Mesh(Box::new(uncut(model, options, start, move || source.read(options))?)),
    })
}

/// What was read.
struct Read {
    mesh: Mesh,
    strokes: Strokes,
    report: ReadReport,
}

/// Where a model is read from.
enum Source<'a> {
    Builtin(&'a str),
    File(Input),
}

impl<'a> Source<'a> {
    fn open(model: &'a Path, options: &LoadOptions) -> Result<Self, LoadError> {
        if let Some(name) = model.to_str().filter(|m| m.starts_with("builtin:")) {
            return Ok(Self::Builtin(name));
        }
        begin(options, "reading", 0);
        let options = ReadOptions {
            memory_limit: options.memory_limit,
            progress: options.progress,
            ..ReadOptions::default()
        };
        Ok(Self::File(io::input::open(model, &options)?))
    }

    /// The file, if it is a prepared model.
    fn prepared(&self) -> Option<&Input> {
        match self {
            Self::File(input) if is_prepared(input.bytes()) => Some(input),
            _ => None,
        }
    }

    /// Reads the mesh; the file is closed.
    fn read(self, options: &LoadOptions) -> Result<Read, LoadError> {
        match self {
            Self::Builtin(name) => make_builtin(name, options),
            Self::File(input) => read_input(&input, options),
        }
    }
}

/// All stages from reading to clusters.
fn cut<E: From<LoadError>>(
    model: &Path,
    options: &LoadOptions,
    all: Instant,
    read: impl FnOnce() -> Result<Read, E>,
) -> Result<Loaded, E> {
    let (mut mesh, strokes, mut report) = read_and_repair(model, options, all, read)?;
    if options.clip.is_some() {
        let clipped = clipped(model, options, all, mesh, report)?;
        return Ok(Loaded { strokes, ..clipped });
    }
    let wanted = wanted_normals(&mesh, options);
    if let Some(crease_angle @ None) = wanted {
        make_normals(&mut mesh, crease_angle, options, &mut report);
    }
    let mending = crease_angle(options);
    if mending.is_none() {
        report.mended_normals = normals::mend_normals(&mut mesh, None);
    }
    begin(options, "sorting triangles", 0);
    let start = Instant::now();
    let mut blocks = BlockedMesh::new(mesh, Order::Auto);
    report.times.partition = milliseconds(start);
    if let Some(Some(crease_angle)) = wanted {
        begin(options, "making normals", 0);
        let start = Instant::now();
        blocks.make_normals(crease_angle);
        report.made_normals = true;
        report.times.normals = milliseconds(start);
    } else if let Some(crease_angle) = mending {
        let start = Instant::now();
        report.mended_normals = blocks.mend_normals(crease_angle);
        report.times.normals = milliseconds(start);
    }
    report.mesh = MeshSummary::from_blocks(&blocks);
    let mesh = clusters(model, options, blocks, &mut report)?;
    report.times.total = milliseconds(all);
    Ok(Loaded { mesh, caps: None, whole: None, strokes, report })
}

/// The clusters of a mesh that is summarised already.
fn clusters(
    model: &Path,
    options: &LoadOptions,
    blocks: BlockedMesh,
    report: &mut LoadReport,
) -> Result<Arc<ClusteredMesh>, LoadError> {
    check_memory(model, options, "the model and its clusters", partition_bytes(&report.mesh))?;
    begin(options, "making clusters", blocks.triangle_count());
    let partition = PartitionOptions { progress: options.progress, ..PartitionOptions::default() };
    let start = Instant::now();
    let mesh = cluster::partition_blocks(blocks, &partition);
    report.times.partition += milliseconds(start);
    Ok(Arc::new(mesh))
}

/// All stages of a model that is clipped, after its repair. Normals are made on the whole mesh, so that those at the cut
/// are right.
fn clipped(
    model: &Path,
    options: &LoadOptions,
    all: Instant,
    mesh: Mesh,
    report: LoadReport,
) -> Result<Loaded, LoadError> {
    let (LoadedMesh { mesh, caps, mut report }, whole) = finished(model, options, mesh, report)?;
    begin(options, "sorting triangles", 0);
    let mut sorted = |mesh| {
        let start = Instant::now();
        let blocks = BlockedMesh::new(mesh, Order::Auto);
        report.times.partition += milliseconds(start);
        clusters(model, options, blocks, &mut report)
    };
    let mesh = sorted(mesh)?;
    let caps = caps.map(sorted).transpose()?;
    report.times.total = milliseconds(all);
    Ok(Loaded { mesh, caps, whole, strokes: Strokes::default(), report })
}

/// All stages from reading to normals.
fn uncut(
    model: &Path,
    options: &LoadOptions,
    all: Instant,
    read: impl FnOnce() -> Result<Read, LoadError>,
) -> Result<LoadedMesh, LoadError> {
    let (mesh, _, report) = read_and_repair(model, options, all, read)?;
    let (mut loaded, _) = finished(model, options, mesh, report)?;
    loaded.report.times.total = milliseconds(all);
    Ok(loaded)
}

/// Makes normals and clips; with the extent of the whole model, if it was clipped.
fn finished(
    model: &Path,
    options: &LoadOptions,
    mut mesh: Mesh,
    mut report: LoadReport,
) -> Result<(LoadedMesh, Option<Extent>), LoadError> {
    if let Some(crease_angle) = wanted_normals(&mesh, options) {
        make_normals(&mut mesh, crease_angle, options, &mut report);
    }
    report.mended_normals = normals::mend_normals(&mut mesh, crease_angle(options));
    let (mut caps, mut whole) = (None, None);
    if let Some(clipping) = &options.clip {
        let needed = MeshSummary::bytes_of(&mesh) + clipping::needed_bytes(&mesh);
        check_memory(model, options, "the model and its clipping", needed)?;
        begin(options, "clipping", 0);
        let start = Instant::now();
        let parts = clipping::clip(&mut mesh, clipping, &model.display().to_string())?;
        report.times.clip = milliseconds(start);
        report.clipped = Some(parts.report);
        (caps, whole) = (parts.caps, Some(parts.whole));
    }
    report.mesh = MeshSummary::from_mesh(&mesh);
    Ok((LoadedMesh { mesh, caps, report }, whole))
}

/// The crease angle for the normals that are to be made, if any are.
fn wanted_normals(mesh: &Mesh, options: &LoadOptions) -> Option<Option<f64>> {
    match options.normals {
        Normals::FileOrMade { crease_angle } if mesh.normals.is_none() => Some(crease_angle),
        _ => None,
    }
}

/// The crease angle for normals of the file that have to be replaced.
fn crease_angle(options: &LoadOptions) -> Option<f64> {
    match options.normals {
        Normals::FileOrMade { crease_angle } => crease_angle,
        Normals::File => None,
    }
}

fn make_normals(mesh: &mut Mesh, crease_angle: Option<f64>, options: &LoadOptions, report: &mut LoadReport) {
    begin(options, "making normals", 0);
    let start = Instant::now();
    normals::make_normals(mesh, crease_angle);
    report.made_normals = true;
    report.times.normals = milliseconds(start);
}

fn read_input(input: &Input, options: &LoadOptions) -> Result<Read, LoadError> {
    let options = ReadOptions {
        memory_limit: options.memory_limit,
        progress: options.progress,
        step: options.step,
        ..ReadOptions::default()
    };
    begin_stage(options.progress, "reading", 0);
    let model = io::read_input(input, &options)?;
    Ok(Read { mesh: model.mesh, strokes: model.strokes, report: model.report })
}

/// All stages before the normals.
fn read_and_repair<E: From<LoadError>>(
    model: &Path,
    options: &LoadOptions,
    start: Instant,
    read: impl FnOnce() -> Result<Read, E>,
) -> Result<(Mesh, Strokes, LoadReport), E> {
    let Read { mut mesh, strokes, report: mut read } = read()?;
    read.warnings.extend(strokes_without_place(&strokes));
    let (lines, points) = (strokes.segments.len() as u64, strokes.points.len() as u64);
    let file_normals = mesh.normals.is_some();
    let mut report = LoadReport { read, lines, points, file_normals, ..LoadReport::default() };
    report.times.read = milliseconds(start);
    check_size(model, &mesh)?;
    // Tested before cleaning, which may leave vertices that no triangle uses.
    let is_soup = weld::is_soup(&mesh);
    let needed = preparation_bytes(&mesh, is_soup, options);
    check_memory(model, options, "the model and its making ready", needed)?;
    begin(options, "cleaning", 0);
    let start = Instant::now();
    report.cleaned = clean::clean(&mut mesh);
    report.times.clean = milliseconds(start);

    let start = Instant::now();
    if is_soup {
        begin(options, "joining vertices", 0);
        report.welded = Some(weld::weld(&mut mesh));
        report.times.weld = milliseconds(start);
    }

    if let Some(made) = options.make {
        let needed = MeshSummary::bytes_of(&mesh) + made.needed_bytes(&mesh);
        check_memory(model, options, "the model and its data", needed)?;
        begin(options, "making data", 0);
        made.add_to(&mut mesh);
    }
    if options.details {
        begin(options, "looking at edges", 0);
        let start = Instant::now();
        report.topology = Some(topology::analyze(&mesh));
        let of_file = mesh.attributes.iter().filter(|a| !Attribute::is_polygon(&a.name, a.domain));
        report.attributes = of_file.map(AttributeSummary::from_attribute).collect();
        report.strokes = StrokesSummary::from_strokes(&strokes);
        report.times.topology = milliseconds(start);
    }
    Ok((mesh, strokes, report))
}

/// Says how many lines and points cannot be drawn.
fn strokes_without_place(strokes: &Strokes) -> Option<String> {
    let is_there = |v: &u32| strokes.positions[*v as usize].iter().all(|c| c.is_finite());
    let points = strokes.points.par_iter().filter(|v| !is_there(v)).count();
    let lines = strokes.segments.par_iter().filter(|ends| !ends.iter().all(is_there)).count();
    let count =
        |n: usize, what: &str| (n > 0).then(|| format!("{n} {what}{}", if n == 1 { "" } else { "s" }));
    let list: Vec<String> = [count(points, "point"), count(lines, "line")].into_iter().flatten().collect();
    (!list.is_empty())
        .then(|| format!("not drawn: {} with coordinates that are not finite numbers", list.join(", ")))
}

fn make_builtin(name: &str, options: &LoadOptions) -> Result<Read, LoadError> {
    begin(options, "making the model", 0);
    check_memory(name.as_ref(), options, "the model", builtin::needed_bytes(name)?)?;
    let mesh = builtin::make(name)?;
    let mut report = ReadReport::default();
    report.format = "built-in".into();
    report.faces = mesh.triangles.len() as u64;
    Ok(Read { mesh, strokes: Strokes::default(), report })
}

pub(crate) fn check_size(model: &Path, mesh: &Mesh) -> Result<(), LoadError> {
    let counts = [("vertices", mesh.positions.len() as u64), ("triangles", mesh.triangles.len() as u64)];
    match counts.into_iter().find(|(_, count)| *count > MAX_ELEMENTS) {
        Some((what, count)) => {
            Err(ReadError::TooMany { file: model.display().to_string(), what, count }.into())
        }
        None => Ok(()),
    }
}

/// The mesh, and the most memory that one of the next steps takes in addition: joining vertices, which distributes
/// them with their hashes; the triangles at each vertex; or the triangles in blocks, with their order and a normal
/// per vertex. The additional memory for creases and seams depends on the model.
pub(crate) fn preparation_bytes(mesh: &Mesh, is_soup: bool, options: &LoadOptions) -> u64 {
    let (vertices, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
    let joining = if is_soup { 24 * vertices } else { 0 };
    let edges = if options.details { 16 * vertices + 12 * triangles } else { 0 };
    let blocks = 8 * vertices + 10 * triangles;
    MeshSummary::bytes_of(mesh) + joining.max(edges).max(blocks)
}

/// Mesh and clusters are both in memory while one is made from the other. Vertices that clusters share are stored in
/// each of them: half as many again is more than occurs in practice.
fn partition_bytes(mesh: &MeshSummary) -> u64 {
    mesh.bytes + mesh.bytes / 2 + mesh.bytes
}

pub(crate) fn check_memory(
    model: &Path,
    options: &LoadOptions,
    what: &str,
    needed: u64,
) -> Result<(), LoadError> {
    let limit = ReadOptions { memory_limit: options.memory_limit, progress: None, ..ReadOptions::default() };
    Ok(limit.check_memory(&model.display().to_string(), what, needed)?)
}

fn begin(options: &LoadOptions, stage: &'static str, total: usize) {
    begin_stage(options.progress, stage, total as u64);
}

fn begin_stage(progress: Option<&Progress>, stage: &'static str, total: u64) {
    if let Some(progress) = progress {
        progress.begin(stage, total);
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn a_soup_with_an_empty_triangle_is_joined_too() {
        let points = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let facets = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 1, 1]];
        let mut stl = vec![b' '; 80];
        stl.extend((facets.len() as u32).to_le_bytes());
        for facet in facets {
            stl.extend([0; 12]);
            stl.extend(facet.iter().flat_map(|&v| points[v]).flat_map(f32::to_le_bytes));
            stl.extend([0; 2]);
        }
        let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
        file.write_all(&stl).expect("room for it");
        let loaded = LoadOptions { normals: Normals::File, ..Default::default() }.load_mesh(file.path());
        let loaded = loaded.expect("a model");
        assert_eq!(loaded.report.cleaned.duplicate_corner, 1);
        assert_eq!(loaded.report.welded, Some(11));
        assert_eq!((loaded.mesh.positions.len(), loaded.mesh.triangles.len()), (4, 4));
    }

    #[test]
    fn a_model_that_is_not_accepted_is_not_processed() {
        #[derive(Debug)]
        enum Error {
            Load(LoadError),
            NotAccepted,
        }
        impl From<LoadError> for Error {
            fn from(error: LoadError) -> Self {
                Self::Load(error)
            }
        }
        let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
        file.write_all(b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("room for it");
        let progress = Progress::default();
        let options = LoadOptions { progress: Some(&progress), ..LoadOptions::default() };
        let rejected = options.load_if(file.path(), |read| {
            assert!(read.companions.iter().any(|path| path.ends_with("a.mtl")), "{:?}", read.companions);
            progress.begin("accept called", 0);
            Err(Error::NotAccepted)
        });
        assert!(matches!(rejected, Err(Error::NotAccepted)), "{rejected:?}");
        assert_eq!(progress.state().0, "accept called");
        let loaded = options.load_if(file.path(), |_| Ok::<_, Error>(())).expect("a model");
        assert_eq!(loaded.report.mesh.triangles, 1);
        let missing = options.load_if("no.obj", |_| Err(Error::NotAccepted));
        assert!(matches!(missing, Err(Error::Load(LoadError::Read(_)))), "{missing:?}");
    }

    /// A pyramid with separate corners of its faces, some of them with an invalid normal.
    fn pyramid(broken: &[usize], normal: &str) -> tempfile::NamedTempFile {
        let points = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
        let mut obj = points.map(|p| format!("v {p}\n")).concat();
        for corner in 0..12 {
            let normal = if broken.contains(&corner) { normal } else { "0.6 0 0.8" };
            obj += &format!("vn {normal}\n");
        }
        for (face, [a, b, c]) in [[1, 3, 2], [1, 2, 4], [2, 3, 4], [3, 1, 4]].iter().enumerate() {
            let n = 3 * face + 1;
            obj += &format!("f {a}//{n} {b}//{} {c}//{}\n", n + 1, n + 2);
        }
        let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
        file.write_all(obj.as_bytes()).expect("room for it");
        file
    }

    #[test]
    fn one_broken_normal_does_not_affect_the_others() {
        let of_file = tercio_mesh::OctNormal::from_vector([0.6, 0.0, 0.8]);
        let count = |mesh: &Mesh, n| mesh.normals.iter().flatten().filter(|m| **m == n).count();
        for normal in ["0 0 0", "nan 0 0", "0 inf 0"] {
            let file = pyramid(&[4, 7], normal);
            for normals in [Normals::default(), Normals::FileOrMade { crease_angle: None }, Normals::File] {
                let options = LoadOptions { normals, ..LoadOptions::default() };
                let loaded = options.load_mesh(file.path()).expect("a model");
                assert_eq!((loaded.report.mended_normals, loaded.report.made_normals), (2, false));
                assert!(loaded.report.file_normals);
                assert_eq!(loaded.report.read.warnings.len(), 1, "{:?}", loaded.report.read.warnings);
                assert_eq!(count(&loaded.mesh, of_file), loaded.mesh.positions.len() - 2);
                assert_eq!(count(&loaded.mesh, tercio_mesh::OctNormal::NONE), 0);
                let drawn = options.load(file.path()).expect("a model");
                assert_eq!(drawn.report.mended_normals, 2);
            }
            // Corners 4 and 7 are at the ends of edges of faces y = 0 and x + y + z = 1.
            let loaded = LoadOptions::default().load_mesh(file.path()).expect("a model");
            let normals = loaded.mesh.normals.as_deref().unwrap_or_default();
            let [back, front] =
                [(1, 1), (2, 1)].map(|(face, k)| normals[loaded.mesh.triangles[face][k] as usize]);
            assert_eq!(back, tercio_mesh::OctNormal::from_vector([0.0, -1.0, 0.0]));
            assert_eq!(front, tercio_mesh::OctNormal::from_vector([1.0, 1.0, 1.0]));
        }
        let all: Vec<usize> = (0..12).collect();
        let loaded = LoadOptions::default().load_mesh(pyramid(&all, "0 0 0").path()).expect("a model");
        assert_eq!((loaded.report.made_normals, loaded.report.file_normals), (true, false));
    }

    #[test]
    fn a_prepared_model_has_no_mesh_unless_it_is_damaged() {
        let (options, read) = (LoadOptions::default(), ReadOptions::default());
        let mut whole = Vec::new();
        let model = options.load("builtin:sphere@100").unwrap();
        model.write_prepared("builtin:sphere@100", &mut whole).unwrap();
        let error = |bytes: &[u8]| {
            let input = Input::from_bytes("m.tercio", bytes.to_vec(), &read).unwrap();
            options.load_mesh_input(&input).unwrap_err().to_string()
        };
        assert!(error(&whole).contains("which is cut into clusters"), "{}", error(&whole));
        for damaged in [&whole[..whole.len() - 1], b"\x89TERCIO# Viewpoint and more".as_slice()] {
            let input = Input::from_bytes("m.tercio", damaged.to_vec(), &read).unwrap();
            assert_eq!(error(damaged), options.load_input(&input).unwrap_err().to_string());
            assert!(error(damaged).starts_with("m.tercio: byte "), "{}", error(damaged));
        }
    }
}
