//! Operations of x86-64 that `fearless_simd` does not offer: table lookups in registers and compression of lanes.

use fearless_simd::prelude::*;
use fearless_simd::{i32x16, u8x16, u8x32, u8x64};

use super::SET_BITS;

fearless_simd::kernel!(
    /// Looks up 16 entries of a table of 64, which is held in four registers.
    #[inline]
    pub fn lookup_avx512(avx512: Avx512, table: &[i32; 64], index: &[u8; 16]) -> std::arch::x86_64::__m512i {
        use std::arch::x86_64::*;
        let part = |k: usize| -> __m512i { i32x16::from_slice(avx512, &table[16 * k..16 * k + 16]).into() };
        let packed: __m128i = u8x16::from_slice(avx512, index).into();
        let wide = _mm512_cvtepu8_epi32(packed);
        let low = _mm512_permutex2var_epi32(part(0), wide, part(1));
        let high = _mm512_permutex2var_epi32(part(2), wide, part(3));
        let upper = _mm512_test_epi32_mask(wide, _mm512_set1_epi32(32));
        _mm512_mask_blend_epi32(upper, low, high)
    }
);

fearless_simd::kernel!(
    /// Looks up 16 entries of a table of 128 bytes, which is held in two registers.
    #[inline]
    pub fn lookup_bytes_avx512(
        avx512: Avx512,
        table: &[u8; 128],
        index: &[u8; 16],
    ) -> std::arch::x86_64::__m128i {
        use std::arch::x86_64::*;
        let part = |k: usize| -> __m512i { u8x64::from_slice(avx512, &table[64 * k..64 * k + 64]).into() };
        let index: __m128i = u8x16::from_slice(avx512, index).into();
        _mm512_castsi512_si128(_mm512_permutex2var_epi8(part(0), _mm512_castsi128_si512(index), part(1)))
    }
);

fearless_simd::kernel!(
    /// Looks up 16 entries of a table of 128 bytes, which is held in four registers.
    #[inline]
    pub fn lookup_bytes_avx2(avx2: Avx2, table: &[u8; 128], index: &[u8; 16]) -> std::arch::x86_64::__m128i {
        use std::arch::x86_64::*;
        let index: __m128i = u8x16::from_slice(avx2, index).into();
        let index = _mm256_broadcastsi128_si256(_mm_and_si128(index, _mm_set1_epi8(127)));
        // Each half of a register holds 16 entries. An index outside of them gets its highest bit set, so that the
        // shuffle returns 0.
        let part = |k: usize| -> __m256i {
            let first = 32 * k as i8;
            let first = _mm256_set_m128i(_mm_set1_epi8(first + 16), _mm_set1_epi8(first));
            let inside = _mm256_adds_epu8(_mm256_sub_epi8(index, first), _mm256_set1_epi8(0x70));
            _mm256_shuffle_epi8(u8x32::from_slice(avx2, &table[32 * k..32 * k + 32]).into(), inside)
        };
        let all = _mm256_or_si256(_mm256_or_si256(part(0), part(1)), _mm256_or_si256(part(2), part(3)));
        _mm_or_si128(_mm256_castsi256_si128(all), _mm256_extracti128_si256::<1>(all))
    }
);

fearless_simd::kernel!(
    /// Looks up 16 entries of a table of 128, which is held in eight registers.
    #[inline]
    pub fn lookup_128_avx512(
        avx512: Avx512,
        table: &[i32; 128],
        index: std::arch::x86_64::__m512i,
    ) -> std::arch::x86_64::__m512i {
        use std::arch::x86_64::*;
        let part = |k: usize| -> __m512i { i32x16::from_slice(avx512, &table[16 * k..16 * k + 16]).into() };
        let pair = |k: usize| -> __m512i { _mm512_permutex2var_epi32(part(2 * k), index, part(2 * k + 1)) };
        let odd = _mm512_test_epi32_mask(index, _mm512_set1_epi32(32));
        let upper = _mm512_test_epi32_mask(index, _mm512_set1_epi32(64));
        let low = _mm512_mask_blend_epi32(odd, pair(0), pair(1));
        let high = _mm512_mask_blend_epi32(odd, pair(2), pair(3));
        _mm512_mask_blend_epi32(upper, low, high)
    }
);

fearless_simd::kernel!(
    /// Looks up 16 entries of a table of 16 in a register.
    #[inline]
    pub fn lookup_16_avx512(
        avx512: Avx512,
        table: std::arch::x86_64::__m512i,
        index: std::arch::x86_64::__m512i,
    ) -> std::arch::x86_64::__m512i {
        let _ = avx512;
        std::arch::x86_64::_mm512_permutexvar_epi32(index, table)
    }
);

fearless_simd::kernel!(
    /// Looks up 8 entries of a table of 16, which is held in two registers.
    #[inline]
    pub fn lookup_16_avx2(
        avx2: Avx2,
        low: std::arch::x86_64::__m256i,
        high: std::arch::x86_64::__m256i,
        index: std::arch::x86_64::__m256i,
    ) -> std::arch::x86_64::__m256i {
        use std::arch::x86_64::*;
        let _ = avx2;
        let low = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(low, index));
        let high = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(high, index));
        // The highest bit selects.
        let is_high = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(index));
        _mm256_castps_si256(_mm256_blendv_ps(low, high, is_high))
    }
);

fearless_simd::kernel!(
    /// The chosen lanes, moved together to the front.
    #[inline]
    pub fn compress_avx512(
        avx512: Avx512,
        lanes: u16,
        from: std::arch::x86_64::__m512i,
    ) -> std::arch::x86_64::__m512i {
        let _ = avx512;
        std::arch::x86_64::_mm512_maskz_compress_epi32(lanes, from)
    }
);

fearless_simd::kernel!(
    /// The chosen lanes, moved together to the front.
    #[inline]
    pub fn compress_avx2(
        avx2: Avx2,
        lanes: u8,
        from: std::arch::x86_64::__m256i,
    ) -> std::arch::x86_64::__m256i {
        use std::arch::x86_64::*;
        let _ = avx2;
        let order = _mm_cvtsi64_si128(i64::from_le_bytes(SET_BITS[lanes as usize]));
        _mm256_permutevar8x32_epi32(from, _mm256_cvtepu8_epi32(order))
    }
);

fearless_simd::kernel!(
    /// 16 entries of a table of four numbers each, one after the other.
    #[inline]
    pub fn lookup_fours_avx512(
        avx512: Avx512,
        table: &[[u16; 4]],
        index: std::arch::x86_64::__m512i,
    ) -> (std::arch::x86_64::__m512i, std::arch::x86_64::__m512i) {
        use std::arch::x86_64::*;
        let _ = avx512;
        let length = i32::try_from(table.len()).unwrap_or(i32::MAX);
        // As numbers without a sign, so that negative ones are too large.
        let inside = _mm512_cmplt_epu32_mask(index, _mm512_set1_epi32(length));
        assert!(inside == 0xffff, "an index is not in the table of {length}");
        let [low, high] = [_mm512_castsi512_si256(index), _mm512_extracti64x4_epi64::<1>(index)];
        let first = table.as_ptr().cast();
        // SAFETY: all indices are in the table, whose entries have 8 bytes.
        unsafe { (_mm512_i32gather_epi64::<8>(low, first), _mm512_i32gather_epi64::<8>(high, first)) }
    }
);

fearless_simd::kernel!(
    /// 8 entries of a table of four numbers each, one after the other.
    #[inline]
    pub fn lookup_fours_avx2(
        avx2: Avx2,
        table: &[[u16; 4]],
        index: std::arch::x86_64::__m256i,
    ) -> (std::arch::x86_64::__m256i, std::arch::x86_64::__m256i) {
        use std::arch::x86_64::*;
        let _ = avx2;
        let length = i32::try_from(table.len()).unwrap_or(i32::MAX);
        assert!(length > 0, "an empty table");
        // As numbers without a sign, so that negative ones are too large.
        let nearest_inside = _mm256_min_epu32(index, _mm256_set1_epi32(length - 1));
        let inside = _mm256_movemask_epi8(_mm256_cmpeq_epi32(nearest_inside, index));
        assert!(inside == -1, "an index is not in the table of {length}");
        let [low, high] = [_mm256_castsi256_si128(index), _mm256_extracti128_si256::<1>(index)];
        let first = table.as_ptr().cast();
        // SAFETY: all indices are in the table, whose entries have 8 bytes.
        unsafe { (_mm256_i32gather_epi64::<8>(first, low), _mm256_i32gather_epi64::<8>(first, high)) }
    }
);
