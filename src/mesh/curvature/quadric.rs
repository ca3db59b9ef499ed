//! Principal curvatures at the vertices by quadrics (F. Cazals, M. Pouget, *Estimating differential quantities using
//! polynomial fitting of osculating jets*, Computer Aided Geometric Design 22, 2005, for degree 2). In a frame with
//! origin x_v and z along the area-weighted normal, the least squares fit of
//!
//! ```text
//! z = c_0 + c_1 x + c_2 y + c_3 x^2 + c_4 x y + c_5 y^2
//! ```
//!
//! to x_v and the two rings of vertices around it has, with p = c_1, q = c_2, r = 2 c_3, s = c_4, t = 2 c_5, the
//! fundamental forms
//!
//! ```text
//! I = [1 + p^2, p q; p q, 1 + q^2],    II = -[r, s; s, t] / sqrt(1 + p^2 + q^2)
//! ```
//!
//! and k1 >= k2 are the eigenvalues of I^-1 II: positive where the surface is convex as seen from the side to which the
//! normal points. The plane is scaled along the principal axes of the points, to unit variance, so that the fit is as
//! well posed on stretched triangles as on regular ones.

use nalgebra::{Cholesky, Matrix2, Matrix3, Matrix6, SymmetricEigen, Vector3, Vector6};

use super::fan::{Links, at_fans, links};
use crate::mesh::Mesh;

/// The quadric at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadric {
    /// k1 >= k2, in 1/length; NaN if there is no fit.
    pub principal: [f64; 2],
    /// The standard deviation of the curvedness sqrt((k1^2 + k2^2) / 2) of a plane whose heights have standard
    /// deviation 1, in 1/length^2.
    pub gain: f64,
}

/// Rings around a vertex that are fitted, if that is well posed.
const RINGS: usize = 2;

/// Rings around a vertex beyond which no fit is attempted.
const MAX_RINGS: usize = 4;

/// Rings do not continue behind vertices of more faces, as at the pole of a globe, so that the time stays linear.
const MAX_FACES_CROSSED: usize = 64;

/// A fit is well posed if no monomial is closer than this to a combination of the others, as a fraction of its norm.
const SMALLEST_DISTANCE: f64 = 1e-3;

/// The quadrics at the V vertices.
///
/// Vertices whose faces do not form one closed fan, such as those on the boundary, take the means of their neighbors
/// that do; NaN if there are none. So are vertices around which too few vertices determine no quadric, and those
/// without a normal.
pub fn quadrics(mesh: &Mesh) -> Vec<Quadric> {
    let (mesh, _) = mesh.without_degenerate_faces();
    let links = links(&mesh);
    let fitted = at_fans(mesh.vertices.len(), &links, || {
        let mut rings = Rings::new(mesh.vertices.len());
        let mut points = Vec::new();
        let (mesh, links) = (&mesh, &links);
        move |v, _| {
            let quadric = quadric(mesh, links, v, &mut rings, &mut points);
            quadric.map_or([f64::NAN; 3], |quadric| {
                let Quadric { principal: [k1, k2], gain } = quadric;
                [k1, k2, gain]
            })
        }
    });
    let quadric = |[k1, k2, gain]: [f64; 3]| Quadric { principal: [k1, k2], gain };
    fitted.into_iter().map(quadric).collect()
}

/// The quadric at vertex v. The last two arguments are storage.
fn quadric(
    mesh: &Mesh,
    links: &Links,
    v: usize,
    rings: &mut Rings,
    points: &mut Vec<Vector3<f64>>,
) -> Option<Quadric> {
    let x = mesh.vertices[v];
    let at = |k: u32| mesh.vertices[k as usize] - x;
    let normal: Vector3<f64> = links.at(v).iter().map(|&[a, b]| at(a).cross(&at(b))).sum();
    let normal = normal.try_normalize(0.0)?;
    rings.start(v);
    points.clear();
    for ring in 1..=MAX_RINGS {
        let more = rings.grow(links);
        points.extend(rings.outermost().iter().map(|&k| at(k)));
        if ring >= RINGS
            && let Some(quadric) = fit(points, &normal)
        {
            return Some(quadric);
        }
        if !more {
            break;
        }
    }
    None
}

/// Fits a quadric to the origin and the points; none if the fit is not well posed.
fn fit(points: &[Vector3<f64>], normal: &Vector3<f64>) -> Option<Quadric> {
    let axis = Vector3::ith(normal.iamin(), 1.0);
    let e1 = normal.cross(&axis).normalize();
    let e2 = normal.cross(&e1);
    let n = points.len() as f64 + 1.0;

    let mut moments = Matrix2::zeros();
    for point in points {
        let (x, y) = (e1.dot(point), e2.dot(point));
        moments += Matrix2::new(x * x, x * y, x * y, y * y);
    }
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(moments / n);
    // The directions along which the points are scaled, and their factors.
    let along = |i: usize| e1 * eigenvectors[(0, i)] + e2 * eigenvectors[(1, i)];
    let (e1, e2) = (along(0), along(1));
    let [g, h] = [0, 1].map(|i| eigenvalues[i].max(0.0).sqrt().recip());
    if !(g.is_finite() && h.is_finite()) {
        return None;
    }

    // The normal equations; the row of the origin is (1, 0, ..., 0), with height 0.
    let mut gram = Matrix6::zeros();
    gram[(0, 0)] = 1.0;
    let mut right = Vector6::zeros();
    for point in points {
        let (x, y) = (g * e1.dot(point), h * e2.dot(point));
        let row = Vector6::new(1.0, x, y, x * x, x * y, y * y);
        gram.ger(1.0, &row, &row, 1.0);
        right.axpy(normal.dot(point), &row, 1.0);
    }
    let cholesky = Cholesky::new(gram)?;
    let l = cholesky.l_dirty();
    // L_ii is the distance of column i to the span of the previous ones.
    if (0..6).any(|i| l[(i, i)] <= SMALLEST_DISTANCE * gram[(i, i)].sqrt()) {
        return None;
    }
    let c = cholesky.solve(&right);

    // The covariance of c_3, c_4, c_5 is that block of the inverse of L L^T.
    let inverse = l.fixed_view::<3, 3>(3, 3).lower_triangle().try_inverse()?;
    let covariance: Matrix3<f64> = inverse.transpose() * inverse;
    let [gg, gh, hh] = [g * g, g * h, h * h];
    let variance = 2.0 * covariance[(0, 0)] * gg * gg
        + covariance[(1, 1)] * gh * gh
        + 2.0 * covariance[(2, 2)] * hh * hh;
    let forms = [g * c[1], h * c[2], 2.0 * gg * c[3], gh * c[4], 2.0 * hh * c[5]];
    Some(Quadric { principal: principal_curvatures(forms), gain: variance.sqrt() })
}

/// k1 >= k2 of a graph with derivatives p, q, r, s, t.
fn principal_curvatures([p, q, r, s, t]: [f64; 5]) -> [f64; 2] {
    let w = (1.0 + p * p + q * q).sqrt();
    // I = L L^T, and L^-1 II L^-T is symmetric with the eigenvalues of I^-1 II.
    let l = (1.0 + p * p).sqrt();
    let inverse = Matrix2::new(1.0 / l, 0.0, -p * q / (l * w), l / w);
    let shape = inverse * Matrix2::new(r, s, s, t) * inverse.transpose() / -w;
    let mean = 0.5 * (shape[(0, 0)] + shape[(1, 1)]);
    let half = (0.5 * (shape[(0, 0)] - shape[(1, 1)])).hypot(shape[(0, 1)]);
    [mean + half, mean - half]
}

/// The rings of vertices around a vertex, without that vertex.
struct Rings {
    /// Number of the vertex plus one around which each vertex was last met.
    met: Vec<u32>,
    vertices: Vec<u32>,
    /// Where the outermost ring begins.
    outermost: usize,
    center: u32,
}

impl Rings {
    fn new(vertices: usize) -> Self {
        Rings { met: vec![0; vertices], vertices: Vec::new(), outermost: 0, center: 0 }
    }

    fn start(&mut self, v: usize) {
        self.center = v as u32;
        self.met[v] = self.center + 1;
        self.vertices.clear();
        self.outermost = 0;
    }

    fn outermost(&self) -> &[u32] {
        &self.vertices[self.outermost..]
    }

    /// Adds the next ring; false if it is empty.
    fn grow(&mut self, links: &Links) -> bool {
        let before = self.outermost..self.vertices.len();
        self.outermost = before.end;
        if before.end == 0 {
            self.meet(links.at(self.center as usize));
        }
        for i in before {
            let link = links.at(self.vertices[i] as usize);
            if link.len() <= MAX_FACES_CROSSED {
                self.meet(link);
            }
        }
        !self.outermost().is_empty()
    }

    fn meet(&mut self, link: &[[u32; 2]]) {
        for &k in link.as_flattened() {
            if self.met[k as usize] != self.center + 1 {
                self.met[k as usize] = self.center + 1;
                self.vertices.push(k);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{assert_within, random_rotation, random_vector, rng, shape};
    use nalgebra::Point3;
    use rand::RngExt;

    /// -1/2 times the second derivatives of z = a x^2 + b x y + c y^2 are the principal curvatures.
    fn exact([a, b, c]: [f64; 3]) -> [f64; 2] {
        let half = (a - c).hypot(b);
        [half - a - c, -half - a - c]
    }

    #[test]
    fn graphs_of_quadratics_in_the_tangent_frame_are_exact() {
        let mut rng = rng(3);
        for n in [5, 6, 9, 18, 40] {
            let stretch = [1.0, 10.0_f64.powf(rng.random_range(-3.0..0.0))];
            let [a, b, c] = [0; 3].map(|_| rng.random_range(-2.0..2.0));
            let turn = random_rotation(&mut rng);
            let points: Vec<Vector3<f64>> = (0..n)
                .map(|_| {
                    let [x, y, _] = random_vector(&mut rng).into();
                    let (x, y) = (x * stretch[0], y * stretch[1]);
                    turn * Vector3::new(x, y, a * x * x + b * x * y + c * y * y)
                })
                .collect();
            let found = fit(&points, &(turn * Vector3::z())).map(|quadric| quadric.principal);
            // 5 points and the vertex are just enough.
            for (found, exact) in found.unwrap().into_iter().zip(exact([a, b, c])) {
                assert_within(found, exact, 1e-7, 1.0);
            }
        }
    }

    /// The stencil of a grid has the symmetry of the quadric, so that its normal is exact.
    #[test]
    fn graphs_of_quadratics_are_exact_at_their_vertex() {
        for [a, b, c] in [[0.5, 0.0, 0.5], [0.0, 1.0, 0.0], [0.3, -0.2, -0.7], [1.0, 0.0, 0.0]] {
            let mut grid = shape("grid:8x8");
            for Point3 { coords: x } in &mut grid.vertices {
                x.x -= 0.5;
                x.y -= 0.5;
                x.z = a * x.x * x.x + b * x.x * x.y + c * x.y * x.y;
            }
            let [k1, k2] = quadrics(&grid)[4 * 9 + 4].principal;
            let [exact1, exact2] = exact([a, b, c]);
            assert_within(k1, exact1, 1e-13, 1.0);
            assert_within(k2, exact2, 1e-13, 1.0);
        }
    }

    /// On a tilted graph the fundamental forms must give what the surface has.
    #[test]
    fn curvatures_do_not_depend_on_the_tilt_of_the_frame() {
        // The unit sphere z = -sqrt(1 - x^2 - y^2) has p = x/w, q = y/w, r = (1 - y^2)/w^3, s = xy/w^3, ...
        for (x, y) in [(0.0, 0.0), (0.3, -0.5), (0.6, 0.6)] {
            let w = (1.0_f64 - x * x - y * y).sqrt();
            let cube = w * w * w;
            let second = [(1.0 - y * y) / cube, x * y / cube, (1.0 - x * x) / cube];
            let [k1, k2] = principal_curvatures([x / w, y / w, second[0], second[1], second[2]]);
            assert_within(k1, -1.0, 1e-14, 1.0);
            assert_within(k2, -1.0, 1e-14, 1.0);
        }
    }

    #[test]
    fn points_on_a_conic_determine_no_quadric() {
        let circle = (0..12).map(|i| {
            let (sin, cos) = f64::from(i).sin_cos();
            Vector3::new(cos - 1.0, sin, 0.1 * cos)
        });
        assert_eq!(fit(&circle.collect::<Vec<_>>(), &Vector3::z()), None);
        let line = (1..9).map(|i| Vector3::new(f64::from(i), 0.0, 0.0));
        assert_eq!(fit(&line.collect::<Vec<_>>(), &Vector3::z()), None);
        assert_eq!(fit(&[], &Vector3::z()), None);
    }

    #[test]
    fn two_rings_are_taken_and_hubs_are_not_crossed() {
        let torus = shape("torus:20x15");
        let mut rings = Rings::new(300);
        let links = links(&torus);
        for v in [0, 17, 299] {
            rings.start(v);
            for count in [6, 12, 18] {
                assert!(rings.grow(&links));
                assert_eq!(rings.outermost().len(), count);
            }
        }
        // A cone over a polygon of many corners.
        let n = 30_000;
        let corner = |i: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
            Point3::new(cos, sin, 0.0)
        };
        let vertices =
            (0..n).map(corner).chain([Point3::new(0.0, 0.0, 1.0), Point3::new(0.0, 0.0, -1.0)]);
        let sides = (0..n).flat_map(|i| [[i, (i + 1) % n, n], [(i + 1) % n, i, n + 1]]);
        let spindle = Mesh::new(vertices.collect(), sides.collect());
        assert_eq!(quadrics(&spindle).len(), n as usize + 2);
    }
}
