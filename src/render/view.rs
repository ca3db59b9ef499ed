//! The choice of views that show as much of the segmentation as possible.
//!
//! A flat mesh is viewed straight on. For others, views from all around the up axis and slightly from above are tried
//! at low resolution; the view with the largest sum of visible area, visible cut and visible regions wins, each
//! relative to the largest value among the views. Regions count double, since small ones would stay hidden otherwise,
//! and ties go to the front. A second view is added if the first one hides much of the surface, or a region that the
//! second one shows.

use std::f64::consts::TAU;
use std::str::FromStr;

use nalgebra::{Matrix3, Vector3};

use super::labels::{LabelField, NO_REGION};
use super::simplified::{Simplified, simplified};
use crate::mesh::Mesh;
use crate::optics::camera::Camera;
use crate::optics::visibility::{Visibility, components};
use crate::sweep;

/// Pixels along the longer side of a trial view.
const TRIAL_SIZE: f64 = 48.0;
const AZIMUTHS: usize = 12;
/// The weights of visible area, cut and regions.
const WEIGHTS: [f64; 3] = [1.0, 1.0, 2.0];
/// The relative margin by which a later candidate must be better, so that rounding does not decide between equals.
const SCORE_MARGIN: f64 = 1e-3;
/// The tangents of the elevations, and a factor on the score of views from there. The higher elevation is for shapes
/// that lie flat.
const ELEVATIONS: [(f64, f64); 2] = [(0.25, 1.0), (0.9, 0.8)];
/// The relative bonus of a view from the front, and the penalty of one from behind.
const FRONT_BONUS: f64 = 0.04;
/// A mesh thinner than this fraction of its length is flat.
const FLAT_RATIO: f64 = 0.02;
/// Z is up if the extent along z is larger than that along x and y by this factor.
const UPRIGHT_RATIO: f64 = 1.5;
/// A second view is added if the first one hides more than this fraction of the surface,
const MIN_HIDDEN: f64 = 0.25;
/// and the second one shows more than this fraction of the surface in addition,
const MIN_GAIN: f64 = 0.1;
/// or if it shows at least this fraction of a region of which the first one shows less.
const MIN_REGION: f64 = 0.02;

/// The viewpoint of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum View {
    /// One or two views, chosen to show the regions.
    #[default]
    Auto,
    /// By two angles.
    Around {
        /// Degrees to the right of the front.
        azimuth: f64,
        /// Degrees above the horizon, from -90 to 90.
        elevation: f64,
    },
    /// From the positive or negative end of a coordinate axis.
    Axis {
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// Whether the view is from the positive end.
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
            Some(_) => {
                Err("the azimuth must be finite and the elevation between -90 and 90 degrees"
                    .into())
            }
            None => Err(format!("must be {}", View::SYNTAX)),
        }
    }
}

/// Views separated by commas; two numbers that follow each other are the angles of one view.
#[derive(Clone, Debug, PartialEq)]
pub struct Views(pub Vec<View>);

impl FromStr for Views {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut views = Vec::new();
        let mut words = text.split(',').map(str::trim);
        while let Some(word) = words.next() {
            let view = match word.parse::<f64>() {
                Ok(_) => format!("{word},{}", words.next().unwrap_or_default()),
                Err(_) => word.to_owned(),
            };
            views.push(view.parse().map_err(|error| format!("{view:?}: {error}"))?);
        }
        Ok(Views(views))
    }
}

/// The direction to the viewer, and the up direction.
pub(super) type Direction = (Vector3<f64>, Vector3<f64>);

/// The cameras, one or two. `mesh` lies in the unit ball and has no unreferenced vertices; `straight` is the direction
/// straight on, if the mesh is to be viewed that way.
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
            let views = choose_views(&simplified(mesh, field), &axes, field.region_count());
            views.into_iter().map(|towards| fit(towards, axes.up)).collect()
        }
        (View::Axis { axis, positive }, _) => {
            let mut towards = Vector3::zeros();
            towards[axis] = if positive { 1.0 } else { -1.0 };
            vec![fit(towards, axes.up_for(towards))]
        }
        (View::Around { azimuth, elevation }, _) => {
            let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
            let horizontal = axes.horizontal(azimuth);
            let towards = horizontal * elevation.cos() + axes.up * elevation.sin();
            // Viewed from a pole, the front is at the bottom or the top of the picture.
            let up =
                if elevation.cos() > 1e-6 { axes.up } else { -horizontal * elevation.signum() };
            vec![fit(towards, up)]
        }
    }
}

/// The direction to a viewer in front, a little to the right and above, and the up direction of the mesh.
pub fn default_view(mesh: &Mesh) -> [[f64; 3]; 2] {
    let axes = Axes::of(mesh);
    let side = axes.up.cross(&axes.front);
    let towards = axes.front + 0.45 * side + 0.5 * axes.up;
    [towards.into(), axes.up.into()]
}

/// The up direction and the front of a mesh.
struct Axes {
    up: Vector3<f64>,
    front: Vector3<f64>,
}

impl Axes {
    fn of(mesh: &Mesh) -> Self {
        let up = up_axis(mesh);
        Axes { up, front: if up == Vector3::y() { Vector3::z() } else { -Vector3::y() } }
    }

    /// The horizontal direction at an angle to the right of the front.
    fn horizontal(&self, azimuth: f64) -> Vector3<f64> {
        self.front * azimuth.cos() + self.up.cross(&self.front) * azimuth.sin()
    }

    /// The up direction in a view from an end of a coordinate axis.
    fn up_for(&self, towards: Vector3<f64>) -> Vector3<f64> {
        let along = towards.dot(&self.up);
        if along.abs() < 0.5 { self.up } else { -self.front * along.signum() }
    }
}

/// The directions to the viewer of one or two views.
fn choose_views(mesh: &Simplified, axes: &Axes, regions: usize) -> Vec<Vector3<f64>> {
    let Simplified { mesh, u, areas } = mesh;
    let field = LabelField::new(mesh, u, regions);
    let component = components(mesh);
    let mut candidates = Vec::new();
    for (elevation, _) in ELEVATIONS {
        for i in 0..AZIMUTHS {
            let horizontal = axes.horizontal(TAU * i as f64 / AZIMUTHS as f64);
            candidates.push(horizontal + elevation * axes.up);
        }
    }
    let merits = sweep::results(candidates.clone(), |towards| {
        let camera = Camera::fit(towards, axes.up, &mesh.vertices).with_longer_side(TRIAL_SIZE);
        Merit::of(&Visibility::new(mesh, &component, &camera), &field, mesh)
    });
    let best = [0, 1, 2].map(|c| merits.iter().map(|merit| merit.terms[c]).fold(0.0, f64::max));
    let score = |i: usize| -> f64 {
        let terms = (0..3).filter(|&c| best[c] > 0.0);
        let sum: f64 = terms.map(|c| WEIGHTS[c] * merits[i].terms[c] / best[c]).sum();
        let front = 1.0 + FRONT_BONUS * (TAU * i as f64 / AZIMUTHS as f64).cos();
        sum * ELEVATIONS[i / AZIMUTHS].1 * front
    };
    let first = best_of(candidates.len(), score);
    // The area that each of the others shows in addition to the first view, and the number of regions it adds.
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
    let missing: Vec<bool> = all
        .iter()
        .zip(&shown)
        .map(|(all, shown)| *all > 0.0 && *shown < MIN_REGION * all)
        .collect();
    let gains: Vec<(f64, usize)> = merits
        .iter()
        .map(|merit| {
            let new = region_area(&|v| hidden(v) && !merit.hidden[*v]);
            let added =
                (0..regions).filter(|&p| missing[p] && new[p] >= MIN_REGION * all[p]).count();
            (new.iter().sum::<f64>() / total, added)
        })
        .collect();
    let second = best_of(candidates.len(), |i| {
        (gains[i].0 + gains[i].1 as f64) * ELEVATIONS[i / AZIMUTHS].1
    });
    let hidden_share = 1.0 - shown.iter().sum::<f64>() / total;
    let (gain, added) = gains[second];
    let mut chosen = vec![candidates[first]];
    if added > 0 || hidden_share > MIN_HIDDEN && gain > MIN_GAIN {
        chosen.push(candidates[second]);
    }
    chosen
}

/// The best candidate; a later one replaces an earlier one only if it is better by `SCORE_MARGIN`.
fn best_of(count: usize, score: impl Fn(usize) -> f64) -> usize {
    let scores: Vec<f64> = (0..count).map(score).collect();
    let mut chosen = 0;
    for i in 1..count {
        if scores[i] > (1.0 + SCORE_MARGIN) * scores[chosen] {
            chosen = i;
        }
    }
    chosen
}

/// The direction to the viewer of a flat mesh, and its up direction; `None` for other meshes.
pub(super) fn straight_on(mesh: &Mesh) -> Option<Direction> {
    let count = mesh.vertices.len() as f64;
    let mean = mesh.vertices.iter().map(|x| x.coords).sum::<Vector3<f64>>() / count;
    let mut covariance = Matrix3::zeros();
    for x in &mesh.vertices {
        let offset = x.coords - mean;
        covariance += offset * offset.transpose();
    }
    let eigen = covariance.symmetric_eigen();
    let (smallest, value) = eigen.eigenvalues.argmin();
    if value.max(0.0).sqrt() > FLAT_RATIO * eigen.eigenvalues.max().sqrt() {
        return None;
    }
    let normal: Vector3<f64> = eigen.eigenvectors.column(smallest).into();
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
    if extent.z > UPRIGHT_RATIO * extent.x.max(extent.y) { Vector3::z() } else { Vector3::y() }
}

/// The merit of a view.
struct Merit {
    /// Visible area, visible length of the cut, and effective number of visible regions: the exponential of the entropy
    /// of their shares of the picture, which is m for m equal shares.
    terms: [f64; 3],
    /// Whether each vertex is hidden.
    hidden: Vec<bool>,
}

/// The depth, in pixels, by which the surface must be nearer to hide a vertex: no less than depths differ on a steep
/// surface, and less than the thickness of a limb.
const OCCLUSION_PIXELS: f64 = 1.5;

impl Merit {
    fn of(visibility: &Visibility, field: &LabelField, mesh: &Mesh) -> Self {
        let camera = visibility.camera();
        let regions = field.pixel_regions(visibility);
        let mut area = 0.0;
        let mut counts = vec![0.0; field.region_count()];
        for (i, &p) in regions.iter().enumerate().filter(|(_, p)| **p != NO_REGION) {
            let Some((j, _)) = visibility.first_hit(i) else { continue };
            let ray = camera.to_eye(mesh.corners(j)[0]);
            let normal = camera.rotate(mesh.area_vector(j));
            let cosine = normal.dot(&ray).abs() / (normal.norm() * ray.norm());
            area += camera.pixel_width(1.0 / ray.z).powi(2) / cosine.max(0.25);
            counts[p as usize] += 1.0;
        }
        let total: f64 = counts.iter().sum();
        let entropy: f64 = counts
            .iter()
            .filter(|&&count| count > 0.0)
            .map(|count| -(count / total) * (count / total).ln())
            .sum();
        let cut = field.count_crossings(visibility, &regions) as f64;
        let hidden =
            (0..mesh.vertices.len()).map(|v| visibility.is_occluded(v, OCCLUSION_PIXELS)).collect();
        Merit { terms: [area, cut, entropy.exp()], hidden }
    }
}
