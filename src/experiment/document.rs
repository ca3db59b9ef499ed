//! A TOML file whose values all know their spans in it, so that what is wrong with it is shown where it stands.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use toml::de::{DeTable, DeValue};

use super::nearest::did_you_mean;
use crate::format_error::FormatError;

/// A message and the bytes it is about; [`Document::format_error`] makes it whole.
#[derive(Debug)]
pub struct Wrong {
    pub span: Range<usize>,
    pub message: String,
}

impl Wrong {
    pub fn at(span: &Range<usize>, message: impl Into<String>) -> Self {
        Wrong { span: span.clone(), message: message.into() }
    }
}

pub type Fits<T> = Result<T, Wrong>;

/// A number, a text or a truth: what a list is swept over.
#[derive(Clone, Debug, PartialEq)]
pub enum Scalar {
    Integer(i64),
    Float(f64),
    Text(String),
    Truth(bool),
}

impl Scalar {
    /// As a solver option takes it, and as people read it.
    pub fn text(&self) -> String {
        match self {
            Scalar::Integer(x) => x.to_string(),
            Scalar::Float(x) if *x != 0.0 && (x.abs() < 1e-3 || x.abs() >= 1e6) => format!("{x:e}"),
            Scalar::Float(x) => x.to_string(),
            Scalar::Text(x) => x.clone(),
            Scalar::Truth(x) => x.to_string(),
        }
    }

    pub fn number(&self) -> Option<f64> {
        match self {
            Scalar::Integer(x) => Some(*x as f64),
            Scalar::Float(x) => Some(*x),
            Scalar::Text(_) | Scalar::Truth(_) => None,
        }
    }

    /// Whether it is the same value: 1 and 1.0 are.
    pub fn is(&self, other: &Scalar) -> bool {
        match (self.number(), other.number()) {
            (Some(a), Some(b)) => a == b,
            _ => self == other,
        }
    }

    /// As it would stand in a TOML file.
    pub fn toml(&self) -> toml::Value {
        match self {
            Scalar::Integer(x) => toml::Value::Integer(*x),
            Scalar::Float(x) => toml::Value::Float(*x),
            Scalar::Text(x) => toml::Value::String(x.clone()),
            Scalar::Truth(x) => toml::Value::Boolean(*x),
        }
    }
}

/// A value and its span.
#[derive(Clone, Debug)]
pub struct Spanned<T> {
    pub value: T,
    pub span: Range<usize>,
}

/// A key and its values.
pub type KeyValues = (Spanned<String>, Vec<Spanned<Scalar>>);

/// A table of the file. Keys are taken out one by one; those that are left over are unknown.
pub struct Section<'a> {
    /// For messages: `[[solver]]`.
    pub name: Cow<'static, str>,
    pub span: Range<usize>,
    entries: Vec<(String, Range<usize>, toml::Spanned<DeValue<'a>>)>,
    known: Vec<&'static str>,
}

impl<'a> Section<'a> {
    fn new(name: impl Into<Cow<'static, str>>, span: Range<usize>, table: DeTable<'a>) -> Self {
        let entries = table
            .into_iter()
            .map(|(key, value)| (key.get_ref().to_string(), key.span(), value))
            .collect();
        Section { name: name.into(), span, entries, known: Vec::new() }
    }

    fn take(&mut self, key: &'static str) -> Option<toml::Spanned<DeValue<'a>>> {
        self.known.push(key);
        let i = self.entries.iter().position(|(name, ..)| name == key)?;
        Some(self.entries.remove(i).2)
    }

    /// One value, or several in a list that is not empty.
    pub fn list(&mut self, key: &'static str) -> Fits<Option<Vec<Spanned<Scalar>>>> {
        self.take(key).map(|value| scalars(key, value)).transpose()
    }

    /// A list of texts, or one.
    pub fn texts(&mut self, key: &'static str) -> Fits<Vec<Spanned<String>>> {
        let list = self.list(key)?.unwrap_or_default();
        list.into_iter().map(|scalar| text(key, scalar)).collect()
    }

    pub fn text(&mut self, key: &'static str) -> Fits<Option<Spanned<String>>> {
        self.scalar(key)?.map(|scalar| text(key, scalar)).transpose()
    }

    pub fn number(&mut self, key: &'static str) -> Fits<Option<Spanned<f64>>> {
        self.scalar(key)?
            .map(|Spanned { value, span }| match value.number() {
                Some(value) => Ok(Spanned { value, span }),
                None => Err(Wrong::at(&span, format!("{key} must be a number"))),
            })
            .transpose()
    }

    /// A whole number from `least`.
    pub fn count(&mut self, key: &'static str, least: u64) -> Fits<Option<Spanned<u64>>> {
        self.scalar(key)?
            .map(|Spanned { value, span }| match value {
                Scalar::Integer(x) if u64::try_from(x).is_ok_and(|x| x >= least) => {
                    Ok(Spanned { value: x as u64, span })
                }
                _ => Err(Wrong::at(&span, format!("{key} must be a whole number from {least}"))),
            })
            .transpose()
    }

    pub fn truth(&mut self, key: &'static str) -> Fits<Option<bool>> {
        self.scalar(key)?
            .map(|Spanned { value, span }| match value {
                Scalar::Truth(value) => Ok(value),
                _ => Err(Wrong::at(&span, format!("{key} must be true or false"))),
            })
            .transpose()
    }

    fn scalar(&mut self, key: &'static str) -> Fits<Option<Spanned<Scalar>>> {
        self.take(key).map(|value| scalar(key, value)).transpose()
    }

    /// A table `[key]` or `key = { ... }`.
    pub fn section(&mut self, key: &'static str) -> Fits<Option<Section<'a>>> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => Ok(Some(Section::new(format!("[{key}]"), span, table))),
            _ => Err(Wrong::at(&span, format!("{key} must be a table"))),
        }
    }

    /// Tables `[[key]]`, in their order.
    pub fn sections(&mut self, key: &'static str) -> Fits<Vec<Section<'a>>> {
        let Some(value) = self.take(key) else { return Ok(Vec::new()) };
        let span = value.span();
        let wrong =
            |span: &Range<usize>| Wrong::at(span, format!("{key} must be tables: [[{key}]]"));
        let DeValue::Array(array) = value.into_inner() else { return Err(wrong(&span)) };
        array
            .into_iter()
            .map(|value| {
                let span = value.span();
                match value.into_inner() {
                    DeValue::Table(table) => Ok(Section::new(format!("[[{key}]]"), span, table)),
                    _ => Err(wrong(&span)),
                }
            })
            .collect()
    }

    /// All that is left, whatever its name: values or lists of them.
    pub fn rest(&mut self) -> Fits<Vec<KeyValues>> {
        let entries = std::mem::take(&mut self.entries);
        entries
            .into_iter()
            .map(|(key, span, value)| {
                let values = scalars(&key, value)?;
                Ok((Spanned { value: key, span }, values))
            })
            .collect()
    }

    /// Refuses what nobody asked for.
    pub fn end(self) -> Fits<()> {
        match self.entries.first() {
            None => Ok(()),
            Some((key, span, _)) => {
                let name = if self.name.is_empty() { "the file".into() } else { self.name };
                let meant = did_you_mean(key, self.known.iter().copied());
                let known = self.known.join(", ");
                Err(Wrong::at(span, format!("{key:?} is no key of {name}; it has {known}{meant}")))
            }
        }
    }
}

fn scalars(key: &str, value: toml::Spanned<DeValue<'_>>) -> Fits<Vec<Spanned<Scalar>>> {
    if !value.get_ref().is_array() {
        return Ok(vec![scalar(key, value)?]);
    }
    let span = value.span();
    let DeValue::Array(array) = value.into_inner() else { unreachable!("it is an array") };
    if array.is_empty() {
        return Err(Wrong::at(&span, format!("{key} is an empty list: nothing would run")));
    }
    array.into_iter().map(|value| scalar(key, value)).collect()
}

fn scalar(key: &str, value: toml::Spanned<DeValue<'_>>) -> Fits<Spanned<Scalar>> {
    let span = value.span();
    let wrong = |what: &str| Err(Wrong::at(&span, format!("{key} {what}")));
    let value = match value.into_inner() {
        DeValue::String(text) => Scalar::Text(text.into_owned()),
        DeValue::Boolean(truth) => Scalar::Truth(truth),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(x) => Scalar::Integer(x),
            Err(_) => return wrong("is too large a whole number"),
        },
        DeValue::Float(float) => match float.as_str().parse::<f64>() {
            Ok(x) if x.is_finite() => Scalar::Float(x),
            _ => return wrong("must be a finite number"),
        },
        DeValue::Datetime(_) => return wrong("must not be a date"),
        DeValue::Array(_) => return wrong("must not be a list of lists"),
        DeValue::Table(_) => return wrong("must not be a table"),
    };
    Ok(Spanned { value, span })
}

fn text(key: &str, Spanned { value, span }: Spanned<Scalar>) -> Fits<Spanned<String>> {
    match value {
        Scalar::Text(value) => Ok(Spanned { value, span }),
        _ => Err(Wrong::at(&span, format!("{key} must be a text in quotes"))),
    }
}

/// Reads a document with `read`, which takes what it knows; the rest is refused.
pub fn read<T>(
    path: &Path,
    text: &str,
    read: impl FnOnce(&mut Section<'_>) -> Fits<T>,
) -> Result<T, FormatError> {
    let format_error = |span: Range<usize>, message: String| {
        let end = text.len();
        let span = span.start.min(end)..span.end.min(end);
        FormatError { path: path.to_owned(), text: text.to_owned(), span, message }
    };
    let table = DeTable::parse(text).map_err(|error| {
        format_error(error.span().unwrap_or(0..0), error.message().trim().replace('\n', ", "))
    })?;
    let span = table.span();
    let mut section = Section::new("", span, table.into_inner());
    read(&mut section)
        .and_then(|value| section.end().map(|()| value))
        .map_err(|Wrong { span, message }| format_error(span, message))
}
