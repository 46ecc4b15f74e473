//! The arrays of a C program.

use std::error::Error;
use std::mem::size_of;
use std::slice;

use tercio::mesh::arrays::{Arrays, Positions};

/// Triangles in arrays of the program, which are read during the call only. Set unused fields to zero.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct tercio_arrays {
    /// Number of vertices.
    pub vertices: usize,
    /// x, y and z of each vertex in single precision; NULL if they are in double precision.
    pub positions_f32: *const f32,
    /// x, y and z of each vertex in double precision; NULL if they are in single precision.
    pub positions_f64: *const f64,
    /// Number of triangles.
    pub triangles: usize,
    /// Three vertex numbers for each triangle, the first vertex is 0; counter-clockwise seen from outside.
    pub corners: *const u32,
    /// x, y and z of the normal at each vertex, of any length; NULL to have normals made.
    pub normals: *const f32,
    /// Red, green, blue (sRGB) and alpha of each vertex; NULL for the colour of the part.
    pub colors: *const u8,
}

impl tercio_arrays {
    /// The arrays as slices.
    ///
    /// # Safety
    /// Each pointer that is not null points to as many values as its documentation says, which nobody writes to as long as the
    /// result is used.
    pub unsafe fn read<'a>(&self) -> Result<Arrays<'a>, Box<dyn Error>> {
        // SAFETY: as required from the caller.
        let of_f32 = |at, what| unsafe { rows::<f32, 3>(at, self.vertices, what) };
        let single = of_f32(self.positions_f32, "positions_f32")?;
        // SAFETY: likewise.
        let double = unsafe { rows::<f64, 3>(self.positions_f64, self.vertices, "positions_f64") }?;
        let positions = match (single, double) {
            (Some(_), Some(_)) => return Err("arrays have both positions_f32 and positions_f64".into()),
            (Some(single), None) => Positions::F32(single),
            (None, Some(double)) => Positions::F64(double),
            (None, None) if self.vertices == 0 => Positions::F32(&[]),
            (None, None) => {
                return Err(format!("arrays have {} vertices, but no positions", self.vertices).into());
            }
        };
        // SAFETY: likewise.
        let corners = unsafe { rows::<u32, 3>(self.corners, self.triangles, "corners") }?;
        if corners.is_none() && self.triangles > 0 {
            return Err(format!("arrays have {} triangles, but no corners", self.triangles).into());
        }
        let normals = of_f32(self.normals, "normals")?;
        // SAFETY: likewise.
        let vertex_colors = unsafe { rows::<u8, 4>(self.colors, self.vertices, "colors") }?;
        Ok(Arrays { positions, triangles: corners.unwrap_or_default(), normals, vertex_colors })
    }
}

/// `count` rows of `N` values each; `None` for a null pointer.
///
/// # Safety
/// As [`tercio_arrays::read`].
unsafe fn rows<'a, T, const N: usize>(
    at: *const T,
    count: usize,
    what: &str,
) -> Result<Option<&'a [[T; N]]>, Box<dyn Error>> {
    if at.is_null() {
        return Ok(None);
    }
    if !at.is_aligned() {
        return Err(format!("{what} must be at an address that is a multiple of {}", align_of::<T>()).into());
    }
    if count > isize::MAX as usize / size_of::<[T; N]>() {
        return Err(format!("{what} of {count} elements are more than there is memory").into());
    }
    // SAFETY: the pointer is aligned and not null, the caller guarantees the values, and they are no more bytes than an object has.
    Ok(Some(unsafe { slice::from_raw_parts(at.cast::<[T; N]>(), count) }))
}
