//! Polygon rendering on a ring of processors, pass by pass (document 000: Eldridge 1995, appendix A).
//!
//! Processors form a ring, each with a slot for one polygon descriptor, a queue of polygons to send and a list of
//! polygons received. In a pass of stride d all slots move d processors to the right at once; then each processor looks
//! at its slot and keeps a copy if it is among the descriptor's destinations. A descriptor that all processors have
//! seen frees its slot, which is noticed every t passes; a processor whose slot is free fills it from its queue.
//!
//! [`machine`] has the costs of a machine and the parameters of the algorithm; [`destinations`] computes the
//! destinations and the sender of each polygon; [`stage`] runs the passes of one stride; [`receipts`] makes the three
//! checks of appendix A.3; [`compositing`] is the second half of sort-twice. [`mod@stepwise`] moves every slot in every
//! pass as in appendix A.2.2; it is the reference against which [`stage`], which only processes slots with events, is
//! tested.
//!
//! Points that the document leaves open: a processor keeps its own polygons before a stage begins, and those with no
//! other destination never take a slot (figure A-6 has such a polygon); the ring runs until the last slot is free.

pub mod compositing;
pub mod destinations;
pub mod machine;
pub mod receipts;
mod simulate;
pub mod stage;
pub mod stepwise;
#[cfg(test)]
mod tests;

pub use machine::{Algorithm, AlgorithmError, Machine};
pub use receipts::Checks;
pub use simulate::{GeometryRun, RasterRun, RingRun, StageRun, simulate};
