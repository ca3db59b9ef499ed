//! Three numbers as a text, such as a direction or a color.

use std::str::FromStr;

/// Three numbers, separated by commas.
#[derive(Clone, Copy, Debug)]
pub struct Triple(pub [f64; 3]);

impl FromStr for Triple {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        let numbers = text.split(',').map(|number| number.trim().parse().ok());
        let numbers: Option<Vec<f64>> = numbers.collect();
        let triple = numbers.and_then(|numbers| numbers.try_into().ok());
        triple.map(Triple).ok_or("must be three numbers, separated by commas")
    }
}
