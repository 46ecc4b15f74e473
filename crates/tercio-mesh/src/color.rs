//! sRGB and linear light, the same on every machine: computed with basic operations only, without the system's
//! mathematical library, whose results differ in the last digit from system to system.
//!
//! For settings and tables; the renderer's kernels use tables made from it.

/// Linear light, 0 to 1, of an sRGB component, 0 to 1. Source: IEC 61966-2-1.
pub fn srgb_to_linear(srgb: f64) -> f64 {
    if srgb <= 0.04045 {
        return srgb / 12.92;
    }
    // x^2.4 = x^2 * (x^(1/5))^2
    let x = (srgb + 0.055) / 1.055;
    let root = nth_root::<5>(x);
    (x * x) * (root * root)
}

/// sRGB component, 0 to 1, of linear light, 0 to 1. Source: IEC 61966-2-1.
pub fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        return linear * 12.92;
    }
    // x^(1/2.4) = x^(5/12) = x^(1/4) * x^(1/6)
    let root = linear.sqrt();
    1.055 * (root.sqrt() * nth_root::<3>(root)) - 0.055
}

/// sRGB bytes of linear light, which is cut to 0 to 1.
pub fn srgb_bytes(linear: [f32; 3]) -> [u8; 3] {
    linear.map(|c| (linear_to_srgb(f64::from(c).clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// The N-th root of a number from 0 to 1 by Newton's method from above, where it decreases without overshooting.
fn nth_root<const N: i32>(x: f64) -> f64 {
    let n = f64::from(N);
    let mut root = 1.0;
    loop {
        let mut power = 1.0;
        (1..N).for_each(|_| power *= root);
        let next = ((n - 1.0) * root + x / power) / n;
        if next >= root {
            return root;
        }
        root = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_follow_the_standard() {
        for i in 0..=10_000 {
            let x = f64::from(i) / 10_000.0;
            let encoded = if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            let decoded = if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
            assert!((linear_to_srgb(x) - encoded).abs() < 1e-12, "{x}");
            assert!((srgb_to_linear(x) - decoded).abs() < 1e-12, "{x}");
        }
    }
}
