//! The JSON text of a glTF file: its version, and the extensions that it requires.
//!
//! ```text
//! asset: {version: "2.x"}, extensionsRequired: [name ...]
//! ```
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 3.2, "Asset", and section 3.12, "Specifying Extensions".

use std::path::Path;

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::document::Document;
use crate::error::{Error, Result};
use crate::mesh::io::text::quote;
use crate::one_line::one_line;

pub const DRACO: &str = "KHR_draco_mesh_compression";

/// Extensions that encode positions and faces in other ways.
const COMPRESSIONS: [&str; 3] = [DRACO, "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Beginnings of extensions that are supported, or do not change positions and faces.
const HARMLESS: [&str; 10] = [
    "KHR_mesh_quantization",
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_animation_",
    "KHR_node_",
    "KHR_xmp",
];

/// What decides whether the rest can be read: in glTF 1.0, it has other types.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Option<Asset>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

/// The document, if its version and its extensions are supported.
pub fn parse(path: &Path, json: &[u8]) -> Result<Document> {
    let head: Head = from_json(path, json)?;
    let version = head.asset.map(|asset| asset.version);
    let version = version.ok_or_else(|| Error::malformed(path, "is JSON, but not glTF"))?;
    if version.split('.').next() != Some("2") {
        let version = quote(version.as_bytes());
        let message = format!("is glTF of version {version}; convert it to version 2.0");
        return Err(Error::malformed(path, message));
    }
    for name in &head.extensions_required {
        check_extension(path, name)?;
    }
    from_json(path, json)
}

fn from_json<T: DeserializeOwned>(path: &Path, json: &[u8]) -> Result<T> {
    const LONGEST_MESSAGE: usize = 100;
    serde_json::from_slice(json).map_err(|error| {
        let (line, column) = (error.line(), error.column());
        let message = error.to_string();
        let what = message.rsplit_once(" at line ").map_or(message.as_str(), |(what, _)| what);
        // It may quote any text of the file.
        let what: String = one_line(what).chars().take(LONGEST_MESSAGE).collect();
        Error::malformed(
            path,
            format!("the JSON is not valid: line {line}, column {column}: {what}"),
        )
    })
}

fn check_extension(path: &Path, name: &str) -> Result<()> {
    if COMPRESSIONS.contains(&name) {
        Err(compressed(path, name))
    } else if HARMLESS.iter().any(|beginning| name.starts_with(beginning)) {
        Ok(())
    } else {
        let name = quote(name.as_bytes());
        let message =
            format!("requires the extension {name}, which is not supported; save it without");
        Err(Error::malformed(path, message))
    }
}

/// The error of a file with a compression.
pub fn compressed(path: &Path, extension: &str) -> Error {
    Error::malformed(path, format!("is compressed by {extension}; convert it without compression"))
}
