//! The result of a run, and its certificate: gap, relative gap, and the gap of the rounded labels; see `problem.rs`.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use ndarray::{Array1, Array2};
use serde::{Deserialize, Deserializer, Serialize};

use crate::coarse::Record;
use crate::contour::{CutRecord, threshold};
use crate::counted::rounded_up;
use crate::domain::{Domain, Element};
use crate::empty_regions;
use crate::error;
use crate::field::Tangent;
use crate::mesh::order::Order;
use crate::mesh::{Mesh, Weld};
use crate::names::Named;
use crate::operator::{Operator, Stencil};
use crate::problem::{Problem, label_gap, relative_gap};
use crate::regions;
use crate::request::{Observer, Request};
use crate::rounding::{Rounded, Rounding, Tightened, round, tighten};
use crate::run::{Run, Sample, Status};
use crate::units::Unit;

/// The numbers of a result, as in `summary.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Summary {
    /// The name of the method, such as `chambolle-pock`.
    pub solver: String,
    /// Its settings that differ from the defaults, by key.
    pub solver_options: BTreeMap<String, String>,
    /// How the run ended.
    pub status: Status,
    /// [`Status::sentence`].
    pub status_sentence: Cow<'static, str>,
    /// Steps of the solver on the finest mesh.
    pub iterations: u64,
    /// Wall time of the steps of the solver and of all that `coarse_to_fine` counts, in seconds. Evaluations of
    /// energies and bounds do not count.
    pub seconds: f64,
    /// E of `u`.
    pub energy: f64,
    /// D: no U has a smaller energy.
    pub dual_bound: f64,
    /// B = sum_k min_p f_kp, from which all relative gaps are measured; see `problem.rs`.
    pub baseline: f64,
    /// E - D.
    pub gap: f64,
    /// (E - D) / (E - B).
    pub relative_gap: f64,
    /// R, the energy of the one-hot rows of `labels`.
    pub rounded_energy: f64,
    /// How `labels` were found; `None` in results from before there was more than argmax.
    #[serde(flatten)]
    pub rounding: Option<RoundingRecord>,
    /// (R - L) / (L - B): the labels are at most this share above any labeling, measured from B as well; L is the
    /// `label_bound`. Infinite (null in JSON) where L = B, which bounds no such share.
    #[serde(deserialize_with = "null_as_infinity")]
    pub rounded_relative_gap: f64,
    /// V.
    pub vertices: usize,
    /// F, faces without area included.
    pub faces: usize,
    /// `faces` if the labels, and the rows of U, are those of faces; `None` for vertices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<Cow<'static, str>>,
    /// m.
    pub regions: usize,
    /// Regions without any label, ascending.
    pub empty_regions: Vec<usize>,
    /// The t at which the cells {u_0 >= t} and {u_0 < t} of two regions have at most the energy of `u`, see
    /// [`threshold`]; `None` for other numbers of regions, and in results from before it was chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut_threshold: Option<f64>,
    /// The cut as a curve, if it was traced, in units of the mesh before scaling.
    #[serde(flatten)]
    pub cut: Option<CutRecord>,
    /// Weight of the total variation, in units of cost times length.
    pub lambda: f64,
    /// The relaxation: `frobenius`, `separate`, `envelope` or `metric`. Energies and bounds are those of this
    /// relaxation, also those of labels. `None` in results from before there were others than `frobenius`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relaxation: Option<Cow<'static, str>>,
    /// The weights of the pairs of labels, m x m, if cuts between them weigh differently.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label_metric: Option<Vec<Vec<f64>>>,
    /// The quadrature of the data term: `barycentric`, `voronoi` or `consistent`.
    pub mass: Cow<'static, str>,
    /// Sum of A_j over the faces with an area, in squared units of the mesh.
    pub area: f64,
    /// The coarse levels, whose solutions initialized the finest one.
    pub coarse_to_fine: Option<Record>,
    /// Warnings for the user, a sentence each: empty regions, unknown vertices, faces left out.
    pub warnings: Vec<String>,
}

/// The labels of a result and the bound for them, as in `summary.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RoundingRecord {
    /// How U was rounded to `labels`: `expansion`, `moves` or `argmax`.
    pub rounding: Cow<'static, str>,
    /// The energy of the labels argmax_p u_kp.
    pub argmax_energy: f64,
    /// L: no labels have a smaller energy. It is D, R where a minimum cut found the best labels, or higher than D if a
    /// label gap was requested.
    pub label_bound: f64,
    /// The number of ascents that raised L, in both orders of the vertices each.
    pub label_ascents: u64,
    /// Wall time of the rounding and of these ascents, in seconds; missing in results of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rounding_seconds: Option<f64>,
}

/// JSON has no infinity.
fn null_as_infinity<'a, D: Deserializer<'a>>(from: D) -> Result<f64, D::Error> {
    Option::<f64>::deserialize(from).map(|number| number.unwrap_or(f64::INFINITY))
}

/// The result of a run.
pub struct Solution {
    /// The numbers of the result.
    pub summary: Summary,
    /// The samples of the run, by increasing iteration; the first is that of the start.
    pub trace: Vec<Sample>,
    /// The U of minimum energy found: V x m, or F x m for labels of faces, rows in the simplex.
    pub u: Array2<f64>,
    /// U rounded as `rounding` says: an integer from 0 to m - 1 for each row.
    pub labels: Array1<i32>,
    /// The field that certifies `dual_bound`, if it was requested: 2F x m, rows 2j and 2j + 1 those of face j, in the
    /// frame of the rows of K; zero in faces without area.
    pub q: Option<Array2<f64>>,
}

impl Solution {
    /// The solution for the mesh of the caller: vertices and faces in its order, faces without area included.
    pub(crate) fn in_file_order(mut self, mesh: &Mesh, order: &Order) -> Self {
        self.summary.faces = mesh.faces.len();
        self.q = self.q.map(|q| {
            // The faces of the mesh that the model has, in the order of the mesh.
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
        self.unordered(order)
    }

    /// The solution on the faces of a mesh, in its order.
    pub(crate) fn of_faces(mut self, mesh: &Mesh, order: &Order) -> Self {
        self.summary.vertices = mesh.vertices.len();
        self.summary.faces = mesh.faces.len();
        self.unordered(order)
    }

    /// The solution of a problem in a unit of cost, as that was given.
    ///
    /// # Errors
    /// An energy leaves the range of double precision.
    pub(crate) fn given(mut self, unit: Unit) -> error::Result<Self> {
        self.trace.iter_mut().for_each(|sample| *sample = sample.given(unit));
        let summary = &mut self.summary;
        let rounding = summary.rounding.iter_mut();
        let of_rounding =
            rounding.flat_map(|record| [&mut record.argmax_energy, &mut record.label_bound]);
        for number in [
            &mut summary.energy,
            &mut summary.dual_bound,
            &mut summary.baseline,
            &mut summary.gap,
            &mut summary.rounded_energy,
            &mut summary.lambda,
        ]
        .into_iter()
        .chain(of_rounding)
        {
            *number = unit.given(*number);
        }
        if let Some(q) = &mut self.q {
            q.mapv_inplace(|x| unit.given(x));
        }
        let Summary { energy, dual_bound, baseline, rounded_energy, .. } = self.summary;
        unit.check(&[energy, dual_bound, baseline, rounded_energy])?;
        Ok(self)
    }

    fn unordered(self, order: &Order) -> Self {
        match order.indices() {
            Some(indices) => self.gathered(&indices),
            None => self,
        }
    }

    /// The solution for a mesh whose coincident vertices were merged: each vertex gets the row and the label of the
    /// vertex that it was merged onto. The welded mesh has the faces of `mesh`, so q stays as it is.
    pub fn spread(mut self, mesh: &Mesh, weld: &Weld) -> Self {
        self.summary.vertices = mesh.vertices.len();
        self.gathered(&weld.of)
    }

    /// The solution with the given rows of u and labels.
    fn gathered(mut self, rows: &[u32]) -> Self {
        let numbers = self.u.as_slice().expect("rows are contiguous");
        let m = self.u.ncols();
        let mut moved = Vec::with_capacity(rows.len() * m);
        for &v in rows {
            moved.extend_from_slice(&numbers[v as usize * m..][..m]);
        }
        self.u = Array2::from_shape_vec((rows.len(), m), moved).expect("rows of m numbers");
        self.labels = rows.iter().map(|&v| self.labels[v as usize]).collect();
        self
    }
}

/// A run, how it ended, and what the user is warned of.
pub(crate) struct Ended<const M: usize> {
    pub run: Run<M>,
    pub status: Status,
    pub warnings: Vec<String>,
}

/// Rounds the best U and computes the certified gaps.
pub(crate) fn conclude<const M: usize>(
    domain: Domain<'_>,
    problem: &Problem<Stencil, M>,
    m: usize,
    request: &Request,
    ended: Ended<M>,
    observe: Observer<'_>,
) -> Solution {
    let Ended { run, status, mut warnings } = ended;
    let u = run.best_u();
    let baseline = problem.baseline;
    let (energy, bound) = (run.energy(), run.bound());
    let rounding = match status {
        // A user who interrupts a run does not want to wait.
        Status::Interrupted => Rounding::Argmax,
        _ => request.rounding,
    };
    let (begin, mut interrupted) = (Instant::now(), false);
    let spent = Duration::try_from_secs_f64(run.seconds()).unwrap_or_default();
    let left = request.stop.time.map(|limit| limit.saturating_sub(spent));
    let mut go_on = || {
        interrupted |= observe(None).is_break();
        !interrupted && left.is_none_or(|left| begin.elapsed() < left)
    };
    let rounded = round(domain, problem, m, u, rounding, &mut go_on);
    let bound_of = |energy: f64| problem.clamped_bound(energy, bound);
    let label_bound = if rounded.is_optimal { rounded.energy } else { bound_of(rounded.energy) };
    let mut tightened = Tightened { rounded, bound: label_bound, ascents: 0 };
    if let Some(gap) = request.label_gap
        && !matches!(status, Status::Interrupted | Status::Diverged | Status::Contradicted)
    {
        let q = run.best_q().unwrap_or_default();
        tightened = tighten(domain, problem, m, q, tightened, gap, &mut go_on);
        let reached = label_gap(tightened.rounded.energy, tightened.bound);
        if reached > gap && !interrupted {
            let reached = match reached.is_finite() {
                true => format!("{:.1e}", rounded_up(reached)),
                // The bound is the baseline.
                false => {
                    let above = tightened.rounded.energy - tightened.bound;
                    format!("{:.1e} in energy", rounded_up(above))
                }
            };
            warnings.push(format!(
                "the labels are at most {reached} above any labeling, not {gap:.1e} as requested: the bound rises no \
                 further, or the time is over"
            ));
        }
    }
    let status = match status {
        Status::Contradicted => status,
        _ if interrupted => Status::Interrupted,
        _ => status,
    };
    let Tightened { rounded, bound: label_bound, ascents } = tightened;
    let Rounded { labels, energy: rounded_energy, argmax_energy, .. } = rounded;
    let labels: Array1<i32> = labels.into_iter().map(i32::from).collect();
    // The rounded labels are a U, too: their energy must lie below neither bound.
    let below_bound = bound_of(rounded_energy).max(label_bound) > rounded_energy;
    let status = if below_bound { Status::Contradicted } else { status };
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
        rounding: Some(RoundingRecord {
            rounding: rounding.name().into(),
            argmax_energy: baseline + argmax_energy,
            label_bound: baseline + label_bound,
            label_ascents: ascents,
            rounding_seconds: Some(begin.elapsed().as_secs_f64()),
        }),
        rounded_relative_gap: label_gap(rounded_energy, label_bound),
        vertices: problem.k.vertices(),
        faces: problem.k.faces(),
        on: match domain.element() {
            Element::Vertices => None,
            on => Some(on.name().into()),
        },
        regions: m,
        empty_regions: empty_regions::of_labels(&labels, m),
        cut_threshold: match domain {
            Domain::Vertices(mesh) if m == 2 => {
                let f = |k: usize| [problem.f[k].0[0], problem.f[k].0[1]];
                let lambda = problem.lambda * problem.relaxation.label_metric().distance(0, 1);
                Some(threshold(mesh, f, lambda, |k| u[k].0[0], energy))
            }
            _ => None,
        },
        cut: None,
        lambda: problem.lambda,
        relaxation: Some(problem.relaxation.name().into()),
        label_metric: problem.relaxation.weights(),
        mass: request.mass.name().into(),
        area: domain.area(),
        coarse_to_fine: None,
        warnings,
    };
    Solution {
        summary,
        u: regions::array(u, m),
        labels,
        q: (run.best_q().filter(|_| request.keep_dual))
            .map(|q| dual_array(q, problem.k.faces(), m)),
        trace: run.trace,
    }
}

/// The 2F x m array of q; an empty q is zero.
fn dual_array<const M: usize>(q: &[Tangent<M>], faces: usize, m: usize) -> Array2<f64> {
    if q.is_empty() {
        return Array2::zeros((2 * faces, m));
    }
    Array2::from_shape_fn((2 * faces, m), |(row, p)| q[row / 2].0[row % 2].0[p])
}
