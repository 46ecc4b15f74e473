//! Which triangles of a block meet at a vertex.

/// The triangles round each vertex of a block.
#[derive(Default)]
pub(crate) struct Around {
    /// Where each vertex's triangles begin, and one more.
    starts: Vec<u32>,
    triangles: Vec<u16>,
}

impl Around {
    /// Takes a new block of so many vertices. It has at most 2^16 triangles.
    pub fn fill(&mut self, corners: &[[u16; 3]], vertices: usize) {
        self.starts.clear();
        self.starts.resize(vertices + 2, 0);
        // Two places ahead, so that filling leaves every start where it belongs.
        for &v in corners.as_flattened() {
            self.starts[usize::from(v) + 2] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.triangles.resize(corners.len() * 3, 0);
        for (t, corners) in corners.iter().enumerate() {
            for &v in corners {
                let place = &mut self.starts[usize::from(v) + 1];
                self.triangles[*place as usize] = t as u16;
                *place += 1;
            }
        }
    }

    /// Triangles that have the vertex as a corner; twice or more where it is two corners of one.
    #[inline]
    pub fn at(&self, vertex: u16) -> &[u16] {
        let v = usize::from(vertex);
        &self.triangles[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
}
