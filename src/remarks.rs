//! Regions that no vertex belongs to: a degenerate answer, which is said.

use ndarray::Array1;

/// The regions from 0 to m - 1 that no vertex has, ascending. Panics if a label is not among them.
pub fn empty_regions(labels: &Array1<i32>, m: usize) -> Vec<usize> {
    let mut used = vec![false; m];
    labels.iter().for_each(|&label| used[label as usize] = true);
    (0..m).filter(|&p| !used[p]).collect()
}

/// "region 2 is empty", "regions 0, 2 and 5 are empty".
pub fn named(empty: &[usize]) -> String {
    match empty {
        [p] => format!("region {p} is empty"),
        [first @ .., last] => {
            let first: Vec<String> = first.iter().map(usize::to_string).collect();
            format!("regions {} and {last} are empty", first.join(", "))
        }
        [] => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_regions_are_named() {
        let empty = empty_regions(&Array1::from(vec![1, 1, 3]), 6);
        assert_eq!(empty, [0, 2, 4, 5]);
        assert_eq!(named(&empty), "regions 0, 2, 4 and 5 are empty");
        assert_eq!(named(&empty[..2]), "regions 0 and 2 are empty");
        assert_eq!(named(&empty[1..2]), "region 2 is empty");
    }
}
