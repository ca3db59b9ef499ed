//! The choice of the engine and its precision.

use pulp::Arch;

use super::fused::{Fused, Partition, Real};
use super::rows::Rows;
use super::settings::{Engine, Precision, Settings};
use super::stepping::Stepping;
use super::steps::Steps;
use crate::error::Error;
use crate::field::{Row, Tangent};
use crate::operator::{Matrix, Operator, Stencil};
use crate::problem::Problem;
use crate::solver::balance::Balance;
use crate::solver::{Built, OneByOne, Setup};
use crate::sweep::join;

/// A pair (u, q); no q stands for zero.
type Pair<const M: usize> = (Vec<Row<M>>, Option<Vec<Tangent<M>>>);

/// The engines that an operator has in addition to `rows`, which works for all operators.
pub trait Engines: Operator + Sized {
    /// Whether there is a fused engine.
    const IS_FUSED: bool = false;

    /// The fused engine, with the stepping that is computed from the initial pair.
    ///
    /// # Errors
    /// The operator has no fused engine.
    fn fused<'a, const M: usize>(
        _problem: &Problem<Self, M>,
        _start: Pair<M>,
        _precision: Precision,
        _stepping: impl FnOnce(&Pair<M>) -> Stepping<M> + Send,
    ) -> Built<'a, Self, M>
    where
        Self: 'a,
    {
        Err(Error::unsuitable(
            "solver option engine=fused needs the gradient as a stencil, not as a matrix; use engine=auto",
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
        stepping: impl FnOnce(&Pair<M>) -> Stepping<M> + Send,
    ) -> Built<'a, Self, M> {
        Ok(match precision {
            Precision::Double => Box::new(partitioned::<f64, M>(problem, start, stepping)),
            Precision::Single => Box::new(partitioned::<f32, M>(problem, start, stepping)),
        })
    }
}

/// The fused engine; its stepping and its partition are computed in parallel.
fn partitioned<T: Real, const M: usize>(
    problem: &Problem<Stencil, M>,
    start: Pair<M>,
    stepping: impl FnOnce(&Pair<M>) -> Stepping<M> + Send,
) -> Fused<T, M> {
    let partition = || Partition::new::<T, M>(&problem.k, Arch::new());
    let (stepping, partition) = join(|| stepping(&start), partition);
    let (u, q) = start;
    Fused::new(problem, u, q, stepping, partition)
}

/// The solver with the requested engine and precision. Fails if the fused engine is requested and K is not a stencil,
/// or single precision without the fused engine.
pub fn build<'a, K: Engines + 'a, const M: usize>(
    settings: &Settings,
    setup: Setup<'_, K, M>,
) -> Built<'a, K, M> {
    let Settings { steps, rho, balance, engine, precision, .. } = *settings;
    let step_ratio = settings.step_ratio();
    let Setup { problem, start: u, dual_start: q, .. } = setup;
    let stepping = |(u, q): &Pair<M>| {
        let balance = Balance::new(balance, u, q.as_ref());
        Stepping { steps: Steps::new(problem, steps, step_ratio), balance, rho }
    };
    let start = (u, q);
    settings.check_relaxation(problem.relaxation)?;
    let is_fused = K::IS_FUSED && problem.relaxation.has_balls();
    let fused = engine == Engine::Fused || engine == Engine::Auto && is_fused;
    match (fused, precision) {
        (true, _) => K::fused(problem, start, precision, stepping),
        (false, Precision::Single) => Err(Error::unsuitable(
            "solver option precision=f32 needs the fused engine; engine=rows computes in f64",
        )),
        (false, Precision::Double) => {
            let stepping = stepping(&start);
            let (u, q) = start;
            let q = q.unwrap_or_else(|| vec![Tangent::ZERO; problem.k.faces()]);
            Ok(Box::new(OneByOne::new(Rows { u_bar: u.clone(), u, q, stepping })))
        }
    }
}
