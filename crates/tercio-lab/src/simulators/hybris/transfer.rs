//! The bus between host and board: every transfer has a fixed cost, then bytes move at the bus's rate.
//!
//! Source: document 001, 4.5.1, which gives the two limits: 10 MB/s in blocks of 4 KiB, 100 MB/s in large ones. They
//! imply a fixed cost of 369 microseconds per transfer.

use serde::Serialize;

use super::FrontEnd;
use crate::machines;

/// A bus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bus {
    /// Fixed seconds of every transfer.
    pub overhead: f64,
    /// Bytes a second.
    pub bandwidth: f64,
}

/// The transfers of a frame over a bus.
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

    /// Transfers the heaps of a frame. With blocks no larger than a buffer every buffer is a transfer of its own;
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
    use crate::machines::builtin;
    use crate::models::hybris::rates::transfer_overhead;
    use crate::simulators::hybris::front_end::Tiles;
    use crate::simulators::hybris::heap::HeapLayout;
    use crate::simulators::hybris::{Partition, Triangle};
    use crate::units::{Bytes, BytesPerSecond};

    /// A front end with `count` triangles in one tile.
    fn one_tile(count: usize) -> Vec<FrontEnd> {
        let triangle = Triangle::new([(0, 0), (0, 1024), (1024, 0)]);
        let partition = Partition { vertices: 3, outside: 0, triangles: vec![triangle; count] };
        vec![FrontEnd::run(&[partition], Tiles { width: 64, height: 64, edge: 32 }, HeapLayout::DOCUMENT)]
    }

    #[test]
    fn the_board_of_the_document_moves_buffers_at_10_megabytes_a_second() {
        let bus = Bus::of(&builtin("hybris-fpga").unwrap().unwrap().transfer.unwrap());
        let implied =
            transfer_overhead(Bytes::new(4096.0), BytesPerSecond::new(10e6), BytesPerSecond::new(100e6));
        assert!((bus.overhead - implied.unwrap().get()).abs() < 1e-12);
        let full = bus.heaps(&one_tile(63 * 100), 4, 4096, 4096);
        assert_eq!((full.bytes, full.transfers), (4096 * 100, 100));
        assert!((full.bytes as f64 / full.seconds - 10e6).abs() < 1.0);
    }

    #[test]
    fn large_blocks_gather_what_buffers_hold() {
        let bus = Bus { overhead: 1.0, bandwidth: 1e6 };
        // 63 nodes fill a buffer; the second one holds the header and one node.
        let t = bus.heaps(&one_tile(64), 4, 4096, 2_000_000);
        assert_eq!((t.bytes, t.transfers), (4096 + 128, 1));
        assert_eq!(bus.heaps(&one_tile(64), 4, 4096, 4096).transfers, 2);
    }
}
