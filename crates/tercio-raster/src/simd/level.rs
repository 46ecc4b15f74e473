//! SIMD levels by name.

use std::fmt;
use std::str::FromStr;

use fearless_simd::Level;

/// A SIMD level by name; the processor determines which of them are available.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SimdLevel {
    /// One number at a time.
    Scalar,
    /// x86-64 baseline, 128 bits.
    Sse2,
    /// x86-64-v3, 256 bits.
    Avx2,
    /// AVX-512 as in Ice Lake, Zen 4 and later, 512 bits.
    Avx512,
    /// AArch64, 128 bits.
    Neon,
}

impl SimdLevel {
    /// All levels, slowest first.
    pub const ALL: [Self; 5] = [Self::Scalar, Self::Sse2, Self::Avx2, Self::Avx512, Self::Neon];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Sse2 => "sse2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Neon => "neon",
        }
    }

    /// The best level of this processor.
    pub fn best() -> Self {
        *Self::available().last().unwrap_or(&Self::Scalar)
    }

    /// The levels that this processor supports, slowest first.
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|l| l.level().is_some()).collect()
    }

    /// The token of the level, which proves that this processor supports it; `None` if it does not.
    pub fn level(self) -> Option<Level> {
        let best = Level::new();
        match self {
            #[cfg(any(feature = "scalar", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
            Self::Scalar => Some(Level::Fallback(fearless_simd::Fallback::new())),
            #[cfg(target_arch = "x86_64")]
            Self::Sse2 => best.as_sse2().map(Level::Sse2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => best.as_avx2().map(Level::Avx2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => best.as_avx512().map(Level::Avx512),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => best.as_neon().map(Level::Neon),
            #[allow(unreachable_patterns, reason = "which levels exist depends on the architecture")]
            _ => {
                let _ = best;
                None
            }
        }
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for SimdLevel {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|l| l.name() == s).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|l| l.name()).collect();
            format!("expected one of {}, found \"{s}\"", names.join(", "))
        })
    }
}
