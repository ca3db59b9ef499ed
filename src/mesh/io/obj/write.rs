//! Writing OBJ, with numbers in the fewest digits that are read back to the same bits.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io::{self, Write};

use crate::mesh::Mesh;
use crate::mesh::io::coordinates;

/// Writes the mesh. Unknown colors and texture coordinates are omitted. Materials are in the file `library`.
pub fn write(out: &mut dyn Write, mesh: &Mesh, library: Option<&str>) -> io::Result<()> {
    if let Some(library) = library {
        writeln!(out, "mtllib {library}")?;
    }
    for (k, x) in mesh.vertices.iter().enumerate() {
        let [x, y, z] = coordinates(x);
        write!(out, "v {x} {y} {z}")?;
        if let Some(colors) = &mesh.colors {
            let [r, g, b] = colors[k];
            if !r.is_nan() {
                write!(out, " {r} {g} {b}")?;
            }
        }
        writeln!(out)?;
    }
    let mut index_of = HashMap::new();
    for &[u, v] in mesh.uv.iter().flatten().flatten().filter(|t| !t[0].is_nan()) {
        let next = index_of.len() + 1;
        if let Entry::Vacant(entry) = index_of.entry([u, v].map(f64::to_bits)) {
            entry.insert(next);
            writeln!(out, "vt {u} {v}")?;
        }
    }
    let mut material = None;
    for (j, face) in mesh.faces.iter().enumerate() {
        if let Some(materials) = &mesh.materials
            && materials.of_faces[j] != material
        {
            material = materials.of_faces[j];
            match material {
                Some(material) => {
                    writeln!(out, "usemtl {}", materials.all[material as usize].name)?
                }
                None => writeln!(out, "usemtl {}", materials.unused_name())?,
            }
        }
        write!(out, "f")?;
        for (i, &k) in face.iter().enumerate() {
            write!(out, " {}", u64::from(k) + 1)?;
            let texture = mesh.uv.as_ref().map(|uv| uv[j][i]).filter(|t| !t[0].is_nan());
            if let Some(t) = texture {
                write!(out, "/{}", index_of[&t.map(f64::to_bits)])?;
            }
        }
        writeln!(out)?;
    }
    Ok(())
}
