//! The labels of a surface against those of the true surface.

use super::scene::Truth;
use crate::agreement::Agreement;
use crate::error::Result;
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::tree::{Nearest, Tree};
use crate::sweep;

/// The true surface, in which the nearest point is found.
pub struct TrueLabels {
    tree: Tree,
    faces: Vec<[u32; 3]>,
    labels: Vec<usize>,
}

impl TrueLabels {
    /// `None` if the labels are not known, or there is only one.
    pub fn new(truth: &Truth) -> Option<Self> {
        let (labels, colors) = truth.regions.as_ref()?;
        if colors.len() < 2 {
            return None;
        }
        let (mesh, _) = truth.mesh.without_degenerate_faces();
        Some(TrueLabels {
            tree: Tree::new(&mesh),
            faces: mesh.faces.clone(),
            labels: labels.clone(),
        })
    }

    /// The share of the area of a surface with given labels whose label is not that of the nearest point of the truth, under
    /// the best matching of regions. Inside a face of the truth the label is that of the nearest corner, as in
    /// photographs.
    ///
    /// # Errors
    /// The surface has no area.
    pub fn mislabeled(&self, mesh: &Mesh, labels: &[usize]) -> Result<f64> {
        let truth = sweep::collect(mesh.vertices.len(), |k| {
            let Nearest { face, weights, .. } = self.tree.nearest(mesh.vertices[k]);
            let corner =
                (1..3).fold(0, |best, a| if weights[a] > weights[best] { a } else { best });
            self.labels[self.faces[face][corner] as usize] as i64
        });
        let labels: Vec<i64> = labels.iter().map(|&label| label as i64).collect();
        Ok(1.0 - Agreement::new(&labels, &truth, &barycentric_areas(mesh))?.accuracy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colormap::categorical;
    use crate::samples::shape;

    /// On the truth itself nothing is wrong, whatever the names of the regions; elsewhere the share of the area is.
    #[test]
    fn labels_are_those_of_the_nearest_point() {
        let mesh = shape("sphere:4");
        let half: Vec<usize> = mesh.vertices.iter().map(|x| usize::from(x.z > 0.0)).collect();
        let colors = vec![categorical(0), categorical(1)];
        let truth = Truth { mesh: mesh.clone(), regions: Some((half.clone(), colors)) };
        let labels = TrueLabels::new(&truth).unwrap();
        let swapped: Vec<usize> = half.iter().map(|label| 1 - label).collect();
        assert_eq!(labels.mislabeled(&mesh, &half).unwrap(), 0.0);
        assert_eq!(labels.mislabeled(&mesh, &swapped).unwrap(), 0.0);
        // A larger and finer sphere, on which the zone 0 < z < 1/4 is wrong: an eighth of the area.
        let large = shape("sphere:5").scaled(1.1);
        let wrong: Vec<usize> = large.vertices.iter().map(|x| usize::from(x.z > 0.275)).collect();
        let share = labels.mislabeled(&large, &wrong).unwrap();
        assert!((share - 0.125).abs() < 0.02, "{share}");
        let unknown = Truth { mesh, regions: None };
        assert!(TrueLabels::new(&unknown).is_none());
    }
}
