//! Numbers with their nouns, for messages.

/// The number and the noun in the form that it needs: `1 vertex`, `2 vertices`. A verb can follow the noun in both
/// forms: `counted(n, "vertex has", "vertices have")`.
pub fn counted(n: usize, singular: &str, plural: &str) -> String {
    format!("{n} {}", if n == 1 { singular } else { plural })
}

/// A positive number, rounded upwards to two significant digits, so that "at most" stays true.
pub fn rounded_up(x: f64) -> f64 {
    let unit = 10_f64.powf(x.log10().floor() - 1.0);
    let up = (x / unit).ceil() * unit;
    if up.is_finite() { up } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_are_rounded_upwards() {
        for (x, up) in
            [(2.039e-3, "2.1e-3"), (9.91e-6, "1.0e-5"), (0.643, "6.5e-1"), (1e300, "1.0e300")]
        {
            assert_eq!(format!("{:.1e}", rounded_up(x)), up);
        }
        for x in [0.0, f64::INFINITY] {
            assert_eq!(rounded_up(x), x);
        }
    }

    #[test]
    fn only_one_is_singular() {
        assert_eq!(counted(0, "face was", "faces were"), "0 faces were");
        assert_eq!(counted(1, "face was", "faces were"), "1 face was");
        assert_eq!(counted(2, "face was", "faces were"), "2 faces were");
    }
}
