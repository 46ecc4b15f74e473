//! sRGB and linear light.

/// Linear light, 0 to 1, of an sRGB component, 0 to 1. Source: IEC 61966-2-1.
///
/// For settings and tables; the renderer's kernels use tables made from it.
pub fn srgb_to_linear(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// sRGB component, 0 to 1, of linear light, 0 to 1. Source: IEC 61966-2-1.
pub fn linear_to_srgb(l: f64) -> f64 {
    if l <= 0.003_130_8 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 }
}
