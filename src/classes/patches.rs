//! Parts of a mesh at its own resolution, on which a choice is tried: the whole mesh if it is small, or else connected
//! patches around faces that are drawn at random.

use rand::RngExt;
use rand_pcg::Pcg64;

use crate::mesh::Mesh;
use crate::mesh::incidence::Incidence;

/// A mesh with at most this many faces is one patch.
const MAX_WHOLE_FACES: usize = 16_000;

/// The number of faces of a patch, and the number of patches.
const PATCH_FACES: usize = 4_000;
const PATCHES: usize = 4;

/// A part of a mesh.
pub struct Patch {
    /// Its mesh, without faces that have no area.
    pub mesh: Mesh,
    /// The vertex of the whole mesh that each vertex is.
    pub vertices: Vec<usize>,
    /// The same for the faces.
    pub faces: Vec<usize>,
}

/// Patches that share no face, around faces that are known; at least one if there is a face with an area.
pub fn patches(mesh: &Mesh, known: &dyn Fn(usize) -> bool, rng: &mut Pcg64) -> Vec<Patch> {
    let usable = |&j: &usize| !mesh.is_degenerate(j);
    if mesh.faces.len() <= MAX_WHOLE_FACES {
        return vec![Patch::of(mesh, (0..mesh.faces.len()).filter(usable).collect())];
    }
    let around = Incidence::new(mesh, |j, _| j as u32);
    let candidates: Vec<usize> =
        (0..mesh.faces.len()).filter(usable).filter(|&j| known(j)).collect();
    let mut taken = vec![false; mesh.faces.len()];
    let mut found = Vec::new();
    for _ in 0..PATCHES {
        let Some(&first) = candidates.get(rng.random_range(0..candidates.len().max(1))) else {
            break;
        };
        if std::mem::replace(&mut taken[first], true) {
            continue;
        }
        let (mut faces, mut next) = (vec![first], 0);
        while next < faces.len() && faces.len() < PATCH_FACES {
            let corners = mesh.faces[faces[next]];
            next += 1;
            for &k in corners.iter().flat_map(|&v| around.at(v as usize)) {
                let k = k as usize;
                if usable(&k) && !std::mem::replace(&mut taken[k], true) {
                    faces.push(k);
                }
            }
        }
        faces.sort_unstable();
        found.push(Patch::of(mesh, faces));
    }
    found
}

impl Patch {
    fn of(mesh: &Mesh, faces: Vec<usize>) -> Self {
        let mut vertices: Vec<usize> =
            faces.iter().flat_map(|&j| mesh.faces[j].map(|v| v as usize)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let index = |v: u32| {
            vertices.binary_search(&(v as usize)).expect("it is a corner of a face") as u32
        };
        let own = faces.iter().map(|&j| mesh.faces[j].map(index)).collect();
        let points = vertices.iter().map(|&v| mesh.vertices[v]).collect();
        Patch { mesh: Mesh::new(points, own), vertices, faces }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{rng, shape, zoo};

    /// Faces are those of the mesh, once each; a small mesh is one patch, a large one several.
    #[test]
    fn patches_are_parts_of_the_mesh() {
        let large = [("many faces", shape("torus:150x120"))];
        for (name, mesh) in zoo().into_iter().chain(large) {
            let found = patches(&mesh, &|_| true, &mut rng(1601));
            assert_eq!(found.len() > 1, name == "many faces");
            let mut faces: Vec<usize> =
                found.iter().flat_map(|patch| patch.faces.clone()).collect();
            let count = faces.len();
            faces.sort_unstable();
            faces.dedup();
            assert_eq!(faces.len(), count, "{name}");
            for patch in &found {
                for (j, &whole) in patch.faces.iter().enumerate() {
                    assert_eq!(patch.mesh.corners(j), mesh.corners(whole), "{name}");
                }
                for (v, &whole) in patch.vertices.iter().enumerate() {
                    assert_eq!(patch.mesh.vertices[v], mesh.vertices[whole], "{name}");
                }
            }
        }
    }
}
