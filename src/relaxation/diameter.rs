//! The largest sum of <q_p, g_p> over points q_p of the plane whose diameter is at most 1, for vectors g_p that sum to zero.
//!
//! Points of diameter at most 1 lie in a body of constant width 1, and a body has the support function h = 1/2 + k with
//! k(t + pi) = -k(t) and |k + k''| <= 1/2. So the largest sum is that of |g_p| h(t_p), with t_p the direction of g_p. Let P be
//! the convex polygon whose edges have the lengths |g_p| and the normals g_p; its support function has h_P + h_P'' = sum |g_p|
//! delta(t_p). Hence
//!
//! ```text
//! sum |g_p| k(t_p) = int_0^pi ( h_P(t) - h_P(t + pi) ) (k + k'')(t) dt
//! max sum <q_p, g_p> = 1/2 ( sum_p |g_p| + min_x int_0^pi | <a(t) - x, e(t)> | dt )
//! ```
//!
//! with e(t) = (cos t, sin t) and a(t) the sum of the two vertices of P at which <., e(t)> is largest and smallest; x is the
//! multiplier of int (k + k'') e = 0. a(t) jumps by J g_p, J the rotation by a right angle, where t passes the direction of g_p or
//! -g_p. The integral is convex in x, and every x gives an upper bound. For three vectors, the sum is that of the distances
//! of the corners of P from its Fermat point.
//!
//! Bodies of constant width: T. Bonnesen, W. Fenchel, *Theorie der konvexen Körper*, 1934, section 15.

use crate::field::Tangent;

type Vector = [f64; 2];

/// Newton's method ends when the next step can lower the integral by no more than this, in units of sum |g_p|.
const ACCURACY: f64 = 1e-14;

/// The largest number of steps.
const MAX_STEPS: usize = 50;

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// J a.
fn turned([x, y]: Vector) -> Vector {
    [-y, x]
}

/// The sum, from above; exact up to about 1e-14 of sum |g_p|.
pub fn support<const M: usize>(g: Tangent<M>) -> f64 {
    let Tangent([gx, gy]) = g;
    let (mut vectors, mut directions) = ([[0.0; 2]; M], [[0.0; 2]; M]);
    let (mut n, mut length) = (0, 0.0);
    for p in 0..M {
        let vector = [gx.0[p], gy.0[p]];
        let norm = dot(vector, vector).sqrt();
        length += norm;
        if norm > 0.0 {
            // The direction of g_p or -g_p in [0, pi), which fall from left to right with their first coordinate.
            let flipped = vector[1] < 0.0 || vector[1] == 0.0 && vector[0] < 0.0;
            let scale = if flipped { -1.0 } else { 1.0 } / norm;
            let direction = [vector[0] * scale, vector[1] * scale];
            let mut i = n;
            while i > 0 && dot(turned(direction), directions[i - 1]) > 0.0 {
                (directions[i], vectors[i]) = (directions[i - 1], vectors[i - 1]);
                i -= 1;
            }
            (directions[i], vectors[i]) = (direction, vector);
            n += 1;
        }
    }
    if n <= 2 || !length.is_finite() {
        return 0.5 * length;
    }
    let mut corner = [0.0; 2];
    for vector in &mut vectors[..n] {
        let edge = turned(*vector);
        corner = [corner[0] + edge[0], corner[1] + edge[1]];
        *vector = corner;
    }
    let asymmetry = Asymmetry { corners: &vectors[..n], directions: &directions[..n] };
    0.5 * (length + asymmetry.least(length))
}

/// int_0^pi | <a(t) - x, e(t)> | dt.
struct Asymmetry<'a> {
    /// a(t) between the i-th direction and the next one.
    corners: &'a [Vector],
    /// e(t) where a(t) jumps, by increasing t; after the last comes the opposite of the first.
    directions: &'a [Vector],
}

/// The integral as a function of x, with its derivatives.
#[derive(Clone, Copy)]
struct At {
    value: f64,
    gradient: Vector,
    /// The entries xx, xy and yy.
    curvature: [f64; 3],
}

impl Asymmetry<'_> {
    /// The directions where the i-th interval of t begins and ends.
    fn ends(&self, i: usize) -> [Vector; 2] {
        match self.directions.get(i + 1) {
            Some(&end) => [self.directions[i], end],
            None => [self.directions[i], self.directions[0].map(|x| -x)],
        }
    }

    /// The integral over all intervals but one.
    fn without(&self, omitted: usize, x: Vector) -> At {
        let mut sum = At { value: 0.0, gradient: [0.0; 2], curvature: [0.0; 3] };
        for (i, &corner) in self.corners.iter().enumerate() {
            if i != omitted {
                let at = piece([corner[0] - x[0], corner[1] - x[1]], self.ends(i));
                sum.value += at.value;
                for axis in 0..2 {
                    // With respect to x, not to c.
                    sum.gradient[axis] -= at.gradient[axis];
                }
                for k in 0..3 {
                    sum.curvature[k] += at.curvature[k];
                }
            }
        }
        sum
    }

    fn at(&self, x: Vector) -> At {
        self.without(usize::MAX, x)
    }

    /// The minimum over x, from above. `length` is sum |g_p|. There are kinks at the corners, so the search starts below all of
    /// them.
    fn least(&self, length: f64) -> f64 {
        let values = self.corners.iter().map(|&corner| self.at(corner).value).enumerate();
        let lowest = values.min_by(|a, b| a.1.total_cmp(&b.1));
        let (corner, value) = lowest.expect("there are at least three");
        let (direction, slope) = self.descent(corner);
        if slope >= -ACCURACY {
            return value;
        }
        match self.descend(
            self.corners[corner],
            value,
            direction.map(|x| x * length),
            length * slope,
        ) {
            Some((x, at)) => self.minimized(x, at, length),
            None => value,
        }
    }

    /// The unit vector in which the integral falls fastest from a corner, and its slope there. The interval of the corner
    /// contributes the integral of |<v, e(t)>|, which is linear, or 2 |v| and a linear term, for directions v between those that
    /// are perpendicular to its ends.
    fn descent(&self, corner: usize) -> (Vector, f64) {
        let gradient = self.without(corner, self.corners[corner]).gradient;
        let ends @ [begin, end] = self.ends(corner);
        let (j_begin, j_end) = (turned(begin), turned(end));
        let difference = [j_begin[0] - j_end[0], j_begin[1] - j_end[1]];
        let sum = [j_begin[0] + j_end[0], j_begin[1] + j_end[1]];
        let mut best = ([0.0; 2], f64::INFINITY);
        for sign in [1.0, -1.0] {
            let steepest = |term: Vector| [0, 1].map(|i| -gradient[i] + sign * term[i]);
            for v in [
                j_begin.map(|x| sign * x),
                j_end.map(|x| sign * x),
                steepest(difference),
                steepest(sum),
            ] {
                let norm = dot(v, v).sqrt();
                let v = v.map(|x| x / norm);
                let slope = dot(gradient, v) + piece(v, ends).value;
                if slope < best.1 {
                    best = (v, slope);
                }
            }
        }
        best
    }

    /// A point on the way from x by `step` where the integral is lower by a tenth of what its slope promises.
    fn descend(&self, x: Vector, value: f64, step: Vector, slope: f64) -> Option<(Vector, At)> {
        let mut share = 1.0;
        while share > 1e-16 {
            let to = [x[0] + share * step[0], x[1] + share * step[1]];
            let at = self.at(to);
            if at.value <= value + 0.1 * share * slope {
                return Some((to, at));
            }
            share *= 0.5;
        }
        None
    }

    /// Newton's method from x.
    fn minimized(&self, mut x: Vector, mut now: At, length: f64) -> f64 {
        for _ in 0..MAX_STEPS {
            let [g1, g2] = now.gradient;
            let [h11, h12, h22] = now.curvature;
            // Where the integral is not strictly convex, steps are at most about `length`.
            let least = dot(now.gradient, now.gradient).sqrt() / length;
            let (h11, h22) = (h11 + least, h22 + least);
            let determinant = h11 * h22 - h12 * h12;
            let step = [(h12 * g2 - h22 * g1) / determinant, (h12 * g1 - h11 * g2) / determinant];
            let slope = dot(step, now.gradient);
            if slope >= -ACCURACY * length || slope.is_nan() {
                break;
            }
            match self.descend(x, now.value, step, slope) {
                Some(next) => (x, now) = next,
                None => break,
            }
        }
        now.value
    }
}

/// int | <c, e(t)> | dt between two directions, as a function of c.
fn piece(c: Vector, [first, last]: [Vector; 2]) -> At {
    let (begin, end) = (dot(c, first), dot(c, last));
    // <J c, e> = -<c, J e> is an antiderivative of <c, e>.
    let (first, last) = (turned(first), turned(last));
    let (at_first, at_last) = (-dot(c, first), -dot(c, last));
    if begin * end < 0.0 {
        // <c, e> vanishes in between, where the antiderivative is |c| or -|c|.
        let (norm, sign) = (dot(c, c).sqrt(), begin.signum());
        let unit = [c[0] / norm, c[1] / norm];
        let scale = 2.0 / norm;
        At {
            value: 2.0 * norm - sign * (at_first + at_last),
            gradient: [0, 1].map(|i| 2.0 * unit[i] + sign * (first[i] + last[i])),
            curvature: [
                scale * unit[1] * unit[1],
                -scale * unit[0] * unit[1],
                scale * unit[0] * unit[0],
            ],
        }
    } else {
        let sign = (at_last - at_first).signum();
        At {
            value: sign * (at_last - at_first),
            gradient: [0, 1].map(|i| sign * (first[i] - last[i])),
            curvature: [0.0; 3],
        }
    }
}
