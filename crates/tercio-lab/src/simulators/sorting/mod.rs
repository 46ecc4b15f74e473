//! Where to sort, at scale: sort-first, -middle, -last and -twice on up to a million processors.
//!
//! Polygons, given by their boxes on the screen, are dealt out to processors; regions of the screen have owners;
//! every message is put on the links that it passes. From this follow exactly: what each processor computes, what
//! each link carries, how many hops and messages there are. Time is then a model: a phase of computing lasts as long
//! as its busiest processor; a phase of communication as long as its busiest link is busy, plus the hops of its
//! longest way, plus what its busiest processor spends on sending or taking messages. Routing that does not get in
//! its own way reaches the sum of the first two up to a constant (Leighton, Maggs and Rao, 1988), so these are lower
//! bounds that good networks come near.
//!
//! | module | what |
//! |---|---|
//! | [`network`] | ring, mesh, fat tree, crossbar: who shares which link |
//! | [`regions`] | who owns which part of the screen |
//! | [`organisation`] | the four classes, phase by phase |

pub mod network;
pub mod organisation;
pub mod regions;

pub use network::{Links, NetworkModel, Traffic};
pub use organisation::{Computing, Costs, Organisation, Setting, SortReport, simulate, sweep};
pub use regions::{Assignment, Regions};
