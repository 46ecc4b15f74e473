//! Words of the laboratory's texts.

/// `1 copy`, `2 copies`.
pub fn counted(number: u64, one: &str, several: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { several })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_not_several() {
        let copies = [0, 1, 2].map(|n| counted(n, "copy", "copies"));
        assert_eq!(copies, ["0 copies", "1 copy", "2 copies"]);
    }
}
