//! Collects the owners' finished pixels on rank 0.

use tercio_raster::frame::Pixel;
use tercio_raster::{Frame, Outputs};
use tercio_scene::Background;

use super::packet::{pack, unpack};
use crate::comm::Communicator;
use crate::regions::{Region, Regions};
use crate::{ParallelError, RankReport};

/// Sends the drawn pixels to rank 0, whose frame must already have the background where nothing is drawn. Every frame
/// has keys in the regions of its rank; `planes` are sent.
///
/// # Errors
/// [`ParallelError::Comm`], [`ParallelError::Packet`].
pub fn collect(
    comm: &mut impl Communicator,
    regions: &Regions,
    planes: &Outputs,
    frame: &mut Frame,
    report: &mut RankReport,
) -> Result<(), ParallelError> {
    let rank = comm.rank();
    let stages = &mut report.stages;
    if rank > 0 {
        let mut message = comm.buffer(0);
        report.pixels.visible += stages.collect.time(|| {
            let pack_region = |region: Region| {
                pack(frame, &region, planes, &mut message);
                shown(frame, &region)
            };
            regions.of(rank).map(pack_region).sum::<u64>()
        });
        comm.gather(regions.owners(), message)?;
        return Ok(());
    }
    report.pixels.visible +=
        stages.collect.time(|| regions.of(0).map(|region| shown(frame, &region)).sum::<u64>());
    let messages = stages.wait.time(|| comm.gather(regions.owners(), Vec::new()))?;
    for (from, message) in (1..).zip(messages) {
        let done = stages.collect.time(|| unpack(&message, planes, false, frame));
        done.map_err(|source| ParallelError::Packet { from, source })?;
        comm.give_back(from, message);
    }
    Ok(())
}

/// Number of drawn pixels in a region.
fn shown(frame: &Frame, region: &Region) -> u64 {
    let row = |y: u32| {
        let first = y as usize * frame.width as usize;
        let keys = &frame.planes.keys[first + region.x.start as usize..first + region.x.end as usize];
        keys.iter().map(|&key| u64::from(key != 0)).sum::<u64>()
    };
    region.y.clone().map(row).sum()
}

/// Fills a region with the background.
pub fn clear(frame: &mut Frame, region: &Region, background: &Background) {
    for y in region.y.clone() {
        let first = y as usize * frame.width as usize + region.x.start as usize;
        let pixel = Pixel::of_background(background, y, frame.height);
        frame.planes.fill(first..first + region.x.len(), &pixel);
    }
}
