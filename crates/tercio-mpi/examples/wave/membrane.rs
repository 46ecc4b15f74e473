//! The wave equation on a square membrane, fixed at its border, by the implicit trapezoidal rule: each step solves a linear system with
//! conjugate gradients. Heights do not depend on the number of ranks.

use std::ops::Range;

use tercio::parallel::Communicator;
use tercio::parallel::comm::CommError;
use tercio::parallel::comm::collective::all_reduce_arrays;

/// Speed of the waves by length of a step, in cells: an explicit method would be unstable above 0.7.
const COURANT: f64 = 15.0;

/// A rank's rows of the membrane.
pub struct Membrane {
    cells: usize,
    rank: usize,
    ranks: usize,
    /// The rows of points of this rank; those at the border of the membrane belong to nobody, and stay 0.
    rows: Range<usize>,
    /// Heights, with one more row of the neighbours, or of the border, on each side.
    now: Vec<f64>,
    before: Vec<f64>,
}

/// What is drawn: this rank's rows, and the first one of the next rank.
pub struct Surface {
    pub positions: Vec<[f64; 3]>,
    pub colors: Vec<[u8; 4]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Membrane {
    /// At rest, pulled up in two places.
    pub fn new(cells: usize, rank: usize, ranks: usize) -> Self {
        let inner = cells.saturating_sub(1);
        let rows = 1 + inner * rank / ranks..1 + inner * (rank + 1) / ranks;
        let width = cells + 1;
        let mut now = vec![0.0; (rows.len() + 2) * width];
        for (place, height) in now.iter_mut().enumerate() {
            let at = [place % width, rows.start - 1 + place / width];
            let [x, y] = at.map(|k| k as f64 / cells as f64);
            let hill = |cx: f64, cy: f64, r: f64| (-((x - cx).powi(2) + (y - cy).powi(2)) / (r * r)).exp();
            let is_border = at.iter().any(|&k| k == 0 || k == cells);
            *height = if is_border { 0.0 } else { 0.2 * hill(0.3, 0.4, 0.06) + 0.12 * hill(0.7, 0.65, 0.04) };
        }
        Self { cells, rank, ranks, rows, before: now.clone(), now }
    }

    /// The points of this rank in an array.
    fn own(&self) -> Range<usize> {
        let width = self.cells + 1;
        width..(self.rows.len() + 1) * width
    }

    /// One step; returns the iterations of the solver, which ends when the residual is `tolerance` times what it has to be.
    pub fn step(&mut self, comm: &mut impl Communicator, tolerance: f64) -> Result<u32, CommError> {
        let own = self.own();
        // With A = 1 - a L: A next = 2 (1 + a L) now - A before = 4 now - A (2 now + before).
        let mut sum: Vec<f64> = self.now.iter().zip(&self.before).map(|(n, b)| 2.0 * n + b).collect();
        let of_sum = self.apply(comm, &mut sum)?;
        let mut next: Vec<f64> = self.now.iter().zip(&self.before).map(|(n, b)| 2.0 * n - b).collect();
        let of_next = self.apply(comm, &mut next)?;
        let mut residual = vec![0.0; next.len()];
        let mut right = vec![0.0; next.len()];
        for k in own.clone() {
            right[k] = 4.0 * self.now[k] - of_sum[k];
            residual[k] = right[k] - of_next[k];
        }
        let mut direction = residual.clone();
        let [mut square, wanted] = self.products(comm, [(&residual, &residual), (&right, &right)])?;
        let mut iterations = 0;
        while square > tolerance * tolerance * wanted {
            let of_direction = self.apply(comm, &mut direction)?;
            let [along] = self.products(comm, [(&direction, &of_direction)])?;
            let length = square / along;
            for k in own.clone() {
                next[k] += length * direction[k];
                residual[k] -= length * of_direction[k];
            }
            let [after] = self.products(comm, [(&residual, &residual)])?;
            let turn = after / square;
            own.clone().for_each(|k| direction[k] = residual[k] + turn * direction[k]);
            square = after;
            iterations += 1;
        }
        self.exchange(comm, &mut next)?;
        self.before = std::mem::replace(&mut self.now, next);
        Ok(iterations)
    }

    /// `(1 - a L) values`, where L is the Laplacian.
    fn apply(&self, comm: &mut impl Communicator, values: &mut [f64]) -> Result<Vec<f64>, CommError> {
        self.exchange(comm, values)?;
        let (width, a) = (self.cells + 1, COURANT * COURANT / 4.0);
        let mut result = vec![0.0; values.len()];
        for row in 1..=self.rows.len() {
            let of = |row: usize| &values[row * width..][..width];
            let (above, here, below) = (of(row - 1), of(row), of(row + 1));
            let out = &mut result[row * width..][..width];
            for x in 1..width - 1 {
                let neighbours = here[x - 1] + here[x + 1] + above[x] + below[x];
                out[x] = here[x] - a * (neighbours - 4.0 * here[x]);
            }
        }
        Ok(result)
    }

    /// Copies the outermost rows of the neighbours.
    fn exchange(&self, comm: &mut impl Communicator, values: &mut [f64]) -> Result<(), CommError> {
        let (width, count) = (self.cells + 1, self.rows.len());
        // Ranks without rows are passed over.
        let has_rows =
            |rank: &usize| (self.cells - 1) * rank / self.ranks < (self.cells - 1) * (rank + 1) / self.ranks;
        if count == 0 {
            return Ok(());
        }
        let neighbours = [
            ((0..self.rank).rev().find(has_rows), 1, 0),
            ((self.rank + 1..self.ranks).find(has_rows), count, count + 1),
        ];
        for (other, row, _) in neighbours {
            let Some(other) = other else { continue };
            comm.send(other, values[row * width..][..width].iter().flat_map(|h| h.to_le_bytes()).collect())?;
        }
        for (other, _, row) in neighbours {
            let Some(other) = other else { continue };
            let message = comm.receive(other)?;
            let heights = message.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
            values[row * width..][..width].iter_mut().zip(heights).for_each(|(own, theirs)| *own = theirs);
        }
        Ok(())
    }

    /// Scalar products of all ranks. Those of rows are added as integers, so that it does not matter which rank has which rows.
    fn products<const N: usize>(
        &self,
        comm: &mut impl Communicator,
        factors: [(&[f64], &[f64]); N],
    ) -> Result<[f64; N], CommError> {
        let scale = 2f64.powi(80);
        let (own, width) = (self.own(), self.cells + 1);
        let mut sums = factors.map(|(a, b)| {
            let rows = a[own.clone()].chunks(width).zip(b[own.clone()].chunks(width));
            let of_row = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            rows.map(|row| (of_row(row) * scale) as i128).sum::<i128>()
        });
        all_reduce_arrays(comm, &mut sums, |a, b| a + b)?;
        Ok(sums.map(|sum| sum as f64 / scale))
    }

    /// The surface of this rank: from its first row, or the border before it, to the first row of the next rank, or the border.
    pub fn surface(&self) -> Surface {
        let (width, cells) = (self.cells + 1, self.cells as f64);
        let first = usize::from(self.rows.start > 1);
        let rows = if self.rows.is_empty() { first..first } else { first..self.rows.len() + 2 };
        let mut surface = Surface { positions: vec![], colors: vec![], triangles: vec![] };
        for row in rows.clone() {
            for x in 0..width {
                let here = self.now[row * width + x];
                surface.positions.push([x as f64 / cells, (self.rows.start + row - 1) as f64 / cells, here]);
                // Blue below, white, red above.
                let t = (here / 0.08).clamp(-1.0, 1.0);
                let fade = |t: f64| (235.0 - 190.0 * t.max(0.0)) as u8;
                surface.colors.push([fade(-t), fade(t.abs()), fade(t), 255]);
            }
        }
        let w = width as u32;
        for row in 0..rows.len().saturating_sub(1) as u32 {
            for x in 0..w - 1 {
                let a = row * w + x;
                surface.triangles.extend([[a, a + 1, a + w + 1], [a, a + w + 1, a + w]]);
            }
        }
        surface
    }
}
