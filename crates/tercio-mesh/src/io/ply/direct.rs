//! The two columns that nearly every binary file has, read without conversion to `f64`: points of three contiguous
//! `f32`, and triangles of three 32-bit vertex numbers.

/// Twelve bytes at `offset` of every row, as three words.
#[inline]
fn words(rows: &[u8], stride: usize, offset: usize) -> impl Iterator<Item = [[u8; 4]; 3]> {
    rows.chunks_exact(stride).map(move |row| {
        let bytes: Option<&[u8; 12]> = row.get(offset..).and_then(|b| b.first_chunk());
        // The properties end inside the row, so it is never too short.
        let [a, b, c, d, e, f, g, h, i, j, k, l] = *bytes.unwrap_or(&[0; 12]);
        [[a, b, c, d], [e, f, g, h], [i, j, k, l]]
    })
}

/// Reads a point from each row.
pub(super) fn points(rows: &[u8], stride: usize, offset: usize, big: bool, points: &mut [[f32; 3]]) {
    for (point, [x, y, z]) in points.iter_mut().zip(words(rows, stride, offset)) {
        *point = match big {
            true => [f32::from_be_bytes(x), f32::from_be_bytes(y), f32::from_be_bytes(z)],
            false => [f32::from_le_bytes(x), f32::from_le_bytes(y), f32::from_le_bytes(z)],
        };
    }
}

/// Reads a triangle from each row; false if a vertex number is not below `vertices`, which is at most 2^31 for
/// signed numbers.
pub(super) fn triangles(
    rows: &[u8],
    stride: usize,
    offset: usize,
    big: bool,
    vertices: u32,
    triangles: &mut [[u32; 3]],
) -> bool {
    let mut good = true;
    for (triangle, [a, b, c]) in triangles.iter_mut().zip(words(rows, stride, offset)) {
        let [a, b, c] = match big {
            true => [u32::from_be_bytes(a), u32::from_be_bytes(b), u32::from_be_bytes(c)],
            false => [u32::from_le_bytes(a), u32::from_le_bytes(b), u32::from_le_bytes(c)],
        };
        good &= (a < vertices) & (b < vertices) & (c < vertices);
        *triangle = [a, b, c];
    }
    good
}
