//! Numeric properties of vertices or faces that the mesh itself does not keep, such as class probabilities. Those of a
//! polygon are given to its triangles, n - 2 for n corners.

use std::path::Path;

use ndarray::Array2;

use super::header::{Encoding, Header, Kind, Property};
use super::items::{list_length, skip_property};
use super::values::{Ascii, Binary, Values};
use crate::error::{Error, Result};
use crate::mesh::io::scalars::{Properties, Scalars};

/// So many numbers may be repeated for the triangles of polygons.
const MOST_REPEATED: usize = 1 << 27;

/// Reads the scalar properties of vertices or of faces whose element, `vertex` or `face`, and name `matches`.
///
/// # Errors
/// The content is not a valid PLY file, or vertices and faces, or neither, have such properties.
pub fn read_scalars(
    path: &Path,
    bytes: &[u8],
    matches: &dyn Fn(&str, &str) -> bool,
) -> Result<Scalars> {
    let header = Header::parse(path, bytes)?;
    match header.encoding {
        Encoding::Ascii => body(path, &header, Ascii::new(path, bytes, &header), matches),
        Encoding::LittleEndian => {
            body(path, &header, Binary::<false>::new(path, bytes, &header), matches)
        }
        Encoding::BigEndian => {
            body(path, &header, Binary::<true>::new(path, bytes, &header), matches)
        }
    }
}

/// All scalar properties of vertices and of faces except positions and numbers of images.
///
/// # Errors
/// The content is not a valid PLY file.
pub fn read_properties(path: &Path, bytes: &[u8]) -> Result<Properties> {
    let header = Header::parse(path, bytes)?;
    let is_other = |element: &str, name: &str| match element {
        "vertex" => !["x", "y", "z"].contains(&name),
        _ => name != "texnumber",
    };
    let of = |wanted: &str| -> Result<Option<Scalars>> {
        let is_wanted = |element: &str, name: &str| element == wanted && is_other(element, name);
        let has_some = header.elements.iter().any(|element| {
            let is_wanted = |p: &Property| is_wanted(&element.name, p.name());
            element.properties.iter().any(|p| matches!(p.kind, Kind::Scalar(_)) && is_wanted(p))
        });
        has_some.then(|| read_scalars(path, bytes, &is_wanted)).transpose()
    };
    Ok(Properties { of_vertices: of("vertex")?, of_faces: of("face")? })
}

fn body(
    path: &Path,
    header: &Header,
    mut values: impl Values,
    matches: &dyn Fn(&str, &str) -> bool,
) -> Result<Scalars> {
    let matching = |element: &str, property: &Property| {
        matches!(property.kind, Kind::Scalar(_)) && matches(element, property.name())
    };
    let having: Vec<&str> = header
        .elements
        .iter()
        .filter(|element| {
            element.properties.iter().any(|property| matching(&element.name, property))
        })
        .map(|element| element.name.as_str())
        .filter(|name| ["vertex", "face"].contains(name))
        .collect();
    let wanted = match having[..] {
        [only] => only,
        [] => {
            return Err(Error::malformed(
                path,
                format!("has no such number at vertices or faces, but {}", listed(header)),
            ));
        }
        _ => {
            return Err(Error::malformed(
                path,
                "has such properties at vertices and at faces; write vertex:NAME or face:NAME",
            ));
        }
    };
    let mut found = Scalars {
        of_faces: wanted == "face",
        names: Vec::new(),
        types: Vec::new(),
        numbers: Array2::zeros((0, 0)),
    };
    for element in &header.elements {
        values.expect(element)?;
        if element.name != wanted {
            for _ in 0..element.count {
                values.begin()?;
                element.properties.iter().try_for_each(|p| skip_property(p, &mut values))?;
            }
            continue;
        }
        let is_wanted = |property: &Property| matching(&element.name, property);
        let names = element.properties.iter().filter(|property| is_wanted(property));
        for property in names {
            if let Kind::Scalar(scalar) = property.kind {
                found.names.push(property.name().to_owned());
                found.types.push(scalar);
            }
        }
        let columns = found.names.len();
        let corners = match found.of_faces {
            true => Some(element.indices(path)?),
            false => None,
        };
        let (mut rows, mut repeated) = (0, 0);
        let mut numbers = Vec::with_capacity(values.capacity(element) * columns);
        for _ in 0..element.count {
            values.begin()?;
            let begin = numbers.len();
            let mut copies = 1;
            for (at, property) in element.properties.iter().enumerate() {
                match property.kind {
                    Kind::Scalar(scalar) if is_wanted(property) => {
                        numbers.push(values.number(scalar)?);
                    }
                    Kind::List { count, item } if corners == Some(at) => {
                        let n = list_length(&mut values, count)?;
                        values.skip(item, n)?;
                        copies = usize::try_from(n).unwrap_or(usize::MAX).saturating_sub(2);
                    }
                    _ => skip_property(property, &mut values)?,
                }
            }
            rows += copies;
            repeated += copies.saturating_sub(1).saturating_mul(columns);
            if repeated > MOST_REPEATED {
                return Err(Error::malformed(
                    path,
                    "has more numbers at its polygons than fit at their triangles; divide the polygons first",
                ));
            }
            match copies {
                0 => numbers.truncate(begin),
                _ => (1..copies).for_each(|_| numbers.extend_from_within(begin..begin + columns)),
            }
        }
        found.numbers =
            Array2::from_shape_vec((rows, columns), numbers).expect("a number for each name");
    }
    values.finish()?;
    Ok(found)
}

/// The numbers that vertices and faces have.
fn listed(header: &Header) -> String {
    let elements = header.elements.iter().filter(|e| ["vertex", "face"].contains(&e.name.as_str()));
    let names = elements.flat_map(|element| {
        let scalars = element.properties.iter().filter(|p| matches!(p.kind, Kind::Scalar(_)));
        scalars.map(move |property| format!("{}:{}", element.name, property.name()))
    });
    let names: Vec<String> = names.collect();
    if names.is_empty() { "none at all".into() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "element vertex 2\nproperty float x\nproperty double p_0\nproperty uchar p_1\n\
        element face 2\nproperty list uchar int vertex_indices\nproperty short q\nproperty float p_\n";

    fn ascii() -> Vec<u8> {
        let body = "0.5 0.25 3\n1.5 nan 4\n3 0 1 2 -7 1\n4 0 1 2 3 8 2\n";
        format!("ply\nformat ascii 1.0\n{HEADER}end_header\n{body}").into_bytes()
    }

    fn binary() -> Vec<u8> {
        let mut bytes =
            format!("ply\nformat binary_little_endian 1.0\n{HEADER}end_header\n").into_bytes();
        for (x, p, q) in [(0.5_f32, 0.25_f64, 3_u8), (1.5, f64::NAN, 4)] {
            bytes.extend(x.to_le_bytes());
            bytes.extend(p.to_le_bytes());
            bytes.push(q);
        }
        for (corners, q, p) in [(3_u8, -7_i16, 1.0_f32), (4, 8, 2.0)] {
            bytes.push(corners);
            (0..i32::from(corners)).for_each(|k| bytes.extend(k.to_le_bytes()));
            bytes.extend(q.to_le_bytes());
            bytes.extend(p.to_le_bytes());
        }
        bytes
    }

    #[test]
    fn numbers_of_either_element_are_read_from_text_and_bytes() {
        let path = Path::new("some.ply");
        for bytes in [ascii(), binary()] {
            let found =
                read_scalars(path, &bytes, &|_, name| name.starts_with("p_") && name != "p_")
                    .unwrap();
            assert!(!found.of_faces);
            assert_eq!(found.names, ["p_0", "p_1"]);
            assert_eq!(found.numbers.row(0).to_vec(), [0.25, 3.0]);
            assert!(found.numbers[[1, 0]].is_nan() && found.numbers[[1, 1]] == 4.0);
            let found = read_scalars(path, &bytes, &|_, name| name == "q").unwrap();
            // The second face is a quadrilateral, of two triangles.
            assert!(found.of_faces && found.numbers.column(0).to_vec() == [-7.0, 8.0, 8.0]);
            let message = |matches: &dyn Fn(&str, &str) -> bool| {
                read_scalars(path, &bytes, matches).err().unwrap().to_string()
            };
            assert!(
                message(&|_, name| name.starts_with("p_")).contains("at vertices and at faces")
            );
            assert!(
                message(&|_, name| name == "w")
                    .contains("but vertex:x, vertex:p_0, vertex:p_1, face:q")
            );
            let cut = &bytes[..bytes.len() - 6];
            assert!(read_scalars(path, cut, &|_, name| name == "q").is_err());
        }
    }
}
