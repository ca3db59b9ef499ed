//! The result folder of a reconstruction.

use std::path::Path;

use ndarray::{Array1, Array2};
use serde::Serialize;

use crate::colormap::categorical;
use crate::data::radiance::Radiance;
use crate::data::views::{Picture, ViewOptions, Viewed, of_pictures};
use crate::data::{DataModel, Weights, constant::Mean};
use crate::evolve::shots::Photographs;
use crate::evolve::{Plan, Reconstruction, Summary};
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::io::{self, Properties};
use crate::outcome::write_png;
use crate::render::photographs::RegionsInViews;
use crate::render::{self, Picture as Drawn};
use crate::{Result, file, npy};

use super::arguments::Arguments;
use super::warnings;
use crate::cli::preview;

/// The colors of the regions are measured where pixels are pure and not seen at a grazing angle.
const PURE: usize = 2;
const GRAZING: f64 = 0.2;

/// Where and of what results are written.
pub struct Folder<'a> {
    pub arguments: &'a Arguments,
    pub photographs: &'a Photographs,
    pub plan: &'a Plan,
}

/// What `summary.json` has.
#[derive(Serialize)]
struct Record<'a> {
    #[serde(flatten)]
    numbers: Summary,
    views: usize,
    background: &'a str,
    model: &'static str,
    light: Option<[f64; 3]>,
    ambient: Option<f64>,
    seed: u64,
    region_parameters: Vec<Region>,
    warnings: &'a [String],
}

/// A region of the summary.
#[derive(Serialize)]
struct Region {
    /// mu_p, for which the labels are certified.
    mean: [f64; 3],
    /// The mean of its pure pixels, if it has any.
    pure_mean: Option<[f64; 3]>,
    palette: [f64; 3],
    area: f64,
    share: f64,
}

impl Folder<'_> {
    /// Writes the folder and returns the warnings about the result.
    pub fn write(&self, found: &Reconstruction, seconds: f64) -> Result<Vec<String>> {
        let Reconstruction { surface, solution, .. } = found;
        let mesh = &surface.mesh;
        let m = surface.coloring.regions();
        let labels = solution
            .as_ref()
            .map_or_else(|| Array1::zeros(mesh.vertices.len()), |solution| solution.labels.clone());
        let u = Array2::from_shape_vec((mesh.vertices.len(), m), surface.coloring.u.clone());
        let u = u.expect("V rows of m numbers");
        let viewed = self.viewed(found)?;
        let areas = barycentric_areas(mesh);
        let regions = regions(found, &viewed, &labels, &areas);
        let warnings = warnings::about(found, &self.photographs.shots);
        let record = Record {
            numbers: Summary::of(found, seconds),
            views: self.photographs.shots.len(),
            background: &self.photographs.background,
            model: if surface.light.is_some() { "albedo" } else { "constant" },
            light: surface.light.map(|light| light.direction.into()),
            ambient: surface.light.map(|light| light.ambient),
            seed: self.plan.seed,
            region_parameters: regions,
            warnings: &warnings,
        };
        let palette: Vec<[f64; 3]> = (0..m).map(categorical).collect();
        let bytes: Vec<u8> = labels.iter().map(|&label| label as u8).collect();
        file::write_folder(&self.arguments.out, |folder| {
            npy::write(&folder.join("u.npy"), &u)?;
            npy::write(&folder.join("labels.npy"), &labels)?;
            io::write_labeled(
                &folder.join("mesh.ply"),
                mesh,
                &bytes,
                None,
                &palette,
                &Properties::default(),
            )?;
            write_trace(&folder.join("trace.csv"), found)?;
            if !self.arguments.no_preview {
                self.write_pictures(folder, found, &viewed, &record.region_parameters)?;
            }
            file::write(&folder.join("summary.json"), |out| {
                serde_json::to_writer_pretty(&mut *out, &record)?;
                out.write_all(b"\n")
            })
        })?;
        Ok(warnings)
    }

    /// The colors of the surface in pure pixels.
    fn viewed(&self, found: &Reconstruction) -> Result<Viewed> {
        let shots = &self.photographs.shots;
        let views: Vec<_> = shots.iter().map(|shot| shot.view.clone()).collect();
        let pictures: Vec<&Picture> = shots.iter().map(|shot| &shot.picture).collect();
        let options = ViewOptions { pure: PURE, grazing: GRAZING, ..ViewOptions::default() };
        of_pictures(&views, &pictures, &found.surface.mesh, &options).or_else(|_| {
            of_pictures(&views, &pictures, &found.surface.mesh, &ViewOptions::default())
        })
    }

    fn write_pictures(
        &self,
        folder: &Path,
        found: &Reconstruction,
        viewed: &Viewed,
        regions: &[Region],
    ) -> Result<()> {
        let mesh = &found.surface.mesh;
        let (u, m) = (&found.surface.coloring.u, found.surface.coloring.regions());
        let number = |c: f64| format!("{c:.3}");
        let drawn = |(p, region): (usize, &Region)| render::Region {
            color: region.palette,
            mean: Some(region.pure_mean.unwrap_or(region.mean).map(|c| c.clamp(0.0, 1.0))),
            text: preview::legend(p, region.share, "mean", &region.mean, number),
        };
        let data: Vec<[f64; 3]> = (0..mesh.vertices.len())
            .map(|k| [0, 1, 2].map(|channel| viewed.means.at(k)[channel]))
            .collect();
        let regions: Vec<render::Region> = regions.iter().enumerate().map(drawn).collect();
        let view = self.arguments.view;
        let caption = "the mean colors of its pixels";
        let image = Drawn { mesh, data: &data, caption, regions: &regions, u, view }.draw();
        write_png(&folder.join("preview.png"), &image)?;
        let sheet = RegionsInViews::new(mesh, u, m).with_silhouettes();
        write_png(&folder.join("views.png"), &sheet.sheet(&self.photographs.folder)?)
    }
}

fn regions(
    found: &Reconstruction,
    viewed: &Viewed,
    labels: &Array1<i32>,
    areas: &[f64],
) -> Vec<Region> {
    let coloring = &found.surface.coloring;
    let m = coloring.regions();
    let weights: Vec<f64> = coloring.u.iter().enumerate().map(|(i, u)| u * areas[i / m]).collect();
    // Colors are comparable with pixels only without a light.
    let pure = found.surface.light.is_none().then(|| {
        let mut means = vec![Mean { mean: vec![f64::NAN; 3] }; m];
        let fit = Radiance::new(&viewed.means, &viewed.evidence);
        let fitted = fit.fit(Weights::new(&weights, m), &mut means);
        fitted.map_or_else(|_| Vec::new(), |_| means)
    });
    let mut of_regions = vec![0.0; m];
    labels.iter().zip(areas).for_each(|(&label, area)| of_regions[label as usize] += area);
    let total: f64 = areas.iter().sum();
    let region = |(p, &mean): (usize, &[f64; 3])| Region {
        mean,
        pure_mean: pure
            .as_ref()
            .and_then(|pure| <[f64; 3]>::try_from(pure.get(p)?.mean.clone()).ok())
            .filter(|mean| mean.iter().all(|c| c.is_finite())),
        palette: categorical(p),
        area: of_regions[p],
        share: of_regions[p] / total,
    };
    coloring.mu.iter().enumerate().map(region).collect()
}

fn write_trace(path: &Path, found: &Reconstruction) -> Result<()> {
    file::write(path, |out| {
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record([
            "step",
            "level",
            "energy",
            "images",
            "cuts",
            "area",
            "roughness",
            "move",
            "halvings",
            "contour_pixels",
            "distance",
        ])?;
        for (step, distance) in &found.trace {
            let terms = &step.terms;
            csv.write_record([
                step.step.to_string(),
                step.level.to_string(),
                step.energy.to_string(),
                terms.images.to_string(),
                terms.cuts.to_string(),
                terms.area.to_string(),
                terms.roughness.to_string(),
                step.motion.to_string(),
                step.halvings.to_string(),
                step.contour_pixels.to_string(),
                distance.map_or_else(String::new, |distance| distance.to_string()),
            ])?;
        }
        csv.flush()
    })
}
