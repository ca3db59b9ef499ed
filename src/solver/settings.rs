//! Settings by key, for whoever writes them as text: command line, experiment files, help.
//!
//! Each method has a typed `Settings`, whose `Default` is the only place where its defaults stand. What is known here
//! of them, keys, values and help, comes from [`Adjustable::settings`].

use std::collections::BTreeMap;
use std::ops::Bound::{self, Excluded, Included, Unbounded};
use std::ops::RangeBounds;

use crate::error::{Error, Result};
use crate::names::{Named, must_be_one_of};

/// Settings of a method that can be named.
pub trait Adjustable: Default {
    /// All of them, in the order in which they are listed.
    fn settings(&mut self) -> Vec<Setting<'_>>;
}

/// One setting of a method, and where it is kept.
pub struct Setting<'a> {
    pub key: &'static str,
    pub help: &'static str,
    value: Value<'a>,
}

enum Value<'a> {
    Number(&'a mut f64, Range),
    /// What no number stands for.
    Optional(&'a mut Option<f64>, Range, &'static str),
    Choice(&'a mut dyn Choice),
}

/// Where a number may lie.
type Range = (Bound<f64>, Bound<f64>);

/// A variant of an enumeration.
trait Choice {
    fn names(&self) -> &'static [&'static str];

    fn name(&self) -> &'static str;

    /// Whether there is a variant of that name, which is then chosen.
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
    /// A number in a range.
    pub fn number(
        key: &'static str,
        place: &'a mut f64,
        range: impl RangeBounds<f64>,
        help: &'static str,
    ) -> Self {
        Setting { key, help, value: Value::Number(place, bounds(range)) }
    }

    /// A number in a range, or what `otherwise` says.
    pub fn optional(
        key: &'static str,
        place: &'a mut Option<f64>,
        range: impl RangeBounds<f64>,
        otherwise: &'static str,
        help: &'static str,
    ) -> Self {
        Setting { key, help, value: Value::Optional(place, bounds(range), otherwise) }
    }

    /// A variant of an enumeration.
    pub fn choice<T: Named>(key: &'static str, place: &'a mut T, help: &'static str) -> Self {
        Setting { key, help, value: Value::Choice(place) }
    }

    /// The values that it may have.
    pub fn values(&self) -> String {
        match &self.value {
            Value::Number(..) | Value::Optional(..) => "NUMBER".into(),
            Value::Choice(choice) => choice.names().join("|"),
        }
    }

    /// The value that it has.
    pub fn value(&self) -> String {
        match &self.value {
            Value::Number(number, _) => number.to_string(),
            Value::Optional(Some(number), ..) => number.to_string(),
            Value::Optional(None, _, otherwise) => (*otherwise).into(),
            Value::Choice(choice) => choice.name().into(),
        }
    }

    /// # Errors
    /// What the value must be, if it is invalid: the fields are public and may hold any number.
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
    from + &to
}

/// # Errors
/// Which of the settings has an invalid value.
pub(super) fn check(settings: &[Setting<'_>]) -> Result<()> {
    for setting in settings {
        setting.check().map_err(|message| {
            let (key, value) = (setting.key, setting.value());
            Error::unsuitable(format!("solver option {key}={value}: {message}"))
        })?;
    }
    Ok(())
}

/// Values by key, as somebody wrote them.
#[derive(Clone, Debug, Default, PartialEq)]
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

    /// Changes settings to what was given; `name` is that of the method, for the errors.
    pub(super) fn apply(&self, name: &str, mut settings: Vec<Setting<'_>>) -> Result<()> {
        let known: Vec<&str> = settings.iter().map(|setting| setting.key).collect();
        for (key, text) in &self.0 {
            let setting = settings.iter_mut().find(|setting| setting.key == key);
            let setting = setting.ok_or_else(|| {
                let known = known.join(", ");
                Error::unsuitable(format!(
                    "solver option {key:?} is unknown to {name}; it has {known}"
                ))
            })?;
            setting.set(text).map_err(|message| {
                Error::unsuitable(format!("solver option {key}={text}: {message}"))
            })?;
        }
        Ok(())
    }
}
