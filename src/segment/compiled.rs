//! What the alternation needs of solvers, compiled here once for each number of regions.
//!
//! [`super::segment`] is generic over the data model, so it is compiled where it is called, with all generic functions
//! that it calls. The implementations below are not generic: programs with models of their own do not compile the
//! solvers again, which would take most of their build time.

use crate::mesh::Mesh;
use crate::operator::Stencil;
use crate::problem::Problem;
use crate::regions::for_each_size;
use crate::run::{Run, Status, Stop};
use crate::solve::{Observer, Request, Solution, conclude};
use crate::solver::{Built, Method, Setup, Solver};

/// The functions for compiled rows of M regions.
pub trait Compiled<const M: usize> {
    /// [`Method::build`].
    fn build(method: &Method, setup: Setup<'_, Stencil, M>) -> Built<'static, Stencil, M>;

    /// [`Run::advance`].
    fn advance(
        run: &mut Run<M>,
        solver: &mut dyn Solver<Stencil, M>,
        problem: &Problem<Stencil, M>,
        stop: &Stop,
        observe: Observer<'_>,
    ) -> Status;

    /// [`conclude`].
    fn conclude(
        model: &Mesh,
        problem: &Problem<Stencil, M>,
        m: usize,
        request: &Request,
        run: Run<M>,
        end: (Status, Vec<String>),
    ) -> Solution;
}

macro_rules! compiled {
    ($($M:literal)*) => {
        $(impl Compiled<$M> for Stencil {
            fn build(
                method: &Method,
                setup: Setup<'_, Stencil, $M>,
            ) -> Built<'static, Stencil, $M> {
                method.build(setup)
            }

            fn advance(
                run: &mut Run<$M>,
                solver: &mut dyn Solver<Stencil, $M>,
                problem: &Problem<Stencil, $M>,
                stop: &Stop,
                observe: Observer<'_>,
            ) -> Status {
                run.advance(solver, problem, stop, observe)
            }

            fn conclude(
                model: &Mesh,
                problem: &Problem<Stencil, $M>,
                m: usize,
                request: &Request,
                run: Run<$M>,
                (status, warnings): (Status, Vec<String>),
            ) -> Solution {
                conclude(model, problem, m, request, run, status, warnings)
            }
        })*
    };
}

for_each_size!(compiled);
