//! Points and lines on an image plane.

/// A vertex on the image plane.
#[derive(Clone, Copy, Debug)]
pub struct Projected {
    /// In pixels: x to the right, y down.
    pub x: f64,
    pub y: f64,
    /// Reciprocal of the distance along the optical axis; linear over the image of a plane, larger is nearer.
    pub w: f64,
}

/// The edge function of a line a b: at (x, y), twice the signed area of the triangle it forms with a and b. Bitwise
/// antisymmetric in a and b, so that no sample on a shared edge falls between its two faces.
pub struct Edge {
    start: Projected,
    pub dx: f64,
    pub dy: f64,
}

impl Edge {
    #[inline(always)]
    pub fn new(a: &Projected, b: &Projected) -> Self {
        // Both directions start from the same end; (dx, dy) keeps the sign.
        let start = if (a.x, a.y) < (b.x, b.y) { *a } else { *b };
        Edge { start, dx: b.x - a.x, dy: b.y - a.y }
    }

    #[inline(always)]
    pub fn at(&self, x: f64, y: f64) -> f64 {
        self.on_row(self.row_term(y), x)
    }

    /// The part of the value that is constant along a scanline.
    #[inline(always)]
    pub fn row_term(&self, y: f64) -> f64 {
        self.dx * (y - self.start.y)
    }

    /// The value at x on the scanline with that constant part.
    #[inline(always)]
    pub fn on_row(&self, row_term: f64, x: f64) -> f64 {
        row_term - self.dy * (x - self.start.x)
    }

    /// Where the line crosses the scanline with that constant part, up to rounding; infinite or NaN if it is parallel.
    #[inline(always)]
    pub fn crossing(&self, row_term: f64) -> f64 {
        self.start.x + row_term / self.dy
    }

    /// The same line, positive inside a face of this signed area.
    #[inline(always)]
    pub fn oriented(self, area: f64) -> Self {
        let sign = area.signum();
        Edge { start: self.start, dx: sign * self.dx, dy: sign * self.dy }
    }
}

/// The edges opposite to the three corners, and twice the signed area.
#[inline(always)]
pub fn edges([a, b, c]: &[Projected; 3]) -> ([Edge; 3], f64) {
    let edges = [Edge::new(b, c), Edge::new(c, a), Edge::new(a, b)];
    let area = edges[2].at(c.x, c.y);
    (edges, area)
}
