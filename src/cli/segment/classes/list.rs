//! `--classes`: names and colors.
//!
//! ```text
//! name,color           [[class]]
//! wall,#cc8844         name = "wall"
//! roof,#884422         color = "#cc8844"
//! ```

use std::path::Path;

use serde::Deserialize;

use crate::colormap::categorical;
use crate::counted::counted;
use crate::{Error, Result, file, regions};

/// A class as it is shown.
#[derive(Clone, Debug)]
pub struct Class {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// RGB in [0, 1].
    pub color: [f64; 3],
}

/// A class as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    color: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    class: Vec<Written>,
}

/// The m classes of a file; without one, unnamed classes in the colors of regions.
///
/// # Errors
/// The file cannot be read or is malformed, or has another number of classes.
pub fn read(path: Option<&Path>, m: usize) -> Result<Vec<Class>> {
    let Some(path) = path else {
        return Ok((0..m).map(|p| Class { name: None, color: categorical(p) }).collect());
    };
    let classes = classes(path)?;
    if classes.len() == m {
        return Ok(classes);
    }
    Err(Error::malformed(
        path,
        format!("has {}, but there are {m}", counted(classes.len(), "class", "classes")),
    ))
}

/// The number of classes in a file.
///
/// # Errors
/// The file cannot be read or is malformed.
pub fn count(path: &Path) -> Result<usize> {
    classes(path).map(|classes| classes.len())
}

fn classes(path: &Path) -> Result<Vec<Class>> {
    let is_toml = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    let written = if is_toml { toml(path)? } else { table(path)? };
    regions::check(written.len()).map_err(|error| error.of_file(path))?;
    let class = |(p, Written { name, color }): (usize, Written)| {
        if name.trim().is_empty() || name.chars().any(char::is_control) {
            let message = format!("class {p} has no name, or one with a line break");
            return Err(Error::malformed(path, message));
        }
        let color = match color.as_deref().map(str::trim) {
            None | Some("") => categorical(p),
            Some(text) => hex(text).ok_or_else(|| {
                Error::malformed(
                    path,
                    format!("the color of class {p} is `{text}`: write it as #rrggbb"),
                )
            })?,
        };
        Ok(Class { name: Some(name.trim().to_owned()), color })
    };
    let classes: Vec<Class> = written.into_iter().enumerate().map(class).collect::<Result<_>>()?;
    for (p, class) in classes.iter().enumerate() {
        if let Some(other) = classes[..p].iter().position(|other| other.name == class.name) {
            let message = format!("classes {other} and {p} have the same name");
            return Err(Error::malformed(path, message));
        }
    }
    Ok(classes)
}

fn toml(path: &Path) -> Result<Vec<Written>> {
    let text = String::from_utf8(file::read(path)?)
        .map_err(|_| Error::malformed(path, "is not text in UTF-8"))?;
    let file: File = toml::from_str(&text).map_err(|error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        Error::malformed_line(path, line, error.message().replace('\n', " "))
    })?;
    Ok(file.class)
}

fn table(path: &Path) -> Result<Vec<Written>> {
    let bytes = file::read(path)?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&bytes[..]);
    let headers = reader.headers().map_err(|error| Error::malformed(path, error.to_string()))?;
    if !matches!(headers.iter().collect::<Vec<_>>()[..], ["name"] | ["name", "color"]) {
        let message = "must begin with the line `name` or `name,color`";
        return Err(Error::malformed_line(path, 1, message));
    }
    let rows = reader.deserialize();
    rows.map(|row| row.map_err(|error: csv::Error| Error::malformed(path, error.to_string())))
        .collect()
}

fn hex(text: &str) -> Option<[f64; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let mut color = [0.0; 3];
    for (c, pair) in color.iter_mut().zip(0..) {
        *c = f64::from(u8::from_str_radix(&digits[2 * pair..][..2], 16).ok()?) / 255.0;
    }
    Some(color)
}
