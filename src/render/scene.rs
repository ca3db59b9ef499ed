//! The scene: the mesh in the unit ball, and its views. A view is computed once for all layers.

use image::RgbaImage;
use nalgebra::Vector3;
use pulp::Arch;

use super::labels::{self, LabelField};
use super::layer::{Corners, Layer, Paint, linear_or_unknown, mapped};
use super::shading::{Light, srgb_from_linear};
use crate::mesh::Mesh;
use crate::optics::bands::{for_each_band, for_each_scanline};
use crate::optics::camera::Camera;
use crate::optics::visibility::{Fragment, Planes, SAMPLES, Visibility, VisibleFaces, components};
use crate::sweep;

/// The referenced part of the mesh, moved and scaled into the unit ball.
pub(super) struct Scene {
    pub mesh: Mesh,
    /// The vertex of the given mesh that each vertex is.
    referenced: Vec<usize>,
    /// A representative of each vertex's connected component.
    component: Vec<u32>,
    u: Vec<f64>,
    m: usize,
}

/// A ball around a mesh, which becomes the unit ball.
#[derive(Clone, Copy)]
struct Ball {
    center: Vector3<f64>,
    radius: f64,
}

impl Ball {
    /// That of the vertices of faces; `None` if there is nothing to draw.
    fn of(mesh: &Mesh) -> Option<Self> {
        let points = || mesh.faces.iter().flatten().map(|&k| mesh.vertices[k as usize].coords);
        if !points().all(|x| x.iter().all(|c| c.is_finite())) {
            return None;
        }
        let low = points().reduce(|a, b| a.inf(&b))?;
        let high = points().reduce(|a, b| a.sup(&b))?;
        let (center, radius) = (low + (high - low) / 2.0, (high - low).norm() / 2.0);
        (radius > 0.0 && radius.is_finite()).then_some(Ball { center, radius })
    }
}

/// What is behind the surface.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Ground {
    /// Mixed with the surface in linear light where a pixel shows both.
    White,
    /// The alpha of a pixel is the share of its samples that show the surface, and its color is theirs alone.
    Transparent,
}

/// The attributes needed to color a face in one view.
#[derive(Clone, Default)]
struct Facet {
    planes: Planes,
    /// At the corners, in the camera's axes.
    normals: [Vector3<f32>; 3],
    /// The region of the whole face; `None` if the cut passes through it.
    region: Option<u32>,
}

#[inline(always)]
fn mean([a, b, c]: &[Vector3<f32>; 3], weights: [f32; 3]) -> Vector3<f32> {
    a * weights[0] + b * weights[1] + c * weights[2]
}

impl Scene {
    /// The same, moved and scaled as another mesh is into the unit ball; parts may lie outside of it.
    pub fn within(mesh: &Mesh, u: &[f64], m: usize, frame: &Mesh) -> Option<Self> {
        let ball = Ball::of(frame)?;
        Scene::in_ball(mesh, u, m, |_| Some(ball))
    }

    /// `u` has m numbers for each vertex of the mesh. `None` if there is nothing to draw: the mesh has no faces, no
    /// extent, or coordinates that are not finite.
    pub fn new(mesh: &Mesh, u: &[f64], m: usize) -> Option<Self> {
        Scene::in_ball(mesh, u, m, Ball::of)
    }

    fn in_ball(
        mesh: &Mesh,
        u: &[f64],
        m: usize,
        ball: impl FnOnce(&Mesh) -> Option<Ball>,
    ) -> Option<Self> {
        let Ball { center, radius } = ball(mesh)?;
        let count = mesh.vertices.len();
        assert!(m > 0 && u.len() == count * m);
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
        if faces.is_empty() || !points().all(|x| x.iter().all(|c| c.is_finite())) {
            return None;
        }
        let mesh = Mesh::new(points().map(|x| ((x - center) / radius).into()).collect(), faces);
        let rows = || referenced.iter().flat_map(|&k| &u[k * m..(k + 1) * m]).copied().collect();
        let (component, u) = sweep::join(|| components(&mesh), rows);
        Some(Scene { component, mesh, referenced, u, m })
    }

    /// The vertex of the given mesh that each vertex is.
    pub fn vertices(&self) -> &[usize] {
        &self.referenced
    }

    /// Paint from a color per vertex of the given mesh; gray where NaN.
    pub fn colors(&self, colors: &[[f64; 3]]) -> Paint {
        let mut paint = vec![Vector3::zeros(); self.referenced.len()];
        for_each_band(&mut paint, 1, |first, band| {
            for (to, &k) in band.iter_mut().zip(&self.referenced[first..]) {
                *to = linear_or_unknown(colors[k]);
            }
        });
        Paint::Colors(paint)
    }

    /// Paint from a number per vertex of the given mesh.
    pub fn numbers(&self, unit: impl Fn(usize) -> f64) -> Paint {
        Paint::Numbers(self.referenced.iter().map(|&k| unit(k) as f32).collect())
    }

    pub fn field(&self) -> LabelField<'_> {
        LabelField::new(&self.mesh, &self.u, self.m)
    }

    /// One picture per layer through one camera; lit with the given normals at the corners, if any.
    pub fn draw(
        &self,
        field: &LabelField,
        camera: &Camera,
        normals: Option<&[[Vector3<f32>; 3]]>,
        layers: &[Layer],
        ground: Ground,
    ) -> Vec<RgbaImage> {
        let visibility = Visibility::new(&self.mesh, &self.component, camera);
        let line = layers.iter().any(|layer| layer.cut.is_some()).then(|| {
            let regions = field.pixel_regions(&visibility);
            labels::line_coverage(&visibility, &field.crossings(&visibility, &regions))
        });
        let visible = visibility.visible_faces();
        let facets = self.facets(field, &visibility, normals, &visible);
        let corners: Vec<Corners> =
            layers.iter().map(|layer| self.corners(&layer.paint, &visible)).collect();

        let (width, height, count) = (visibility.width, visibility.height, layers.len());
        // Each scanline has the pixels of the first layer, then those of the second, and so on.
        let mut pixels = vec![[255, 255, 255, 0_u8]; count * width * height];
        if ground == Ground::White {
            pixels.fill([255; 4]);
        }
        for_each_scanline(&mut pixels, count * width, |y, scanline| {
            let mut sums = vec![Vector3::<f32>::zeros(); count];
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    for x in 0..width {
                        let i = y * width + x;
                        sums.fill(Vector3::zeros());
                        let mut covered = 0;
                        visibility.fragments(i, |fragment| {
                            let at = visible.index[fragment.face] as usize;
                            let facet = &facets[at];
                            let samples = fragment.samples.count_ones();
                            covered += samples;
                            let position = visibility.centroid(i, fragment.samples);
                            let barycentric = facet.planes.barycentric(position);
                            let light = match normals {
                                Some(_) => Light::on(mean(&facet.normals, barycentric)),
                                None => Light::NONE,
                            };
                            for (sum, corners) in sums.iter_mut().zip(&corners) {
                                let color = match corners {
                                    Corners::Colors(colors) => mean(&colors[at], barycentric),
                                    Corners::Numbers(numbers) => {
                                        let [a, b, c] = numbers[at];
                                        let [s, t, r] = barycentric;
                                        mapped(a * s + b * t + c * r)
                                    }
                                    Corners::Regions(colors) => match facet.region {
                                        Some(p) => colors[p as usize],
                                        None => mean_region_color(
                                            colors,
                                            field,
                                            &visibility,
                                            &facet.planes,
                                            i,
                                            &fragment,
                                        ),
                                    },
                                };
                                *sum += light.reflected(color) * samples as f32;
                            }
                        });
                        if covered == 0 {
                            continue;
                        }
                        for (l, (sum, layer)) in sums.iter_mut().zip(layers).enumerate() {
                            if let (Some(line), Some(cut)) = (&line, layer.cut) {
                                let coverage = f32::from(line[i]) / 255.0;
                                *sum += (cut * covered as f32 - *sum) * coverage;
                            }
                            scanline[l * width + x] = pixel(*sum, covered, ground);
                        }
                    }
                },
            );
        });
        let picture = |l: usize| {
            let mut image = RgbaImage::new(width as u32, height as u32);
            for_each_scanline(&mut image, 4 * width, |y, scanline| {
                let from = &pixels[(y * count + l) * width..][..width];
                scanline.copy_from_slice(from.as_flattened());
            });
            image
        };
        (0..count).map(picture).collect()
    }

    /// The values of a layer at the corners of the visible faces, in the order of the faces.
    fn corners<'a>(&self, paint: &'a Paint, visible: &VisibleFaces) -> Corners<'a> {
        match paint {
            Paint::Colors(colors) => Corners::Colors(self.at_corners(colors, visible)),
            Paint::Numbers(numbers) => Corners::Numbers(self.at_corners(numbers, visible)),
            Paint::Regions(colors) => Corners::Regions(colors),
        }
    }

    fn at_corners<T: Copy + Default + Send + Sync>(
        &self,
        values: &[T],
        visible: &VisibleFaces,
    ) -> Vec<[T; 3]> {
        let mut corners = vec![[T::default(); 3]; visible.faces.len()];
        for_each_band(&mut corners, 1, |first, band| {
            for (to, &j) in band.iter_mut().zip(&visible.faces[first..]) {
                *to = self.mesh.faces[j as usize].map(|v| values[v as usize]);
            }
        });
        corners
    }

    /// The attributes of the visible faces, each contiguous in memory, in the order of the faces.
    fn facets(
        &self,
        field: &LabelField,
        visibility: &Visibility,
        normals: Option<&[[Vector3<f32>; 3]]>,
        visible: &VisibleFaces,
    ) -> Vec<Facet> {
        let camera = visibility.camera();
        let turn = camera.axes().cast::<f32>();
        let mut facets = vec![Facet::default(); visible.faces.len()];
        for_each_band(&mut facets, 1, |first, band| {
            for (facet, &j) in band.iter_mut().zip(&visible.faces[first..]) {
                let j = j as usize;
                facet.planes = visibility.planes(j);
                facet.region = field.face_region(j);
                if let Some(normals) = normals {
                    // Both sides are lit: the normals of faces that point away are reversed.
                    let ray = camera.to_eye(self.mesh.corners(j)[0]);
                    let away = camera.rotate(self.mesh.area_vector(j)).dot(&ray) < 0.0;
                    let turn = if away { -turn } else { turn };
                    facet.normals = normals[j].map(|n| turn * n);
                }
            }
        });
        facets
    }
}

/// The color of a pixel of which `covered` samples show the surface, from the sum of their colors in linear light.
#[inline(always)]
fn pixel(sum: Vector3<f32>, covered: u32, ground: Ground) -> [u8; 4] {
    let (color, alpha) = match ground {
        Ground::White => {
            let white = Vector3::repeat((SAMPLES as u32 - covered) as f32);
            ((sum + white) / SAMPLES as f32, 255)
        }
        Ground::Transparent => {
            (sum / covered as f32, (255 * covered + SAMPLES as u32 / 2) / SAMPLES as u32)
        }
    };
    let [r, g, b] = srgb_from_linear(color.into());
    [r, g, b, alpha as u8]
}

/// The mean color of the regions at the samples of a fragment, on a face that the cut passes through.
fn mean_region_color(
    colors: &[Vector3<f32>],
    field: &LabelField,
    visibility: &Visibility,
    planes: &Planes,
    i: usize,
    Fragment { face, samples }: &Fragment,
) -> Vector3<f32> {
    let mut sum = Vector3::<f32>::zeros();
    for s in (0..SAMPLES).filter(|s| samples >> s & 1 == 1) {
        let barycentric = planes.barycentric(visibility.centroid(i, 1 << s)).map(f64::from);
        sum += colors[field.region_at(*face, &barycentric) as usize];
    }
    sum / samples.count_ones() as f32
}
