//! Numbers with their nouns, for messages.

/// The number and the noun in the form that it needs: `1 vertex`, `2 vertices`. A verb can follow the noun in both
/// forms: `counted(n, "vertex has", "vertices have")`.
pub fn counted(n: usize, singular: &str, plural: &str) -> String {
    format!("{n} {}", if n == 1 { singular } else { plural })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_is_singular() {
        assert_eq!(counted(0, "face was", "faces were"), "0 faces were");
        assert_eq!(counted(1, "face was", "faces were"), "1 face was");
        assert_eq!(counted(2, "face was", "faces were"), "2 faces were");
    }
}
