//! Regions without any vertex: a degenerate result that is reported.

use ndarray::Array1;

/// The regions from 0 to m - 1 that own no vertex, ascending. Panics if a label is not in this range.
pub fn of_labels(labels: &Array1<i32>, m: usize) -> Vec<usize> {
    let mut used = vec![false; m];
    labels.iter().for_each(|&label| used[label as usize] = true);
    (0..m).filter(|&p| !used[p]).collect()
}

/// The clause "region 2 is empty" or "regions 0, 2 and 5 are empty".
pub fn sentence(empty: &[usize]) -> String {
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
        let empty = of_labels(&Array1::from(vec![1, 1, 3]), 6);
        assert_eq!(empty, [0, 2, 4, 5]);
        assert_eq!(sentence(&empty), "regions 0, 2, 4 and 5 are empty");
        assert_eq!(sentence(&empty[..2]), "regions 0 and 2 are empty");
        assert_eq!(sentence(&empty[1..2]), "region 2 is empty");
    }
}
