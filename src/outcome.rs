//! The folder that a run leaves: numbers, trace, fields, the colored mesh, a picture.
//!
//! Other programs read it; DESIGN.md section 3 fixes the names and contents. It appears whole or not at all.

use std::io::Write;
use std::path::Path;

use image::RgbImage;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::file;
use crate::mesh::{Mesh, io};
use crate::npy;
use crate::render::{Picture, Region, View};
use crate::run::{Certificate, Sample};
use crate::solve::Solution;
use crate::sweep;

/// How the regions and the data look.
pub struct Looks {
    pub regions: Vec<Region>,
    /// Without it no picture is drawn.
    pub data: Option<Shown>,
}

/// The data in the picture.
pub struct Shown {
    /// One per vertex; NaN where the data is not known.
    pub colors: Vec<[f64; 3]>,
    /// What they are.
    pub caption: String,
    pub view: View,
}

/// Writes the folder. `summary` becomes `summary.json`.
pub fn write(
    folder: &Path,
    summary: &impl Serialize,
    solution: &Solution,
    mesh: &Mesh,
    looks: &Looks,
) -> Result<()> {
    file::write_folder(folder, |folder| {
        let arrays = || {
            npy::write(&folder.join("u.npy"), &solution.u)?;
            if let Some(q) = &solution.q {
                npy::write(&folder.join("q.npy"), q)?;
            }
            npy::write(&folder.join("labels.npy"), &solution.labels)
        };
        let labels: Vec<u8> = solution.labels.iter().map(|&label| label as u8).collect();
        let palette: Vec<[f64; 3]> = looks.regions.iter().map(|region| region.color).collect();
        let segmented =
            || io::write_labeled(&folder.join("segmented.ply"), mesh, &labels, &palette);
        let (arrays, segmented) = sweep::join(arrays, segmented);
        arrays.and(segmented)?;
        write_trace(&folder.join("trace.csv"), &solution.trace)?;

        if let Some(Shown { colors, caption, view }) = &looks.data {
            let u = solution.u.as_slice().expect("rows are contiguous");
            let regions = &looks.regions;
            let image = Picture { mesh, data: colors, caption, regions, u, view: *view }.draw();
            file::write(&folder.join("preview.png"), |out| {
                png(out, &image).map_err(std::io::Error::other)
            })?;
        }
        file::write(&folder.join("summary.json"), |out| {
            serde_json::to_writer_pretty(&mut *out, summary)?;
            out.write_all(b"\n")
        })
    })?;
    // What an earlier run drew or saved does not belong to this one.
    let made = [("preview.png", looks.data.is_some()), ("q.npy", solution.q.is_some())];
    for (name, _) in made.into_iter().filter(|(_, made)| !made) {
        let path = folder.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(Error::io(&path, error));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Quickly: the file is a third larger than it could be.
fn png(out: &mut dyn Write, image: &RgbImage) -> std::result::Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(out, image.width(), image.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::FilterType::Up);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(image)?;
    writer.finish()
}

pub(crate) fn write_trace(path: &Path, trace: &[Sample]) -> Result<()> {
    let smoothed = trace.iter().any(|sample| sample.smoothed_energy.is_some());
    let certified = trace.iter().any(|sample| sample.certificate.is_some());
    file::write(path, |out| {
        let mut csv = csv::Writer::from_writer(out);
        let mut header =
            vec!["iteration", "seconds", "energy", "dual_bound", "gap", "relative_gap", "change"];
        header.extend(smoothed.then_some("smoothed_energy"));
        header.extend(certified.then_some("certificate"));
        csv.write_record(&header)?;
        for sample in trace {
            let optional = |value: Option<f64>| value.map_or_else(String::new, |x| x.to_string());
            let mut record = vec![
                sample.iteration.to_string(),
                sample.seconds.to_string(),
                sample.energy.to_string(),
                sample.dual_bound.to_string(),
                sample.gap.to_string(),
                sample.relative_gap.to_string(),
                optional(sample.change),
            ];
            record.extend(smoothed.then(|| optional(sample.smoothed_energy)));
            let certificate = sample.certificate.map_or("", Certificate::name);
            record.extend(certified.then(|| certificate.to_owned()));
            csv.write_record(&record)?;
        }
        csv.flush()
    })
}
