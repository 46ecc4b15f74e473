//! Kernels at the SIMD level of the processor.

#[cfg(any(feature = "scalar", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
pub use fearless_simd::Fallback;
pub use fearless_simd::{Level, Simd};

pub use super::baseline;

/// Runs an expression at a SIMD level: `dispatch!(level, simd => kernel(simd, ...))`. As the macro of `fearless_simd`, but without
/// SSE4.2, whose processors use the kernels of SSE2: at most a third slower, while a level more is a quarter more code, and
/// as much longer to compile.
#[macro_export]
macro_rules! dispatch {
    ($level:expr, $simd:pat => $work:expr) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            $crate::dispatching::Level::Avx512(token) => $crate::vectorize!(token, $simd => $work),
            #[cfg(target_arch = "x86_64")]
            $crate::dispatching::Level::Avx2(token) => $crate::vectorize!(token, $simd => $work),
            level => $crate::dispatch_low!(level, $simd => $work),
        }
    };
}

/// [`dispatch!`](crate::dispatch) at the levels below AVX2.
#[cfg(any(feature = "scalar", not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_low {
    ($level:expr, $simd:pat => $work:expr) => {
        if $level.is_fallback() {
            $crate::vectorize!($crate::dispatching::Fallback::new(), $simd => $work)
        } else {
            $crate::vectorize!($crate::dispatching::baseline(), $simd => $work)
        }
    };
}

/// [`dispatch!`](crate::dispatch) at the levels below AVX2.
#[cfg(not(any(feature = "scalar", not(any(target_arch = "x86_64", target_arch = "aarch64")))))]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_low {
    ($level:expr, $simd:pat => $work:expr) => {{
        let _: $crate::dispatching::Level = $level;
        $crate::vectorize!($crate::dispatching::baseline(), $simd => $work)
    }};
}

/// An expression compiled with the features of one level.
#[doc(hidden)]
#[macro_export]
macro_rules! vectorize {
    ($token:expr, $simd:pat => $work:expr) => {{
        let token = $token;
        let $simd = token;
        $crate::dispatching::Simd::vectorize(
            token,
            #[inline(always)]
            || $work,
        )
    }};
}
