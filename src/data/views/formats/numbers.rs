//! Numbers in lines of text.

/// N finite numbers from words, or `None`.
pub fn numbers<'a, const N: usize>(words: &mut impl Iterator<Item = &'a str>) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = words.next()?.parse().ok().filter(|x: &f64| x.is_finite())?;
    }
    Some(numbers)
}
