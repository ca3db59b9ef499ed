//! `--means`: region parameters from a file, which stay as they are.

use std::path::Path;

use ndarray::Array2;
use serde_json::{Map, Value};

use crate::data::ModelName;
use crate::names::Named;
use crate::{Error, Result, file, npy, regions};

use super::memory::Memory;

/// The keys of a region in `summary.json` that are not parameters.
const OTHER_KEYS: [&str; 4] = ["palette", "color", "area", "share"];

/// Parameters, one map per region, and their model.
pub struct Means {
    pub model: ModelName,
    pub parameters: Vec<Value>,
}

/// Reads `FILE.npy`, m rows of d numbers, or the `summary.json` of an earlier run, whose model is that of the
/// parameters.
pub fn read(path: &Path, model: Option<ModelName>, memory: &Memory) -> Result<Means> {
    let found = match path.extension().and_then(|extension| extension.to_str()) {
        Some("npy") => {
            let rows = memory.array(path).cloned().map_or_else(|| npy::read_data(path), Ok)?;
            of_array(path, &rows, model.unwrap_or_default())?
        }
        _ => of_summary(path, model)?,
    };
    regions::check(found.parameters.len()).map_err(|error| error.of_file(path))?;
    Ok(found)
}

/// In the units of data from such a file.
fn of_array(path: &Path, rows: &Array2<f64>, model: ModelName) -> Result<Means> {
    let key = match model {
        ModelName::Constant => "mean",
        ModelName::L1 => "median",
        _ => {
            let message = format!(
                "a region of the model {} has more parameters than one number per column; give the summary.json of a \
                 run of this model",
                model.name()
            );
            return Err(Error::malformed(path, message));
        }
    };
    let parameters = |row: ndarray::ArrayView1<f64>| {
        let numbers: Vec<Value> = row.iter().map(|&x| Value::from(x)).collect();
        Value::Object(Map::from_iter([(key.to_owned(), Value::Array(numbers))]))
    };
    if let Some(((p, _), x)) = rows.indexed_iter().find(|(_, x)| !x.is_finite()) {
        return Err(Error::malformed(path, format!("row {p} has {x}; means must be finite")));
    }
    Ok(Means { model, parameters: rows.outer_iter().map(parameters).collect() })
}

fn of_summary(path: &Path, model: Option<ModelName>) -> Result<Means> {
    let wrong = |message: String| Error::malformed(path, message);
    let bytes = file::read(path)?;
    let summary: Value = serde_json::from_slice(&bytes).map_err(|error| {
        wrong(format!("{error}; give m rows of means as .npy, or the summary.json of `segment`"))
    })?;
    let regions = summary.get("region_parameters").and_then(Value::as_array);
    let name = summary.get("model").and_then(Value::as_str);
    let (Some(regions), Some(name)) = (regions, name) else {
        return Err(wrong(
            "is not the summary.json of `segment`: it has no region_parameters".into(),
        ));
    };
    // The baselines have the parameters of the piecewise constant model.
    let own = ModelName::named(name).unwrap_or_default();
    if let Some(model) = model.filter(|&model| model != own) {
        let message = format!(
            "has the parameters of the model {}, not of {}; leave --model out",
            own.name(),
            model.name()
        );
        return Err(wrong(message));
    }
    let parameters = |region: &Value| {
        let mut parameters = region.clone();
        if let Value::Object(map) = &mut parameters {
            OTHER_KEYS.iter().for_each(|key| _ = map.remove(*key));
        }
        parameters
    };
    Ok(Means { model: own, parameters: regions.iter().map(parameters).collect() })
}
