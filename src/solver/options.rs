//! `--solver-option key=value`: what a solver can be told, and what it may not.

use std::collections::BTreeMap;
use std::ops::Bound::{Excluded, Included, Unbounded};
use std::ops::RangeBounds;

use super::Description;
use crate::error::{Error, Result};

/// One option of one solver.
pub struct OptionDescription {
    pub key: &'static str,
    pub values: &'static str,
    pub default: &'static str,
    pub help: &'static str,
}

/// Options by key, as the user wrote them.
#[derive(Clone, Debug, Default)]
pub struct Options(BTreeMap<String, String>);

impl Options {
    /// From `key=value` texts. A key that comes twice is refused.
    pub fn parse<S: AsRef<str>>(texts: &[S]) -> Result<Self> {
        let mut options = BTreeMap::new();
        for text in texts.iter().map(AsRef::as_ref) {
            let (key, value) = text.split_once('=').ok_or_else(|| {
                Error::unsuitable(format!("solver option {text:?}: must read key=value"))
            })?;
            let (key, value) = (key.trim().to_owned(), value.trim().to_owned());
            if options.insert(key.clone(), value).is_some() {
                return Err(Error::unsuitable(format!("solver option {key:?} is given twice")));
            }
        }
        Ok(Options(options))
    }

    /// What was given.
    pub fn pairs(&self) -> &BTreeMap<String, String> {
        &self.0
    }

    /// Refuses keys that the solver does not know.
    pub fn check(&self, description: &Description) -> Result<()> {
        let known: Vec<&str> = description.options.iter().map(|o| o.key).collect();
        match self.0.keys().find(|key| !known.contains(&key.as_str())) {
            None => Ok(()),
            Some(key) => Err(Error::unsuitable(format!(
                "solver option {key:?} is unknown to {}; it has {}",
                description.name,
                known.join(", ")
            ))),
        }
    }

    /// A number within `range`; `None` if the option is not given.
    pub fn number(&self, key: &str, range: impl RangeBounds<f64>) -> Result<Option<f64>> {
        let Some(text) = self.0.get(key) else {
            return Ok(None);
        };
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() && range.contains(&number) => Ok(Some(number)),
            _ => {
                let from = match range.start_bound() {
                    Included(&f64::MIN_POSITIVE) => " above 0".into(),
                    Included(bound) => format!(" from {bound}"),
                    Excluded(bound) => format!(" above {bound}"),
                    Unbounded => String::new(),
                };
                let to = match range.end_bound() {
                    Included(bound) => format!(" up to {bound}"),
                    Excluded(bound) => format!(" below {bound}"),
                    Unbounded => String::new(),
                };
                Err(Error::unsuitable(format!(
                    "solver option {key}={text}: must be a number{from}{to}"
                )))
            }
        }
    }

    /// One of the named values; the first if the option is not given.
    pub fn choice<T: Copy>(&self, key: &str, named: &[(&str, T)]) -> Result<T> {
        let Some(text) = self.0.get(key) else {
            return Ok(named[0].1);
        };
        match named.iter().find(|(name, _)| name == text) {
            Some(&(_, value)) => Ok(value),
            None => {
                let names: Vec<&str> = named.iter().map(|(name, _)| *name).collect();
                Err(Error::unsuitable(format!(
                    "solver option {key}={text}: must be one of {}",
                    names.join(", ")
                )))
            }
        }
    }
}
