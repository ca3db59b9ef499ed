//! What a run ends with, and what is certain about it.

use std::borrow::Cow;
use std::collections::BTreeMap;

use ndarray::{Array1, Array2};
use serde::{Deserialize, Deserializer, Serialize};

use crate::coarse::Record;
use crate::field::Tangent;
use crate::mesh::order::Order;
use crate::mesh::{Mesh, Weld};
use crate::operator::{Operator, Stencil};
use crate::problem::{Problem, label_gap, relative_gap, rounded};
use crate::regions;
use crate::remarks::empty_regions;
use crate::request::Request;
use crate::run::{Run, Sample, Status};
use crate::sweep;

/// The numbers of a result, as `summary.json` has them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Summary {
    pub solver: String,
    pub solver_options: BTreeMap<String, String>,
    pub status: Status,
    pub status_sentence: Cow<'static, str>,
    pub iterations: u64,
    /// Time spent in the solver's steps, and in all that `coarse_to_fine` counts.
    pub seconds: f64,
    /// E of `u`.
    pub energy: f64,
    /// D: no U has less energy than this.
    pub dual_bound: f64,
    /// B = sum_k min_p f_kp, from which all relative gaps are measured; see `problem.rs`.
    pub baseline: f64,
    /// E - D.
    pub gap: f64,
    /// (E - D) / (E - B).
    pub relative_gap: f64,
    /// R, the energy of the one-hot rows of `labels`.
    pub rounded_energy: f64,
    /// (R - D) / (D - B): the labels are at most this share above any labeling, measured from B as well. Infinite
    /// (null in JSON) where D = B, which bounds no such share.
    #[serde(deserialize_with = "null_as_infinity")]
    pub rounded_relative_gap: f64,
    pub vertices: usize,
    pub faces: usize,
    pub regions: usize,
    /// Those that no vertex has.
    pub empty_regions: Vec<usize>,
    pub lambda: f64,
    pub mass: Cow<'static, str>,
    /// Of the mesh that the energy is measured on.
    pub area: f64,
    /// The levels below the finest, whose solution started it.
    pub coarse_to_fine: Option<Record>,
    pub warnings: Vec<String>,
}

/// JSON has no infinity.
fn null_as_infinity<'a, D: Deserializer<'a>>(from: D) -> Result<f64, D::Error> {
    Option::<f64>::deserialize(from).map(|number| number.unwrap_or(f64::INFINITY))
}

/// What a run ends with.
pub struct Solution {
    pub summary: Summary,
    pub trace: Vec<Sample>,
    /// V x m, rows in the simplex.
    pub u: Array2<f64>,
    /// argmax over the regions, V numbers.
    pub labels: Array1<i32>,
    /// The field that certifies `dual_bound`, if it was asked for: 2F x m, rows 2j and 2j + 1 those of face j, in the
    /// frame of the rows of K; zero in faces without area.
    pub q: Option<Array2<f64>>,
}

impl Solution {
    /// The same for the mesh as the caller knows it.
    pub(crate) fn of(mut self, mesh: &Mesh, order: &Order) -> Self {
        self.summary.faces = mesh.faces.len();
        self.q = self.q.map(|q| {
            // Which face of the mesh is the next of the model.
            let kept: Vec<usize> =
                (0..mesh.faces.len()).filter(|&j| !mesh.is_degenerate(j)).collect();
            let mut all = Array2::zeros((2 * mesh.faces.len(), q.ncols()));
            for (i, j) in order.faces(kept.len()).into_iter().enumerate() {
                for axis in 0..2 {
                    all.row_mut(2 * kept[j] + axis).assign(&q.row(2 * i + axis));
                }
            }
            all
        });
        match order.places() {
            Some(places) => self.gathered(&places),
            None => self,
        }
    }

    /// The same for a mesh whose coincident vertices were merged: each takes what it was merged onto has. Its faces are
    /// all there.
    pub fn spread(mut self, mesh: &Mesh, weld: &Weld) -> Self {
        self.summary.vertices = mesh.vertices.len();
        self.gathered(&weld.of)
    }

    /// Rows from these places.
    fn gathered(mut self, places: &[u32]) -> Self {
        let rows = self.u.as_slice().expect("rows are contiguous");
        let m = self.u.ncols();
        let mut moved = Vec::with_capacity(places.len() * m);
        for &v in places {
            moved.extend_from_slice(&rows[v as usize * m..][..m]);
        }
        self.u = Array2::from_shape_vec((places.len(), m), moved).expect("rows of m numbers");
        self.labels = places.iter().map(|&v| self.labels[v as usize]).collect();
        self
    }
}

/// Rounds the best U and states what is certain about it.
pub(crate) fn conclude<const M: usize>(
    model: &Mesh,
    problem: &Problem<Stencil, M>,
    m: usize,
    request: &Request,
    run: Run<M>,
    status: Status,
    warnings: Vec<String>,
) -> Solution {
    let u = run.best_u();
    let baseline = problem.baseline;
    let (energy, bound) = (run.energy(), run.bound());
    let rounded_energy = problem.energy(&rounded(u));
    let labels = sweep::collect(u.len(), |v| u[v].argmax() as i32).into();
    // Labels are a U as well.
    let below = problem.settled(rounded_energy, bound) > rounded_energy;
    let status = if below { Status::Contradicted } else { status };
    let summary = Summary {
        solver: request.method.name().to_owned(),
        solver_options: request.method.changed(),
        status,
        status_sentence: status.sentence().into(),
        iterations: run.iterations(),
        seconds: run.seconds(),
        energy: baseline + energy,
        dual_bound: baseline + bound,
        baseline,
        gap: energy - bound,
        relative_gap: relative_gap(energy, bound),
        rounded_energy: baseline + rounded_energy,
        rounded_relative_gap: label_gap(rounded_energy, problem.settled(rounded_energy, bound)),
        vertices: problem.k.vertices(),
        faces: problem.k.faces(),
        regions: m,
        empty_regions: empty_regions(&labels, m),
        lambda: problem.lambda,
        mass: request.mass.name().into(),
        area: model.area(),
        coarse_to_fine: None,
        warnings,
    };
    Solution {
        summary,
        u: regions::array(u, m),
        labels,
        q: run.best_q().map(|q| dual_array(q, problem.k.faces(), m)),
        trace: run.trace,
    }
}

/// 2F x m; no q at all is zero.
fn dual_array<const M: usize>(q: &[Tangent<M>], faces: usize, m: usize) -> Array2<f64> {
    if q.is_empty() {
        return Array2::zeros((2 * faces, m));
    }
    Array2::from_shape_fn((2 * faces, m), |(row, p)| q[row / 2].0[row % 2].0[p])
}
