//! Exact simulators of the published machines: pure functions of a machine and a workload.
//!
//! | module | document | what is simulated |
//! |---|---|---|
//! | [`ring`] | 000, appendix A | polygons on a ring of processors, pass by pass |
//! | [`hybris`] | 001 | partitions, triangle heap, tile engines cycle by cycle, bus, two processors |
//! | [`parks`] | 002 | scan conversion by the processors of splitter, interlace and hybrid |
//! | [`mcmanus`] | 003 | raster cycles and silicon of pixel processor arrays |
//! | [`ortega`] | 004 | data-parallel passes over polygons and segments |
//! | [`sorting`] | 000 and 001 | sort-first, -middle, -last and -twice on networks of up to a million processors |

pub mod hybris;
pub mod mcmanus;
pub mod ortega;
pub mod parks;
pub mod ring;
pub mod sorting;
