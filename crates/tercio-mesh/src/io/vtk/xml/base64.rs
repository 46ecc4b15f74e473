//! Base64, on several cores.

use crate::loops::prelude::*;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

const ENGINE: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_allow_trailing_bits(true)
        .with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Characters that a task decodes, a multiple of four.
const CHUNK: usize = 1 << 16;

/// Characters that so many bytes take, with their padding.
pub fn characters(bytes: usize) -> Option<usize> {
    bytes.div_ceil(3).checked_mul(4)
}

/// The bytes of a text; `None` if it is no base64.
pub fn decode(text: &[u8]) -> Option<Vec<u8>> {
    let parts: Vec<Vec<u8>> =
        text.par_chunks(CHUNK).map(|part| ENGINE.decode(part).ok()).collect::<Option<_>>()?;
    Some(parts.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_encoded_is_decoded() {
        for length in [0, 1, 2, 3, 4, 100, 3 * CHUNK / 4, 3 * CHUNK + 1] {
            let bytes: Vec<u8> = (0..length).map(|i| (i * 7 % 251) as u8).collect();
            let text = base64::engine::general_purpose::STANDARD.encode(&bytes);
            assert_eq!(characters(length), Some(text.len()));
            assert_eq!(decode(text.as_bytes()), Some(bytes));
        }
        assert_eq!(decode(b"ab!="), None);
    }
}
