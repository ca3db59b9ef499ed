//! A TOML file whose values all carry their spans, so that errors point to the exact position.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use toml::de::{DeTable, DeValue};

use super::nearest::did_you_mean;
use crate::format_error::FormatError;

/// An error message and the bytes it refers to; [`read`] adds the path and the text.
#[derive(Debug)]
pub struct SpanError {
    pub span: Range<usize>,
    pub message: String,
}

impl SpanError {
    pub fn at(span: &Range<usize>, message: impl Into<String>) -> Self {
        SpanError { span: span.clone(), message: message.into() }
    }
}

pub type SpanResult<T> = Result<T, SpanError>;

/// A number, a string or a Boolean; the values over which lists are swept.
#[derive(Clone, Debug, PartialEq)]
pub enum Scalar {
    Integer(i64),
    Float(f64),
    Text(String),
    Boolean(bool),
}

impl Scalar {
    /// The value as in solver options and labels.
    pub fn text(&self) -> String {
        match self {
            Scalar::Integer(x) => x.to_string(),
            Scalar::Float(x) if *x != 0.0 && (x.abs() < 1e-3 || x.abs() >= 1e6) => format!("{x:e}"),
            Scalar::Float(x) => x.to_string(),
            Scalar::Text(x) => x.clone(),
            Scalar::Boolean(x) => x.to_string(),
        }
    }

    pub fn number(&self) -> Option<f64> {
        match self {
            Scalar::Integer(x) => Some(*x as f64),
            Scalar::Float(x) => Some(*x),
            Scalar::Text(_) | Scalar::Boolean(_) => None,
        }
    }

    /// Whether the values are equal; 1 equals 1.0.
    pub fn is(&self, other: &Scalar) -> bool {
        match (self.number(), other.number()) {
            (Some(a), Some(b)) => a == b,
            _ => self == other,
        }
    }

    /// The value for a TOML file.
    pub fn toml(&self) -> toml::Value {
        match self {
            Scalar::Integer(x) => toml::Value::Integer(*x),
            Scalar::Float(x) => toml::Value::Float(*x),
            Scalar::Text(x) => toml::Value::String(x.clone()),
            Scalar::Boolean(x) => toml::Value::Boolean(*x),
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

/// A table of the file. Keys are taken out one by one; the remaining ones are unknown.
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

    /// The values of a key: one, or several in a nonempty list.
    pub fn list(&mut self, key: &'static str) -> SpanResult<Option<Vec<Spanned<Scalar>>>> {
        self.take(key).map(|value| scalars(key, value)).transpose()
    }

    /// The strings of a key: one, or several in a list.
    pub fn texts(&mut self, key: &'static str) -> SpanResult<Vec<Spanned<String>>> {
        let list = self.list(key)?.unwrap_or_default();
        list.into_iter().map(|scalar| text(key, scalar)).collect()
    }

    pub fn text(&mut self, key: &'static str) -> SpanResult<Option<Spanned<String>>> {
        self.scalar(key)?.map(|scalar| text(key, scalar)).transpose()
    }

    pub fn number(&mut self, key: &'static str) -> SpanResult<Option<Spanned<f64>>> {
        self.scalar(key)?
            .map(|Spanned { value, span }| match value.number() {
                Some(value) => Ok(Spanned { value, span }),
                None => Err(SpanError::at(&span, format!("{key} must be a number"))),
            })
            .transpose()
    }

    /// A whole number that is at least `least`.
    pub fn count(&mut self, key: &'static str, least: u64) -> SpanResult<Option<Spanned<u64>>> {
        self.scalar(key)?
            .map(|Spanned { value, span }| match value {
                Scalar::Integer(x) if u64::try_from(x).is_ok_and(|x| x >= least) => {
                    Ok(Spanned { value: x as u64, span })
                }
                _ => Err(SpanError::at(
                    &span,
                    format!("{key} must be a whole number, {least} or more"),
                )),
            })
            .transpose()
    }

    pub fn boolean(&mut self, key: &'static str) -> SpanResult<Option<bool>> {
        self.scalar(key)?
            .map(|Spanned { value, span }| match value {
                Scalar::Boolean(value) => Ok(value),
                _ => Err(SpanError::at(&span, format!("{key} must be true or false"))),
            })
            .transpose()
    }

    fn scalar(&mut self, key: &'static str) -> SpanResult<Option<Spanned<Scalar>>> {
        self.take(key).map(|value| scalar(key, value)).transpose()
    }

    /// A table `[key]` or `key = { ... }`.
    pub fn section(&mut self, key: &'static str) -> SpanResult<Option<Section<'a>>> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => Ok(Some(Section::new(format!("[{key}]"), span, table))),
            _ => Err(SpanError::at(&span, format!("{key} must be a table"))),
        }
    }

    /// Tables `[[key]]`, in their order.
    pub fn sections(&mut self, key: &'static str) -> SpanResult<Vec<Section<'a>>> {
        let Some(value) = self.take(key) else { return Ok(Vec::new()) };
        let span = value.span();
        let wrong = |span: &Range<usize>| {
            SpanError::at(span, format!("{key} must be a list of tables: [[{key}]]"))
        };
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

    /// All remaining keys, each with one value or several.
    pub fn rest(&mut self) -> SpanResult<Vec<KeyValues>> {
        let entries = std::mem::take(&mut self.entries);
        entries
            .into_iter()
            .map(|(key, span, value)| {
                let values = scalars(&key, value)?;
                Ok((Spanned { value: key, span }, values))
            })
            .collect()
    }

    /// Fails if there are unknown keys.
    pub fn end(self) -> SpanResult<()> {
        match self.entries.first() {
            None => Ok(()),
            Some((key, span, _)) => {
                let name = if self.name.is_empty() { "the file".into() } else { self.name };
                let meant = did_you_mean(key, self.known.iter().copied());
                let known = self.known.join(", ");
                Err(SpanError::at(
                    span,
                    format!("{key:?} is not a key of {name}; its keys are {known}{meant}"),
                ))
            }
        }
    }
}

fn scalars(key: &str, value: toml::Spanned<DeValue<'_>>) -> SpanResult<Vec<Spanned<Scalar>>> {
    if !value.get_ref().is_array() {
        return Ok(vec![scalar(key, value)?]);
    }
    let span = value.span();
    let DeValue::Array(array) = value.into_inner() else { unreachable!("it is an array") };
    if array.is_empty() {
        return Err(SpanError::at(&span, format!("{key} is an empty list: nothing would run")));
    }
    array.into_iter().map(|value| scalar(key, value)).collect()
}

fn scalar(key: &str, value: toml::Spanned<DeValue<'_>>) -> SpanResult<Spanned<Scalar>> {
    let span = value.span();
    let wrong = |what: &str| Err(SpanError::at(&span, format!("{key} {what}")));
    let value = match value.into_inner() {
        DeValue::String(text) => Scalar::Text(text.into_owned()),
        DeValue::Boolean(value) => Scalar::Boolean(value),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(x) => Scalar::Integer(x),
            Err(_) => return wrong("is too large"),
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

fn text(key: &str, Spanned { value, span }: Spanned<Scalar>) -> SpanResult<Spanned<String>> {
    match value {
        Scalar::Text(value) => Ok(Spanned { value, span }),
        _ => Err(SpanError::at(&span, format!("{key} must be a string in quotes"))),
    }
}

/// Reads a document with `read`, which takes the keys it knows; any other key is an error.
pub fn read<T>(
    path: &Path,
    text: &str,
    read: impl FnOnce(&mut Section<'_>) -> SpanResult<T>,
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
        .map_err(|SpanError { span, message }| format_error(span, message))
}
