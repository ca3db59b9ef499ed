//! Closed surfaces r(d) d of the directions d, with known volumes: truths for surfaces from views.
//!
//! | shape | point in the direction d = (x, y, z) | volume |
//! |---|---|---|
//! | ellipsoid | (x, 0.8 y, 0.6 z) | 4 pi / 3 a b c, a = 1, b = 0.8, c = 0.6 |
//! | peanut | (a + b x^2) d, a = 0.55, b = 0.45 | 4 pi / 3 (a^3 + a^2 b + 3/5 a b^2 + b^3 / 7) |
//! | dent | (1 - c max(0, 2 z - 1)^2) d, c = 0.55 | 2 pi / 3 (2 - c / 2 + 3/10 c^2 - c^3 / 14) |
//!
//! The peanut has a waist, since b > a / 2. The dent is a pit in the sphere: its rim is at z = 0.65 and its bottom at
//! z = 0.45, so that no line through a point below the rim misses the body, and no silhouette shows the pit.

use nalgebra::{Point3, Vector3};
use strum::{EnumString, IntoStaticStr};

/// A kind of such a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Star {
    /// With the half axes 1, 0.8 and 0.6.
    Ellipsoid,
    /// Two bulges along x.
    Peanut,
    /// A sphere with a pit around z that silhouettes do not see.
    Dent,
}

impl Star {
    /// The point in a direction of length 1.
    pub fn point(self, d: Vector3<f64>) -> Point3<f64> {
        match self {
            Star::Ellipsoid => Point3::new(d.x, 0.8 * d.y, 0.6 * d.z),
            Star::Peanut => ((0.55 + 0.45 * d.x * d.x) * d).into(),
            Star::Dent => ((1.0 - 0.55 * (2.0 * d.z - 1.0).max(0.0).powi(2)) * d).into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::views::{Ball, around};
    use crate::mesh::{Mesh, Statistics};
    use crate::optics::zbuffer::ZBuffer;
    use crate::samples::{observed_order, shape};
    use std::f64::consts::PI;

    fn volume(mesh: &Mesh) -> f64 {
        let part = |j: usize| {
            let [a, b, c] = mesh.corners(j).map(|x| x.coords);
            a.dot(&b.cross(&c)) / 6.0
        };
        (0..mesh.faces.len()).map(part).sum()
    }

    #[test]
    fn volumes_converge_with_order_2() {
        let (a, b, c): (f64, f64, f64) = (0.55, 0.45, 0.55);
        let peanut = a.powi(3) + a * a * b + 0.6 * a * b * b + b.powi(3) / 7.0;
        let dent = 2.0 - c / 2.0 + 0.3 * c * c - c.powi(3) / 14.0;
        let volumes = [
            ("ellipsoid", 4.0 / 3.0 * PI * 0.48),
            ("peanut", 4.0 / 3.0 * PI * peanut),
            ("dent", 2.0 / 3.0 * PI * dent),
        ];
        for (name, exact) in volumes {
            let levels = [3, 4, 5];
            let errors = levels.map(|level| {
                let mesh = shape(&format!("{name}:{level}"));
                let found = Statistics::of(&mesh);
                assert_eq!((found.euler_characteristic, found.inconsistent_edges), (2, 0));
                (volume(&mesh) - exact).abs()
            });
            let order = observed_order(&levels.map(|level| 0.5_f64.powi(level)), &errors);
            assert!((order - 2.0).abs() < 0.1, "{name}: {order} {errors:?}");
        }
    }

    /// The waist is a saddle: a plane through the axis cuts it in a curve that bends away from the axis.
    #[test]
    fn the_peanut_has_a_waist() {
        let at = |angle: f64| Star::Peanut.point(Vector3::new(angle.sin(), angle.cos(), 0.0));
        assert!(at(0.5).y > at(0.0).y && (at(0.0).y - 0.55).abs() <= 1e-15);
        assert!((at(PI / 2.0).x - 1.0).abs() <= 1e-15);
    }

    /// The silhouettes are those of the body whose pit is filled up to the rim.
    #[test]
    fn silhouettes_do_not_show_the_pit() {
        let dent = shape("dent:5");
        let rim = dent.vertices.iter().map(|x| x.z).fold(0.0, f64::max);
        assert!((0.64..0.66).contains(&rim), "{rim}");
        let bottom = dent.vertices.iter().filter(|x| x.x.hypot(x.y) < 0.02).map(|x| x.z);
        assert!((bottom.fold(0.0, f64::max) - 0.45).abs() < 0.01);
        let mut filled = dent.clone();
        let radius = dent.vertices.iter().filter(|x| x.z == rim).map(|x| x.x.hypot(x.y));
        let radius = radius.fold(0.0, f64::max);
        for x in filled.vertices.iter_mut().filter(|x| x.z > 0.0 && x.x.hypot(x.y) < radius) {
            x.z = rim;
        }
        assert!(volume(&filled) > volume(&dent) + 0.03);
        let ball = Ball { center: Point3::origin(), radius: 1.0 };
        let (mut different, mut all) = (0, 0);
        for view in around(&ball, 24, 4.0, [160, 120]).unwrap() {
            let of = |mesh| ZBuffer::new(mesh, &view.camera, [160, 120], 1);
            let (dent, filled) = (of(&dent), of(&filled));
            for sample in 0..160 * 120 {
                different +=
                    u32::from(dent.face(sample).is_some() != filled.face(sample).is_some());
                all += u32::from(filled.face(sample).is_some());
            }
        }
        assert!(f64::from(different) < 2e-4 * f64::from(all), "{different} of {all}");
    }
}
