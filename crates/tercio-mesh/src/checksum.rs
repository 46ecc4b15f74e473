//! Checksums of large arrays, computed by all threads.

use crate::loops::prelude::*;
use twox_hash::XxHash3_64;

/// Bytes that are hashed at a time.
pub const CHUNK: usize = 1 << 20;

/// XXH3 of the XXH3 hashes, little-endian, of all chunks of [`CHUNK`] bytes.
pub fn of(bytes: &[u8]) -> u64 {
    of_chunks(&bytes.par_chunks(CHUNK).map(XxHash3_64::oneshot).collect::<Vec<u64>>())
}

/// The hashes of all chunks of [`CHUNK`] bytes; the last may be shorter. `done` is called with each chunk that is hashed.
pub fn of_each_chunk(bytes: &[u8], done: impl Fn(&[u8]) + Sync) -> Vec<u64> {
    let hash = |chunk: &[u8]| {
        let hash = XxHash3_64::oneshot(chunk);
        done(chunk);
        hash
    };
    bytes.par_chunks(CHUNK).map(hash).collect()
}

/// The checksum of bytes from the hashes of their chunks.
pub fn of_chunks(hashes: &[u64]) -> u64 {
    let bytes: Vec<u8> = hashes.iter().flat_map(|hash| hash.to_le_bytes()).collect();
    XxHash3_64::oneshot(&bytes)
}

/// Is this the checksum of the bytes? A fuzzer would never find one, so under a fuzzer every checksum is accepted.
pub fn matches(bytes: &[u8], checksum: u64) -> bool {
    cfg!(fuzzing) || of(bytes) == checksum
}
