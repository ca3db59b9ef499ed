//! The options that `solve` and `segment` share: how to solve, when to stop, where to write.

use std::path::{Path, PathBuf};

use clap::Args;
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::coarse::Record;
use crate::counted::rounded_up;
use crate::empty_regions;
use crate::mesh::io::check_labeled_faces;
use crate::names::Named;
use crate::operator::Mass;
use crate::outcome::Export;
use crate::relaxation::Relaxation;
use crate::render::View;
use crate::rounding::Rounding;
use crate::run::{Status, Stop, time_limit};
use crate::solve::{Request, Summary};
use crate::solver::chambolle_pock::Precision;
use crate::solver::{Method, Options};
use crate::sweep::MAX_THREADS;
use crate::{Error, Result};

use super::{Failure, Outcome, named, table};

#[derive(Args)]
pub struct Solving {
    /// The convex relaxation of the labels. frobenius: that of the paper; separate: the norms of the regions are added up, which
    /// gives tighter bounds and sharper labels if there are more than two regions, at the same cost per iteration; envelope:
    /// the tightest of the three, many times slower [default: frobenius for solve; for segment separate, or frobenius for
    /// two regions, for which all are the same]
    #[arg(long, value_parser = named::<Relaxation>())]
    pub relaxation: Option<Relaxation>,

    /// How much cuts between each two labels weigh: a table of pairs `a,b,weight` with this header (labels are numbers,
    /// or names of --classes; other pairs weigh 1), or m x m numbers (.csv, .npy). The weights must be a metric: none
    /// larger than two others by way of a third label. The relaxation is then that of `envelope` for these weights,
    /// slower than the others
    #[arg(long, value_name = "FILE", conflicts_with_all = ["relaxation", "label_gap"])]
    pub pairs: Option<PathBuf>,

    /// Quadrature of the data term
    #[arg(long, value_parser = named::<Mass>(), default_value = "barycentric")]
    mass: Mass,

    /// The solver, see `meshseg solvers`
    #[arg(long, default_value = Method::default().name(), value_parser = clap::builder::PossibleValuesParser::new(
        Method::all().iter().map(Method::name)))]
    solver: String,

    /// Option of the solver; can be repeated
    #[arg(long = "solver-option", value_name = "KEY=VALUE")]
    solver_options: Vec<String>,

    /// Precision of the iterates: f32 moves half the bytes and reaches gaps down to about 1e-5; certificates are always
    /// evaluated in f64. Short for --solver-option precision=...
    #[arg(long, value_name = "PRECISION", value_parser = named::<Precision>())]
    precision: Option<Precision>,

    /// Stop when the certified gap (E - D) / (E - B) is at most this; B is the sum of the minimum costs of all
    /// vertices, below which no energy can lie
    #[arg(long, value_name = "GAP", default_value_t = 1e-4, allow_negative_numbers = true)]
    gap: f64,

    /// Maximum number of iterations
    #[arg(long, value_name = "N", default_value_t = 100_000, allow_negative_numbers = true)]
    max_iterations: u64,

    /// Time limit in seconds
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    time_limit: Option<f64>,

    /// Stop when no entry of U changes by more than this in an iteration (the rule of the paper; it certifies
    /// nothing)
    #[arg(long, value_name = "DELTA", allow_negative_numbers = true)]
    stop_change: Option<f64>,

    /// Iterations between checks of the gap [default: 4, later 4 % of the iterations, or up to 8 or 25 % while the gap
    /// is large]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000), allow_negative_numbers = true)]
    check_every: Option<u64>,

    /// Solve on coarser meshes first, each of which provides the start for the next finer one. This helps if many
    /// iterations are needed, as for a large lambda; the time includes all meshes
    #[arg(long)]
    coarse_to_fine: bool,

    /// Additional output. q: the dual field of the lower bound, as q.npy (2F x m, rows as in K), from which
    /// `evaluate --q` computes the same bound
    #[arg(long, value_name = "WHAT", value_parser = named::<Saved>())]
    save: Vec<Saved>,

    /// How U is rounded to labels. expansion: for two regions the best labels, by a minimum cut; for more, expansion moves
    /// and then single moves, each of which lowers the energy; moves: single moves only; argmax: the largest entry of u
    #[arg(long, value_parser = named::<Rounding>(), default_value = "expansion")]
    rounding: Rounding,

    /// After the solve, improve the labels and a bound for labels until they are at most this share above any labeling, for
    /// example 1e-3; ends earlier at --time-limit, or if the bound rises no further
    #[arg(long, value_name = "GAP", allow_negative_numbers = true)]
    label_gap: Option<f64>,

    /// Write contours.obj: the cut of U through the faces, where the two largest entries of u are equal, as polylines (`l`)
    /// with their lengths, in a group for each pair of regions
    #[arg(long)]
    pub contours: bool,

    /// Write the mesh divided along the cut of U, so that each face is in one region: a property `label` in .ply,
    /// materials in .obj, colors in .off
    #[arg(long, value_name = "FILE")]
    pub cut_mesh: Option<PathBuf>,

    /// Write the result in another format as well; can be repeated. vtp, vtu: for ParaView and pyvista, with u and the margin
    /// of each label; glb: for viewers and browsers; label-gii: GIFTI labels of vertices; annot: the same for FreeSurfer; json:
    /// labels.json
    #[arg(long, value_name = "FORMAT", value_parser = named::<Export>())]
    pub also: Vec<Export>,

    /// Number of threads; the result does not depend on it [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_THREADS)), allow_negative_numbers = true)]
    threads: Option<u16>,

    /// Folder for the results; written completely or not at all
    #[arg(long, value_name = "DIR", required = true)]
    pub out: Option<PathBuf>,

    /// Viewpoint of preview.png: auto (one or two views that show the regions), front, back, x, -x, y, -y, z,
    /// -z, or AZIMUTH,ELEVATION in degrees from the front and the horizon
    #[arg(
        long,
        value_name = "VIEW",
        default_value = "auto",
        allow_hyphen_values = true,
        hide_default_value = true
    )]
    pub view: View,

    /// Do not write preview.png, nor views.png for views
    #[arg(long)]
    pub no_preview: bool,
}

#[derive(Clone, Copy, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Saved {
    Q,
}

/// Results that a cut mesh might replace.
const RESULTS: [&str; 2] = ["segmented.ply", "contours.obj"];

impl Solving {
    /// Whether there is to be a picture.
    pub fn draws(&self) -> bool {
        self.out.is_some() && !self.no_preview
    }

    /// The line that says where the results are.
    pub fn written_to(&self) -> Option<(&'static str, String)> {
        self.out.as_ref().map(|out| ("written to", out.display().to_string()))
    }

    /// What to look at, at the beginning of a sentence.
    pub fn see(&self) -> String {
        let picture = if self.no_preview { "segmented.ply" } else { "preview.png" };
        self.out
            .as_ref()
            .map_or_else(String::new, |out| format!("see {}; ", out.join(picture).display()))
    }

    pub fn threads(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }

    pub fn request(&self, mesh: &Path, lambda: f64) -> Result<Request> {
        let not_negative = |name: &str, value: f64| {
            if value >= 0.0 && value.is_finite() {
                Ok(value)
            } else {
                Err(Error::unsuitable(format!(
                    "{name} {value:?}: must be a finite number, 0 or more"
                )))
            }
        };
        let time = match self.time_limit {
            None => None,
            Some(seconds) => Some(time_limit(seconds).map_err(|message| {
                Error::unsuitable(format!("--time-limit {seconds:?}: {message}"))
            })?),
        };
        let change = self.stop_change.map(|delta| not_negative("--stop-change", delta));
        let precision = self.precision.map(|precision| format!("precision={}", precision.name()));
        let options: Vec<String> = self.solver_options.iter().cloned().chain(precision).collect();
        let request = Request {
            lambda,
            relaxation: self.relaxation.unwrap_or_default(),
            mass: self.mass,
            method: Method::parse(&self.solver, &Options::parse(&options)?)?,
            stop: Stop {
                relative_gap: Some(not_negative("--gap", self.gap)?),
                iterations: Some(self.max_iterations),
                time,
                change: change.transpose()?,
                interval: self.check_every,
            },
            coarse_to_fine: self.coarse_to_fine,
            keep_dual: self.save.contains(&Saved::Q),
            rounding: self.rounding,
            label_gap: self.label_gap.map(|gap| not_negative("--label-gap", gap)).transpose()?,
        };
        request.check()?;
        if let Some(out) = &self.out {
            crate::file::check_folder(out)?;
        }
        if let Some(path) = &self.cut_mesh {
            self.check_cut_mesh(path, mesh)?;
        }
        Ok(request)
    }

    /// Checks that the cut mesh can be written, and that it replaces neither the mesh, nor its materials, nor other results.
    fn check_cut_mesh(&self, path: &Path, mesh: &Path) -> Result<()> {
        check_labeled_faces(path)?;
        let out = self.out.as_deref();
        // The folder of the results is created before.
        let in_results = out.is_some() && path.parent() == out;
        if !in_results || out.is_some_and(Path::is_dir) {
            crate::file::check_file(path)?;
        }
        let is = |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
        let refuse = |what: &str| {
            let message = format!("--cut-mesh would replace {what}; choose another name");
            Err(Error::malformed(path, message))
        };
        if is(path, mesh) {
            return refuse("the mesh that is cut");
        }
        let of_run = out.into_iter().flat_map(|out| RESULTS.map(|name| out.join(name)));
        if of_run.into_iter().any(|file| file == path || is(&file, path)) {
            return refuse("another result");
        }
        let library = path.with_extension("mtl");
        let is_obj = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("obj"));
        if is_obj && library.exists() && !path.exists() {
            return refuse(&format!("{}, the materials of another mesh", library.display()));
        }
        Ok(())
    }
}

/// The exit of a run whose results are written.
///
/// Ctrl-C in a terminal ends a whole pipe, so that the summary may have no reader; hence the status takes precedence
/// over an error in `printed`.
pub fn exit(status: Status, printed: std::io::Result<()>) -> Outcome {
    match status {
        Status::Interrupted => Err(Failure::Interrupted),
        Status::Contradicted => Err(Failure::Contradicted),
        _ => Ok(printed?),
    }
}

fn time(summary: &Summary) -> String {
    let all = format!("{:.3} s in the solver", summary.seconds);
    match &summary.coarse_to_fine {
        None => all,
        Some(Record { spent, levels }) => {
            format!("{all}, {:.3} s of it on {} coarser meshes", spent.as_secs_f64(), levels.len())
        }
    }
}

/// A share in percent, rounded upwards to two digits after the point, or to two significant ones if it is small.
pub fn percent_or_less(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 || percent >= 0.01 {
        return format!("{:.2} %", (100.0 * percent).ceil() / 100.0);
    }
    format!("{:.1e} %", rounded_up(percent))
}

/// The lines of the summary that every run prints.
pub fn summary_lines(summary: &Summary) -> Vec<(&'static str, String)> {
    let share = summary.rounded_relative_gap;
    let above = if share.is_finite() {
        percent_or_less(share)
    } else {
        table::number(summary.rounded_energy - summary.dual_bound)
    };
    let mut lines = vec![("status", summary.status_sentence.to_string())];
    if !summary.empty_regions.is_empty() {
        let used = summary.regions - summary.empty_regions.len();
        let empty = empty_regions::sentence(&summary.empty_regions);
        lines.push(("regions", format!("{used} of {} used: {empty}", summary.regions)));
    }
    lines.extend([
        ("energy", table::number(summary.energy)),
        ("lower bound", table::number(summary.dual_bound)),
        ("baseline", format!("{}, the sum of the minimum costs", table::number(summary.baseline))),
        ("certified gap", format!("{:.2e} of the energy above the baseline", summary.relative_gap)),
        (
            "labels",
            format!(
                "energy {}, at most {above} above any labeling",
                table::number(summary.rounded_energy)
            ),
        ),
        ("lambda", table::number(summary.lambda)),
        ("iterations", format!("{} of {}", summary.iterations, summary.solver)),
        ("time", time(summary)),
    ]);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_rounded_upwards() {
        let shown = [0.0, 0.021001, 0.0209, 1e-4, 9.11e-6, 2.41e-9].map(percent_or_less);
        let expected = ["0.00 %", "2.11 %", "2.09 %", "0.01 %", "9.2e-4 %", "2.5e-7 %"];
        assert_eq!(shown, expected);
    }
}
