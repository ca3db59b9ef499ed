//! "Did you mean": the known name that looks most like a given one.

/// Names less alike than this are no misspellings of each other (Jaro and Winkler's measure, 1 for equal ones).
const LEAST_SIMILARITY: f64 = 0.8;

/// `; did you mean "NAME"?`, or nothing.
pub fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let plain = |name: &str| name.to_lowercase().replace(['_', ' '], "-");
    let alike = |name: &str| {
        // A part of a long name counts as well: labels are found by what they contain.
        let (name, given) = (plain(name), plain(given));
        let words = name.split([',', '-', ':', '/']).map(str::trim);
        let word = words.map(|word| 0.95 * strsim::jaro_winkler(word, &given)).fold(0.0, f64::max);
        // One slip of the finger: a letter more or less, another, or two in the wrong order.
        let slip = given.chars().count() > 2 && strsim::osa_distance(&name, &given) == 1;
        strsim::jaro_winkler(&name, &given).max(word).max(if slip { 0.9 } else { 0.0 })
    };
    let mut best: Option<(&str, f64)> = None;
    for name in known {
        let alike = alike(name);
        if alike >= LEAST_SIMILARITY && best.is_none_or(|(_, least)| alike > least) {
            best = Some((name, alike));
        }
    }
    best.map_or(String::new(), |(name, _)| format!("; did you mean {name:?}?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspellings_are_found_and_strangers_are_not() {
        let names = ["chambolle-pock", "douglas-rachford", "fista", "projected-gradient"];
        for (given, meant) in [
            ("chambole-pock", "chambolle-pock"),
            ("chambolle", "chambolle-pock"),
            ("Fista", "fista"),
            ("fitsa", "fista"),
            ("ista", "fista"),
            ("rachford", "douglas-rachford"),
            ("projected_gradient", "projected-gradient"),
        ] {
            assert_eq!(did_you_mean(given, names), format!("; did you mean {meant:?}?"));
        }
        for given in ["", "x", "newton", "ipm"] {
            assert_eq!(did_you_mean(given, names), "", "{given}");
        }
        assert_eq!(did_you_mean("a", []), "");
    }
}
