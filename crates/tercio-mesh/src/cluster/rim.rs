//! The vertices that an open cluster could take next.

/// Vertices outside a cluster that would complete a triangle with two vertices inside.
///
/// Those that close a notch of the outline come first, among equals the one that waits longest. That makes
/// clusters as round as choosing by distance from the middle does, and looks at nothing twice.
#[derive(Default)]
pub(super) struct Rim {
    queues: [Queue; 3],
}

/// First come, first served.
#[derive(Default)]
struct Queue {
    vertices: Vec<u16>,
    /// Those before are served.
    next: usize,
}

impl Rim {
    pub fn clear(&mut self) {
        for queue in &mut self.queues {
            queue.vertices.clear();
            queue.next = 0;
        }
    }

    /// Adds a vertex, or moves it forward: it now completes so many triangles, which are its last or not. A
    /// vertex whose last triangles are completed would never be taken so cheaply again.
    #[inline]
    pub fn push(&mut self, vertex: u16, completes: u32, last: bool) {
        let urgency = if last { 2 } else { (completes - 1).min(2) };
        self.queues[urgency as usize].vertices.push(vertex);
    }

    /// The vertex that comes next. One that was moved forward comes again later; the caller knows it.
    #[inline]
    pub fn pop(&mut self) -> Option<u16> {
        self.queues.iter_mut().rev().find_map(|queue| {
            let vertex = queue.vertices.get(queue.next).copied();
            queue.next += usize::from(vertex.is_some());
            vertex
        })
    }
}
