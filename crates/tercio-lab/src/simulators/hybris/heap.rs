//! The bucket sorted triangle heap: a list of buffers for each bucket, a buffer a page of SDRAM.
//!
//! Source: document 001, 3.5 and 4.4.

use serde::Serialize;

use crate::machines::{self, Sdram};

/// Sizes of the heap's parts in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct HeapLayout {
    /// A triangle node.
    pub node: u64,
    /// A buffer.
    pub buffer: u64,
    /// The header of a buffer.
    pub header: u64,
}

impl HeapLayout {
    /// Nodes of 64 bytes in buffers of 4096 with a header of 64: 63 of them.
    pub const DOCUMENT: Self = Self { node: 64, buffer: 4096, header: 64 };

    /// The layout of a machine's heap.
    pub fn of(heap: &machines::Heap) -> Self {
        Self { node: heap.node.whole(), buffer: heap.buffer.whole(), header: heap.header.whole() }
    }

    /// Nodes in a buffer, at least one.
    pub fn nodes_per_buffer(&self) -> u64 {
        (self.buffer.saturating_sub(self.header) / self.node.max(1)).max(1)
    }
}

/// Assignment of buffers to the banks of the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum BankMapping {
    /// In the order of allocation: the best that software can do.
    InOrder,
    /// Neighbouring tiles in different banks, which hardware can arrange (document 001, 4.4).
    ByTile,
}

/// Page accesses and misses while a heap was written or read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PageCounts {
    /// Accesses.
    pub accesses: u64,
    /// Accesses that found another page open in their bank.
    pub misses: u64,
    /// Memory cycles: data and opening of pages.
    pub cycles: u64,
}

impl PageCounts {
    /// The sum of both.
    pub fn plus(self, o: Self) -> Self {
        Self {
            accesses: self.accesses + o.accesses,
            misses: self.misses + o.misses,
            cycles: self.cycles + o.cycles,
        }
    }
}

/// A heap: the nodes of each bucket, in the order of arrival.
#[derive(Clone, Debug)]
pub struct Heap {
    layout: HeapLayout,
    buckets: Vec<Vec<u32>>,
    /// Buffer number of each bucket's buffers.
    buffers: Vec<Vec<u32>>,
    taken: u32,
    /// Bucket and buffer of every write, in order.
    writes: Vec<(u32, u32)>,
}

impl Heap {
    /// An empty heap.
    pub fn new(buckets: usize, layout: HeapLayout) -> Self {
        Self {
            layout,
            buckets: vec![Vec::new(); buckets],
            buffers: vec![Vec::new(); buckets],
            taken: 0,
            writes: Vec::new(),
        }
    }

    /// Writes a node into a bucket; allocates a new buffer if the last one is full.
    pub fn push(&mut self, bucket: usize, node: u32) {
        let full = (self.buckets[bucket].len() as u64).is_multiple_of(self.layout.nodes_per_buffer());
        if full {
            self.buffers[bucket].push(self.taken);
            self.taken += 1;
        }
        self.buckets[bucket].push(node);
        let buffer = self.buffers[bucket][self.buffers[bucket].len() - 1];
        self.writes.push((bucket as u32, buffer));
    }

    /// The nodes of a bucket.
    pub fn bucket(&self, bucket: usize) -> &[u32] {
        &self.buckets[bucket]
    }

    /// Nodes in all buckets.
    pub fn entries(&self) -> u64 {
        self.writes.len() as u64
    }

    /// Buffers allocated.
    pub fn buffers(&self) -> u64 {
        u64::from(self.taken)
    }

    /// Bytes of the buffers.
    pub fn bytes(&self) -> u64 {
        self.buffers() * self.layout.buffer
    }

    /// Bytes used in each buffer of a bucket, headers included: the size of a transfer of that buffer.
    pub fn filled_bytes(&self, bucket: usize) -> impl Iterator<Item = u64> {
        let (layout, per) = (self.layout, self.layout.nodes_per_buffer());
        let nodes = self.buckets[bucket].len() as u64;
        (0..nodes.div_ceil(per)).map(move |k| layout.header + (nodes - k * per).min(per) * layout.node)
    }

    /// Memory accesses while the front end writes: nodes come in the order of the triangles.
    pub fn write_pages(&self, sdram: &Sdram, mapping: BankMapping, columns: u32) -> PageCounts {
        let mut memory = Memory::new(sdram, mapping, columns);
        for &(bucket, buffer) in &self.writes {
            memory.access(bucket, buffer, self.layout.node);
        }
        memory.counts
    }

    /// Memory accesses while the back end reads: bucket after bucket, buffer after buffer.
    pub fn read_pages(&self, sdram: &Sdram, mapping: BankMapping, columns: u32) -> PageCounts {
        let mut memory = Memory::new(sdram, mapping, columns);
        for (bucket, buffers) in self.buffers.iter().enumerate() {
            for (&buffer, bytes) in buffers.iter().zip(self.filled_bytes(bucket)) {
                memory.access(bucket as u32, buffer, bytes);
            }
        }
        memory.counts
    }
}

/// Banks with one open page each.
struct Memory {
    open: Vec<Option<u64>>,
    mapping: BankMapping,
    columns: u32,
    width: u64,
    miss: u64,
    counts: PageCounts,
}

impl Memory {
    fn new(sdram: &Sdram, mapping: BankMapping, columns: u32) -> Self {
        Self {
            open: vec![None; sdram.banks.whole() as usize],
            mapping,
            columns: columns.max(1),
            width: sdram.width.whole().max(1),
            miss: sdram.page_miss.whole(),
            counts: PageCounts::default(),
        }
    }

    fn access(&mut self, bucket: u32, buffer: u32, bytes: u64) {
        let bank = match self.mapping {
            BankMapping::InOrder => buffer,
            // The tiles of a 2x2 block have four different banks, as they meet at a corner.
            BankMapping::ByTile => (bucket % self.columns) % 2 + (bucket / self.columns) % 2 * 2,
        } as usize
            % self.open.len();
        let page = Some(u64::from(buffer));
        let missed = u64::from(self.open[bank] != page);
        self.open[bank] = page;
        self.counts.accesses += 1;
        self.counts.misses += missed;
        self.counts.cycles += bytes.div_ceil(self.width) + missed * self.miss;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::builtin;

    fn sdram() -> Sdram {
        builtin("hybris-asic").unwrap().unwrap().sdram.unwrap()
    }

    #[test]
    fn the_64th_node_of_a_bucket_takes_a_second_buffer() {
        assert_eq!(HeapLayout::DOCUMENT.nodes_per_buffer(), 63);
        let mut heap = Heap::new(4, HeapLayout::DOCUMENT);
        (0..63).for_each(|n| heap.push(2, n));
        assert_eq!((heap.buffers(), heap.bytes()), (1, 4096));
        heap.push(2, 63);
        heap.push(0, 64);
        assert_eq!((heap.buffers(), heap.entries()), (3, 65));
        assert_eq!(heap.filled_bytes(2).collect::<Vec<_>>(), [4096, 128]);
        assert_eq!(heap.bucket(2).len(), 64);
    }

    #[test]
    fn two_buckets_in_one_bank_close_each_others_pages() {
        let mut heap = Heap::new(16, HeapLayout::DOCUMENT);
        // Tiles 0 and 2 of a row share a bank if banks are assigned by tile; tiles 0 and 1 do not.
        (0..10).for_each(|n| heap.push(if n % 2 == 0 { 0 } else { 2 }, n));
        let counts = heap.write_pages(&sdram(), BankMapping::ByTile, 4);
        assert_eq!((counts.accesses, counts.misses, counts.cycles), (10, 10, 10 * (8 + 4)));
        let counts = heap.write_pages(&sdram(), BankMapping::InOrder, 4);
        assert_eq!((counts.misses, counts.cycles), (2, 10 * 8 + 2 * 4));
    }

    #[test]
    fn reading_opens_each_buffer_once() {
        let mut heap = Heap::new(2, HeapLayout::DOCUMENT);
        (0..130).for_each(|n| heap.push(1, n));
        let counts = heap.read_pages(&sdram(), BankMapping::ByTile, 2);
        assert_eq!((counts.accesses, counts.misses), (3, 3));
        assert_eq!(counts.cycles, (512 + 512 + (64 + 4 * 64) / 8) + 3 * 4);
    }
}
