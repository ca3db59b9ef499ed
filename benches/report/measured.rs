//! The results in criterion's output folder.

use std::path::Path;

use serde_json::Value;

pub struct Measured {
    pub group: String,
    pub id: String,
    /// The median in seconds, and its confidence interval.
    pub median: f64,
    pub low: f64,
    pub high: f64,
    bytes: Option<f64>,
}

/// The parts of an id such as "chambolle-pock fused f32, 2 thread(s)".
pub struct Name<'a> {
    pub what: &'a str,
    pub precision: &'a str,
    pub threads: &'a str,
}

impl Measured {
    pub fn name(&self) -> Name<'_> {
        let (what, threads) = self.id.rsplit_once(", ").unwrap_or((&self.id, "1"));
        let precision = what.rsplit(' ').next().unwrap_or_default();
        Name { what, precision, threads: threads.trim_end_matches(" thread(s)") }
    }

    /// GB/s.
    pub fn rate(&self) -> Option<f64> {
        Some(1e-9 * self.bytes? / self.median)
    }
}

/// All measurements, in the order in which they were made.
pub fn read(folder: &Path) -> Result<Vec<Measured>, Box<dyn std::error::Error>> {
    let mut found = Vec::new();
    for group in std::fs::read_dir(folder)? {
        let Ok(benchmarks) = std::fs::read_dir(group?.path()) else { continue };
        for benchmark in benchmarks {
            let new = benchmark?.path().join("new");
            if !new.join("estimates.json").exists() {
                continue;
            }
            let json = |name: &str| -> Result<Value, Box<dyn std::error::Error>> {
                Ok(serde_json::from_slice(&std::fs::read(new.join(name))?)?)
            };
            let (about, estimates) = (json("benchmark.json")?, json("estimates.json")?);
            let text = |key: &str| about[key].as_str().unwrap_or_default().to_owned();
            let median = &estimates["median"];
            let seconds = |value: &Value| 1e-9 * value.as_f64().unwrap_or(f64::NAN);
            let written = std::fs::metadata(new.join("estimates.json"))?.modified()?;
            found.push((
                written,
                Measured {
                    group: text("group_id"),
                    id: text("function_id"),
                    median: seconds(&median["point_estimate"]),
                    low: seconds(&median["confidence_interval"]["lower_bound"]),
                    high: seconds(&median["confidence_interval"]["upper_bound"]),
                    bytes: about["throughput"]["Bytes"].as_f64(),
                },
            ));
        }
    }
    found.sort_by_key(|(written, _)| *written);
    Ok(found.into_iter().map(|(_, measured)| measured).collect())
}
