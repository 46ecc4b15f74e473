//! Models in parts: each of several ranks loads a share of a model, and no rank holds the whole.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use tercio_mesh::arrays::Arrays;
use tercio_mesh::cluster::{self, Order, PartitionOptions};
use tercio_mesh::io::input::{self, Input};
use tercio_mesh::io::prepared::is_prepared;
use tercio_mesh::io::share::{Facts, Shareable};
use tercio_mesh::io::{self, ReadModel, ReadOptions, ReadReport};
use tercio_mesh::mesh::choose_origin;
use tercio_mesh::strokes::Strokes;
use tercio_mesh::{Aabb, Attribute, BlockedMesh, Mesh, builtin, clean, normals, weld};
use tercio_parallel::comm::CommError;
use tercio_parallel::comm::collective::{all_max, all_reduce, all_sum, exclusive_sum};
use tercio_parallel::parts::seam::{self, Numbers, VertexNumbers};
use tercio_parallel::parts::{agree, bounds_of_all, number};
use tercio_parallel::{Communicator, ParallelError, PartsError};
use tercio_scene::{Instance, Share};

use crate::load::{check_memory, check_size, preparation_bytes};
use crate::{Error, LoadError, LoadOptions, LoadReport, Loaded, MeshSummary, Normals, prepared};

/// What stands for the number of the rank in the name of a model of which each rank has a file of its own.
pub const RANK: &str = "{rank}";

/// A rank's part of a model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadedPart {
    /// The part, as any loaded model. The report is that of the part; bounds of the mesh are those of the whole model.
    pub loaded: Loaded,
    /// Which part of the model it is.
    pub share: Share,
}

impl LoadedPart {
    /// The part at the position given by its file.
    pub fn instance(&self) -> Instance {
        Instance { share: Some(self.share), ..Instance::new(self.loaded.mesh.clone()) }
    }
}

/// The file of a rank: the name with the number of the rank for [`RANK`], or the name itself, if all ranks share one file.
pub fn file_of_rank(model: impl AsRef<Path>, rank: usize) -> PathBuf {
    let model = model.as_ref();
    match model.to_str() {
        Some(name) if name.contains(RANK) => name.replace(RANK, &rank.to_string()).into(),
        _ => model.to_owned(),
    }
}

impl LoadOptions<'_> {
    /// Loads this rank's part of a model, together with the other ranks, which have to call this with the same name and
    /// options. Together the parts are drawn as the whole model would be, byte for byte.
    ///
    /// A name with [`RANK`] in it (`part_{rank}.ply`) stands for a file for each rank, of any format; the model is that of all
    /// triangles in the order of the ranks. Otherwise ranks share one file: a prepared model, binary PLY or binary STL, of which
    /// each reads a range of clusters or faces, or a built-in model, which each makes and keeps a range of.
    ///
    /// Vertices at the seams get the normals of the whole model: ranks exchange the triangles near them.
    ///
    /// # Errors
    /// [`LoadError`] if this rank's part cannot be read, or the file cannot be shared; [`ParallelError`] if another rank failed,
    /// or the parts do not fit together. Clipping is refused.
    pub fn load_part(
        &self,
        comm: &mut impl Communicator,
        model: impl AsRef<Path>,
    ) -> Result<LoadedPart, Error> {
        load(comm, model.as_ref(), self)
    }

    /// Makes this rank's part of a model from arrays, together with the other ranks, which have to call this with theirs. The model
    /// is that of all triangles in the order of the ranks; surfaces of several ranks are joined where they have vertices at the same
    /// position. A part may be empty. The arrays are copied.
    ///
    /// All ranks that have vertices give normals, or none of them does, and the same for colours.
    ///
    /// # Errors
    /// [`LoadError::Arrays`] on a rank whose arrays do not make a mesh, and [`PartsError::Failed`] on the others;
    /// [`PartsError::Differs`] if only some have normals or colours, [`PartsError::TooLarge`]: on all ranks, which may go on after
    /// that. [`LoadError::MemoryLimit`](LoadError) and [`ParallelError::Comm`] on one rank.
    pub fn load_arrays(&self, comm: &mut impl Communicator, arrays: &Arrays) -> Result<LoadedPart, Error> {
        let start = Instant::now();
        let raw = of_arrays(comm, arrays)?;
        finish(comm, Path::new("arrays"), raw, self, start)
    }
}

fn load(comm: &mut impl Communicator, model: &Path, options: &LoadOptions) -> Result<LoadedPart, Error> {
    let start = Instant::now();
    if options.clip.is_some() {
        return Err(unsupported(model, "clipping a model in parts").into());
    }
    let path = file_of_rank(model, comm.rank());
    if let Some(name) = path.to_str().filter(|name| name.starts_with("builtin:")) {
        return of_builtin(comm, name, options, start);
    }
    let read = ReadOptions {
        memory_limit: options.memory_limit,
        progress: options.progress,
        is_part: true,
        ..ReadOptions::default()
    };
    let input = input::open(&path, &read).map_err(LoadError::from)?;
    let is_shared = path == model;
    if is_prepared(input.bytes()) {
        if !is_shared {
            return Err(unsupported(&path, "a prepared model for each rank (prepare the whole)").into());
        }
        return of_prepared(comm, &input, options, start);
    }
    let raw = if is_shared { share_of_file(comm, input, &read)? } else { own_file(comm, &input, &read)? };
    finish(comm, &path, raw, options, start)
}

/// A part before anything was repaired.
struct Raw {
    mesh: Mesh,
    read: ReadReport,
    numbers: Numbers,
    /// Input faces.
    faces: u64,
    /// Vertices of the whole model, used or not.
    vertices: u64,
}

/// A part of a file that all ranks read.
fn share_of_file(comm: &mut impl Communicator, input: Input, options: &ReadOptions) -> Result<Raw, Error> {
    let (rank, size) = (comm.rank(), comm.size());
    let shareable = Shareable::open(&input).map_err(LoadError::from)?;
    let range = shareable.range(rank, size);
    let own = [u64::from(shareable.is_uniform(&range)), shareable.marks(&range)];
    let [is_uniform, marks] = all_reduce(comm, own, |a, b| std::array::from_fn(|k| a[k] & b[k]))?;
    let unused = shareable.coordinates(rank, size, options).map_err(LoadError::from)?;
    let share = shareable.take(&range, is_uniform > 0, marks, options).map_err(LoadError::from)?;
    let (faces, vertices) = (range.len() as u64, shareable.vertices());
    drop(shareable);
    drop(input);
    let model = settled(comm, unused, options, |options| Ok(share.read(options)?))?;
    let first = 3 * range.start as u64;
    let triangles = model.mesh.triangles.len() as u64;
    let (before, _) = exclusive_sum(comm, [triangles])?;
    let vertex_numbers = share.vertices.map_or(VertexNumbers::From(first), VertexNumbers::List);
    let numbers = Numbers { first_triangle: before[0], vertices: vertex_numbers };
    let ReadModel { mesh, report: read, .. } = model;
    Ok(Raw { mesh, read, numbers, faces, vertices })
}

/// Arrays that are this rank's own.
fn of_arrays(comm: &mut impl Communicator, arrays: &Arrays) -> Result<Raw, Error> {
    const WRONG: u64 = 1;
    const NORMALS: u64 = 2;
    const COLORS: u64 = 4;
    let checked = arrays.check();
    let mut own = if checked.is_err() { WRONG } else { 0 };
    own |= if arrays.normals.is_some() { NORMALS } else { 0 };
    own |= if arrays.vertex_colors.is_some() { COLORS } else { 0 };
    let block = [own, arrays.positions.len() as u64].map(u64::to_le_bytes).concat();
    let mut all = Vec::new();
    for (rank, block) in comm.all_gather(block)?.iter().enumerate() {
        let &[has, vertices] = block.as_chunks().0 else {
            return Err(CommError::Transport { rank, reason: "what its arrays have".into() }.into());
        };
        all.push((u64::from_le_bytes(has), u64::from_le_bytes(vertices)));
    }
    checked.map_err(LoadError::from)?;
    if let Some(rank) = all.iter().position(|(has, _)| has & WRONG > 0) {
        return Err(ParallelError::from(PartsError::Failed { rank }).into());
    }
    // An empty part has what the others have.
    let mut of_vertices = all.iter().enumerate().filter(|(_, (_, vertices))| *vertices > 0);
    let has = of_vertices.next().map_or(0, |(_, (has, _))| *has);
    if let Some((rank, _)) = of_vertices.find(|(_, (other, _))| *other != has) {
        let what = "other normals or colours";
        return Err(ParallelError::from(PartsError::Differs { rank, what }).into());
    }
    let bounds = bounds_of_all(comm, &arrays.bounds())?;
    let mut mesh = arrays.mesh(choose_origin(&bounds));
    if arrays.positions.is_empty() {
        mesh.normals = (has & NORMALS > 0).then(Vec::new);
        mesh.vertex_colors = (has & COLORS > 0).then(Vec::new);
    }
    let (faces, vertices) = (mesh.triangles.len() as u64, all.iter().map(|(_, vertices)| vertices).sum());
    let numbers = Numbers::consecutive(comm, &mesh)?;
    Ok(Raw { mesh, read: ReadReport::default(), numbers, faces, vertices })
}

/// A file that is this rank's own.
fn own_file(comm: &mut impl Communicator, input: &Input, options: &ReadOptions) -> Result<Raw, Error> {
    let model = settled(comm, Aabb::EMPTY, options, |options| Ok(io::read_input(input, options)?))?;
    let numbers = Numbers::consecutive(comm, &model.mesh)?;
    let [vertices] = all_sum(comm, [model.mesh.positions.len() as u64])?;
    let last =
        model.mesh.face_of_triangle.as_ref().map(|faces| faces.last().map_or(0, |&last| u64::from(last) + 1));
    let faces = last.unwrap_or(model.mesh.triangles.len() as u64);
    let ReadModel { mesh, report: read, .. } = model;
    Ok(Raw { mesh, read, numbers, faces, vertices })
}

/// Reads a part, with the origin of the whole model, and settles what depends on that. `unused` are the coordinates of vertices
/// that are in no part.
fn settled(
    comm: &mut impl Communicator,
    unused: Aabb,
    options: &ReadOptions,
    read: impl Fn(&ReadOptions) -> Result<ReadModel, LoadError>,
) -> Result<ReadModel, Error> {
    let mut model = read(options)?;
    let own = unused.union(model.coordinates);
    let bounds = bounds_of_all(comm, &own)?;
    let origin = choose_origin(&bounds);
    if origin != model.mesh.origin && !model.mesh.positions.is_empty() {
        model = read(&ReadOptions { origin: Some(origin), progress: None, ..*options })?;
    }
    model.mesh.origin = origin;
    let [facts] = all_reduce(comm, [Facts::of(&model).bits()], |[a], [b]| [a | b])?;
    Facts::from_bits(facts).settle(&mut model);
    Ok(model)
}

/// From the faces of a part to its clusters.
fn finish(
    comm: &mut impl Communicator,
    path: &Path,
    raw: Raw,
    options: &LoadOptions,
    start: Instant,
) -> Result<LoadedPart, Error> {
    let Raw { mut mesh, read, numbers, faces, vertices } = raw;
    let mut report = LoadReport { read, file_normals: mesh.normals.is_some(), ..LoadReport::default() };
    report.times.read = milliseconds(start);
    check_size(path, &mesh)?;
    let has_faces = mesh.face_of_triangle.is_some();
    // A model is a triangle soup if all parts are, and no vertex is left over.
    let is_soup = u64::from(!weld::is_soup(&mesh));
    let [others, triangles] = all_sum(comm, [is_soup, mesh.triangles.len() as u64])?;
    let is_soup = others == 0 && 3 * triangles == vertices;
    check_memory(
        path,
        options,
        "a part of the model and its making ready",
        preparation_bytes(&mesh, is_soup, options),
    )?;
    // Some files may have numbers of polygons and others not; parts have no edges, which alone need them.
    mesh.attributes.retain(|a| !Attribute::is_polygon(&a.name, a.domain));
    // Readers choose none for parts: those that each rank chose from its own values would make pictures depend on their number.
    mesh.attributes.iter_mut().for_each(|a| a.set_offset(0.0));
    check_arrays(comm, &mesh)?;
    let step = Instant::now();
    let joined = seam::join(comm, &mut mesh, &numbers)?;
    drop(numbers);
    let cleaned = clean::clean_part(&mut mesh, joined.clone());
    report.cleaned = cleaned.found;
    let [largest] = all_max(comm, [f64::from(cleaned.largest)])?;
    mesh.bring_into_range(largest as f32);
    report.times.clean = milliseconds(step);
    if is_soup {
        let step = Instant::now();
        report.welded = Some(weld::weld(&mut mesh));
        report.times.weld = milliseconds(step);
    }
    let step = Instant::now();
    report.mended_normals = make_normals(&mut mesh, options, &mut report.made_normals);
    report.times.normals = milliseconds(step);

    let step = Instant::now();
    drop_others(&mut mesh, &joined, &cleaned.own, has_faces);
    let blocks = BlockedMesh::new(mesh, Order::Auto);
    report.mesh = MeshSummary::from_blocks(&blocks);
    let partition = PartitionOptions { progress: options.progress, ..PartitionOptions::default() };
    let mesh = cluster::partition_blocks(blocks, &partition);
    report.times.partition = milliseconds(step);
    numbered(comm, mesh, faces, report, start)
}

/// Makes or mends normals; returns how many of the file were mended.
fn make_normals(mesh: &mut Mesh, options: &LoadOptions, made: &mut bool) -> u64 {
    let crease_angle = match options.normals {
        Normals::FileOrMade { crease_angle } => crease_angle,
        Normals::File => None,
    };
    if mesh.normals.is_none() && options.normals != Normals::File {
        normals::make_normals(mesh, crease_angle);
        *made = true;
    }
    normals::mend_normals(mesh, crease_angle)
}

/// Drops the triangles of other ranks. `joined` were the part's own ones when these came, `own` are those that are left.
fn drop_others(mesh: &mut Mesh, joined: &Range<usize>, own: &Range<usize>, has_faces: bool) {
    mesh.keep_triangles(own.clone());
    // Without numbers of faces before, those of the triangles that are left count the triangles of other ranks, too.
    if let Some(faces) = mesh.face_of_triangle.as_mut().filter(|_| !has_faces) {
        faces.iter_mut().for_each(|face| *face -= joined.start as u32);
        if own.len() == joined.len() {
            mesh.face_of_triangle = None;
        }
    }
}

/// A part whose place in the model is found together with the other ranks.
fn numbered(
    comm: &mut impl Communicator,
    mut mesh: cluster::ClusteredMesh,
    faces: u64,
    mut report: LoadReport,
    start: Instant,
) -> Result<LoadedPart, Error> {
    let share = number(comm, &mut mesh, faces)?;
    report.mesh.bounds = mesh.bounds;
    report.times.total = milliseconds(start);
    let loaded =
        Loaded { mesh: Arc::new(mesh), caps: None, whole: None, strokes: Strokes::default(), report };
    Ok(LoadedPart { loaded, share })
}

/// A range of a built-in model.
fn of_builtin(
    comm: &mut impl Communicator,
    name: &str,
    options: &LoadOptions,
    start: Instant,
) -> Result<LoadedPart, Error> {
    check_memory(name.as_ref(), options, "the model", builtin::needed_bytes(name)?)?;
    let mut loaded = options.load_mesh(name)?;
    let (rank, size) = (comm.rank() as u64, comm.size() as u64);
    let all = loaded.mesh.triangles.len() as u64;
    let own = (all * rank / size) as usize..(all * (rank + 1) / size) as usize;
    loaded.mesh.keep_triangles(own.clone());
    if let Some(faces) = &mut loaded.mesh.face_of_triangle {
        let first = faces.first().copied().unwrap_or_default();
        faces.iter_mut().for_each(|face| *face -= first);
    }
    let faces = own.len() as u64;
    let blocks = BlockedMesh::new(loaded.mesh, Order::Auto);
    loaded.report.mesh = MeshSummary::from_blocks(&blocks);
    let mesh = cluster::partition_blocks(blocks, &PartitionOptions::default());
    numbered(comm, mesh, faces, loaded.report, start)
}

/// A range of the clusters of a prepared model.
fn of_prepared(
    comm: &mut impl Communicator,
    input: &Input,
    options: &LoadOptions,
    start: Instant,
) -> Result<LoadedPart, Error> {
    let (rank, size) = (comm.rank(), comm.size());
    let read = ReadOptions {
        memory_limit: options.memory_limit,
        progress: options.progress,
        ..ReadOptions::default()
    };
    let parts = io::prepared::Parts::open(input, &read).map_err(LoadError::from)?;
    let (triangles, faces) = (parts.triangles(), parts.faces());
    let own = parts.hashes(rank, size);
    // Ranks have one hash more or less than others.
    let [most] = all_reduce(comm, [own.len() as u64], |[a], [b]| [a.max(b)])?;
    let mut block = vec![own.len() as u64];
    block.extend(&own);
    block.resize(most as usize + 1, 0);
    let mut hashes = Vec::new();
    for (from, block) in
        comm.all_gather(block.iter().flat_map(|n| n.to_le_bytes()).collect())?.iter().enumerate()
    {
        let numbers: Vec<u64> = block.as_chunks().0.iter().map(|&n| u64::from_le_bytes(n)).collect();
        let count = numbers.first().map_or(0, |&count| count as usize);
        let reason = || CommError::Transport { rank: from, reason: format!("{count} hashes of a model") };
        hashes.extend(numbers.get(1..).and_then(|rest| rest.get(..count)).ok_or_else(reason)?);
    }
    let (prepared, whole) = parts.take(rank, size, &hashes).map_err(LoadError::from)?;
    agree(comm, whole.checksum, "another prepared model")?;
    let loaded = prepared::loaded(input, prepared, start)?;
    let share = Share { triangles, faces, has_whole_numbers: true, ..Share::default() };
    Ok(LoadedPart { loaded, share })
}

/// Fails if the parts do not have the same arrays.
fn check_arrays(comm: &mut impl Communicator, mesh: &Mesh) -> Result<(), Error> {
    let attributes: Vec<_> = mesh.attributes.iter().map(|a| (&a.name, a.domain)).collect();
    let arrays = format!(
        "{} {} {} {} {} {attributes:?} {:?}",
        mesh.normals.is_some(),
        mesh.vertex_colors.is_some(),
        mesh.face_colors.is_some(),
        mesh.texcoords.is_some(),
        mesh.triangle_materials.is_some(),
        mesh.materials
    );
    let what = "other normals, colours, texture coordinates, materials or attributes";
    Ok(agree(comm, tercio_mesh::checksum::of(arrays.as_bytes()), what)?)
}

fn unsupported(model: &Path, what: &str) -> LoadError {
    tercio_mesh::ReadError::Unsupported {
        file: model.display().to_string(),
        place: tercio_mesh::Place::File,
        what: what.into(),
    }
    .into()
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
