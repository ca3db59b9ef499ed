//! The solvers. Each one has its own algorithm, reference and file, and none imports another.
//!
//! To add one, write its file, with a [`Description`], typed `Settings` and an implementation of [`Step`], and add a
//! line to `solvers!` below. `run.rs` does timing, stopping and sampling; a solver only advances.

mod balance;
mod interface;
mod metric;
mod settings;
mod step;

#[cfg(test)]
mod tests;

pub use chambolle_pock::Engines;
pub use interface::{Built, Description, Iterate, Setup, Solver};
pub use settings::{Adjustable, Options, Setting};
pub use step::{OneByOne, Step};

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use crate::relaxation::Relaxation;

/// Turns each line into a solver: its module, and its settings as a variant of [`Method`].
macro_rules! solvers {
    ($($(#[$attribute:meta])* $Name:ident = mod $module:ident;)*) => {
        $($(#[$attribute])* pub mod $module;)*

        /// A method with its settings.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Method {
            $(
                #[doc = concat!("See [`", stringify!($module), "`].")]
                $(#[$attribute])* $Name($module::Settings),
            )*
        }

        $($(#[$attribute])* impl From<$module::Settings> for Method {
            fn from(settings: $module::Settings) -> Self {
                Method::$Name(settings)
            }
        })*

        impl Method {
            /// All methods with their default settings.
            pub fn all() -> Vec<Self> {
                vec![$($(#[$attribute])* Method::$Name(Default::default()),)*]
            }

            /// Name, summary and references of the method, whatever its settings.
            pub fn description(&self) -> &'static Description {
                match self {
                    $($(#[$attribute])* Method::$Name(_) => &$module::DESCRIPTION,)*
                }
            }

            /// The settings of the method, to be read or changed.
            pub fn settings(&mut self) -> Vec<Setting<'_>> {
                match self {
                    $($(#[$attribute])* Method::$Name(settings) => settings.settings(),)*
                }
            }

            /// Resets all settings to their defaults.
            fn reset(&mut self) {
                match self {
                    $($(#[$attribute])* Method::$Name(settings) => *settings = Default::default(),)*
                }
            }

            /// The solver, ready to advance.
            ///
            /// # Errors
            /// A setting is out of range, or two settings exclude each other.
            pub fn build<'a, K: Engines + 'a, const M: usize>(
                &self,
                setup: Setup<'_, K, M>,
            ) -> Built<'a, K, M> {
                self.check()?;
                match self {
                    $($(#[$attribute])* Method::$Name(settings) => $module::build(settings, setup),)*
                }
            }
        }
    };
}

solvers! {
    ChambollePock = mod chambolle_pock;
    DouglasRachford = mod douglas_rachford;
    Fista = mod fista;
    ProjectedGradient = mod projected_gradient;
    AlphaExpansion = mod alpha_expansion;
    #[cfg(test)]
    ArrowHurwicz = mod arrow_hurwicz;
}

impl Default for Method {
    fn default() -> Self {
        Method::ChambollePock(chambolle_pock::Settings::default())
    }
}

impl Method {
    /// The method of that name with its default settings. Fails if there is none, with a list of the names.
    pub fn named(name: &str) -> Result<Self> {
        Method::all().into_iter().find(|method| method.name() == name).ok_or_else(|| {
            let names: Vec<&str> = Method::all().iter().map(Method::name).collect();
            Error::unsuitable(format!(
                "solver {name:?} is unknown; the solvers are {}",
                names.join(", ")
            ))
        })
    }

    /// The method of that name with settings given as text. Fails if the name or a key is unknown, or a value is out of
    /// range.
    pub fn parse(name: &str, options: &Options) -> Result<Self> {
        let mut method = Method::named(name)?;
        method.set(options)?;
        Ok(method)
    }

    /// Changes settings to those given as text. Fails if a key is unknown or a value is out of range; keys that sort
    /// before it have been applied then.
    pub fn set(&mut self, options: &Options) -> Result<()> {
        options.apply(self.name(), self.settings())
    }

    /// The method for costs that are re-estimated after every few steps; settings that were chosen stay.
    pub fn for_estimates(&self) -> Self {
        match self.clone() {
            Method::ChambollePock(settings) => settings.for_estimates().into(),
            method => method,
        }
    }

    /// Fails if a setting is out of range, naming it.
    pub fn check(&self) -> Result<()> {
        settings::check(&self.clone().settings())
    }

    /// Fails if the settings do not apply to a relaxation.
    pub fn check_relaxation(&self, relaxation: Relaxation) -> Result<()> {
        match self {
            Method::ChambollePock(settings) => settings.check_relaxation(relaxation),
            _ => Ok(()),
        }
    }

    /// The name in `--solver NAME`.
    pub fn name(&self) -> &'static str {
        self.description().name
    }

    /// The settings that differ from their defaults, by key.
    pub fn changed(&self) -> BTreeMap<String, String> {
        let (mut own, mut default) = (self.clone(), self.clone());
        default.reset();
        let pairs = own.settings().into_iter().zip(default.settings());
        pairs
            .filter(|(own, default)| own.value() != default.value())
            .map(|(own, _)| (own.key.to_owned(), own.value()))
            .collect()
    }
}
