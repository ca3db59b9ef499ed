//! The argument of `--start`.

use std::path::PathBuf;
use std::str::FromStr;

/// The surface that evolves.
#[derive(Clone)]
pub enum Start {
    /// A sphere, in the middle of what the cameras see if it has no center and radius.
    Sphere(Option<[f64; 4]>),
    /// A box in the middle of what the cameras see.
    Box,
    /// The visual hull.
    Hull,
    /// A mesh.
    Mesh(PathBuf),
}

impl FromStr for Start {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        match text {
            "sphere" => return Ok(Start::Sphere(None)),
            "box" => return Ok(Start::Box),
            "hull" => return Ok(Start::Hull),
            _ => {}
        }
        let Some(numbers) = text.strip_prefix("sphere:").filter(|text| text.contains(',')) else {
            return Ok(Start::Mesh(text.into()));
        };
        let numbers = numbers.split(',').map(|number| number.trim().parse().ok());
        let numbers: Option<Vec<f64>> = numbers.collect();
        let ball = numbers.and_then(|numbers| <[f64; 4]>::try_from(numbers).ok());
        let possible = |ball: &[f64; 4]| ball.iter().all(|x| x.is_finite()) && ball[3] > 0.0;
        ball.filter(possible)
            .map(|ball| Start::Sphere(Some(ball)))
            .ok_or("must be sphere:CX,CY,CZ,R, with a radius R above 0")
    }
}
