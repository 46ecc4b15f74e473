//! Properties of whole numbers, of which the laboratory's formulas need the same.

/// The greatest common divisor of two numbers; if one of them is 0, it is the other one.
pub fn gcd(mut a: usize, mut b: usize) -> usize {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greatest_common_divisor_divides_both_numbers() {
        assert_eq!([(12, 18), (18, 12), (7, 5), (4, 4)].map(|(a, b)| gcd(a, b)), [6, 6, 1, 4]);
        assert_eq!([(0, 5), (5, 0), (0, 0)].map(|(a, b)| gcd(a, b)), [5, 5, 0]);
    }
}
