//! The choice of views that show what there is to see.
//!
//! A flat mesh is seen straight on. Others are tried from all around their up axis, slightly from above, at low
//! resolution; the view with the best sum of visible area, visible cut and visible regions wins, each in
//! proportion to the best that any of the views offers. Regions count double, or small ones would stay hidden, and
//! among equals the front wins.
//! A second view shows what the first one hides, if that is much or has a region of its own.

use std::f64::consts::TAU;
use std::str::FromStr;

use nalgebra::{Matrix3, Vector3};

use super::labels::{LabelField, NOWHERE};
use super::simplified::{Simplified, simplified};
use crate::mesh::Mesh;
use crate::optics::camera::Camera;
use crate::optics::visibility::{Visibility, components};
use crate::sweep;

/// Pixels along the longer side.
const SIZE: f64 = 48.0;
const AZIMUTHS: usize = 12;
/// Of visible area, cut and regions.
const WEIGHTS: [f64; 3] = [1.0, 1.0, 2.0];
/// How much better a later candidate must be, so that rounding does not decide between equals.
const MARGIN: f64 = 1e-3;
/// Tangents of the heights above the horizon, and how much a view from there is liked: the higher one is for
/// shapes that lie.
const ELEVATIONS: [(f64, f64); 2] = [(0.25, 1.0), (0.9, 0.8)];
/// How much more a view from the front is liked than one from the side, and that more than one from behind.
const FRONT: f64 = 0.04;
/// Thinner than this share of its length, a mesh counts as flat.
const FLAT: f64 = 0.02;
/// Z is up if the mesh is this much taller along it than wide.
const TALL: f64 = 1.5;
/// A view is added if one hides more than this share of the surface,
const HIDDEN: f64 = 0.25;
/// and the other shows so much of it,
const GAIN: f64 = 0.1;
/// or at least so much of a region of which the first shows less.
const SPECK: f64 = 0.02;

/// From where the mesh is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum View {
    /// One or two views that show the regions.
    #[default]
    Auto,
    /// Degrees to the right of the front, and above the horizon.
    Around {
        /// 0 is the front, 90 the right side; any finite number.
        azimuth: f64,
        /// From -90, below, to 90, above.
        elevation: f64,
    },
    /// From the positive or negative end of an axis of the file.
    Axis {
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// Whether the viewer is at the positive end.
        positive: bool,
    },
}

impl View {
    /// The forms that [`View::from_str`] takes.
    pub const SYNTAX: &str =
        "auto, front, back, x, -x, y, -y, z, -z, or AZIMUTH,ELEVATION in degrees";
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let around = |azimuth: f64, elevation: f64| View::Around { azimuth, elevation };
        let axis = |axis: usize| View::Axis { axis, positive: !text.starts_with('-') };
        match text {
            "auto" => return Ok(View::Auto),
            "front" => return Ok(around(0.0, 0.0)),
            "back" => return Ok(around(180.0, 0.0)),
            "x" | "-x" => return Ok(axis(0)),
            "y" | "-y" => return Ok(axis(1)),
            "z" | "-z" => return Ok(axis(2)),
            _ => {}
        }
        let angles = text.split_once(',').and_then(|(azimuth, elevation)| {
            Some((azimuth.trim().parse::<f64>().ok()?, elevation.trim().parse::<f64>().ok()?))
        });
        match angles {
            Some((azimuth, elevation))
                if azimuth.is_finite() && (-90.0..=90.0).contains(&elevation) =>
            {
                Ok(around(azimuth, elevation))
            }
            Some(_) => Err("the elevation goes from -90 to 90 degrees".into()),
            None => Err(format!("must be {}", View::SYNTAX)),
        }
    }
}

/// The direction to a viewer, and what is up for him.
pub(super) type Direction = (Vector3<f64>, Vector3<f64>);

/// The cameras, one or two. `mesh` lies in the unit ball and has no unreferenced vertices; `straight` is how it is
/// seen straight on, if it is to be.
pub(super) fn cameras(
    mesh: &Mesh,
    field: &LabelField,
    view: View,
    straight: Option<Direction>,
) -> Vec<Camera> {
    let fit = |towards, up| Camera::fit(towards, up, &mesh.vertices);
    let axes = Axes::of(mesh);
    match (view, straight) {
        (_, Some((towards, up))) => vec![fit(towards, up)],
        (View::Auto, None) => {
            let views = choose(&simplified(mesh, field), &axes, field.regions());
            views.into_iter().map(|towards| fit(towards, axes.up)).collect()
        }
        (View::Axis { axis, positive }, _) => {
            let mut towards = Vector3::zeros();
            towards[axis] = if positive { 1.0 } else { -1.0 };
            vec![fit(towards, axes.above(towards))]
        }
        (View::Around { azimuth, elevation }, _) => {
            let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
            let horizontal = axes.around(azimuth);
            let towards = horizontal * elevation.cos() + axes.up * elevation.sin();
            // From a pole, what is in front is below.
            let up =
                if elevation.cos() > 1e-6 { axes.up } else { -horizontal * elevation.signum() };
            vec![fit(towards, up)]
        }
    }
}

/// The directions to a viewer in front and a little above, and up, as the picture sees the mesh stand.
pub fn standing(mesh: &Mesh) -> [[f64; 3]; 2] {
    let axes = Axes::of(mesh);
    let side = axes.up.cross(&axes.front);
    let towards = axes.front + 0.45 * side + 0.5 * axes.up;
    [towards.into(), axes.up.into()]
}

/// How the mesh stands.
struct Axes {
    up: Vector3<f64>,
    front: Vector3<f64>,
}

impl Axes {
    fn of(mesh: &Mesh) -> Self {
        let up = up_axis(mesh);
        Axes { up, front: if up == Vector3::y() { Vector3::z() } else { -Vector3::y() } }
    }

    /// A horizontal direction, by its angle to the right of the front.
    fn around(&self, azimuth: f64) -> Vector3<f64> {
        self.front * azimuth.cos() + self.up.cross(&self.front) * azimuth.sin()
    }

    /// What is up in a view from an end of an axis.
    fn above(&self, towards: Vector3<f64>) -> Vector3<f64> {
        let along = towards.dot(&self.up);
        if along.abs() < 0.5 { self.up } else { -self.front * along.signum() }
    }
}

/// The directions to the viewer of one or two views.
fn choose(mesh: &Simplified, axes: &Axes, regions: usize) -> Vec<Vector3<f64>> {
    let Simplified { mesh, u, areas } = mesh;
    let field = LabelField::new(mesh, u, regions);
    let component = components(mesh);
    let mut candidates = Vec::new();
    for (elevation, _) in ELEVATIONS {
        for i in 0..AZIMUTHS {
            let horizontal = axes.around(TAU * i as f64 / AZIMUTHS as f64);
            candidates.push(horizontal + elevation * axes.up);
        }
    }
    let merits = sweep::results(candidates.clone(), |towards| {
        let camera = Camera::fit(towards, axes.up, &mesh.vertices).sized(SIZE);
        Merit::of(&Visibility::new(mesh, &component, &camera), &field, mesh)
    });
    let best = [0, 1, 2].map(|c| merits.iter().map(|merit| merit.terms[c]).fold(0.0, f64::max));
    let score = |i: usize| -> f64 {
        let terms = (0..3).filter(|&c| best[c] > 0.0);
        let sum: f64 = terms.map(|c| WEIGHTS[c] * merits[i].terms[c] / best[c]).sum();
        let front = 1.0 + FRONT * (TAU * i as f64 / AZIMUTHS as f64).cos();
        sum * ELEVATIONS[i / AZIMUTHS].1 * front
    };
    let first = best_of(candidates.len(), score);
    // What each of the others shows that the first does not: its area, and regions that it brings in.
    let total: f64 = areas.iter().sum();
    let hidden = |v: &usize| merits[first].hidden[*v];
    let region_area = |shown: &dyn Fn(&usize) -> bool| {
        let mut sums = vec![0.0; regions];
        for v in (0..areas.len()).filter(shown) {
            sums[field.region(v)] += areas[v];
        }
        sums
    };
    let all = region_area(&|_| true);
    let shown = region_area(&|v| !hidden(v));
    let lacks: Vec<bool> =
        all.iter().zip(&shown).map(|(all, shown)| *all > 0.0 && *shown < SPECK * all).collect();
    let gains: Vec<(f64, usize)> = merits
        .iter()
        .map(|merit| {
            let new = region_area(&|v| hidden(v) && !merit.hidden[*v]);
            let brought = (0..regions).filter(|&p| lacks[p] && new[p] >= SPECK * all[p]).count();
            (new.iter().sum::<f64>() / total, brought)
        })
        .collect();
    let second = best_of(candidates.len(), |i| {
        (gains[i].0 + gains[i].1 as f64) * ELEVATIONS[i / AZIMUTHS].1
    });
    let hides = 1.0 - shown.iter().sum::<f64>() / total;
    let (gain, brought) = gains[second];
    let mut chosen = vec![candidates[first]];
    if brought > 0 || hides > HIDDEN && gain > GAIN {
        chosen.push(candidates[second]);
    }
    chosen
}

/// The first candidate that no other beats clearly.
fn best_of(count: usize, score: impl Fn(usize) -> f64) -> usize {
    let scores: Vec<f64> = (0..count).map(score).collect();
    let mut chosen = 0;
    for i in 1..count {
        if scores[i] > (1.0 + MARGIN) * scores[chosen] {
            chosen = i;
        }
    }
    chosen
}

/// The direction to the viewer of a flat mesh, and its up.
pub(super) fn straight_on(mesh: &Mesh) -> Option<Direction> {
    let count = mesh.vertices.len() as f64;
    let mean = mesh.vertices.iter().map(|x| x.coords).sum::<Vector3<f64>>() / count;
    let mut covariance = Matrix3::zeros();
    for x in &mesh.vertices {
        let offset = x.coords - mean;
        covariance += offset * offset.transpose();
    }
    let eigen = covariance.symmetric_eigen();
    let (least, value) = eigen.eigenvalues.argmin();
    if value.max(0.0).sqrt() > FLAT * eigen.eigenvalues.max().sqrt() {
        return None;
    }
    let normal: Vector3<f64> = eigen.eigenvectors.column(least).into();
    let facing: f64 = (0..mesh.faces.len()).map(|j| mesh.area_vector(j).dot(&normal)).sum();
    let towards = if facing < 0.0 { -normal } else { normal };
    let up = if normal.y.abs() < 0.9 { Vector3::y() } else { -Vector3::z() };
    Some((towards, up))
}

fn up_axis(mesh: &Mesh) -> Vector3<f64> {
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = Vector3::repeat(f64::NEG_INFINITY);
    for x in &mesh.vertices {
        low = low.inf(&x.coords);
        high = high.sup(&x.coords);
    }
    let extent = high - low;
    if extent.z > TALL * extent.x.max(extent.y) { Vector3::z() } else { Vector3::y() }
}

/// What a view shows.
struct Merit {
    /// Visible area, visible length of the cut, and how evenly the regions show: the exponential of the entropy of
    /// their shares of the picture, which is m for m equal shares.
    terms: [f64; 3],
    /// The vertices that it does not show.
    hidden: Vec<bool>,
}

/// Pixels by which what hides a vertex must be nearer: no less than steep surfaces differ by, and than limbs are thick.
const NEARER: f64 = 1.5;

impl Merit {
    fn of(visibility: &Visibility, field: &LabelField, mesh: &Mesh) -> Self {
        let camera = visibility.camera();
        let regions = field.seen(visibility);
        let mut area = 0.0;
        let mut seen = vec![0.0; field.regions()];
        for (i, &p) in regions.iter().enumerate().filter(|(_, p)| **p != NOWHERE) {
            let Some((j, _)) = visibility.front(i) else { continue };
            let ray = camera.to_eye(mesh.corners(j)[0]);
            let normal = camera.rotate(mesh.area_vector(j));
            let cosine = normal.dot(&ray).abs() / (normal.norm() * ray.norm());
            area += camera.pixel(1.0 / ray.z).powi(2) / cosine.max(0.25);
            seen[p as usize] += 1.0;
        }
        let total: f64 = seen.iter().sum();
        let entropy: f64 = seen
            .iter()
            .filter(|&&count| count > 0.0)
            .map(|count| -(count / total) * (count / total).ln())
            .sum();
        let cut = field.count_crossings(visibility, &regions) as f64;
        let hidden = (0..mesh.vertices.len()).map(|v| visibility.hides(v, NEARER)).collect();
        Merit { terms: [area, cut, entropy.exp()], hidden }
    }
}
