//! The gradient of the energy of an image with respect to the contours of the surface: where it ends in the image, what is
//! behind it comes into view.
//!
//! ```text
//! dE/dX_a += -+ omega det K int_0^1 (1-t) vis(t) (e_front - e_behind) (X_a x X_b) / z(t)^3 dt      (X_b: t instead of 1-t)
//! ```
//!
//! over the edges whose faces all project to the same side; minus if that side is left of the projected a -> b (the cross
//! product is positive in the axes of the image), plus else. Samples are equally spaced in the image:
//!
//! ```text
//! t = (l / z_b) / ze,   ze = (1-l) / z_a + l / z_b,   dt / z^3 = ze / (z_a z_b) dl
//! ```
//!
//! One ray without the faces of the edge decides: anything nearer hides the edge, and the next face is what is behind, or
//! the background. The image is the pixel that the sample lies in, and e_front has the labels of the edge, on which its
//! faces agree. Back faces count like front faces: otherwise folds would open holes.

use nalgebra::Vector3;

use super::bins::Bins;
use super::edges::Edges;
use super::images::Image;
use super::scene::{Scene, Seen, cost_beyond_image};
use crate::optics::edge::{Edge, Projected};

/// The edge itself hides nothing: faces that meet it in one of its ends are at the same depth there.
const NEARER: f64 = 1.0 + 1e-9;

/// Adds the gradient, in the axes of the camera, with `per_pixel` samples per pixel. Returns the length of the visible
/// contours in pixels.
pub fn add_gradient(
    scene: &Scene,
    edges: &Edges,
    image: &Image,
    seen: &Seen,
    per_pixel: f64,
    gradient: &mut [Vector3<f64>],
) -> f64 {
    let silhouettes = silhouettes(edges, image, &seen.projected, per_pixel);
    let points = silhouettes.iter().flat_map(|silhouette| {
        let [a, b] = edges.ends[silhouette.edge].map(|k| &seen.projected[k as usize]);
        silhouette.samples().map(move |l| between(a, b, l))
    });
    let bins = Bins::new(image.size(), &seen.projected, &scene.mesh.faces, points);
    let scale = image.omega * image.camera.pixels_per_unit();
    let mut visible = 0.0;
    for silhouette in &silhouettes {
        let ends = edges.ends[silhouette.edge].map(|k| k as usize);
        let [a, b] = ends.map(|k| &seen.projected[k]);
        let wings = edges.wings(silhouette.edge);
        let own = |j: usize| wings.iter().any(|wing| wing.face as usize == j);
        let mut forces = [0.0; 2];
        let step = silhouette.step();
        for l in silhouette.samples() {
            let at = between(a, b, l);
            let ze = (1.0 - l) * a.w + l * b.w;
            let Ok(behind) = bins.behind(at, ze * NEARER, own) else { continue };
            visible += step * silhouette.length;
            let t = l * b.w / ze;
            let pixel = image.pixels[pixel(at, image)];
            let color = pixel.color.map(f64::from);
            let front = {
                let (look, s) = scene.mean(&ends, &[1.0 - t, t]);
                cost_beyond_image(color, look, s)
            };
            let behind = match behind {
                Some(met) => {
                    let corners = scene.mesh.faces[met.face].map(|k| k as usize);
                    let (look, s) = scene.mean(&corners, &met.beta);
                    cost_beyond_image(color, look, s)
                }
                None => f64::from(pixel.beyond) - color.iter().map(|c| c * c).sum::<f64>(),
            };
            let force = (front - behind) * ze * step;
            forces[0] += (1.0 - t) * force;
            forces[1] += t * force;
        }
        let [xa, xb] = ends.map(|k| seen.points[k]);
        let direction = (-silhouette.side * scale * a.w * b.w) * xa.cross(&xb);
        for (k, force) in ends.into_iter().zip(forces) {
            gradient[k] += force * direction;
        }
    }
    visible
}

/// The part in the image of an edge whose faces all project to one side of it.
struct Silhouette {
    edge: usize,
    /// 1 if that side is left of a -> b, else -1.
    side: f64,
    /// The length of the whole edge in pixels.
    length: f64,
    /// l at the ends of the part.
    part: [f64; 2],
    /// The number of samples.
    count: usize,
}

impl Silhouette {
    /// dl.
    fn step(&self) -> f64 {
        (self.part[1] - self.part[0]) / self.count as f64
    }

    /// l of each sample.
    fn samples(&self) -> impl Iterator<Item = f64> + use<> {
        let (start, step) = (self.part[0], self.step());
        (0..self.count).map(move |i| start + (i as f64 + 0.5) * step)
    }
}

fn silhouettes(
    edges: &Edges,
    image: &Image,
    projected: &[Projected],
    per_pixel: f64,
) -> Vec<Silhouette> {
    let mut found = Vec::new();
    for (edge, ends) in edges.ends.iter().enumerate() {
        let [a, b] = ends.map(|k| &projected[k as usize]);
        if !(a.w > 0.0 && b.w > 0.0) {
            continue;
        }
        let line = Edge::new(a, b);
        // Faces that reach behind the camera are not drawn, and those seen edge on cover nothing.
        let sides = edges.wings(edge).iter().filter_map(|wing| {
            let c = &projected[wing.opposite as usize];
            let side = if c.w > 0.0 { line.at(c.x, c.y) } else { 0.0 };
            (side != 0.0).then(|| side.signum())
        });
        let Some(side) = agreed(sides) else { continue };
        let Some(part) = part_inside(a, b, image) else { continue };
        let length = line.dx.hypot(line.dy);
        let count = (per_pixel * length * (part[1] - part[0])).ceil().max(1.0) as usize;
        found.push(Silhouette { edge, side, length, part, count });
    }
    found
}

/// The value of all of them, if they are equal and there are any.
#[inline(always)]
fn agreed(mut values: impl Iterator<Item = f64>) -> Option<f64> {
    let first = values.next()?;
    values.all(|value| value == first).then_some(first)
}

/// The values of l from 0 to 1 at which a + l (b - a) is in the image.
fn part_inside(a: &Projected, b: &Projected, image: &Image) -> Option<[f64; 2]> {
    let mut part = [0.0_f64, 1.0_f64];
    for (from, to, n) in [(a.x, b.x, image.width), (a.y, b.y, image.height)] {
        let (low, high) = (-0.5 - from, n as f64 - 0.5 - from);
        let d = to - from;
        if d == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let [first, last] = if d > 0.0 { [low / d, high / d] } else { [high / d, low / d] };
        part = [part[0].max(first), part[1].min(last)];
    }
    (part[0] < part[1]).then_some(part)
}

#[inline(always)]
fn between(a: &Projected, b: &Projected, l: f64) -> [f64; 2] {
    [a.x + l * (b.x - a.x), a.y + l * (b.y - a.y)]
}

/// The pixel that a point of the image lies in.
#[inline(always)]
fn pixel([x, y]: [f64; 2], image: &Image) -> usize {
    let index = |at: f64, n: usize| ((at + 0.5).max(0.0) as usize).min(n - 1);
    index(y, image.height) * image.width + index(x, image.width)
}
