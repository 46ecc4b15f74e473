//! Checksums of large arrays, computed by all threads.

use rayon::prelude::*;
use twox_hash::XxHash3_64;

/// Bytes that are hashed at a time.
pub const CHUNK: usize = 1 << 20;

/// XXH3 of the XXH3 hashes, little-endian, of all chunks of [`CHUNK`] bytes.
pub fn of(bytes: &[u8]) -> u64 {
    of_chunks(&bytes.par_chunks(CHUNK).map(XxHash3_64::oneshot).collect::<Vec<u64>>())
}

/// The checksum from the hashes of the chunks.
fn of_chunks(hashes: &[u64]) -> u64 {
    let bytes: Vec<u8> = hashes.iter().flat_map(|hash| hash.to_le_bytes()).collect();
    XxHash3_64::oneshot(&bytes)
}

/// Is this the checksum of the bytes? A fuzzer would never find one, so under a fuzzer every checksum is accepted.
pub fn matches(bytes: &[u8], checksum: u64) -> bool {
    cfg!(fuzzing) || of(bytes) == checksum
}
