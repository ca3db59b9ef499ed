//! Images projected onto a surface: texture coordinates from positions.
//!
//! **Plane.** One axis runs along the width of the image, one along its height, and the image covers the bounding box
//! of the surface: either it keeps its aspect ratio and is cropped at both ends of the longer side, or it is stretched.
//! Parts of the surface behind others get the same colors. **Cylinder, sphere.** The image goes once around an axis
//! through the center of the box, u = 1/2 + angle / 2 pi, and is stretched from one end to the other: v runs over the
//! height, or is 1/2 + latitude / pi.

use std::fmt;
use std::str::FromStr;

use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::charts::{around, latitude};
use crate::sweep;

/// The x, y or z axis, or its opposite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    index: usize,
    reversed: bool,
}

/// How an image is projected onto a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Along the third axis; parts of the surface behind others get the same colors.
    Plane {
        /// The axis along which u grows, the width of the image.
        across: Axis,
        /// The axis along which v grows, the height of the image; not parallel to `across`.
        up: Axis,
    },
    /// Once around this axis; v runs from 0 to 1 along it, over the bounding box.
    Cylinder(Axis),
    /// Once around this axis; v runs from 0 to 1 with the latitude, seen from the center of the bounding box.
    Sphere(Axis),
}

/// How an image fills a box of another aspect ratio. Cylinder and sphere always stretch it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Fit {
    /// The image keeps its aspect ratio and is cropped at both ends of its longer side. The default.
    #[default]
    Cover,
    /// The whole image is visible, with the aspect ratio of the box.
    Stretch,
}

/// The texture coordinates of a projected image, and a description.
pub struct Projected {
    /// The texture coordinates of the corners of each face, F triples; v upwards.
    pub uv: Vec<[[f64; 2]; 3]>,
    /// A description: the size of the image, the projection, and what was cropped or distorted.
    pub description: String,
}

impl Projection {
    /// The forms that [`Projection::from_str`] takes.
    pub const SYNTAX: &str = "xy, xz, yz, two axes such as x,-z (along the width, up), cylinder or sphere (around z; \
                              around another axis as cylinder:y)";

    /// The projection for surfaces in the plane z = 0.
    pub const XY: Projection = Projection::Plane { across: X, up: Y };

    /// Projects an image of `size` pixels (width, height) onto a mesh.
    ///
    /// Fails if the mesh has no extent along an axis of the image.
    pub fn project(self, mesh: &Mesh, size: [u32; 2], fit: Fit) -> Result<Projected> {
        let bounds = Bounds::of(mesh);
        let [width, height] = size;
        let (uv, how) = match self {
            Projection::Plane { across, up } => {
                let extent = [bounds.extent(across)?, bounds.extent(up)?];
                let ratio = (f64::from(width) / f64::from(height)) / (extent[0] / extent[1]);
                let shown = fit.shown(ratio);
                let loss = fit.loss(ratio, shown);
                (
                    plane(mesh, &bounds, [across, up], extent, shown),
                    format!("projected onto {self}{loss}"),
                )
            }
            Projection::Cylinder(axis) => {
                let extent = bounds.extent(axis)?;
                let uv = cylinder(mesh, &bounds, axis, extent);
                (uv, format!("wrapped around {axis} as a cylinder"))
            }
            Projection::Sphere(axis) => {
                (sphere(mesh, &bounds, axis), format!("wrapped around {axis} as a sphere"))
            }
        };
        Ok(Projected { uv, description: format!("image {width} x {height} {how}") })
    }
}

impl Fit {
    /// The fractions of the image's width and height that are inside the box; `ratio` is the aspect ratio of the image
    /// divided by that of the box.
    fn shown(self, ratio: f64) -> [f64; 2] {
        match self {
            Fit::Cover => [1.0_f64.min(1.0 / ratio), 1.0_f64.min(ratio)],
            Fit::Stretch => [1.0; 2],
        }
    }

    /// A description of how the image is cropped or distorted.
    fn loss(self, ratio: f64, shown: [f64; 2]) -> String {
        let hidden = |side: &str, shown: f64| {
            // Enough digits to tell it from 100 %.
            let digits = (-(100.0 * shown).log10()).ceil().max(1.0) as usize;
            format!(", {:.digits$} % of its {side} cropped", 100.0 * (1.0 - shown))
        };
        match self {
            Fit::Stretch if ratio > 1.0 => {
                format!(", stretched by a factor of {ratio:.2} in height")
            }
            Fit::Stretch => format!(", stretched by a factor of {:.2} in width", 1.0 / ratio),
            Fit::Cover if shown[0] < 0.9995 => hidden("width", shown[0]),
            Fit::Cover if shown[1] < 0.9995 => hidden("height", shown[1]),
            Fit::Cover => String::new(),
        }
    }
}

/// The positions of the corners of face j.
fn corners(mesh: &Mesh, j: usize) -> [[f64; 3]; 3] {
    mesh.corners(j).map(|x| [x.x, x.y, x.z])
}

fn plane(
    mesh: &Mesh,
    bounds: &Bounds,
    axes: [Axis; 2],
    extent: [f64; 2],
    shown: [f64; 2],
) -> Vec<[[f64; 2]; 3]> {
    sweep::collect(mesh.faces.len(), |j| {
        corners(mesh, j).map(|x| {
            let [s, t] = [0, 1].map(|i| bounds.along(axes[i], extent[i], x));
            [0.5 + shown[0] * (s - 0.5), 0.5 + shown[1] * (t - 0.5)]
        })
    })
}

fn cylinder(mesh: &Mesh, bounds: &Bounds, axis: Axis, extent: f64) -> Vec<[[f64; 2]; 3]> {
    let frame = axis.frame();
    sweep::collect(mesh.faces.len(), |j| {
        let corners = corners(mesh, j);
        let turns = around(corners.map(|x| {
            let [x, y, _] = bounds.relative_to_center(frame, x);
            [x, y]
        }));
        std::array::from_fn(|i| [turns[i], bounds.along(axis, extent, corners[i])])
    })
}

fn sphere(mesh: &Mesh, bounds: &Bounds, axis: Axis) -> Vec<[[f64; 2]; 3]> {
    let frame = axis.frame();
    sweep::collect(mesh.faces.len(), |j| {
        let corners = corners(mesh, j).map(|x| bounds.relative_to_center(frame, x));
        let turns = around(corners.map(|[x, y, _]| [x, y]));
        std::array::from_fn(|i| [turns[i], latitude(corners[i])])
    })
}

/// The bounding box of the faces.
struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl Bounds {
    fn of(mesh: &Mesh) -> Self {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for &k in mesh.faces.as_flattened() {
            let x = mesh.vertices[k as usize];
            for i in 0..3 {
                low[i] = low[i].min(x[i]);
                high[i] = high[i].max(x[i]);
            }
        }
        Bounds { low, high }
    }

    /// The length of the box along an axis.
    fn extent(&self, axis: Axis) -> Result<f64> {
        let lengths = [0, 1, 2].map(|i| self.high[i] - self.low[i]);
        let longest = lengths.into_iter().fold(0.0, f64::max);
        let extent = lengths[axis.index];
        if extent > 1e-9 * longest {
            Ok(extent)
        } else {
            Err(Error::unsuitable(format!(
                "has no extent along {}; choose another --project: {}",
                AXIS_NAMES[axis.index],
                Projection::SYNTAX
            )))
        }
    }

    /// A position along an axis, 0 to 1 in the box.
    fn along(&self, axis: Axis, extent: f64, x: [f64; 3]) -> f64 {
        let t = (x[axis.index] - self.low[axis.index]) / extent;
        if axis.reversed { 1.0 - t } else { t }
    }

    /// A point relative to the center of the box, along three axes.
    fn relative_to_center(&self, frame: [Axis; 3], x: [f64; 3]) -> [f64; 3] {
        frame.map(|Axis { index, reversed }| {
            let t = x[index] - 0.5 * (self.low[index] + self.high[index]);
            if reversed { -t } else { t }
        })
    }
}

const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];
const X: Axis = Axis { index: 0, reversed: false };
const Y: Axis = Axis { index: 1, reversed: false };
const Z: Axis = Axis { index: 2, reversed: false };

impl Axis {
    /// The right-handed frame with this axis as its third.
    fn frame(self) -> [Axis; 3] {
        let [a, b] = [1, 2].map(|i| Axis { index: (self.index + i) % 3, reversed: false });
        if self.reversed { [b, a, self] } else { [a, b, self] }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}{}", if self.reversed { "-" } else { "" }, AXIS_NAMES[self.index])
    }
}

impl FromStr for Axis {
    type Err = ();

    fn from_str(text: &str) -> std::result::Result<Self, ()> {
        let (reversed, name) = match text.strip_prefix('-') {
            Some(name) => (true, name),
            None => (false, text.strip_prefix('+').unwrap_or(text)),
        };
        let index = AXIS_NAMES.iter().position(|known| name == *known).ok_or(())?;
        Ok(Axis { index, reversed })
    }
}

impl fmt::Display for Projection {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Projection::Plane { across, up } if !across.reversed && !up.reversed => {
                write!(f, "{across}{up}")
            }
            Projection::Plane { across, up } => write!(f, "{across},{up}"),
            Projection::Cylinder(axis) => write!(f, "cylinder:{axis}"),
            Projection::Sphere(axis) => write!(f, "sphere:{axis}"),
        }
    }
}

impl FromStr for Projection {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let plane = |across: &str, up: &str| {
            let (across, up): (Axis, Axis) = (across.parse().ok()?, up.parse().ok()?);
            (across.index != up.index).then_some(Projection::Plane { across, up })
        };
        let projection = match text.split_once([':', ',']) {
            Some(("cylinder", axis)) => axis.parse().ok().map(Projection::Cylinder),
            Some(("sphere", axis)) => axis.parse().ok().map(Projection::Sphere),
            Some((across, up)) => plane(across, up),
            None if text == "cylinder" => Some(Projection::Cylinder(Z)),
            None if text == "sphere" => Some(Projection::Sphere(Z)),
            None if text.is_char_boundary(1) => plane(&text[..1], &text[1..]),
            None => None,
        };
        projection.ok_or_else(|| format!("must be {}", Projection::SYNTAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Mesh {
        "grid:4x2".parse::<crate::mesh::Shape>().unwrap().mesh()
    }

    fn project(text: &str, mesh: &Mesh, size: [u32; 2], fit: Fit) -> Projected {
        text.parse::<Projection>().unwrap().project(mesh, size, fit).unwrap()
    }

    #[test]
    fn names_go_both_ways() {
        for text in ["xy", "zx", "x,-z", "-y,z", "cylinder:z", "cylinder:-y", "sphere:x"] {
            assert_eq!(text.parse::<Projection>().unwrap().to_string(), text);
        }
        for (text, same) in [("x,z", "xz"), ("+x,z", "xz"), ("sphere", "sphere:z")] {
            assert_eq!(text.parse::<Projection>().unwrap().to_string(), same);
        }
        for text in ["", "x", "xx", "x,-x", "xyz", "é", "cylinder:", "cube", "x,y,z", "-xy"] {
            assert!(text.parse::<Projection>().unwrap_err().contains("x,-z"), "{text}");
        }
    }

    /// The box is 1 x 1/2; an image twice as wide as high fits, a square one loses half of its height at the two ends.
    #[test]
    fn the_image_covers_the_box_in_its_own_aspect() {
        let mesh = grid();
        let point = |projected: &Projected, j: usize| projected.uv[j][0];
        let fits = project("xy", &mesh, [8, 4], Fit::Cover);
        assert_eq!((point(&fits, 0), fits.uv[15][1]), ([0.0, 0.0], [1.0, 1.0]));
        assert_eq!(fits.description, "image 8 x 4 projected onto xy");
        let square = project("xy", &mesh, [4, 4], Fit::Cover);
        assert_eq!((point(&square, 0), square.uv[15][1]), ([0.0, 0.25], [1.0, 0.75]));
        assert!(
            square.description.ends_with("50.0 % of its height cropped"),
            "{}",
            square.description
        );
        let wide = project("xy", &mesh, [16, 4], Fit::Cover);
        assert_eq!((point(&wide, 0), wide.uv[15][1]), ([0.25, 0.0], [0.75, 1.0]));
        assert!(wide.description.ends_with("50.0 % of its width cropped"), "{}", wide.description);
        let sliver = project("xy", &mesh, [50_000, 2], Fit::Cover);
        assert!(
            sliver.description.ends_with("99.992 % of its width cropped"),
            "{}",
            sliver.description
        );
        let stretched = project("xy", &mesh, [4, 4], Fit::Stretch);
        assert_eq!(point(&stretched, 0), [0.0, 0.0]);
        assert!(stretched.description.ends_with("stretched by a factor of 2.00 in width"));
        let flipped = project("-x,y", &mesh, [8, 4], Fit::Cover);
        assert_eq!(point(&flipped, 0), [1.0, 0.0]);
    }

    #[test]
    fn an_image_needs_an_extent() {
        let mesh = grid();
        for (text, axis) in [("xz", "along z"), ("zy", "along z"), ("cylinder", "along z")] {
            let projection: Projection = text.parse().unwrap();
            let error = projection.project(&mesh, [1, 1], Fit::Cover).err().unwrap().to_string();
            assert!(error.contains(axis) && error.contains("--project"), "{error}");
        }
    }

    /// Around the axis of a sphere the projection is its own chart, whatever the scale.
    #[test]
    fn around_a_sphere_it_is_the_chart() {
        let shape: crate::mesh::Shape = "sphere:3".parse().unwrap();
        let (expected, mesh) = (shape.textured().uv.unwrap(), shape.mesh().scaled(1e4));
        let around_sphere = project("sphere", &mesh, [2, 1], Fit::Cover);
        for (a, b) in expected.iter().zip(&around_sphere.uv) {
            for (a, b) in a.as_flattened().iter().zip(b.as_flattened()) {
                assert!((a - b).abs() < 1e-12);
            }
        }
        let cylinder = project("cylinder", &mesh, [2, 1], Fit::Cover);
        for (j, uv) in cylinder.uv.iter().enumerate() {
            for (x, [u, v]) in mesh.corners(j).iter().zip(uv) {
                assert!((v - (0.5 + 0.5 * x.z / 1e4)).abs() < 1e-12);
                if x.x.hypot(x.y) > 1.0 {
                    let turn = 0.5 + x.y.atan2(x.x) / std::f64::consts::TAU - u;
                    assert!((turn - turn.round()).abs() < 1e-12);
                }
            }
        }
        // Seen from the side, left and right are not swapped whichever end of the axis is up.
        assert_eq!(Axis { index: 2, reversed: true }.frame().map(|axis| axis.index), [1, 0, 2]);
    }
}
