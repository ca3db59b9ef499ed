//! Settings by key and as text: for the command line, experiment files and the help.
//!
//! Each method has a typed `Settings`, whose `Default` alone defines its defaults. Keys, values and help texts come
//! from [`Adjustable::settings`].

use std::collections::BTreeMap;
use std::ops::Bound::{self, Excluded, Included, Unbounded};
use std::ops::RangeBounds;

use crate::error::{Error, Result};
use crate::names::{Named, must_be_one_of};

/// The settings of a method, which can be listed and set by key.
pub trait Adjustable: Default {
    /// All of them, in the order of the help.
    fn settings(&mut self) -> Vec<Setting<'_>>;
}

/// One setting of a method, and where it is kept.
pub struct Setting<'a> {
    /// Its name in `--solver-option KEY=VALUE`.
    pub key: &'static str,
    /// One line for `meshseg solvers`.
    pub help: &'static str,
    value: Value<'a>,
}

enum Value<'a> {
    Number(&'a mut f64, Range),
    /// An optional number, and a description of what applies without it.
    Optional(&'a mut Option<f64>, Range, &'static str),
    Choice(&'a mut dyn Choice),
}

/// The range of a number.
type Range = (Bound<f64>, Bound<f64>);

/// A variant of an enumeration.
trait Choice {
    fn names(&self) -> &'static [&'static str];

    fn name(&self) -> &'static str;

    /// Chooses the variant of that name. Returns whether there is one.
    fn choose(&mut self, name: &str) -> bool;
}

impl<T: Named> Choice for T {
    fn names(&self) -> &'static [&'static str] {
        T::names()
    }

    fn name(&self) -> &'static str {
        Named::name(*self)
    }

    fn choose(&mut self, name: &str) -> bool {
        T::named(name).map(|variant| *self = variant).is_some()
    }
}

impl<'a> Setting<'a> {
    /// A number in a range, kept at `place`; NaN and infinities are refused.
    pub fn number(
        key: &'static str,
        place: &'a mut f64,
        range: impl RangeBounds<f64>,
        help: &'static str,
    ) -> Self {
        Setting { key, help, value: Value::Number(place, bounds(range)) }
    }

    /// An optional number in a range, kept at `place`; `otherwise` describes what applies without it.
    pub fn optional(
        key: &'static str,
        place: &'a mut Option<f64>,
        range: impl RangeBounds<f64>,
        otherwise: &'static str,
        help: &'static str,
    ) -> Self {
        Setting { key, help, value: Value::Optional(place, bounds(range), otherwise) }
    }

    /// A variant of an enumeration, kept at `place`, by its name.
    pub fn choice<T: Named>(key: &'static str, place: &'a mut T, help: &'static str) -> Self {
        Setting { key, help, value: Value::Choice(place) }
    }

    /// The values that it may have, for the help: `NUMBER`, or all names.
    pub fn values(&self) -> String {
        match &self.value {
            Value::Number(..) | Value::Optional(..) => "NUMBER".into(),
            Value::Choice(choice) => choice.names().join("|"),
        }
    }

    /// The current value.
    pub fn value(&self) -> String {
        match &self.value {
            Value::Number(number, _) => number.to_string(),
            Value::Optional(Some(number), ..) => number.to_string(),
            Value::Optional(None, _, otherwise) => (*otherwise).into(),
            Value::Choice(choice) => choice.name().into(),
        }
    }

    /// Checks the current value, because any number can be written to the typed fields.
    ///
    /// # Errors
    /// What the value must be, if it is invalid.
    fn check(&self) -> std::result::Result<(), String> {
        let within =
            |number: f64, range: &Range| match number.is_finite() && range.contains(&number) {
                true => Ok(()),
                false => Err(format!("must be a number{}", words(*range))),
            };
        match &self.value {
            Value::Number(number, range) => within(**number, range),
            Value::Optional(Some(number), range, _) => within(*number, range),
            Value::Optional(None, ..) | Value::Choice(_) => Ok(()),
        }
    }

    /// Sets the value from text.
    ///
    /// # Errors
    /// What the value must be, if it is invalid.
    fn set(&mut self, text: &str) -> std::result::Result<(), String> {
        let within = |range: &Range| {
            let number = text.parse().ok().filter(|x: &f64| x.is_finite() && range.contains(x));
            number.ok_or_else(|| format!("must be a number{}", words(*range)))
        };
        match &mut self.value {
            Value::Number(place, range) => **place = within(range)?,
            Value::Optional(place, range, _) => **place = Some(within(range)?),
            Value::Choice(choice) => {
                if !choice.choose(text) {
                    return Err(must_be_one_of(choice.names()));
                }
            }
        }
        Ok(())
    }
}

fn bounds(range: impl RangeBounds<f64>) -> Range {
    (range.start_bound().cloned(), range.end_bound().cloned())
}

/// A range in words.
fn words((low, high): Range) -> String {
    let from = match low {
        Included(f64::MIN_POSITIVE) => " above 0".into(),
        Included(bound) => format!(" from {bound}"),
        Excluded(bound) => format!(" above {bound}"),
        Unbounded => String::new(),
    };
    let to = match high {
        Included(bound) => format!(" up to {bound}"),
        Excluded(bound) => format!(" below {bound}"),
        Unbounded => String::new(),
    };
    let and = if from.is_empty() || to.is_empty() { "" } else { " and" };
    format!("{from}{and}{to}")
}

/// # Errors
/// A setting has an invalid value; the message names it.
pub(super) fn check(settings: &[Setting<'_>]) -> Result<()> {
    for setting in settings {
        setting.check().map_err(|message| {
            let (key, value) = (setting.key, setting.value());
            Error::unsuitable(format!("solver option {key}={value}: {message}"))
        })?;
    }
    Ok(())
}

/// Values by key, as text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options(BTreeMap<String, String>);

impl Options {
    /// From `key=value` texts. Fails if one has no `=`, or a key comes twice; whether a method knows the keys is not
    /// checked here.
    pub fn parse<S: AsRef<str>>(texts: &[S]) -> Result<Self> {
        let mut options = BTreeMap::new();
        for text in texts.iter().map(AsRef::as_ref) {
            let (key, value) = text.split_once('=').ok_or_else(|| {
                Error::unsuitable(format!("solver option {text:?}: must be key=value"))
            })?;
            let (key, value) = (key.trim().to_owned(), value.trim().to_owned());
            if options.insert(key.clone(), value).is_some() {
                return Err(Error::unsuitable(format!("solver option {key:?} is given twice")));
            }
        }
        Ok(Options(options))
    }

    /// The given values by key.
    pub fn pairs(&self) -> &BTreeMap<String, String> {
        &self.0
    }

    /// Changes settings to the given values; `name` is that of the method, for the errors.
    pub(super) fn apply(&self, name: &str, mut settings: Vec<Setting<'_>>) -> Result<()> {
        let known: Vec<&str> = settings.iter().map(|setting| setting.key).collect();
        for (key, text) in &self.0 {
            let setting = settings.iter_mut().find(|setting| setting.key == key);
            let setting = setting.ok_or_else(|| {
                let known = known.join(", ");
                Error::unsuitable(format!(
                    "solver option {key:?} is unknown to {name}; its options are {known}"
                ))
            })?;
            setting.set(text).map_err(|message| {
                Error::unsuitable(format!("solver option {key}={text}: {message}"))
            })?;
        }
        Ok(())
    }
}
