//! Enumerations whose variants have names for the command line, files and settings.

use std::fmt::Display;
use std::str::FromStr;

use strum::VariantNames;

/// Any enumeration that derives `EnumString`, `IntoStaticStr` and `VariantNames` of strum.
pub trait Named: Copy + FromStr + Into<&'static str> + VariantNames {
    /// The name of this variant.
    fn name(self) -> &'static str {
        self.into()
    }

    /// The variant with the given name, if there is one.
    fn named(name: &str) -> Option<Self> {
        name.parse().ok()
    }

    /// The names of all variants.
    fn names() -> &'static [&'static str] {
        Self::VARIANTS
    }
}

impl<T: Copy + FromStr + Into<&'static str> + VariantNames> Named for T {}

/// The error for any other name.
pub fn must_be_one_of(names: impl IntoIterator<Item = impl Display>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| name.to_string()).collect();
    format!("must be one of {}", names.join(", "))
}
