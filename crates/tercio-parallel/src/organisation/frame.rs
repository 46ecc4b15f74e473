//! The steps of a frame, as one of several ranks takes them.

use std::time::Instant;

use rayon::scope;
use tercio_mesh::loops::prelude::*;
use tercio_raster::context::FrameContext;
use tercio_raster::frame::{FragmentsOfTile, TileFragments};
use tercio_raster::stats::FrontEndCounts;
use tercio_raster::{ClusterSet, Frame, FrameStats, RenderError, SampleShading, Settings, TileSet};

use super::collect::{self, Finished, composited_planes};
use super::depth_bounds::{self, Others};
use super::envelope::FrameComm;
use super::front_first;
use super::redistribute::redistribute;
use super::rounds::Rounds;
use super::{Organisation, Rank, Sharing, Task, clusters, divided, group_of, is_translucent, tile_edge};
use crate::comm::{Communicator, Group, Kind};
use crate::composite::exchange::{Content, Parts, exchange};
use crate::composite::packet::{only_drawn, pack_all, pack_drawn};
use crate::composite::{Encoding, Shared, Touched};
use crate::division::tiles_of;
use crate::{ParallelError, RankReport};

/// A rank's part of a frame of several ranks.
pub fn draw(
    own: &mut Rank,
    comm: &mut FrameComm<'_, impl Communicator>,
    task: &Task,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    if let Some(counts) = draw_steps(own, comm, task, frame, report)? {
        (report.frame.frontend, frame.stats.frontend) = (counts, counts);
    }
    Ok(())
}

/// Takes the steps. Returns the counts of the front end over this rank's own clusters, if it sorted those of other ranks, too.
fn draw_steps(
    own: &mut Rank,
    comm: &mut FrameComm<'_, impl Communicator>,
    task: &Task,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<Option<FrontEndCounts>, ParallelError> {
    let Task { sharing, scene, camera, settings } = *task;
    let (rank, size) = (comm.rank(), comm.size());
    let in_parts = scene.is_in_parts();
    let shares_clusters = sharing.organisation != Organisation::SortFirst && !in_parts;
    let has_fragments = settings.sampling.pattern.count() > 1 || is_translucent(scene);
    let sends_all = sharing.encoding == Encoding::Dense && sharing.organisation.composites(size);
    if has_fragments && sends_all {
        return Err(RenderError::Setting {
            what: "the encoding of composited pixels",
            range: match is_translucent(scene) {
                true => "visible or sparse where something is not opaque, as a material, a colour or an edge of this scene is",
                false => "visible or sparse where there are several samples per pixel",
            }
            .into(),
            value: sharing.encoding.to_string(),
        }
        .into());
    }
    let threads = rayon::current_num_threads();
    let tile_size = Some(tile_edge(scene, settings, sharing.organisation, size));
    let whole = Settings { clusters: ClusterSet::ALL, tiles: TileSet::ALL, tile_size, ..settings.clone() };
    let mut context = FrameContext::new(scene, camera, &whole, threads)?;
    let tiles = context.grid.count();
    if shares_clusters {
        context.drawn_clusters = divided::clusters(&sharing, &context, (rank, size), report);
    }
    report.clusters =
        context.drawn_clusters.ranges(context.clusters()).iter().map(|range| range.len() as u64).sum();

    // The ranks that share the tiles with this one.
    let members = group_of(sharing.organisation, size, rank);
    let owners = divided::owners(own, comm, task, &context, &members, report)?;
    let own_tiles = tiles_of(&owners, rank - members.start);
    // Of models in parts, the clusters of this rank's tiles, which are then sorted into these.
    let gathered;
    let (mut scene, mut counts) = (scene, None);
    if in_parts {
        own.held.begin(&members, clusters::needs_faces(&context), context.is_wide());
    }
    if in_parts && members.len() > 1 {
        own.sort(&context, report);
        counts = Some(own.sorted.front_end_counts());
        comm.begin(Kind::Clusters);
        let mut group = Group::new(comm, members.clone());
        gathered = clusters::exchange(&mut group, &owners, &context, &own.sorted, &mut own.held, report)?;
        scene = &gathered;
        context = FrameContext::new(scene, camera, &whole, threads)?;
    }
    let task = &Task { scene, ..*task };
    if !shares_clusters && members.len() > 1 {
        context.grid.drawn = own_tiles.clone();
    }
    own.sort(&context, report);
    if shares_clusters && members.len() > 1 {
        comm.begin(Kind::Bins);
        redistribute(&mut Group::new(comm, members.clone()), &owners, &context, &mut own.sorted, report)?;
    }
    let sorted_into = own.sorted.tiles_with_entries(&context.grid);
    let may_show = |tile: &u32| sends_all || sorted_into.contains(*tile);
    let own_touched: Vec<u32> = own_tiles.numbers(tiles).filter(may_show).collect();

    // Rank 0 has the whole picture in the end.
    frame.resize(&whole);
    if !sharing.organisation.composites(size) {
        own.draw_finished(&context, &own_touched, frame, report);
        let has_tiles = |rank: &usize| owners.contains(&(*rank as u32));
        let finished = Finished { tiles: &own_touched, packets: Parts::new() };
        finish(own, comm, &context, finished, has_tiles, frame, report)?;
        return Ok(counts);
    }

    comm.begin(Kind::Touched);
    let touched = Touched::gather(
        comm,
        tiles,
        |tile| own_touched.binary_search(&tile).is_ok(),
        &mut report.stages.wait,
    )?;
    let shared = touched.shared();
    let mut finished = own_touched;
    finished.retain(|tile| shared.binary_search(tile).is_err());
    let ranks = touched.ranks_of_any(&shared);
    let all = Shared { tiles: &shared, ranks: &ranks, touched: &touched };
    let is_shared_by = |rank: usize| ranks.binary_search(&rank).is_ok();
    let finishes_blocks = sharing.encoding == Encoding::Visible && has_fragments && context.has_blocks();
    let mut bounds = None;
    if finishes_blocks && is_shared_by(rank) {
        comm.begin(Kind::DepthBounds);
        bounds = Some(depth_bounds::send(comm, &context, &own.sorted, &all, &mut report.stages)?);
    }
    own.draw_finished(&context, &finished, frame, report);
    let others = match bounds {
        Some(bounds) => Some(bounds.receive(comm, &context, &all, &mut report.stages)?),
        None => None,
    };
    let (packets, owns) = if has_fragments {
        composite_fragments(own, comm, task, &context, others, &all, &mut finished, frame, report)?
    } else {
        composite_pixels(own, comm, task, &context, &all, frame, report)?
    };
    let finished = Finished { tiles: &finished, packets };
    let sends = |rank: &usize| {
        touched.has_sole(*rank, &shared) || owns.contains(rank) || finishes_blocks && is_shared_by(*rank)
    };
    finish(own, comm, &context, finished, sends, frame, report)?;
    Ok(counts)
}

/// Brings finished tiles to rank 0; `sends` returns which ranks have some.
fn finish(
    own: &mut Rank,
    comm: &mut FrameComm<'_, impl Communicator>,
    context: &FrameContext,
    finished: Finished,
    sends: impl Fn(&usize) -> bool,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    comm.begin(Kind::Finished);
    let rank = comm.rank();
    if rank > 0 {
        if sends(&rank) {
            collect::send(comm, context, &finished, frame, report)?;
        }
        return Ok(());
    }
    report.stages.collect.time(|| {
        let is_drawn = |tile: u32| finished.tiles.binary_search(&tile).is_ok();
        let others = TileSet::from_fn(context.grid.count(), |tile| !is_drawn(tile));
        own.renderer.clear(context, &others, frame);
    });
    let senders = (1..comm.size()).filter(sends);
    collect::receive(comm, context, &finished, senders, frame, report)?;
    frame.stats = report.frame.clone();
    Ok(())
}

impl Rank {
    /// The front end.
    fn sort(&mut self, context: &FrameContext, report: &mut RankReport) {
        let Self { renderer, sorted, .. } = self;
        let stages = &mut report.stages;
        let begin = Instant::now();
        // Of models in parts there are two sorts.
        let before = (stages.front_end.milliseconds, stages.front_end.busy_milliseconds);
        scope(|_| stages.front_end.time(|| renderer.sort(context, sorted)));
        stages.draw.milliseconds += stages.front_end.milliseconds - before.0;
        stages.draw.busy_milliseconds += stages.front_end.busy_milliseconds - before.1;
        report.frame.milliseconds.frontend += begin.elapsed().as_secs_f64() * 1e3;
    }

    /// Draws tiles as they are in the picture.
    fn draw_finished(
        &mut self,
        context: &FrameContext,
        tiles: &[u32],
        frame: &mut Frame,
        report: &mut RankReport,
    ) {
        self.draw_tiles(context, tiles, frame, report);
        report.pixels.visible = report.frame.backend.pixels_visible;
    }

    /// Draws some tiles; their counts are added to the report.
    pub fn draw_tiles(
        &mut self,
        context: &FrameContext,
        tiles: &[u32],
        frame: &mut Frame,
        report: &mut RankReport,
    ) {
        let set = TileSet::from_fn(context.grid.count(), |tile| tiles.binary_search(&tile).is_ok());
        let Self { renderer, sorted, last_frame, .. } = self;
        let stage = &mut report.stages.draw;
        scope(|_| stage.time(|| renderer.draw(context, sorted, &set, frame)));
        last_frame.add(renderer.work_of_tiles());
        report.frame = plus(std::mem::take(&mut report.frame), &frame.stats, context.cells.count as u64);
    }
}

/// The counts of two parts of a frame that were drawn from the same bins.
fn plus(before: FrameStats, drawn: &FrameStats, samples: u64) -> FrameStats {
    let mut stats = drawn.clone();
    stats.backend = before.backend.plus(stats.backend).finish(samples);
    stats.milliseconds.backend += before.milliseconds.backend;
    stats.milliseconds.frontend = before.milliseconds.frontend;
    stats.milliseconds.total = stats.milliseconds.frontend + stats.milliseconds.backend;
    stats
}

/// What was composited: packets of the tiles that this rank owns, and all ranks that own tiles.
type Composited = (Parts, Vec<usize>);

/// Draws the shared tiles, and composites their pixels.
fn composite_pixels(
    own: &mut Rank,
    comm: &mut FrameComm<'_, impl Communicator>,
    task: &Task,
    context: &FrameContext,
    shared: &Shared,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<Composited, ParallelError> {
    let Sharing { composition, encoding, .. } = task.sharing;
    let planes = composited_planes(&task.settings.outputs, context.is_wide());
    let settings = Settings { outputs: planes, ..context.settings.clone() };
    let keyed = FrameContext::new(task.scene, task.camera, &settings, rayon::current_num_threads())?;
    if frame.planes.keys.is_empty() {
        frame.planes.keys = std::mem::take(&mut own.keys);
    }
    if frame.planes.ties.is_empty() {
        frame.planes.ties = std::mem::take(&mut own.ties);
    }
    frame.resize(&settings);
    let tiles = shared.tiles_of(comm.rank());
    own.draw_tiles(&keyed, &tiles, frame, report);
    let parts = report.stages.compose.time(|| {
        let drawn = &*frame;
        let pack = |&tile: &u32| {
            let mut packet = Vec::new();
            let rect = keyed.grid.rect(tile, keyed.size());
            match encoding {
                Encoding::Visible | Encoding::Sparse => _ = pack_drawn(drawn, rect, &planes, &mut packet),
                Encoding::Dense => pack_all(drawn, rect, &planes, &mut packet),
            }
            (tile, packet)
        };
        let packets: Vec<(u32, Vec<u8>)> = tiles.par_iter().with_max_len(1).map(pack).collect();
        packets.into_iter().filter(|(_, packet)| !packet.is_empty()).collect()
    });
    if !task.settings.outputs.keys {
        own.keys = std::mem::take(&mut frame.planes.keys);
    }
    if !task.settings.outputs.ties {
        own.ties = std::mem::take(&mut frame.planes.ties);
    }
    let content = Content::Pixels { planes, width: task.settings.width };
    comm.begin(Kind::Pixels);
    let mut packets = exchange(comm, composition, shared, parts, content, report)?;
    if encoding == Encoding::Dense {
        // Rank 0 needs only what is drawn.
        let from = comm.rank();
        let whole: Vec<(u32, Vec<u8>)> = packets.into_iter().collect();
        let drawn = |(tile, packet): &(u32, Vec<u8>)| match only_drawn(packet, &planes) {
            Ok(drawn) => Ok((*tile, drawn)),
            Err(source) => Err(ParallelError::Packet { from, source }),
        };
        let drawn: Result<Vec<(u32, Vec<u8>)>, ParallelError> =
            report.stages.compose.time(|| whole.par_iter().with_max_len(1).map(drawn).collect());
        packets = drawn?.into_iter().filter(|(_, packet)| !packet.is_empty()).collect();
    }
    let owners = composition.owners(shared);
    Ok((packets, owners.into_iter().map(|place| shared.ranks[place]).collect()))
}

/// Draws the shared tiles, and composites their fragments, in rounds. In the frame are then finished the tiles that this rank owns, and,
/// where it is known how near others may draw, its finished pixels of the other ones.
#[expect(clippy::too_many_arguments, reason = "one call site; a struct would only rename them")]
fn composite_fragments(
    own: &mut Rank,
    comm: &mut FrameComm<'_, impl Communicator>,
    task: &Task,
    context: &FrameContext,
    mut others: Option<Others>,
    shared: &Shared,
    finished: &mut Vec<u32>,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<Composited, ParallelError> {
    let settings = Settings { keep_fragments: true, ..context.settings.clone() };
    let mut drawing = FrameContext::new(task.scene, task.camera, &settings, rayon::current_num_threads())?;
    let content = Content::Fragments(drawing.fragment_merger(&drawing.settings.outputs));
    let finishes_blocks = others.is_some();
    let (rank, composition) = (comm.rank(), task.sharing.composition);
    let mut owners = Vec::new();
    let mut rounds = match is_translucent(task.scene) {
        true => rounds_of(&drawing, own, rank, shared),
        false => Rounds::whole(shared.tiles.len()),
    };
    // Rank 0 leads the rounds.
    let takes_part = |rank: usize| rank == 0 || shared.ranks.binary_search(&rank).is_ok();
    while takes_part(rank) {
        comm.begin(Kind::Round);
        let Some(round) = rounds.next(comm, takes_part, &mut report.stages.wait)? else { break };
        let tiles = &shared.tiles[round.clone()];
        let ranks = shared.touched.ranks_of_any(tiles);
        let of_round = Shared { tiles, ranks: &ranks, touched: shared.touched };
        let touched = of_round.tiles_of(rank);
        // If ranks tell what they hide, there is one round.
        let drawn = match others.take() {
            Some(others) => {
                comm.begin(Kind::Occlusion);
                front_first::draw(own, comm, &mut drawing, others, &of_round, frame, report)?
            }
            None => {
                own.draw_tiles(&drawing, &touched, frame, report);
                std::mem::take(&mut frame.fragments)
            }
        };
        rounds.found(&round, drawn.iter().map(|of_tile| of_tile.bytes.len() as u64).sum());
        report.pixels.visible += drawn.iter().map(|of_tile| of_tile.finished.pixels).sum::<u64>();
        let has_fragments = drawn.into_iter().filter(|of_tile| !of_tile.bytes.is_empty());
        let parts = has_fragments.map(|TileFragments { tile, bytes, .. }| (tile, bytes)).collect();
        comm.begin(Kind::Fragments);
        let merged = exchange(comm, composition, &of_round, parts, content, report)?;
        let of_tiles: Vec<usize> =
            composition.owners(&of_round).into_iter().map(|place| ranks[place]).collect();
        let owned: Vec<FragmentsOfTile> = tiles
            .iter()
            .zip(&of_tiles)
            .filter(|(_, owner)| **owner == rank)
            .map(|(&tile, _)| FragmentsOfTile {
                tile,
                parts: merged.get(&tile).map(|bytes| &bytes[..]).into_iter().collect(),
                // The owner may have drawn nothing in it.
                has_finished: finishes_blocks && shared.touched.is_touched(rank, tile),
            })
            .collect();
        let stage = &mut report.stages.compose;
        report.pixels.visible += scope(|_| stage.time(|| own.renderer.merge(context, &owned, frame)))?;
        finished.extend(owned.iter().map(|of| of.tile));
        if finishes_blocks {
            finished.extend(touched);
        }
        owners.extend(of_tiles);
    }
    finished.sort_unstable();
    finished.dedup();
    Ok((Parts::new(), owners))
}

/// The rounds for what is not opaque.
fn rounds_of(drawing: &FrameContext, own: &Rank, rank: usize, shared: &Shared) -> Rounds {
    let Settings { sampling, outputs, layer_memory, .. } = drawing.settings;
    let (count, layout) = (sampling.pattern.count(), drawing.fragment_layout(outputs));
    let of_pixel = match sampling.shading {
        SampleShading::Sample => count * layout.bytes(1),
        _ => layout.bytes(count),
    };
    let pixels = own.sorted.layer_pixels(drawing);
    // There may be entries in tiles that other ranks of its group draw.
    let is_drawn = |tile: u32| shared.touched.is_touched(rank, tile);
    let bytes =
        |&tile: &u32| if is_drawn(tile) { pixels[tile as usize].saturating_mul(of_pixel as u64) } else { 0 };
    // All of a round may be of one rank, and the owner needs as much again.
    Rounds::new(shared.tiles.iter().map(bytes).collect(), *layer_memory as u64 / 2)
}
