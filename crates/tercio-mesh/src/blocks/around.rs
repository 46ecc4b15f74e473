//! Which triangles of a block meet at a vertex.

/// The triangles around each vertex of a block.
pub(crate) struct Around {
    /// Where each vertex's triangles begin, plus one end entry. It has an entry for every 16-bit number, so that
    /// indexing needs no bounds check.
    starts: Box<[u32; (1 << 16) + 2]>,
    corners: Vec<Corner>,
}

/// A triangle as one of its corners sees it.
#[derive(Clone, Copy, Default)]
pub(crate) struct Corner {
    /// The corner after it.
    pub next: u16,
    /// The corner before it.
    pub previous: u16,
    pub triangle: u16,
}

impl Default for Around {
    fn default() -> Self {
        let starts = vec![0; (1 << 16) + 2].into_boxed_slice();
        let starts =
            starts.try_into().unwrap_or_else(|_| unreachable!("the table was made with this length"));
        Self { starts, corners: Vec::new() }
    }
}

impl Around {
    /// Fills the table for a new block with this many vertices. A block has at most 2^16 / 3 triangles.
    pub fn fill(&mut self, triangles: &[[u16; 3]], vertices: usize) {
        let starts = &mut *self.starts;
        starts[..vertices + 2].fill(0);
        // Counts are stored two entries ahead, so that filling the lists leaves every start in its final place.
        for &v in triangles.as_flattened() {
            starts[usize::from(v) + 2] += 1;
        }
        let mut sum = 0;
        for start in &mut starts[..vertices + 2] {
            sum += *start;
            *start = sum;
        }
        self.corners.resize(triangles.len() * 3, Corner::default());
        let corners = self.corners.as_mut_slice();
        for (t, &[a, b, c]) in triangles.iter().enumerate() {
            let triangle = t as u16;
            for [corner, next, previous] in [[a, b, c], [b, c, a], [c, a, b]] {
                let place = &mut starts[usize::from(corner) + 1];
                corners[*place as usize] = Corner { next, previous, triangle };
                *place += 1;
            }
        }
    }

    /// Triangles that have the vertex as a corner; repeated if several corners of a triangle are this vertex.
    #[inline]
    pub fn at(&self, vertex: u16) -> &[Corner] {
        let v = usize::from(vertex);
        &self.corners[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
}
