//! The solvers: one algorithm, one reference, one file; none imports another.
//!
//! To add one: write its file, with a [`Description`], typed `Settings` and an implementation of [`Step`], and give it a
//! line in `solvers!` below. Clock, stopping and samples are those of `run.rs`; a solver only advances.

mod balance;
mod metric;
mod settings;
mod step;

#[cfg(test)]
mod tests;

pub use chambolle_pock::Engines;
pub use settings::{Adjustable, Options, Setting};
pub use step::{OneByOne, Step};

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::operator::Operator;
use crate::problem::{Problem, Smoothing};

/// Makes of one line a solver: its module, and its settings as a variant of [`Method`].
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

            /// Its settings, to be read or changed.
            pub fn settings(&mut self) -> Vec<Setting<'_>> {
                match self {
                    $($(#[$attribute])* Method::$Name(settings) => settings.settings(),)*
                }
            }

            /// Back to the default settings.
            fn reset(&mut self) {
                match self {
                    $($(#[$attribute])* Method::$Name(settings) => *settings = Default::default(),)*
                }
            }

            /// The solver, ready to advance.
            ///
            /// # Errors
            /// Settings that are out of range or exclude each other.
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
    #[cfg(test)]
    ArrowHurwicz = mod arrow_hurwicz;
}

/// What runs a method. Most methods implement [`Step`], of which [`OneByOne`] makes a solver; what makes several steps in
/// one pass implements this.
pub trait Solver<K, const M: usize> {
    /// Makes so many steps, at least one, and ends with a feasible pair. `go_on` is asked before every pass of one or
    /// several steps; where it says no, one step more is the last. Returns how many were made.
    fn advance(
        &mut self,
        problem: &Problem<K, M>,
        steps: u64,
        go_on: &mut dyn FnMut() -> bool,
    ) -> u64;

    /// A feasible U, rows in the simplex, and a feasible dual field.
    fn iterate(&mut self) -> Iterate<'_, M>;

    /// U alone, where that is cheaper.
    fn labels(&mut self) -> &[Row<M>] {
        self.iterate().u
    }

    /// D of the dual field, where that is known more cheaply than from the field.
    fn dual_bound(&mut self, problem: &Problem<K, M>) -> f64
    where
        K: Operator,
    {
        problem.dual_bound(self.iterate().q)
    }

    /// max |u^n - u^{n-1}| of the last step; zero before the first.
    fn change(&mut self) -> f64;

    /// f or lambda changed to those of `problem`, and no step may come before this: drop momentum, fit the
    /// steps, keep the iterate.
    fn restart(&mut self, _problem: &Problem<K, M>) {}

    /// The smoothing of the energy that is minimized in place of E, if there is one.
    fn smoothing(&self) -> Option<Smoothing> {
        None
    }
}

/// What certifies itself: E(u) is an upper, D(q) a lower bound of the least energy.
#[derive(Clone, Copy)]
pub struct Iterate<'a, const M: usize> {
    /// U, V rows in the simplex.
    pub u: &'a [Row<M>],
    /// The dual field, F tangents with |q_j| <= lambda.
    pub q: &'a [Tangent<M>],
}

/// What a solver is built from, beside its settings.
pub struct Setup<'a, K, const M: usize> {
    /// The mesh that K is of; every face has an area.
    pub mesh: &'a Mesh,
    /// What is minimized.
    pub problem: &'a Problem<K, M>,
    /// U at the start: rows in the simplex.
    pub start: Vec<Row<M>>,
    /// q at the start, |q_j| <= lambda; zero if there is none. Methods without a dual field ignore it.
    pub dual_start: Option<Vec<Tangent<M>>>,
}

/// What `meshseg solvers` prints of a method, beside its settings.
pub struct Description {
    /// Its name in `--solver NAME`.
    pub name: &'static str,
    /// One line on how it works.
    pub summary: &'static str,
    /// Authors and year of what it is taken from.
    pub reference: &'static str,
    /// How the step lengths are chosen.
    pub steps: &'static str,
}

/// A solver, or why there is none.
pub type Built<'a, K, const M: usize> = Result<Box<dyn Solver<K, M> + 'a>>;

impl Default for Method {
    fn default() -> Self {
        Method::ChambollePock(chambolle_pock::Settings::default())
    }
}

impl Method {
    /// The method of that name with its default settings. Fails with a list of the names if there is none of that name.
    pub fn named(name: &str) -> Result<Self> {
        Method::all().into_iter().find(|method| method.name() == name).ok_or_else(|| {
            let names: Vec<&str> = Method::all().iter().map(Method::name).collect();
            Error::unsuitable(format!("solver {name:?} is unknown; there are {}", names.join(", ")))
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

    /// Fails if a setting is out of range, naming it.
    pub fn check(&self) -> Result<()> {
        settings::check(&self.clone().settings())
    }

    /// The name in `--solver NAME`.
    pub fn name(&self) -> &'static str {
        self.description().name
    }

    /// The values of the settings that are not those by default, by key.
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
