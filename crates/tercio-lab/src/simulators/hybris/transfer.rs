//! The bus between host and board: every transfer has a fixed cost, then bytes run at the bus's rate.
//!
//! Source: document 001, 4.5.1, which gives the two ends: 10 MB/s in blocks of 4 KiB, 100 MB/s in large ones. They
//! imply a fixed cost of 369 microseconds a transfer.

use serde::Serialize;

use super::FrontEnd;
use crate::machines;

/// A bus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bus {
    /// Seconds that every transfer costs, whatever its size.
    pub overhead: f64,
    /// Bytes a second.
    pub bandwidth: f64,
}

/// A frame's way over a bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Transferred {
    /// Bytes moved.
    pub bytes: u64,
    /// Transfers.
    pub transfers: u64,
    /// Seconds.
    pub seconds: f64,
}

impl Bus {
    /// The bus of a description.
    pub fn of(transfer: &machines::Transfer) -> Self {
        Self { overhead: transfer.overhead.value, bandwidth: transfer.bandwidth.value }
    }

    /// The bus that moves `block` bytes at one rate and boundless blocks at another, in bytes a second. The first
    /// must be the smaller.
    pub fn from_rates(block: f64, block_rate: f64, large_rate: f64) -> Self {
        Self { overhead: block / block_rate - block / large_rate, bandwidth: large_rate }
    }

    /// Bytes a second in blocks of a size.
    pub fn rate(&self, block: f64) -> f64 {
        block / (self.overhead + block / self.bandwidth)
    }

    /// Moves the heaps of a frame. With blocks no larger than a buffer every buffer is a transfer of its own;
    /// otherwise the buffers' contents are gathered into blocks first.
    pub fn heaps(&self, front_ends: &[FrontEnd], buckets: usize, buffer: u64, block: u64) -> Transferred {
        let buffers = front_ends.iter().flat_map(|f| (0..buckets).flat_map(|b| f.heap.filled_bytes(b)));
        let (count, bytes) = buffers.fold((0, 0), |(n, sum), b| (n + 1, sum + b));
        let transfers = if block <= buffer { count } else { bytes.div_ceil(block) };
        let seconds = transfers as f64 * self.overhead + bytes as f64 / self.bandwidth;
        Transferred { bytes, transfers, seconds }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documents_rates_imply_the_fixed_cost() {
        let bus = Bus::from_rates(4096.0, 10e6, 100e6);
        assert!((bus.overhead * 1e6 - 368.64).abs() < 1e-9, "{}", bus.overhead);
        assert!((bus.rate(4096.0) - 10e6).abs() < 1e-3);
        // Blocks of 2 MB come within two per cent of the bus.
        assert!(bus.rate(2e6) > 0.98 * 100e6 && bus.rate(2e6) < 100e6);
    }
}
