//! Concurrent writes of several threads to disjoint parts of one picture.

use std::marker::PhantomData;

/// A row-major plane that several threads write, each to its own pixels.
pub struct SharedPlane<'a, T> {
    first: *mut T,
    width: usize,
    height: usize,
    plane: PhantomData<&'a mut [T]>,
}

// SAFETY: threads access the elements only through `row`, whose callers guarantee disjoint ranges.
unsafe impl<T: Send> Sync for SharedPlane<'_, T> {}
// SAFETY: it is `Send` like the `&mut [T]` that it is made from.
unsafe impl<T: Send> Send for SharedPlane<'_, T> {}

impl<'a, T> SharedPlane<'a, T> {
    /// Shares a plane of `width` by `height` elements, or an empty one that was not requested.
    ///
    /// # Panics
    /// If the plane has any other length.
    pub fn new(plane: &'a mut [T], width: usize, height: usize) -> Self {
        assert!(plane.is_empty() || plane.len() == width * height, "a plane has one element per pixel");
        let height = if plane.is_empty() { 0 } else { height };
        Self { first: plane.as_mut_ptr(), width, height, plane: PhantomData }
    }

    /// Was the plane requested?
    pub fn is_wanted(&self) -> bool {
        self.height > 0
    }

    /// `count` elements of row `y` from column `x` on.
    ///
    /// # Panics
    /// If they are not inside the plane.
    ///
    /// # Safety
    /// While the result is alive, no other reference to the same elements may exist.
    #[expect(clippy::mut_from_ref, reason = "the point of the type; see the safety contract")]
    pub unsafe fn row(&self, x: usize, y: usize, count: usize) -> &mut [T] {
        assert!(y < self.height && x <= self.width && count <= self.width - x);
        // SAFETY: inside the plane as asserted, and not aliased, as the caller guarantees.
        unsafe { std::slice::from_raw_parts_mut(self.first.add(y * self.width + x), count) }
    }
}
