//! Exact simulators of the published machines: pure functions of a machine and a workload.
//!
//! | module | document | what is simulated |
//! |---|---|---|
//! | [`ring`] | 000, appendix A | polygons on a ring of processors, pass by pass |
//! | [`parks`] | 002 | scan conversion by the processors of splitter, interlace and hybrid |
//! | [`mcmanus`] | 003 | raster cycles and silicon of pixel processor arrays |
//! | [`ortega`] | 004 | data-parallel passes over polygons and segments |

pub mod mcmanus;
pub mod ortega;
pub mod parks;
pub mod ring;
