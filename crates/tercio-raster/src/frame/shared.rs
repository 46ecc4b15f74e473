//! Lets threads write the tiles of one picture at the same time.

use std::marker::PhantomData;

/// A row-major plane that several threads write, each its own pixels.
pub struct SharedPlane<'a, T> {
    first: *mut T,
    width: usize,
    height: usize,
    plane: PhantomData<&'a mut [T]>,
}

// SAFETY: threads reach the elements only through `row`, whose callers promise not to overlap.
unsafe impl<T: Send> Sync for SharedPlane<'_, T> {}
// SAFETY: as a `&mut [T]` would be.
unsafe impl<T: Send> Send for SharedPlane<'_, T> {}

impl<'a, T> SharedPlane<'a, T> {
    /// Shares a plane of `width` by `height` elements, or an empty one that is not wanted.
    ///
    /// # Panics
    /// If the plane is neither.
    pub fn new(plane: &'a mut [T], width: usize, height: usize) -> Self {
        assert!(plane.is_empty() || plane.len() == width * height, "a plane holds one element a pixel");
        let height = if plane.is_empty() { 0 } else { height };
        Self { first: plane.as_mut_ptr(), width, height, plane: PhantomData }
    }

    /// Was the plane asked for?
    pub fn is_wanted(&self) -> bool {
        self.height > 0
    }

    /// `count` elements of row `y` from column `x` on.
    ///
    /// # Panics
    /// If they do not lie inside the plane.
    ///
    /// # Safety
    /// While the result lives nobody else may hold elements of the same stretch.
    #[expect(clippy::mut_from_ref, reason = "the point of the type; see the safety contract")]
    pub unsafe fn row(&self, x: usize, y: usize, count: usize) -> &mut [T] {
        assert!(y < self.height && x <= self.width && count <= self.width - x);
        // SAFETY: inside the plane as asserted, and not held by anybody else as the caller promises.
        unsafe { std::slice::from_raw_parts_mut(self.first.add(y * self.width + x), count) }
    }
}
