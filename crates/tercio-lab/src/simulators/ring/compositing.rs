//! The second half of sort-twice: the groups' pictures are composited (document 000, section 6.3).
//!
//! Processors r, r + g, r + 2g ... have rasterized region r. Each starts with a different pixel of the region and
//! passes it g processors on, where it is merged with the local copy, until all n/g copies are merged.

/// The processor that has pixel `j` of region `r` in the end (figures 6-2 and 6-3).
///
/// # Panics
/// If `group` does not divide `processors`.
pub fn owner(processors: u32, group: u32, region: u32, pixel: u64) -> u32 {
    assert!(group > 0 && processors.is_multiple_of(group), "groups divide the ring");
    let groups = u64::from(processors / group);
    region + group * (pixel % groups) as u32
}

/// The processor that starts passing pixel `j` of region `r`: the next in the ring after its owner that has a copy.
///
/// # Panics
/// If `group` does not divide `processors`.
pub fn start(processors: u32, group: u32, region: u32, pixel: u64) -> u32 {
    (owner(processors, group, region, pixel) + group) % processors
}

/// Passes that composite a screen of `pixels`: ceil(P/n) (n/g - 1), which is equation 6.2 where n divides P.
///
/// # Panics
/// If `group` does not divide `processors`.
pub fn passes(processors: u32, group: u32, pixels: u64) -> u64 {
    assert!(group > 0 && processors.is_multiple_of(group), "groups divide the ring");
    pixels.div_ceil(u64::from(processors)) * (u64::from(processors / group) - 1)
}
