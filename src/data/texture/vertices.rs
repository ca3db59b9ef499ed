//! Colors of vertices from those of faces: a vertex takes the mean over its share of its faces, weighted by their
//! areas, so that seams split no vertex. A vertex without any colored face is NaN (unknown).

use super::pyramid::Texture;
use super::sample::{self, Footprint, Texel};
use crate::mesh::{Mesh, is_position};
use crate::sweep;

/// The color of vertices without area.
const MID_GRAY: [f64; 3] = [0.5; 3];

/// Approximate number of samples of all faces together.
const TOTAL_SAMPLES: f64 = (1_u64 << 24) as f64;

/// Number of faces that are sampled at a time.
const FACES_AT_ONCE: usize = 1 << 16;

/// Whether a face has a position in a texture.
pub fn is_placed(uv: &[[f64; 2]; 3]) -> bool {
    uv.iter().all(|&t| is_position(t))
}

/// Area-weighted colors and areas, summed at V vertices.
pub struct Sums {
    colors: Vec<[f64; 3]>,
    areas: Vec<f64>,
}

impl Sums {
    /// Zeros at all vertices of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        Sums { colors: vec![[0.0; 3]; mesh.vertices.len()], areas: vec![0.0; mesh.vertices.len()] }
    }

    /// Adds face j with a uniform color.
    pub fn add_color(&mut self, mesh: &Mesh, j: usize, color: [f64; 3]) {
        self.add(mesh, j, [color; 3]);
    }

    /// Adds the faces `faces(i)`, i < n, with the colors of a texture; all must have finite texture coordinates.
    pub fn add_texture(
        &mut self,
        mesh: &Mesh,
        uv: &[[[f64; 2]; 3]],
        texture: &mut Texture,
        texel: Texel,
        n: usize,
        faces: impl Fn(usize) -> usize + Sync,
    ) {
        let (extent, clamp) = (texture.extent(), texture.clamp);
        let most = (TOTAL_SAMPLES / (6 * mesh.faces.len()) as f64).sqrt().max(4.0) as u32;
        for first in (0..n).step_by(FACES_AT_ONCE) {
            let count = FACES_AT_ONCE.min(n - first);
            let footprint = |i: usize| Footprint::new(&uv[faces(first + i)], extent, clamp, most);
            let footprints = sweep::collect(count, footprint);
            if texel == Texel::Mean {
                texture
                    .reach(footprints.iter().map(|footprint| footprint.level).max().unwrap_or(0));
            }
            let texture = &*texture;
            let colors = sweep::collect(
                count,
                #[inline(always)]
                |i| texture.of_corners(&footprints[i], texel),
            );
            for (i, colors) in colors.into_iter().enumerate() {
                self.add(mesh, faces(first + i), colors);
            }
        }
    }

    fn add(&mut self, mesh: &Mesh, j: usize, colors: [[f64; 3]; 3]) {
        let area = mesh.face_area(j);
        for (&k, color) in mesh.faces[j].iter().zip(colors) {
            for (sum, value) in self.colors[k as usize].iter_mut().zip(color) {
                *sum += area * value;
            }
            self.areas[k as usize] += area;
        }
    }

    /// The means; NaN at vertices with area but without a known face, mid-gray at vertices without area.
    pub fn means(self, mesh: &Mesh) -> Vec<[f64; 3]> {
        let mean = |(sum, &area): (&[f64; 3], &f64)| {
            if area > 0.0 { sum.map(|value| (value / area).min(1.0)) } else { [f64::NAN; 3] }
        };
        let mut means: Vec<_> = self.colors.iter().zip(&self.areas).map(mean).collect();
        if self.areas.iter().any(|&area| area <= 0.0) {
            let mut has_area = vec![false; means.len()];
            for (j, face) in mesh.faces.iter().enumerate() {
                if mesh.face_area(j) > 0.0 {
                    face.iter().for_each(|&k| has_area[k as usize] = true);
                }
            }
            let bare = means.iter_mut().zip(has_area).filter(|(_, has_area)| !has_area);
            bare.for_each(|(color, _)| *color = MID_GRAY);
        }
        means
    }
}

/// The median number of texels of the placed faces, 0 if there are none. `size` is that of the image in its file.
pub fn texels_per_face(uv: &[[[f64; 2]; 3]], size: impl Fn(usize) -> Option<[f64; 2]>) -> f64 {
    let mut areas: Vec<f64> = uv
        .iter()
        .enumerate()
        .filter_map(|(j, uv)| size(j).map(|size| sample::area(uv, size)))
        .collect();
    if areas.is_empty() {
        return 0.0;
    }
    let middle = areas.len() / 2;
    *areas.select_nth_unstable_by(middle, f64::total_cmp).1
}
