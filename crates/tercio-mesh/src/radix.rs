//! Sorting of numbers in linear time.

/// Bits of a digit: three of them are all of a key.
const BITS: u32 = 11;
/// Fewer keys are sorted by comparison: three tables of counts would take longer.
const FEW: usize = 1 << 10;

/// The places of keys, in the order of the keys; of equal ones, the first one first.
pub fn order_of(keys: &[u32]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    if keys.len() < FEW {
        order.sort_by_key(|&place| keys[place as usize]);
        return order;
    }
    let mut next = vec![0; keys.len()];
    for shift in [0, BITS, 2 * BITS] {
        let digit = |place: u32| (keys[place as usize] >> shift) as usize % (1 << BITS);
        let mut ends = [0; 1 << BITS];
        order.iter().for_each(|&place| ends[digit(place)] += 1);
        let mut sum = 0;
        for end in &mut ends {
            (sum, *end) = (sum + *end, sum);
        }
        for &place in &order {
            let end = &mut ends[digit(place)];
            next[*end] = place;
            *end += 1;
        }
        std::mem::swap(&mut order, &mut next);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_that_of_a_stable_sort() {
        for count in [0, 1, 5, FEW - 1, FEW, 3 * FEW + 7] {
            for range in [3, 5_000, 1 << 30, u32::MAX] {
                let key = |i: usize| (i as u32).wrapping_mul(0x9e37_79b1).rotate_left(7) % range;
                let keys: Vec<u32> = (0..count).map(key).collect();
                let mut expected: Vec<u32> = (0..count as u32).collect();
                expected.sort_by_key(|&place| keys[place as usize]);
                assert_eq!(order_of(&keys), expected, "{count} keys below {range}");
            }
        }
        assert_eq!(order_of(&[u32::MAX; FEW]), Vec::from_iter(0..FEW as u32));
    }
}
