//! What is drawn: the mesh in the unit ball, and its colors in linear light; and one view of it, twice.

use image::RgbImage;
use nalgebra::Vector3;
use pulp::Arch;

use super::labels::{self, LabelField};
use super::shading::{Light, linear_from_srgb, srgb_from_linear};
use crate::mesh::Mesh;
use crate::optics::bands::{for_each_band, for_each_row};
use crate::optics::camera::Camera;
use crate::optics::visibility::{Fragment, Planes, SAMPLES, Visibility, Visible, components};
use crate::sweep;

/// The color of the cut, in sRGB: darker than any region.
const CUT_COLOR: [f64; 3] = [0.09, 0.09, 0.11];
/// Where the data is not known.
const UNKNOWN: [f64; 3] = [0.72; 3];

/// The referenced part of the mesh, moved and scaled into the unit ball, with colors in linear light.
pub(super) struct Scene {
    pub mesh: Mesh,
    /// A representative of each vertex's connected component.
    component: Vec<u32>,
    u: Vec<f64>,
    data: Vec<Vector3<f32>>,
    regions: Vec<Vector3<f32>>,
}

/// What is needed of a face to color it in one view.
#[derive(Clone, Default)]
struct Facet {
    planes: Planes,
    /// At the corners, in the camera's axes.
    normals: [Vector3<f32>; 3],
    data: [Vector3<f32>; 3],
    /// Of all of it; none where the cut goes through it.
    region: Option<u32>,
}

impl Facet {
    /// The data and a region at a place of the picture.
    #[inline(always)]
    fn colors(&self, place: [f64; 2], region: Vector3<f32>, lit: bool) -> [Vector3<f32>; 2] {
        let barycentric = self.planes.barycentric(place);
        let light = if lit { Light::on(mean(&self.normals, barycentric)) } else { Light::NONE };
        [light.reflected(mean(&self.data, barycentric)), light.reflected(region)]
    }
}

#[inline(always)]
fn mean([a, b, c]: &[Vector3<f32>; 3], weights: [f32; 3]) -> Vector3<f32> {
    a * weights[0] + b * weights[1] + c * weights[2]
}

impl Scene {
    /// None if there is nothing to see.
    pub fn new(
        mesh: &Mesh,
        data_colors: &[[f64; 3]],
        region_colors: &[[f64; 3]],
        u: &[f64],
    ) -> Option<Self> {
        let (count, m) = (mesh.vertices.len(), region_colors.len());
        assert!(m > 0 && data_colors.len() == count && u.len() == count * m);
        let mut index = vec![u32::MAX; count];
        let mut referenced = Vec::with_capacity(count);
        let mut faces = mesh.faces.clone();
        for v in faces.iter_mut().flatten() {
            let k = *v as usize;
            if index[k] == u32::MAX {
                index[k] = referenced.len() as u32;
                referenced.push(k);
            }
            *v = index[k];
        }
        let points = || referenced.iter().map(|&k| mesh.vertices[k].coords);
        if !points().all(|x| x.iter().all(|c| c.is_finite())) {
            return None;
        }
        let low = points().reduce(|a, b| a.inf(&b))?;
        let high = points().reduce(|a, b| a.sup(&b))?;
        let (center, radius) = (low + (high - low) / 2.0, (high - low).norm() / 2.0);
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let mesh = Mesh::new(points().map(|x| ((x - center) / radius).into()).collect(), faces);
        let colored = || {
            let mut own = Vec::with_capacity(referenced.len() * m);
            for &k in &referenced {
                own.extend_from_slice(&u[k * m..(k + 1) * m]);
            }
            let mut data = vec![Vector3::zeros(); referenced.len()];
            for_each_band(&mut data, 1, |first, band| {
                for (to, &k) in band.iter_mut().zip(&referenced[first..]) {
                    let color = data_colors[k];
                    let known = color.iter().all(|c| !c.is_nan());
                    *to = linear_from_srgb(if known { color } else { UNKNOWN }).into();
                }
            });
            (own, data)
        };
        let (component, (u, data)) = sweep::join(|| components(&mesh), colored);
        Some(Scene {
            component,
            mesh,
            u,
            data,
            regions: region_colors.iter().map(|&color| linear_from_srgb(color).into()).collect(),
        })
    }

    pub fn field(&self) -> LabelField<'_> {
        LabelField::new(&self.mesh, &self.u, self.regions.len())
    }

    /// The data, and the regions with their cut, seen by one camera; lit by normals at the corners, if there are any.
    pub fn draw(
        &self,
        field: &LabelField,
        camera: &Camera,
        normals: Option<&[[Vector3<f32>; 3]]>,
    ) -> [RgbImage; 2] {
        let visibility = Visibility::new(&self.mesh, &self.component, camera);
        let regions = field.seen(&visibility);
        let line = labels::line(&visibility, &field.crossings(&visibility, &regions));
        let seen = visibility.seen_faces();
        let facets = self.facets(field, &visibility, normals, &seen);
        let cut = Vector3::from(linear_from_srgb(CUT_COLOR));

        // The colors of a fragment in the two pictures.
        let colors = |i: usize, fragment: &Fragment| {
            let facet = &facets[seen.index[fragment.face] as usize];
            let region = match facet.region {
                Some(p) => self.regions[p as usize],
                None => self.mixed(field, &visibility, &facet.planes, i, fragment),
            };
            facet.colors(visibility.middle(i, fragment.samples), region, normals.is_some())
        };

        let width = visibility.width;
        let mut pixels = vec![[[255_u8; 3]; 2]; width * visibility.height];
        for_each_row(&mut pixels, width, |y, row| {
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    for (x, pixel) in row.iter_mut().enumerate() {
                        let i = y * width + x;
                        let mut sums = [Vector3::<f32>::zeros(); 2];
                        let mut seen = 0;
                        visibility.fragments(i, |fragment| {
                            let count = fragment.samples.count_ones();
                            seen += count;
                            for (sum, color) in sums.iter_mut().zip(colors(i, &fragment)) {
                                *sum += color * count as f32;
                            }
                        });
                        if seen > 0 {
                            let covers = f32::from(line[i]) / 255.0;
                            sums[1] += (cut * seen as f32 - sums[1]) * covers;
                            let white = Vector3::repeat((SAMPLES as u32 - seen) as f32);
                            let mean = sums.map(|sum| (sum + white) / SAMPLES as f32);
                            *pixel = mean.map(|mean| srgb_from_linear(mean.into()));
                        }
                    }
                },
            );
        });
        let picture = |half: usize| {
            let mut image = RgbImage::new(width as u32, visibility.height as u32);
            for_each_row(&mut image, 3 * width, |y, row| {
                let (row, _) = row.as_chunks_mut::<3>();
                for (color, pixel) in row.iter_mut().zip(&pixels[y * width..]) {
                    *color = pixel[half];
                }
            });
            image
        };
        [picture(0), picture(1)]
    }

    /// What is needed of the faces that are seen, each in one place of memory, in their order.
    fn facets(
        &self,
        field: &LabelField,
        visibility: &Visibility,
        normals: Option<&[[Vector3<f32>; 3]]>,
        seen: &Visible,
    ) -> Vec<Facet> {
        let camera = visibility.camera();
        let turn = camera.axes().cast::<f32>();
        let mut facets = vec![Facet::default(); seen.faces.len()];
        for_each_band(&mut facets, 1, |first, band| {
            for (facet, &j) in band.iter_mut().zip(&seen.faces[first..]) {
                let j = j as usize;
                facet.planes = visibility.planes(j);
                facet.data = self.mesh.faces[j].map(|v| self.data[v as usize]);
                facet.region = field.whole(j);
                if let Some(normals) = normals {
                    // Both sides are lit: each face is turned towards the viewer.
                    let ray = camera.to_eye(self.mesh.corners(j)[0]);
                    let away = camera.rotate(self.mesh.area_vector(j)).dot(&ray) < 0.0;
                    let turn = if away { -turn } else { turn };
                    facet.normals = normals[j].map(|n| turn * n);
                }
            }
        });
        facets
    }

    /// The mean color of the regions at some samples of a pixel, on a face that the cut goes through.
    fn mixed(
        &self,
        field: &LabelField,
        visibility: &Visibility,
        planes: &Planes,
        i: usize,
        Fragment { face, samples }: &Fragment,
    ) -> Vector3<f32> {
        let mut sum = Vector3::<f32>::zeros();
        for s in (0..SAMPLES).filter(|s| samples >> s & 1 == 1) {
            let barycentric = planes.barycentric(visibility.middle(i, 1 << s)).map(f64::from);
            sum += self.regions[field.at(*face, &barycentric) as usize];
        }
        sum / samples.count_ones() as f32
    }
}
