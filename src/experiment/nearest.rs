//! "Did you mean": the known name that is most similar to a given one.

/// Names below this similarity are not misspellings of each other (Jaro-Winkler similarity, 1 for equal names).
const MIN_SIMILARITY: f64 = 0.8;

/// `; did you mean "NAME"?`, or nothing.
pub fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let plain = |name: &str| name.to_lowercase().replace(['_', ' '], "-");
    let alike = |name: &str| {
        // Words of a long name are compared as well, since labels are found by substrings.
        let (name, given) = (plain(name), plain(given));
        let words = name.split([',', '-', ':', '/']).map(str::trim);
        let word = words.map(|word| 0.95 * strsim::jaro_winkler(word, &given)).fold(0.0, f64::max);
        // A single typing error: an insertion, deletion, substitution or transposition.
        let typo = given.chars().count() > 2 && strsim::osa_distance(&name, &given) == 1;
        strsim::jaro_winkler(&name, &given).max(word).max(if typo { 0.9 } else { 0.0 })
    };
    let mut best: Option<(&str, f64)> = None;
    for name in known {
        let alike = alike(name);
        if alike >= MIN_SIMILARITY && best.is_none_or(|(_, least)| alike > least) {
            best = Some((name, alike));
        }
    }
    best.map_or(String::new(), |(name, _)| format!("; did you mean {name:?}?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspellings_are_found_and_unrelated_names_are_not() {
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
