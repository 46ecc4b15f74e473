//! Clusters of models in parts, sent to the ranks of the group that draw the tiles they reach, unless these have them since the last
//! frame.
//!
//! A message has a section for each instance of the scene: the number of bytes of its clusters and the number of the sender's
//! clusters that the receiver has (8 bytes each, little-endian; none if the sender's part is another one than in the last
//! frame), for each of these a bit that says whether it is kept (in whole bytes, the lowest first), then the new clusters
//! ([`tercio_mesh::cluster::write_clusters`]), with the numbers of their faces if these are drawn, as ids or as data.
//!
//! Clusters have numbers of 32 bits: those in the whole model, if no number in the scene needs more. Otherwise they keep those in the
//! sender's part, the numbers of whose first triangle and first face in the whole model are sent, too (8 bytes each, after the two
//! numbers above); then the receiver has an instance for each sender.

use std::ops::Range;
use std::sync::Arc;

use tercio_mesh::cluster::{Assembly, TransferError, write_clusters};
use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_scene::{DataSource, Instance, Scene, Share, SurfaceData};

use super::held::{Held, Kept, Migration};
use super::redistribute::tiles_of_owners;
use crate::comm::{CommError, Communicator, Group};
use crate::parts::PartsError;
use crate::{ParallelError, RankReport};

/// Bytes before what is said of an instance.
const SECTION_HEAD: usize = 2 * size_of::<u64>();

/// Exchanges clusters between the ranks of a group, each of which has sorted those of its own parts into all tiles: returns the
/// scene with the clusters of all of them that may reach this rank's tiles. Their primitives and faces have the numbers that they
/// have in the whole scene. `owners` has the owner of each tile, a rank of the group; `held` is of the same group, and empty after an error.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Clusters`], [`PartsError::Whole`].
pub fn exchange(
    group: &mut Group<'_, impl Communicator>,
    owners: &[u32],
    context: &FrameContext,
    sorted: &Sorted,
    held: &mut Held,
    report: &mut RankReport,
) -> Result<Scene, ParallelError> {
    held.keep_instances(context.scene.instances.len());
    let exchanged = exchange_some(group, owners, context, sorted, held, report);
    if exchanged.is_err() {
        *held = Held::default();
    }
    exchanged
}

/// Are the numbers of faces drawn, as ids or as data?
pub fn needs_faces(context: &FrameContext) -> bool {
    let shows_faces = |instance: &Instance| {
        let data = instance.data.as_deref();
        matches!(data, Some(SurfaceData::Mapped { source: DataSource::Face, .. }))
    };
    context.settings.outputs.ids || context.scene.instances.iter().any(shows_faces)
}

/// [`exchange`] of what others have not.
fn exchange_some(
    group: &mut Group<'_, impl Communicator>,
    owners: &[u32],
    context: &FrameContext,
    sorted: &Sorted,
    held: &mut Held,
    report: &mut RankReport,
) -> Result<Scene, ParallelError> {
    let (scene, has_faces) = (context.scene, needs_faces(context));
    let shares = shares_of(scene)?;
    let (own, count) = (group.rank(), group.size());
    let rank = group.outer_rank(own);
    let tiles = tiles_of_owners(owners, count);
    let stages = &mut report.stages;
    let mut write = |to: usize, message: &mut Vec<u8>| {
        let written = stages
            .redistribute
            .time(|| write(context, &shares, held, to, &sorted.clusters_in(&tiles[to]), message));
        written.map_err(|source| ParallelError::Clusters { from: rank, source })
    };
    let (mut sent, mut migrated, mut kept) = (0, 0, 0);
    // Every rank begins with the next one, so that no rank gets all messages at once.
    for to in (1..count).map(|step| (own + step) % count) {
        let mut message = group.buffer(to);
        let [new, had] = write(to, &mut message)?;
        (sent, migrated, kept) = (sent + message.len() as u64, migrated + new, kept + had);
        group.send(to, message)?;
    }
    let mut of_own = Vec::new();
    write(own, &mut of_own)?;
    report.cluster_bytes = Some(sent);
    (report.clusters_sent, report.clusters_kept) = (Some(migrated), Some(kept));

    let earlier = std::mem::take(&mut held.gathered);
    let mut gathered: Vec<Gathered> = Vec::new();
    for (number, (instance, share)) in scene.instances.iter().zip(&shares).enumerate() {
        let earlier = earlier.get(number).map_or(&[][..], Vec::as_slice);
        let mut of = Gathered { instance, share: *share, earlier, has_faces, base: None, pieces: Vec::new() };
        if context.is_wide() {
            of.base = Some(context.base(number));
        } else {
            of.pieces.push(of.piece([0; 2]));
        }
        gathered.push(of);
    }
    let stages = &mut report.stages;
    stages.redistribute.time(|| read(&mut gathered, rank, &of_own))?;
    drop(of_own);
    for from in (1..count).map(|step| (own + count - step) % count) {
        let message = stages.wait.time(|| group.receive(from))?;
        stages.redistribute.time(|| read(&mut gathered, group.outer_rank(from), &message))?;
        group.give_back(from, message);
    }
    let mut instances = Vec::new();
    for of in gathered {
        let finished = stages.redistribute.time(|| of.finish(scene))?;
        let kept = |(instance, ends): (Instance, Ends)| {
            let kept = Kept { mesh: instance.mesh.clone(), ends };
            instances.push(instance);
            kept
        };
        held.gathered.push(finished.into_iter().map(kept).collect());
    }
    Ok(Scene {
        instances,
        lights: scene.lights.clone(),
        environment: scene.environment.clone(),
        background: scene.background,
        materials: scene.materials.clone(),
        textures: scene.textures.clone(),
    })
}

/// Clusters of an instance from several ranks.
struct Gathered<'a> {
    instance: &'a Instance,
    share: Share,
    /// What this rank gathered for the last frame.
    earlier: &'a [Kept],
    has_faces: bool,
    /// If clusters keep the numbers of their senders' parts: those in the scene of the model's first triangle and first face.
    base: Option<[u64; 2]>,
    /// One for all senders, or one for each.
    pieces: Vec<Piece<'a>>,
}

/// Each sender, and the number of clusters after its own.
type Ends = Vec<(usize, usize)>;

/// Clusters whose numbers count from the same ones.
struct Piece<'a> {
    /// The numbers in the whole model of triangle 0 and face 0.
    first: [u64; 2],
    assembly: Assembly<'a>,
    ends: Ends,
}

impl<'a> Gathered<'a> {
    /// No clusters yet. Precondition: the numbers are not above those of the model.
    fn piece(&self, first: [u64; 2]) -> Piece<'a> {
        let faces = self.has_faces.then_some(self.share.faces - first[1]);
        let assembly = Assembly::new(&self.instance.mesh, self.share.triangles - first[0], faces);
        Piece { first, assembly, ends: Vec::new() }
    }

    /// What clusters of a rank were gathered for the last frame.
    fn earlier_of(&self, from: usize) -> (Option<&'a Kept>, Range<usize>) {
        let found = self.earlier.iter().map(|kept| (Some(kept), kept.of(from)));
        found.max_by_key(|(_, clusters)| clusters.len()).unwrap_or((None, 0..0))
    }

    /// The instances with the clusters, all of which are checked, and whose they are. There is always one, which has the bounds of
    /// the model.
    fn finish(mut self, scene: &Scene) -> Result<Vec<(Instance, Ends)>, ParallelError> {
        let pieces = std::mem::take(&mut self.pieces).into_iter().enumerate();
        let pieces = pieces.filter(|(number, piece)| *number == 0 || piece.assembly.clusters() > 0);
        pieces.map(|(_, piece)| self.finish_piece(piece, scene)).collect()
    }

    fn finish_piece(&self, piece: Piece, scene: &Scene) -> Result<(Instance, Ends), ParallelError> {
        let Self { instance, share, base, .. } = *self;
        let Piece { first, assembly, ends } = piece;
        let wrong = |(cluster, source): (usize, TransferError)| {
            let from = ends.iter().find(|(_, end)| cluster < *end).map_or(0, |(from, _)| *from);
            ParallelError::Clusters { from, source }
        };
        let mesh = assembly.finish().map_err(wrong)?;
        let materials = instance.materials.as_ref().map(|m| m.for_part(&mesh, scene, m.is_translucent()));
        if let Some(materials) = materials.as_ref().filter(|m| !m.is_translucent())
            && let Some(cluster) = (0..mesh.clusters().len()).find(|&c| materials.is_cluster_translucent(c))
        {
            let expected = "opaque materials, as in the model";
            return Err(wrong((cluster, TransferError::Cluster { cluster, expected })));
        }
        let [first_triangle, first_face] = first;
        let (has_whole_numbers, base) = (base.is_none(), base.or(share.base));
        let share = Some(Share { first_triangle, first_face, base, has_whole_numbers, ..share });
        Ok((Instance { mesh: Arc::new(mesh), materials, share, ..instance.clone() }, ends))
    }

    /// Adds those of the clusters from a rank that it still needs; the bits say which. There are no others than these.
    fn keep(&mut self, from: usize, is_kept: impl Iterator<Item = bool>) -> Result<(), TransferError> {
        let (Some(earlier), clusters) = self.earlier_of(from) else { return Ok(()) };
        let Some(piece) = self.pieces.last_mut() else { return Ok(()) };
        let kept = clusters.zip(is_kept).filter(|(_, is_kept)| *is_kept);
        piece.assembly.keep(&earlier.mesh, kept.map(|(cluster, _)| cluster))
    }
}

fn shares_of(scene: &Scene) -> Result<Vec<Share>, PartsError> {
    let of_instance = |(instance, of): (usize, &Instance)| of.share.ok_or(PartsError::Whole { instance });
    scene.instances.iter().enumerate().map(of_instance).collect()
}

/// Appends a message for a rank of the group that needs some clusters of the frame, in ascending order. Returns how many of them it
/// gets, and how many it has.
fn write(
    context: &FrameContext,
    shares: &[Share],
    held: &mut Held,
    to: usize,
    clusters: &[u32],
    out: &mut Vec<u8>,
) -> Result<[u64; 2], TransferError> {
    let (has_faces, is_wide) = (needs_faces(context), context.is_wide());
    let (mut rest, mut counts) = (clusters, [0, 0]);
    for (number, (instance, share)) in context.scene.instances.iter().zip(shares).enumerate() {
        let count = rest.partition_point(|&cluster| context.locate(cluster).0 <= number);
        let (own, behind) = rest.split_at(count);
        rest = behind;
        let needed: Vec<u32> = own.iter().map(|&cluster| context.locate(cluster).1 as u32).collect();
        let Migration { is_kept, new } = held.migrate(number, (instance, *share), to, &needed);
        counts = [counts[0] + new.len() as u64, counts[1] + (needed.len() - new.len()) as u64];
        let begin = out.len();
        out.extend([0; SECTION_HEAD]);
        let numbers = [share.first_triangle, share.first_face];
        if is_wide {
            out.extend(numbers.map(u64::to_le_bytes).as_flattened());
        }
        let byte = |bits: &[bool]| bits.iter().rev().fold(0, |byte: u8, &bit| byte << 1 | u8::from(bit));
        out.extend(is_kept.chunks(8).map(byte));
        let first = out.len();
        let [first_triangle, first_face] = if is_wide { [0; 2] } else { numbers };
        let new = new.iter().map(|&cluster| cluster as usize);
        write_clusters(&instance.mesh, new, first_triangle, has_faces.then_some(first_face), out)?;
        let bytes = (out.len() - first) as u64;
        let head = [bytes, is_kept.len() as u64].map(u64::to_le_bytes);
        out[begin..begin + SECTION_HEAD].copy_from_slice(head.as_flattened());
    }
    Ok(counts)
}

/// Adds the clusters of a message to those of each instance, with those that are kept.
fn read(gathered: &mut [Gathered], from: usize, message: &[u8]) -> Result<(), ParallelError> {
    let (instances, mut rest) = (gathered.len(), message);
    let wrong = || {
        let reason = format!("{} bytes that are not clusters of {instances} instances", message.len());
        CommError::Transport { rank: from, reason }
    };
    let number = |bytes: [u8; 8]| usize::try_from(u64::from_le_bytes(bytes)).map_err(|_| wrong());
    for of in gathered {
        let (bytes, behind) = rest.split_first_chunk().ok_or_else(wrong)?;
        let (had, behind) = behind.split_first_chunk().ok_or_else(wrong)?;
        let (bytes, had) = (number(*bytes)?, number(*had)?);
        let mut behind = behind;
        if of.base.is_some() {
            let (numbers, rest) = behind.split_first_chunk::<{ 2 * size_of::<u64>() }>().ok_or_else(wrong)?;
            let first: [u64; 2] = bytemuck::pod_read_unaligned::<[u64; 2]>(numbers).map(u64::from_le);
            if first[0] > of.share.triangles || first[1] > of.share.faces {
                return Err(wrong().into());
            }
            of.pieces.push(of.piece(first));
            behind = rest;
        }
        // The sender knows what this rank has of it, or begins anew.
        if had != 0 && of.earlier_of(from).1.len() != had {
            return Err(wrong().into());
        }
        let (bits, behind) = behind.split_at_checked(had.div_ceil(8)).ok_or_else(wrong)?;
        let (clusters, behind) = behind.split_at_checked(bytes).ok_or_else(wrong)?;
        let is_kept = bits.iter().flat_map(|byte| (0..8).map(move |bit| byte >> bit & 1 == 1));
        of.keep(from, is_kept).map_err(|source| ParallelError::Clusters { from, source })?;
        let Some(piece) = of.pieces.last_mut() else { return Err(wrong().into()) };
        piece.assembly.read(clusters).map_err(|source| ParallelError::Clusters { from, source })?;
        piece.ends.push((from, piece.assembly.clusters()));
        rest = behind;
    }
    if rest.is_empty() { Ok(()) } else { Err(wrong().into()) }
}
