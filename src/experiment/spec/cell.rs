//! The values of one cell of an `[[instance]]` or a `[[solver]]`, accessed by key.

use std::ops::{Range, RangeInclusive};

use super::super::document::{Scalar, SpanError, SpanResult, Spanned};
use super::super::grid::{Group, Keys};
use super::super::nearest::did_you_mean;
use crate::names::{Named, must_be_one_of};

/// The values of a cell, accessed by key.
pub struct Cell<'a>(pub &'a [(String, Spanned<Scalar>)]);

impl Cell<'_> {
    pub fn get(&self, key: &str) -> Option<&Spanned<Scalar>> {
        self.0.iter().find(|(name, _)| name == key).map(|(_, value)| value)
    }

    pub fn number(&self, key: &str, default: f64, least: f64) -> SpanResult<f64> {
        let Some(Spanned { value, span }) = self.get(key) else { return Ok(default) };
        let number = value.number().filter(|&number| number >= least);
        number
            .ok_or_else(|| SpanError::at(span, format!("{key} must be a number, {least} or more")))
    }

    pub fn count(&self, key: &str, default: u64, range: RangeInclusive<u64>) -> SpanResult<u64> {
        let Some(Spanned { value, span }) = self.get(key) else { return Ok(default) };
        match value {
            Scalar::Integer(x) if u64::try_from(*x).is_ok_and(|x| range.contains(&x)) => {
                Ok(*x as u64)
            }
            _ => {
                let (from, to) = (range.start(), range.end());
                let allowed = match *to {
                    u64::MAX => format!(", {from} or more"),
                    to => format!(" from {from} to {to}"),
                };
                Err(SpanError::at(span, format!("{key} must be a whole number{allowed}")))
            }
        }
    }

    pub fn named<T: Named>(&self, key: &str, default: T) -> SpanResult<T> {
        let Some(Spanned { value, span }) = self.get(key) else { return Ok(default) };
        let found = if let Scalar::Text(name) = value { T::named(name) } else { None };
        found.ok_or_else(|| {
            let meant = did_you_mean(&value.text(), T::names().iter().copied());
            let quoted = T::names().iter().map(|name| format!("{name:?}"));
            SpanError::at(span, format!("{key} {}{meant}", must_be_one_of(quoted)))
        })
    }

    pub fn text(&self, key: &str) -> SpanResult<Option<(&str, &Range<usize>)>> {
        match self.get(key) {
            None => Ok(None),
            Some(Spanned { value: Scalar::Text(text), span }) => Ok(Some((text, span))),
            Some(Spanned { span, .. }) => {
                Err(SpanError::at(span, format!("{key} must be a string in quotes")))
            }
        }
    }

    pub fn keys(&self) -> Keys {
        self.0.iter().map(|(key, spanned)| (key.clone(), spanned.value.clone())).collect()
    }
}

/// The given label followed by the values that differ between the cells of its table, or else `plain`.
pub fn label_of(label: Option<&str>, plain: String, cell: &Cell<'_>, group: &Group) -> String {
    let Some(label) = label else { return plain };
    let varied = cell.0.iter().filter(|(key, _)| group.varies(key));
    let varied = varied.map(|(key, spanned)| {
        let key = key.strip_prefix("options.").unwrap_or(key);
        format!(", {key} {}", spanned.value.text())
    });
    label.to_owned() + &varied.collect::<String>()
}
