//! Where to sort, at scale: sort-first, -middle, -last and -twice on up to a million processors.
//!
//! Polygons, given by their bounding boxes, are distributed over processors; regions of the screen have owners; every
//! message is added to the links of its path. The following is exact: the work of each processor, the load of each
//! link, the numbers of hops and messages. Time is then a model: a computing phase lasts as long as its busiest
//! processor; a communication phase as long as its busiest link is busy, plus the hops of its longest path, plus the
//! time that its busiest processor spends on sending or receiving messages. Routing without interference reaches the
//! sum of the first two up to a constant (Leighton, Maggs and Rao, 1988), so these are lower bounds that good networks
//! approach.
//!
//! | module | what |
//! |---|---|
//! | [`network`] | ring, mesh, fat tree, crossbar: who shares which link |
//! | [`regions`] | who owns which part of the screen |
//! | [`composition`] | how the groups' pictures become one, and how that is delivered |
//! | [`simd`] | rings that execute one instruction at a time |
//! | [`organisation`] | the four classes, phase by phase |

pub mod composition;
pub mod network;
pub mod organisation;
pub mod regions;
pub mod simd;

pub use network::{Links, NetworkModel, NodeModel, Traffic};
pub use organisation::{Computing, Costs, Organisation, Setting, SortReport, simulate, sweep, usual_group};
pub use regions::{Assignment, Regions};
