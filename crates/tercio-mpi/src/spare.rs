//! Reuse of message memory: otherwise the system would have to provide and clear new pages for every frame.

/// Unused buffers, from the smallest to the largest.
#[derive(Debug)]
pub struct Spare {
    buffers: Vec<Vec<u8>>,
    most: usize,
}

impl Spare {
    /// Room for this many buffers; if there are more, the smallest are dropped.
    pub fn new(most: usize) -> Self {
        Self { buffers: Vec::new(), most }
    }

    /// Whether there are no buffers.
    pub fn is_empty(&self) -> bool {
        self.buffers.is_empty()
    }

    /// An empty buffer: the smallest with room for this many bytes, the largest if none has. 0 returns the largest,
    /// for a message of unknown length.
    pub fn take(&mut self, bytes: usize) -> Vec<u8> {
        let fits = self.buffers.partition_point(|b| b.capacity() < bytes);
        let at = if bytes == 0 { usize::MAX } else { fits };
        match self.buffers.len() {
            0 => Vec::new(),
            count => self.buffers.remove(at.min(count - 1)),
        }
    }

    /// Adds a buffer; its contents are lost.
    pub fn put(&mut self, mut buffer: Vec<u8>) {
        if buffer.capacity() == 0 {
            return;
        }
        buffer.clear();
        let at = self.buffers.partition_point(|b| b.capacity() < buffer.capacity());
        self.buffers.insert(at, buffer);
        if self.buffers.len() > self.most {
            self.buffers.remove(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(capacities: &[usize]) -> Spare {
        let mut spare = Spare::new(3);
        capacities.iter().for_each(|&c| spare.put(Vec::with_capacity(c)));
        spare
    }

    #[test]
    fn the_smallest_buffer_that_fits_is_taken() {
        let mut spare = of(&[300, 100, 200]);
        assert_eq!(spare.take(150).capacity(), 200);
        assert_eq!(spare.take(1000).capacity(), 300, "the largest has to grow least");
        assert_eq!(spare.take(0).capacity(), 100);
        assert_eq!(spare.take(10).capacity(), 0);
        assert!(spare.is_empty());
        assert_eq!(of(&[100, 300, 200]).take(0).capacity(), 300);
    }

    #[test]
    fn the_smallest_are_dropped_and_buffers_are_cleared() {
        let mut spare = of(&[10, 40, 0, 20, 30]);
        spare.put(vec![7; 50]);
        let mut left = Vec::new();
        while !spare.is_empty() {
            let buffer = spare.take(1);
            assert!(buffer.is_empty());
            left.push(buffer.capacity());
        }
        assert_eq!(left, [30, 40, 50]);
    }
}
