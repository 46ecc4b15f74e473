//! Parts of the scene.

use std::ffi::c_int;

use tercio::PartId;
use tercio::glam::{DAffine3, DMat4};
use tercio::mesh::arrays::{Arrays, Positions};
use tercio::mesh::color::srgb_to_linear;

use crate::arrays::tercio_arrays;
use crate::session::{Failed, run, tercio_session, with};
use crate::values::{unit, values};

/// Makes something of arrays, on all ranks or on none: if those of this rank cannot be read, the others learn it.
///
/// # Safety
/// As [`tercio_arrays::read`], if the pointer is not null.
unsafe fn with_arrays<T>(
    arrays: *const tercio_arrays,
    make: impl FnOnce(&Arrays) -> Result<T, tercio::Error>,
) -> Result<T, Failed> {
    // SAFETY: as required from the caller.
    let read = match unsafe { arrays.as_ref() } {
        // SAFETY: likewise.
        Some(arrays) => unsafe { arrays.read() },
        None => Err("the arrays are NULL".into()),
    };
    match read {
        Ok(arrays) => Ok(make(&arrays)?),
        Err(error) => {
            let no_mesh = Arrays::new(Positions::F32(&[]), &[[0; 3]]);
            match make(&no_mesh) {
                Err(tercio::Error::Load(tercio::LoadError::Arrays(_))) => Err(error),
                // The session failed in another way, which matters more.
                Err(other) => Err(other.into()),
                Ok(_) => Err("arrays without vertices were a mesh".into()),
            }
        }
    }
}

/// Adds a part that stays until it is removed, and stores its number, 0 for the first one. Collective; each process passes the triangles
/// that it has, which may be none. Surfaces of several processes are joined where they have vertices at the same position. All
/// processes that have vertices pass normals, or none does, and the same for colours.
///
/// # Safety
/// The arrays are as their documentation says; `part` may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_add(
    session: *mut tercio_session,
    arrays: *const tercio_arrays,
    part: *mut u32,
) -> c_int {
    let add = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let id = with!(&mut session.ranks, s => unsafe { with_arrays(arrays, |arrays| s.add(arrays)) })?;
        // SAFETY: likewise.
        if let Some(part) = unsafe { part.as_mut() } {
            *part = id.number();
        }
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, add) }
}

/// Replaces the arrays of a part; transform and surface stay. Collective.
///
/// # Safety
/// As [`tercio_add`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_update(
    session: *mut tercio_session,
    part: u32,
    arrays: *const tercio_arrays,
) -> c_int {
    let id = PartId::from_number(part);
    let update = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        with!(&mut session.ranks, s => unsafe { with_arrays(arrays, |arrays| s.update(id, arrays)) })
    };
    // SAFETY: likewise.
    unsafe { run(session, update) }
}

/// Removes a part; its number is not used again.
///
/// # Safety
/// As [`tercio_set_timeout`](crate::tercio_set_timeout).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_remove(session: *mut tercio_session, part: u32) -> c_int {
    let id = PartId::from_number(part);
    // SAFETY: as required from the caller.
    unsafe { run(session, |session| Ok(with!(&mut session.ranks, s => s.remove(id))?)) }
}

/// Adds triangles for the next picture only. Collective.
///
/// # Safety
/// As [`tercio_add`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_show(session: *mut tercio_session, arrays: *const tercio_arrays) -> c_int {
    let show = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        with!(&mut session.ranks, s => unsafe { with_arrays(arrays, |arrays| s.show(arrays)) })
    };
    // SAFETY: likewise.
    unsafe { run(session, show) }
}

/// Places a part: 16 numbers of an affine matrix in column-major order (as in OpenGL; the translation is numbers 12 to 14).
///
/// # Safety
/// `matrix` points to 16 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_transform(
    session: *mut tercio_session,
    part: u32,
    matrix: *const f64,
) -> c_int {
    let set = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let columns = unsafe { values::<f64, 16>(matrix, "the matrix") }?;
        let matrix = DMat4::from_cols_array(&columns);
        if !matrix.is_finite() || matrix.row(3) != DMat4::IDENTITY.row(3) || matrix.determinant() == 0.0 {
            return Err("the matrix must be finite, with the last row 0 0 0 1, and invertible".into());
        }
        let id = PartId::from_number(part);
        *with!(&mut session.ranks, s => s.transform_mut(id))? = DAffine3::from_mat4(matrix);
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, set) }
}

/// The colour (sRGB, 0 to 1) of a part that has no colours of its own, and its opacity, 0 to 1.
///
/// # Safety
/// `rgb` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_surface(
    session: *mut tercio_session,
    part: u32,
    rgb: *const f64,
    opacity: f64,
) -> c_int {
    let set = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let rgb = unit(unsafe { values::<f64, 3>(rgb, "the colour") }?)?;
        let [opacity] = unit([opacity])?;
        let id = PartId::from_number(part);
        let surface = with!(&mut session.ranks, s => s.surface_mut(id))?;
        surface.base_color = rgb.map(|c| srgb_to_linear(c) as f32);
        surface.opacity = opacity as f32;
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, set) }
}
