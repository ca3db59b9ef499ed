//! Triangulation of polygons inside themselves.
//!
//! Readers cut a polygon c_1 ... c_n into the fan (c_1, c_i, c_{i+1}) and record it. When all positions are known, each
//! fan with a triangle that is oriented against the polygon, as seen along the polygon's normal
//!
//! ```text
//! N = 1/2 sum_i x_i x x_{i+1}          (Newell)
//! ```
//!
//! is replaced by the n - 2 triangles of ear clipping. In any order, the triangles that are cut off one by one add up
//! to the polygon as chains: if all have its orientation, they cover each point as often as the polygon winds around
//! it, once if it does not cross itself. So the area is correct without further proof. A polygon that cannot be
//! finished in this way crosses itself: it stays a fan, with a warning.
//!
//! We use our own ear clipping because existing libraries drop corners within straight sides, which disconnects
//! neighboring faces, and take cubic time for polygons that cross themselves.
//!
//! References: Meisters, *Polygons Have Ears*, 1975; Newell's normal as in Sutherland, Sproull, Schumacker, 1974.

use std::path::Path;

use nalgebra::{Point3, Vector2, Vector3};

use super::occurrences::Occurrences;

/// A triangle whose doubled area is at most this fraction of its longest side squared is flat up to rounding.
const FLAT_FATNESS: f64 = 1e-12;
/// A triangle above this fraction is not a needle.
const NEEDLE_FATNESS: f64 = 1e-3;
/// Maximum number of point-in-triangle tests per file, one or two seconds; further polygons stay fans.
const MAX_POINTS_TESTED: usize = 1 << 30;

/// The polygons of a file with more than three corners.
#[derive(Default)]
pub struct Polygons {
    fans: Vec<Fan>,
}

/// The triangles of its fan.
struct Fan {
    first: usize,
    corners: usize,
}

impl Polygons {
    /// Records a polygon whose fan begins with the given triangle.
    #[inline]
    pub fn add(&mut self, first: usize, corners: usize) {
        if corners > 3 {
            self.fans.push(Fan { first, corners });
        }
    }

    /// Replaces the fans that leave their polygon. Values at corners move with them.
    pub fn triangulate<T: Copy>(
        &self,
        path: &Path,
        vertices: &[Point3<f64>],
        faces: &mut [[u32; 3]],
        mut of_corners: Option<&mut [[T; 3]]>,
    ) {
        let mut crossed = Occurrences::default();
        let mut work = MAX_POINTS_TESTED;
        let mut polygon = Vec::new();
        for (i, fan) in self.fans.iter().enumerate() {
            let triangles = fan.first..fan.first + fan.corners - 2;
            let fan = &mut faces[triangles.clone()];
            polygon.clear();
            polygon.extend(unfanned(fan));
            let origin = vertices[polygon[0] as usize];
            let point = |k: u32| vertices[k as usize] - origin;
            let normal = normal(polygon.iter().map(|&k| point(k)));
            let inside = |&[a, b, c]: &[u32; 3]| {
                let (a, b, c) = (point(a), point(b), point(c));
                let longest =
                    (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
                (b - a).cross(&(c - a)).dot(&normal) > FLAT_FATNESS * longest
            };
            if fan.iter().all(inside) {
                continue;
            }
            let points = projected(polygon.iter().map(|&k| point(k)), normal);
            let Some(ears) = Ring::new(&points).ears(&mut work) else {
                crossed
                    .add(|| format!("polygon {i} of {} with more than 3 corners", self.fans.len()));
                continue;
            };
            for (triangle, ear) in fan.iter_mut().zip(&ears) {
                *triangle = ear.map(|corner| polygon[corner]);
            }
            if let Some(of_corners) = &mut of_corners {
                let of_fan = &mut of_corners[triangles];
                let of_polygon: Vec<T> = unfanned(of_fan).collect();
                for (triangle, ear) in of_fan.iter_mut().zip(&ears) {
                    *triangle = ear.map(|corner| of_polygon[corner]);
                }
            }
        }
        crossed.warn(
            path,
            "polygons that cross themselves, have no area or are too large are cut into fans at their first corner",
        );
    }
}

/// The corners of the polygon whose fan this is.
fn unfanned<T: Copy>(fan: &[[T; 3]]) -> impl Iterator<Item = T> + '_ {
    fan[..1].iter().flat_map(|&[a, b, _]| [a, b]).chain(fan.iter().map(|triangle| triangle[2]))
}

/// The unit normal of a polygon whose first corner is the origin; 0 if there is none.
fn normal(points: impl Iterator<Item = Vector3<f64>>) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    let mut last = Vector3::zeros();
    for point in points {
        sum += last.cross(&point);
        last = point;
    }
    sum.try_normalize(0.0).unwrap_or_default()
}

/// Projects the polygon against its normal, so that it is counterclockwise.
fn projected(
    points: impl Iterator<Item = Vector3<f64>>,
    normal: Vector3<f64>,
) -> Vec<Vector2<f64>> {
    // The first axis is orthogonal to the normal and to a coordinate axis far from it.
    let mut axis = Vector3::zeros();
    axis[normal.iamin()] = 1.0;
    let right = normal.cross(&axis).try_normalize(0.0).unwrap_or_default();
    let up = normal.cross(&right);
    points.map(|x| Vector2::new(x.dot(&right), x.dot(&up))).collect()
}

/// Twice the area of a triangle, relative to its longest side squared; positive if it is counterclockwise.
fn fatness([a, b, c]: [Vector2<f64>; 3]) -> f64 {
    let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
    if longest > 0.0 { (b - a).perp(&(c - a)) / longest } else { 0.0 }
}

/// A criterion for ears, from strict ones to those for coinciding or collinear corners.
#[derive(Clone, Copy)]
struct Rule {
    /// Minimum fatness.
    fatness: f64,
    /// No corner may lie in it, or outside within this margin.
    margin: Option<f64>,
}

const EAR_RULES: [Rule; 5] = [
    Rule { fatness: NEEDLE_FATNESS, margin: Some(FLAT_FATNESS) },
    Rule { fatness: FLAT_FATNESS, margin: Some(FLAT_FATNESS) },
    Rule { fatness: FLAT_FATNESS, margin: Some(-FLAT_FATNESS) },
    Rule { fatness: FLAT_FATNESS, margin: None },
    Rule { fatness: -FLAT_FATNESS, margin: None },
];
/// After an ear by this rule or a later one, the earlier rules may apply again.
const FIRST_LATER_RULE: usize = 2;

/// The remaining polygon.
struct Ring<'a> {
    points: &'a [Vector2<f64>],
    next: Vec<usize>,
    previous: Vec<usize>,
    /// The corners that may lie in an ear: the reflex ones, and some that are no longer reflex.
    reflex: Vec<usize>,
    is_reflex: Vec<bool>,
}

impl<'a> Ring<'a> {
    fn new(points: &'a [Vector2<f64>]) -> Self {
        let n = points.len();
        let mut ring = Ring {
            points,
            next: (0..n).map(|i| (i + 1) % n).collect(),
            previous: (0..n).map(|i| (i + n - 1) % n).collect(),
            reflex: Vec::new(),
            is_reflex: Vec::new(),
        };
        ring.is_reflex = (0..n).map(|i| ring.turn(i) <= FLAT_FATNESS).collect();
        ring.reflex = (0..n).filter(|&i| ring.is_reflex[i]).collect();
        ring
    }

    fn corner(&self, i: usize) -> [usize; 3] {
        [self.previous[i], i, self.next[i]]
    }

    fn turn(&self, i: usize) -> f64 {
        fatness(self.corner(i).map(|i| self.points[i]))
    }

    /// n - 2 counterclockwise triangles, as indices into the polygon; `None` if there is no such triangulation.
    fn ears(mut self, work: &mut usize) -> Option<Vec<[usize; 3]>> {
        let n = self.points.len();
        let mut ears = Vec::with_capacity(n - 2);
        let (mut at, mut rule, mut failed) = (0, 0, 0);
        while ears.len() + 3 < n {
            if self.is_ear(at, EAR_RULES[rule], work) {
                ears.push(self.corner(at));
                at = self.cut(at);
                failed = 0;
                rule = if rule >= FIRST_LATER_RULE { 0 } else { rule };
                continue;
            }
            at = self.next[at];
            failed += 1;
            if failed == n - ears.len() {
                failed = 0;
                rule += 1;
            }
            if rule == EAR_RULES.len() || *work == 0 {
                return None;
            }
        }
        ears.push(self.corner(at));
        (self.turn(at) >= -FLAT_FATNESS).then_some(ears)
    }

    fn is_ear(&mut self, i: usize, rule: Rule, work: &mut usize) -> bool {
        let corner @ [a, b, c] = self.corner(i).map(|i| self.points[i]);
        if fatness(corner) < rule.fatness {
            return false;
        }
        let Some(margin) = rule.margin else { return true };
        let sides = [(a, b - a), (b, c - b), (c, a - c)];
        let longest = sides.iter().map(|(_, side)| side.norm_squared()).fold(0.0, f64::max);
        let outside = -margin * longest;
        let is_reflex = &self.is_reflex;
        self.reflex.retain(|&k| is_reflex[k]);
        *work = work.saturating_sub(self.reflex.len());
        !self.reflex.iter().map(|&k| self.points[k]).any(|x| {
            // Polygons around a hole visit some points twice.
            x != a
                && x != b
                && x != c
                && sides.iter().all(|(from, side)| side.perp(&(x - from)) >= outside)
        })
    }

    /// Removes a corner and returns the next one.
    fn cut(&mut self, i: usize) -> usize {
        let [before, _, after] = self.corner(i);
        self.next[before] = after;
        self.previous[after] = before;
        self.is_reflex[i] = false;
        for k in [before, after] {
            // Corners that become reflex by a cut, which happens only if the polygon crosses itself, are not tracked.
            self.is_reflex[k] &= self.turn(k) <= FLAT_FATNESS;
        }
        after
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Unit};

    /// The areas of the triangles of a polygon, and whether all of its corners are used.
    fn areas(points: &[Point3<f64>]) -> (f64, f64, bool) {
        let n = points.len() as u32;
        let mut faces: Vec<[u32; 3]> = (2..n).map(|i| [0, i - 1, i]).collect();
        let mut corners = faces.clone();
        let mut polygons = Polygons::default();
        polygons.add(0, points.len());
        polygons.triangulate(Path::new("test"), points, &mut faces, Some(&mut corners));
        assert_eq!(faces, corners);
        let vector = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|k| points[k as usize]);
            0.5 * (b - a).cross(&(c - a))
        };
        let sum: f64 = faces.iter().map(|&face| vector(face).norm()).sum();
        let whole = faces.iter().map(|&face| vector(face)).sum::<Vector3<f64>>().norm();
        let least = faces.iter().map(|&face| vector(face).norm()).fold(f64::INFINITY, f64::min);
        let all = (0..n).all(|k| faces.as_flattened().contains(&k));
        (sum, whole, all && least > 1e-9 * sum)
    }

    /// In any position, from any first corner, in both directions, the triangles of a simple polygon add up to its
    /// area, none has area 0, and every corner is used, including those within straight sides.
    #[test]
    fn simple_polygons_are_covered_once() {
        let ell = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        let dart = [[0., 0.], [3., 1.], [0., 2.], [1., 1.]];
        let straight =
            [[0., 0.], [1., 0.], [2., 0.], [2., 1.], [2., 2.], [1., 2.], [0., 2.], [0., 1.]];
        let triangle = [[0., 0.], [1., 0.], [2., 0.], [3., 0.], [0., 3.]];
        let comb: Vec<[f64; 2]> = (0..20)
            .map(|i| [f64::from(i), if i % 2 == 0 { 0.0 } else { 5.0 }])
            .chain([[19.0, -1.0], [0.0, -1.0]])
            .collect();
        // A comb: ten triangular teeth, nine of base 2, one of base 1 at the right end, and the ground.
        let comb_area = 0.5 * 5.0 * 19.0 + 19.0;
        let spiral: Vec<[f64; 2]> = (0..60)
            .map(|i| (f64::from(i) * 0.3, 1.0))
            .chain((0..60).rev().map(|i| (f64::from(i) * 0.3, 0.8)))
            .map(|(t, scale)| [scale * (1.0 + t) * t.cos(), scale * (1.0 + t) * t.sin()])
            .collect();
        let spiral_area = {
            let shifted = spiral.iter().cycle().skip(1);
            0.5 * spiral.iter().zip(shifted).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
        };
        // A square around a square hole, joined by a cut that is traversed twice.
        let ring = [
            [0., 0.],
            [4., 0.],
            [4., 4.],
            [0., 4.],
            [0., 0.],
            [1., 1.],
            [1., 3.],
            [3., 3.],
            [3., 1.],
            [1., 1.],
        ];
        for (polygon, area) in [
            (&ell[..], 3.0),
            (&dart, 2.0),
            (&straight, 4.0),
            (&triangle, 4.5),
            (&comb, comb_area),
            (&spiral, spiral_area.abs()),
            (&ring, 12.0),
        ] {
            for turn in 0..12 {
                let axis = Unit::new_normalize(Vector3::new(1.0, f64::from(turn), -2.0));
                let rotation = Rotation3::from_axis_angle(&axis, 0.7 * f64::from(turn));
                let scale = 10.0_f64.powi(turn - 6);
                let shift = Vector3::new(5.0, -3.0, 2.0) * scale;
                for first in 0..polygon.len() {
                    for backwards in [false, true] {
                        let mut points: Vec<_> = polygon
                            .iter()
                            .map(|&[x, y]| {
                                Point3::from(rotation * Vector3::new(x, y, 0.0) * scale + shift)
                            })
                            .collect();
                        points.rotate_left(first);
                        if backwards {
                            points.reverse();
                        }
                        let (sum, whole, complete) = areas(&points);
                        let expected = area * scale * scale;
                        assert!(
                            (sum - expected).abs() < 1e-9 * expected,
                            "{sum} {expected} {points:?}"
                        );
                        assert!((whole - expected).abs() < 1e-9 * expected);
                        assert!(complete, "{points:?}");
                    }
                }
            }
        }
    }

    /// Triangles keep the orientation of their polygon, and convex polygons their fans.
    #[test]
    fn convex_polygons_stay_fans() {
        let points: Vec<_> = (0..7)
            .map(|i| f64::from(i) * std::f64::consts::TAU / 7.0)
            .map(|t| Point3::new(t.cos(), 2.0 * t.sin(), 0.1 * (3.0 * t).sin()))
            .collect();
        let fan: Vec<[u32; 3]> = (2..7).map(|i| [0, i - 1, i]).collect();
        let mut faces = fan.clone();
        let mut polygons = Polygons::default();
        polygons.add(0, 7);
        polygons.triangulate::<u32>(Path::new("test"), &points, &mut faces, None);
        assert_eq!(faces, fan);
    }

    /// No input hangs or panics, and only corners of the polygon are used.
    #[test]
    fn arbitrary_polygons_terminate() {
        use rand::{RngExt, SeedableRng};
        let mut random = rand_pcg::Pcg64::seed_from_u64(4);
        for n in (4..40).chain([1000]) {
            for _ in 0..if n > 100 { 1 } else { 50 } {
                // On a coarse grid, so that points coincide and lie on lines.
                let mut coordinate = || f64::from(random.random_range(0..4));
                let points: Vec<_> = (0..n)
                    .map(|_| Point3::new(coordinate(), coordinate(), 0.1 * coordinate()))
                    .collect();
                let mut faces: Vec<[u32; 3]> = (2..n).map(|i| [0, i - 1, i]).collect();
                let mut polygons = Polygons::default();
                polygons.add(0, n as usize);
                polygons.triangulate::<u32>(Path::new("test"), &points, &mut faces, None);
                assert!(faces.as_flattened().iter().all(|&k| k < n));
            }
        }
    }
}
