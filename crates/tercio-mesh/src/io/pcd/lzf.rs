//! The compression of liblzf.

/// Decompresses to exactly so many bytes; `None` if the data are damaged.
pub fn decompress(mut from: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut to = Vec::with_capacity(length);
    while let Some((&control, rest)) = from.split_first() {
        from = rest;
        let control = usize::from(control);
        if control < 32 {
            // Bytes as they are.
            let (literals, rest) = from.split_at_checked(control + 1)?;
            to.extend_from_slice(literals);
            from = rest;
        } else {
            // A repetition: its length, and how far back.
            let mut count = control >> 5;
            if count == 7 {
                let (&more, rest) = from.split_first()?;
                count += usize::from(more);
                from = rest;
            }
            let (&low, rest) = from.split_first()?;
            from = rest;
            let back = ((control & 31) << 8 | usize::from(low)) + 1;
            let start = to.len().checked_sub(back)?;
            if to.len() + count + 2 > length {
                return None;
            }
            for i in start..start + count + 2 {
                to.push(to[i]);
            }
        }
        if to.len() > length {
            return None;
        }
    }
    (to.len() == length).then_some(to)
}

#[cfg(test)]
mod tests {
    use super::decompress;

    #[test]
    fn literals_and_repetitions() {
        assert_eq!(decompress(&[2, 1, 2, 3], 3), Some(vec![1, 2, 3]));
        assert_eq!(decompress(&[0, 9, 0x60, 0], 6), Some(vec![9; 6]));
        assert_eq!(decompress(&[1, 1, 2, 0xe0, 3, 1], 14), Some([1, 2].repeat(7)));
        for damaged in [&[2, 1, 2][..], &[0x20, 0], &[0, 9, 0x60], &[0, 9, 0x20, 5]] {
            assert_eq!(decompress(damaged, 6), None);
        }
    }
}
