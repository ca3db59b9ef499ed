//! The engines of the method, and the one place where an engine and its precision are chosen.

use pulp::Arch;

use super::Method;
use super::fused::{Fused, Plan, Real};
use super::rows::Rows;
use super::steps::Steps;
use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::operator::{Matrix, Operator, Stencil};
use crate::problem::Problem;
use crate::solver::balance::Balance;
use crate::solver::{OneByOne, Setup, Solver};
use crate::sweep::join;

/// What iterates.
#[derive(Clone, Copy, PartialEq)]
enum Engine {
    /// The fused one where the operator has it.
    Auto,
    Fused,
    Rows,
}

/// Of the iterates; certificates are in double precision.
#[derive(Clone, Copy, PartialEq)]
pub enum Precision {
    Double,
    Single,
}

/// A pair (u, q), where q is zero if there is none.
type Pair<const M: usize> = (Vec<Row<M>>, Option<Vec<Tangent<M>>>);

/// A solver, or why there is none.
type Built<'a, K, const M: usize> = Result<Box<dyn Solver<K, M> + 'a>>;

/// The engines that an operator has beside the rows, which are for all.
pub trait Engines: Operator + Sized {
    /// Whether there is a fused one.
    const IS_FUSED: bool = false;

    /// The fused engine, of a method that is made for the pair from which it starts.
    ///
    /// # Errors
    /// That of the method; or that there is none, for operators of which nothing is known but their rows.
    fn fused<'a, const M: usize>(
        _problem: &Problem<Self, M>,
        _start: Pair<M>,
        _precision: Precision,
        _method: impl FnOnce(&Pair<M>) -> Result<Method<M>> + Send,
    ) -> Built<'a, Self, M>
    where
        Self: 'a,
    {
        Err(Error::unsuitable(
            "solver option engine=fused needs the gradient as a stencil, not as a matrix",
        ))
    }
}

impl Engines for Matrix {}

impl Engines for Stencil {
    const IS_FUSED: bool = true;

    fn fused<'a, const M: usize>(
        problem: &Problem<Self, M>,
        start: Pair<M>,
        precision: Precision,
        method: impl FnOnce(&Pair<M>) -> Result<Method<M>> + Send,
    ) -> Built<'a, Self, M> {
        Ok(match precision {
            Precision::Double => Box::new(planned::<f64, M>(problem, start, method)?),
            Precision::Single => Box::new(planned::<f32, M>(problem, start, method)?),
        })
    }
}

/// Method and plan side by side.
fn planned<T: Real, const M: usize>(
    problem: &Problem<Stencil, M>,
    start: Pair<M>,
    method: impl FnOnce(&Pair<M>) -> Result<Method<M>> + Send,
) -> Result<Fused<T, M>> {
    let plan = || Plan::new::<T, M>(&problem.k, Arch::new());
    let (method, plan) = join(|| method(&start), plan);
    let (u, q) = start;
    Ok(Fused::new(problem, u, q, method?, plan))
}

/// The solver in the engine and the precision that the options ask for.
pub fn build<'a, K: Engines + 'a, const M: usize>(setup: Setup<'_, K, M>) -> Built<'a, K, M> {
    let Setup { problem, options, start: u, dual_start: q, .. } = setup;
    let engine = options.choice(
        "engine",
        &[("auto", Engine::Auto), ("fused", Engine::Fused), ("rows", Engine::Rows)],
    )?;
    let precision =
        options.choice("precision", &[("f64", Precision::Double), ("f32", Precision::Single)])?;
    let rho = options.number("rho", f64::MIN_POSITIVE..2.0)?.unwrap_or(1.9);
    let method = |(u, q): &Pair<M>| {
        let balance = Balance::new(options, u, q.as_ref())?;
        Ok(Method { steps: Steps::new(problem, options)?, balance, rho })
    };
    let start = (u, q);
    let fused = engine == Engine::Fused || engine == Engine::Auto && K::IS_FUSED;
    match (fused, precision) {
        (true, _) => K::fused(problem, start, precision, method),
        (false, Precision::Single) => Err(Error::unsuitable(
            "solver options engine=rows and precision=f32 exclude each other: rows are in double precision",
        )),
        (false, Precision::Double) => {
            let method = method(&start)?;
            let (u, q) = start;
            let q = q.unwrap_or_else(|| vec![Tangent::ZERO; problem.k.faces()]);
            Ok(Box::new(OneByOne::new(Rows { u_bar: u.clone(), u, q, method })))
        }
    }
}
