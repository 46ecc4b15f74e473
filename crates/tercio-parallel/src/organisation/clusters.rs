//! Clusters of models in parts, sent to the ranks of the group that draw the tiles they reach.
//!
//! A message has a section for each instance of the scene: the number of its bytes (8 bytes, little-endian), then its clusters
//! ([`tercio_mesh::cluster::write_clusters`]), with the numbers of their faces if ids are drawn.

use std::sync::Arc;

use tercio_mesh::cluster::{Assembly, TransferError, write_clusters};
use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_scene::{Instance, Scene, Share};

use super::redistribute::tiles_of_owners;
use crate::comm::{CommError, Communicator, Group};
use crate::parts::PartsError;
use crate::{ParallelError, RankReport};

/// Bytes before the clusters of an instance.
const SECTION_HEAD: usize = size_of::<u64>();

/// Exchanges clusters between the ranks of a group, each of which has sorted those of its own parts into all tiles: returns the
/// scene with the clusters of all of them that may reach this rank's tiles. Their primitives and faces have their numbers in the
/// whole models. `owners` has the owner of each tile, a rank of the group.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Clusters`], [`PartsError::Whole`].
pub fn exchange(
    group: &mut Group<'_, impl Communicator>,
    owners: &[u32],
    context: &FrameContext,
    sorted: &Sorted,
    report: &mut RankReport,
) -> Result<Scene, ParallelError> {
    let (scene, has_faces) = (context.scene, context.settings.outputs.ids);
    let shares = shares_of(scene)?;
    let (own, count) = (group.rank(), group.size());
    let rank = group.outer_rank(own);
    let tiles = tiles_of_owners(owners, count);
    let stages = &mut report.stages;
    let mut write = |tiles: &[u32], message: &mut Vec<u8>| {
        let written = stages
            .redistribute
            .time(|| write(context, &shares, has_faces, &sorted.clusters_in(tiles), message));
        written.map_err(|source| ParallelError::Clusters { from: rank, source })
    };
    let mut sent = 0;
    // Every rank begins with the next one, so that no rank gets all messages at once.
    for to in (1..count).map(|step| (own + step) % count) {
        let mut message = group.buffer(to);
        write(&tiles[to], &mut message)?;
        sent += message.len() as u64;
        group.send(to, message)?;
    }
    let mut of_own = Vec::new();
    write(&tiles[own], &mut of_own)?;
    report.cluster_bytes = Some(sent);

    let mut gathered: Vec<Gathered> = Vec::new();
    for (instance, share) in scene.instances.iter().zip(&shares) {
        let faces = has_faces.then_some(share.faces);
        let assembly = Assembly::new(&instance.mesh, share.triangles, faces);
        gathered.push(Gathered { instance, share: *share, assembly, ends: Vec::new() });
    }
    let stages = &mut report.stages;
    stages.redistribute.time(|| read(&mut gathered, rank, &of_own))?;
    drop(of_own);
    for from in (1..count).map(|step| (own + count - step) % count) {
        let message = stages.wait.time(|| group.receive(from))?;
        stages.redistribute.time(|| read(&mut gathered, group.outer_rank(from), &message))?;
        group.give_back(from, message);
    }
    let finish = |of: Gathered| of.finish(scene);
    let instances =
        stages.redistribute.time(|| gathered.into_iter().map(finish).collect::<Result<_, _>>())?;
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
    assembly: Assembly<'a>,
    /// Each sender, and the number of clusters after its own.
    ends: Vec<(usize, usize)>,
}

impl Gathered<'_> {
    /// The instance with the clusters, all of which are checked.
    fn finish(self, scene: &Scene) -> Result<Instance, ParallelError> {
        let Self { instance, share, assembly, ends } = self;
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
        let share = Some(Share { first_triangle: 0, first_face: 0, has_whole_numbers: true, ..share });
        Ok(Instance { mesh: Arc::new(mesh), materials, share, ..instance.clone() })
    }
}

fn shares_of(scene: &Scene) -> Result<Vec<Share>, PartsError> {
    let of_instance = |(instance, of): (usize, &Instance)| of.share.ok_or(PartsError::Whole { instance });
    scene.instances.iter().enumerate().map(of_instance).collect()
}

/// Appends a message of some clusters of the frame, in ascending order.
fn write(
    context: &FrameContext,
    shares: &[Share],
    has_faces: bool,
    clusters: &[u32],
    out: &mut Vec<u8>,
) -> Result<(), TransferError> {
    let mut rest = clusters;
    for (number, (instance, share)) in context.scene.instances.iter().zip(shares).enumerate() {
        let count = rest.partition_point(|&cluster| context.locate(cluster).0 <= number);
        let (own, behind) = rest.split_at(count);
        rest = behind;
        let begin = out.len() + SECTION_HEAD;
        out.extend([0; SECTION_HEAD]);
        let own = own.iter().map(|&cluster| context.locate(cluster).1);
        let first_face = has_faces.then_some(share.first_face);
        write_clusters(&instance.mesh, own, share.first_triangle, first_face, out)?;
        let bytes = (out.len() - begin) as u64;
        out[begin - SECTION_HEAD..begin].copy_from_slice(&bytes.to_le_bytes());
    }
    Ok(())
}

/// Adds the clusters of a message to those of each instance.
fn read(gathered: &mut [Gathered], from: usize, message: &[u8]) -> Result<(), ParallelError> {
    let (instances, mut rest) = (gathered.len(), message);
    let wrong = || {
        let reason = format!("{} bytes that are not clusters of {instances} instances", message.len());
        CommError::Transport { rank: from, reason }
    };
    for Gathered { assembly, ends, .. } in gathered {
        let (head, behind) = rest.split_first_chunk::<SECTION_HEAD>().ok_or_else(wrong)?;
        let bytes = usize::try_from(u64::from_le_bytes(*head)).map_err(|_| wrong())?;
        let (clusters, behind) = behind.split_at_checked(bytes).ok_or_else(wrong)?;
        assembly.read(clusters).map_err(|source| ParallelError::Clusters { from, source })?;
        ends.push((from, assembly.clusters()));
        rest = behind;
    }
    if rest.is_empty() { Ok(()) } else { Err(wrong().into()) }
}
