//! Silhouettes of views, and how well a surface fills them.

use serde::Serialize;

use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;
use crate::optics::zbuffer::ZBuffer;
use crate::sweep;

/// The pixels of a view that show the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Silhouette {
    /// From the units of the mesh to pixels.
    pub camera: Pinhole,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Row by row.
    pub inside: Vec<bool>,
}

impl Silhouette {
    /// The silhouette of a mesh: the pixels whose centers see it.
    pub fn of(mesh: &Mesh, camera: &Pinhole, size: [usize; 2]) -> Self {
        let zbuffer = ZBuffer::new(mesh, camera, size, 1);
        let inside = (0..size[0] * size[1]).map(|pixel| zbuffer.face(pixel).is_some()).collect();
        Silhouette { camera: *camera, size, inside }
    }
}

/// Numbers of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Overlap {
    /// In both silhouettes.
    pub both: u64,
    /// In one of them, or in both.
    pub either: u64,
}

impl Overlap {
    /// Intersection over union; 1 if both are empty.
    pub fn iou(&self) -> f64 {
        if self.either == 0 { 1.0 } else { self.both as f64 / self.either as f64 }
    }
}

/// How the silhouettes of a mesh overlap given ones, one per view.
pub fn overlaps(mesh: &Mesh, silhouettes: &[Silhouette]) -> Vec<Overlap> {
    sweep::results(silhouettes.iter().collect(), |given: &Silhouette| {
        let own = Silhouette::of(mesh, &given.camera, given.size);
        let mut overlap = Overlap::default();
        for (&a, &b) in own.inside.iter().zip(&given.inside) {
            overlap.both += u64::from(a && b);
            overlap.either += u64::from(a || b);
        }
        overlap
    })
}

/// The pixels of all views together.
pub fn overlap(mesh: &Mesh, silhouettes: &[Silhouette]) -> Overlap {
    overlaps(mesh, silhouettes).into_iter().fold(Overlap::default(), |sum, view| Overlap {
        both: sum.both + view.both,
        either: sum.either + view.either,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::views::{Ball, around};
    use crate::samples::shape;
    use nalgebra::Point3;

    /// Disks around the middle of the image have areas like the squares of their radii.
    #[test]
    fn overlaps_of_concentric_spheres_are_ratios_of_disks() {
        let ball = Ball { center: Point3::origin(), radius: 1.0 };
        let views = around(&ball, 5, 4.0, [320, 240]).unwrap();
        let sphere = shape("sphere:5");
        let of = |mesh: &Mesh| -> Vec<Silhouette> {
            views.iter().map(|view| Silhouette::of(mesh, &view.camera, [320, 240])).collect()
        };
        let whole = of(&sphere);
        assert_eq!(overlap(&sphere, &whole).iou(), 1.0);
        let small = sphere.scaled(0.8);
        // A sphere of radius r has a contour of radius f r / sqrt(16 - r^2).
        let exact = 0.64 * 15.0 / (16.0 - 0.64);
        for view in overlaps(&small, &whole) {
            assert!((view.iou() - exact).abs() <= 3e-3, "{} {exact}", view.iou());
        }
        let all = overlap(&small, &whole);
        assert_eq!(all, overlap(&shape("sphere:5"), &of(&small)));
        assert_eq!(
            all.both,
            of(&small).iter().flat_map(|s| &s.inside).filter(|&&s| s).count() as u64
        );
    }

    #[test]
    fn empty_silhouettes_agree() {
        let view =
            &around(&Ball { center: Point3::origin(), radius: 1.0 }, 1, 4.0, [9, 9]).unwrap()[0];
        let mut far = shape("sphere:1");
        far.vertices.iter_mut().for_each(|x| x.x += 1e3);
        let none = Silhouette::of(&far, &view.camera, [9, 9]);
        assert!(none.inside.iter().all(|inside| !inside));
        assert_eq!(overlap(&far, &[none]).iou(), 1.0);
    }
}
