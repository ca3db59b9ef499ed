//! MTL, the descriptions of materials that an OBJ file names.
//!
//! ```text
//! newmtl NAME
//! Kd r g b                             its diffuse color
//! map_Kd [-option values ...] FILE     the image of its diffuse color
//! ```
//!
//! Everything else is skipped. Names may contain blanks, stand in quotes, and separate folders by backslashes.
//!
//! Reference: Wavefront Technologies, *Advanced Visualizer Manual*, "Material Library File", and "Texture Map Options" there.

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::mesh::io::paths::relative;
use crate::mesh::io::places::Places;
use crate::mesh::io::text::{Text, decode, file_name, parse_float, without_comment};
use crate::mesh::{Material, Materials};

/// The materials of a library by name. Images are as found from the folder of the library.
pub fn parse(path: &Path, bytes: &[u8]) -> HashMap<String, Material> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut text = Text::new(path, bytes).with_comments();
    let mut all = HashMap::new();
    let mut current = None;
    let mut moved = Places::default();
    while text.next_line() {
        let keyword = text.token().unwrap_or_default().to_ascii_lowercase();
        if keyword == b"newmtl" {
            let name = decode(text.rest_of_line());
            all.insert(name.clone(), Material { name: name.clone(), ..Material::default() });
            current = Some(name);
            continue;
        }
        let Some(material) = current.as_ref().and_then(|name| all.get_mut(name)) else { continue };
        match keyword.as_slice() {
            b"kd" => material.color = color(&mut text),
            b"map_kd" => {
                let (name, moves) = image(text.rest_of_line());
                if moves {
                    moved.add(|| format!("line {}", text.line()));
                }
                material.image = (!name.is_empty()).then(|| folder.join(file_name(name)));
            }
            _ => {}
        }
    }
    moved.warn(path, "the options -o, -s, -t and -clamp of map_Kd, which move the image or bound it, are ignored");
    all
}

/// One number for all components, or three; in [0, 1], or up to 255.
fn color(text: &mut Text) -> Option<[f64; 3]> {
    let mut component = || text.token().and_then(parse_float).filter(|c| (0.0..=255.0).contains(c));
    let r = component()?;
    let color = match (component(), component()) {
        (Some(g), Some(b)) => [r, g, b],
        _ => [r; 3],
    };
    let full = if color.iter().any(|&c| c > 1.0) { 255.0 } else { 1.0 };
    Some(color.map(|c| c / full))
}

/// The name of the file behind the options, and whether these change where the image lies or ends.
fn image(mut rest: &[u8]) -> (&[u8], bool) {
    let mut moves = false;
    while rest.starts_with(b"-") {
        let (option, mut behind) = split(rest);
        let (least, most) = match option.to_ascii_lowercase().as_slice() {
            b"-o" | b"-s" | b"-t" => (1, 3),
            b"-mm" => (2, 2),
            b"-bm" | b"-boost" | b"-texres" | b"-clamp" | b"-blendu" | b"-blendv" | b"-cc"
            | b"-imfchan" | b"-type" => (1, 1),
            _ => break,
        };
        let neutral = if option.eq_ignore_ascii_case(b"-s") { 1.0 } else { 0.0 };
        for i in 0..most {
            let (value, further) = split(behind);
            let number = parse_float(value);
            // As many as are numbers, but the last word is the file.
            if further.is_empty() || (i >= least && number.is_none()) {
                break;
            }
            moves |= most == 3 && number.is_some_and(|number| number != neutral);
            moves |= option.eq_ignore_ascii_case(b"-clamp") && value.eq_ignore_ascii_case(b"on");
            behind = further;
        }
        rest = behind;
    }
    (rest, moves)
}

/// The first word, and what follows it.
fn split(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    (&text[..end], text[end..].trim_ascii_start())
}

/// A library for an OBJ file in `folder`, to which the names of images become relative.
pub fn write(out: &mut dyn Write, materials: &Materials, folder: &Path) -> io::Result<()> {
    for Material { name, color, image } in &materials.all {
        writeln!(out, "newmtl {name}")?;
        if let Some([r, g, b]) = color {
            writeln!(out, "Kd {r} {g} {b}")?;
        }
        if let Some(image) = image {
            writeln!(out, "map_Kd {}", relative(image, folder))?;
        }
    }
    if materials.of_faces.contains(&None) {
        writeln!(out, "newmtl {}", materials.unused_name())?;
    }
    Ok(())
}

/// The files that a line of an OBJ file in `folder` names: one name with blanks, or several.
pub fn libraries(folder: &Path, names: &[u8]) -> Vec<PathBuf> {
    let whole = folder.join(file_name(names));
    if whole.is_file() {
        return vec![whole];
    }
    let names = without_comment(names);
    // A name ends with its extension.
    let mut found = Vec::new();
    let mut name: Vec<u8> = Vec::new();
    for word in names.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
        if !name.is_empty() {
            name.push(b' ');
        }
        name.extend(word);
        let ended = name.trim_ascii_end().strip_suffix(b"\"").unwrap_or(&name).to_ascii_lowercase();
        if ended.ends_with(b".mtl") {
            found.push(folder.join(file_name(&name)));
            name.clear();
        }
    }
    if !name.is_empty() {
        found.push(folder.join(file_name(&name)));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_come_before_the_name() {
        for (line, name, moves) in [
            ("a.png", "a.png", false),
            ("my roof 2.png", "my roof 2.png", false),
            ("-clamp on a.png", "a.png", true),
            ("-clamp off a.png", "a.png", false),
            ("-s 1 1 1 -o 0 0 0 -mm 0 1 -bm 1.0 a b.png", "a b.png", false),
            ("-s 2 2 a.png", "a.png", true),
            ("-o 0.5 a.png", "a.png", true),
            ("-blendu off -blendv on -s 1 7.png", "7.png", false),
            ("-s 1 1 1 1", "1", false),
            ("-odd.png", "-odd.png", false),
        ] {
            assert_eq!(image(line.as_bytes()), (name.as_bytes(), moves), "{line}");
        }
    }

    #[test]
    fn materials_of_every_spelling() {
        let text = "# made by hand\nKd 1 1 1\nnewmtl wall paper\r\nillum 2\nKd 0.5 0.25 1 # pale\n\
            map_Kd \"tex\\wall #2.png\"\nmap_Bump -bm 1 b.png\nnewmtl b\nkd 0.5\nKs 1 1 1\nnewmtl c\nKd 255 0 51\n\
            newmtl d\nKd spectral file.rfl 1\n\nmap_Kd\n";
        let all = parse(Path::new("some/where.mtl"), text.as_bytes());
        assert_eq!(all.len(), 4);
        assert_eq!(all["wall paper"].color, Some([0.5, 0.25, 1.0]));
        assert_eq!(all["wall paper"].image, Some(PathBuf::from("some/tex/wall #2.png")));
        assert_eq!(all["b"].color, Some([0.5; 3]));
        assert_eq!(all["c"].color, Some([1.0, 0.0, 0.2]));
        assert_eq!((all["d"].color, &all["d"].image), (None, &None));
    }

    #[test]
    fn several_libraries_and_names_with_blanks() {
        for (names, expected) in [
            ("a.mtl", vec!["f/a.mtl"]),
            ("a.mtl b.MTL", vec!["f/a.mtl", "f/b.MTL"]),
            ("my house.mtl", vec!["f/my house.mtl"]),
            ("\"my house.mtl\" lib\\b.mtl", vec!["f/my house.mtl", "f/lib/b.mtl"]),
            ("materials", vec!["f/materials"]),
            ("a.mtl # b.mtl", vec!["f/a.mtl"]),
        ] {
            let expected: Vec<PathBuf> = expected.into_iter().map(PathBuf::from).collect();
            assert_eq!(libraries(Path::new("f"), names.as_bytes()), expected);
        }
    }
}
