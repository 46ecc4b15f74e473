//! Finished pixels, sent to rank 0.
//!
//! Only pixels that differ from the background are sent: rank 0 fills the tiles of the others with it first. So several ranks may
//! have finished pixels of one tile.

use tercio_mesh::loops::prelude::*;
use tercio_raster::context::FrameContext;
use tercio_raster::frame::Pixel;
use tercio_raster::{Frame, Outputs};

use crate::comm::{Awaited, Communicator};
use crate::composite::exchange::Parts;
use crate::composite::packet::{PacketError, count_pixels, pack_shown, unpack, without_keys};
use crate::{ParallelError, RankReport};

/// What a rank has finished.
pub struct Finished<'a> {
    /// Tiles whose pixels in the frame are those of the picture, or the background where other ranks have them.
    pub tiles: &'a [u32],
    /// Further tiles as packets of the [`composited_planes`].
    pub packets: Parts,
}

/// Sends the finished tiles of this rank to rank 0.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Packet`].
pub fn send(
    comm: &mut impl Communicator,
    context: &FrameContext,
    finished: &Finished,
    frame: &Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let outputs = &context.settings.outputs;
    let mut message = comm.buffer(0);
    let is_wide = context.is_wide();
    let packed = report.stages.collect.time(|| {
        let rows = 0..frame.height;
        let background =
            &Pixel::of_background_rows(&context.scene.background, rows, frame.height, outputs.linear);
        let pack = |tile: &u32, out: &mut Vec<u8>| {
            pack_shown(frame, context.grid.rect(*tile, context.size()), background, outputs, out);
        };
        if rayon::current_num_threads() == 1 {
            finished.tiles.iter().for_each(|tile| pack(tile, &mut message));
        } else {
            let packed = |tile| {
                let mut packet = Vec::new();
                pack(tile, &mut packet);
                packet
            };
            let packets: Vec<Vec<u8>> = finished.tiles.par_iter().map(packed).collect();
            packets.iter().for_each(|packet| message.extend_from_slice(packet));
        }
        strip(finished, outputs, is_wide, &mut message)
    });
    report.pixels.visible += packed.map_err(|source| ParallelError::Packet { from: comm.rank(), source })?;
    comm.send(0, message)?;
    Ok(())
}

/// The planes of packets that are composited for a frame with these.
pub fn composited_planes(outputs: &Outputs, is_wide: bool) -> Outputs {
    Outputs { keys: true, ties: outputs.ties || is_wide, ..*outputs }
}

/// Appends the packets without keys and ties, unless these are requested, and returns the number of their pixels.
fn strip(
    finished: &Finished,
    outputs: &Outputs,
    is_wide: bool,
    message: &mut Vec<u8>,
) -> Result<u64, PacketError> {
    let mut pixels = 0;
    let planes = composited_planes(outputs, is_wide);
    for packet in finished.packets.values() {
        if planes == *outputs {
            pixels += count_pixels(packet, &planes)?;
            message.extend_from_slice(packet);
        } else {
            pixels += without_keys(packet, &planes, outputs, message)?;
        }
    }
    Ok(pixels)
}

/// Completes the picture on rank 0, whose frame has the tiles that it drew, from the messages of the `senders`.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Packet`].
pub fn receive(
    comm: &mut impl Communicator,
    context: &FrameContext,
    finished: &Finished,
    senders: impl Iterator<Item = usize>,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let outputs = context.settings.outputs;
    let stages = &mut report.stages;
    let own = stages.collect.time(|| {
        let mut message = Vec::new();
        let pixels = strip(finished, &outputs, context.is_wide(), &mut message)?;
        unpack(&message, &outputs, frame)?;
        Ok(pixels)
    });
    report.pixels.visible += own.map_err(|source| ParallelError::Packet { from: comm.rank(), source })?;
    // In the order of arrival: a rank that is late delays nobody.
    let mut awaited = Awaited::new(senders);
    while !awaited.is_empty() {
        let (from, message) = stages.wait.time(|| comm.receive_any(&mut awaited))?;
        let done = stages.collect.time(|| unpack(&message, &outputs, frame));
        done.map_err(|source| ParallelError::Packet { from, source })?;
        comm.give_back(from, message);
    }
    Ok(())
}
