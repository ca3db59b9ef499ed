//! MTL, the material libraries of OBJ files.
//!
//! ```text
//! newmtl NAME
//! Kd r g b                             its diffuse color
//! map_Kd [-option values ...] FILE     the image of its diffuse color
//! ```
//!
//! These options are supported:
//!
//! ```text
//! -s u [v [w]]                         the image is sampled at s t + o instead of t; s is 1 and o is 0 by default;
//! -o u [v [w]]                         w is ignored
//! -clamp on|off                        on: one copy of the image instead of many
//! ```
//!
//! The manual says "expanding or shrinking the pattern" and "shifting the position of the map origin"; the formula is
//! that of programs that read and write these options (Blender, three.js, Assimp). Other options that change the image
//! are skipped with a warning, everything else without one. Names may contain blanks, be quoted, and separate folders
//! by backslashes.
//!
//! Reference: Wavefront Technologies, *Advanced Visualizer Manual*, "Material Library File" and "Texture Map Options".

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::mesh::io::occurrences::Occurrences;
use crate::mesh::io::paths::relative;
use crate::mesh::io::text::{Text, decode, file_name, parse_float, without_comment};
use crate::mesh::{Image, Material, Materials, Placement};

/// The materials of a library by name. The paths of images are resolved against the folder of the library.
pub fn parse(path: &Path, bytes: &[u8]) -> HashMap<String, Material> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut text = Text::new(path, bytes).with_comments();
    let mut all = HashMap::new();
    let mut current = None;
    let mut skipped = Occurrences::default();
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
                let Map { name, placement, complete } = Map::of(text.rest_of_line());
                if !complete {
                    skipped.add(|| format!("line {}", text.line()));
                }
                material.image =
                    (!name.is_empty()).then(|| Image::File(folder.join(file_name(name))));
                material.placement = placement;
            }
            _ => {}
        }
    }
    skipped.warn(
        path,
        "options of map_Kd that distort the image or change its colors (-t, -mm, -cc), or lack their numbers, are \
         ignored",
    );
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

/// The arguments of `map_Kd`.
#[derive(Debug, PartialEq)]
struct Map<'a> {
    name: &'a [u8],
    placement: Placement,
    /// Whether all options that change the image are supported.
    complete: bool,
}

impl<'a> Map<'a> {
    /// Parses the options and the file name that follows them.
    fn of(mut rest: &'a [u8]) -> Self {
        let mut placement = Placement::default();
        let mut complete = true;
        while rest.starts_with(b"-") {
            let (option, mut behind) = split(rest);
            let option = option.to_ascii_lowercase();
            let (least, most) = match option.as_slice() {
                b"-o" | b"-s" | b"-t" => (1, 3),
                b"-mm" => (2, 2),
                b"-bm" | b"-boost" | b"-texres" | b"-clamp" | b"-blendu" | b"-blendv" | b"-cc"
                | b"-imfchan" | b"-type" => (1, 1),
                _ => break,
            };
            let mut numbers = Vec::new();
            let mut on = false;
            for i in 0..most {
                let (value, further) = split(behind);
                let number = parse_float(value).filter(|number| number.is_finite());
                // All following words that are numbers, but the last word is the file.
                if further.is_empty() || (i >= least && number.is_none()) {
                    break;
                }
                numbers.push(number.unwrap_or(f64::NAN));
                on |= value.eq_ignore_ascii_case(b"on");
                behind = further;
            }
            match option.as_slice() {
                b"-s" | b"-o" if numbers.iter().any(|number| number.is_nan()) => complete = false,
                b"-s" => placement.scale = plane(&numbers, 1.0),
                b"-o" => placement.offset = plane(&numbers, 0.0),
                b"-clamp" => placement.clamp = on,
                b"-t" => complete &= numbers.iter().all(|&t| t == 0.0),
                b"-mm" => complete &= numbers == [0.0, 1.0],
                b"-cc" => complete &= !on,
                _ => {}
            }
            rest = behind;
        }
        Map { name: rest, placement, complete }
    }
}

/// The first two numbers; missing ones have the given value.
fn plane(numbers: &[f64], missing: f64) -> [f64; 2] {
    [0, 1].map(|axis| numbers.get(axis).copied().unwrap_or(missing))
}

/// The first word and the rest.
fn split(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    (&text[..end], text[end..].trim_ascii_start())
}

/// Writes a library for an OBJ file in `folder`, to which the names of images are relative.
pub fn write(out: &mut dyn Write, materials: &Materials, folder: &Path) -> io::Result<()> {
    for Material { name, color, image, placement } in &materials.all {
        writeln!(out, "newmtl {name}")?;
        if let Some([r, g, b]) = color {
            writeln!(out, "Kd {r} {g} {b}")?;
        }
        if let Some(image) = image {
            write!(out, "map_Kd ")?;
            let Placement { scale, offset, clamp } = placement;
            for (option, [u, v], neutral) in [("-s", scale, 1.0), ("-o", offset, 0.0)] {
                if [*u, *v] != [neutral; 2] {
                    // All three numbers, since the file name may begin with a number.
                    write!(out, "{option} {u} {v} {neutral} ")?;
                }
            }
            if *clamp {
                write!(out, "-clamp on ")?;
            }
            writeln!(out, "{}", relative(image.path(), folder))?;
        }
    }
    if materials.of_faces.contains(&None) {
        writeln!(out, "newmtl {}", materials.unused_name())?;
    }
    Ok(())
}

/// The files named by a `mtllib` line of an OBJ file in `folder`: one name with blanks, or several.
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
        let plain = Placement::default();
        let clamped = Placement { clamp: true, ..plain };
        let doubled = Placement { scale: [2.0, 2.0], ..plain };
        let moved = Placement { offset: [0.5, 0.0], ..plain };
        let both = Placement { scale: [2.0, -1.0], offset: [0.25, 1.0], clamp: true };
        for (line, name, placement, complete) in [
            ("a.png", "a.png", plain, true),
            ("my roof 2.png", "my roof 2.png", plain, true),
            ("-clamp on a.png", "a.png", clamped, true),
            ("-clamp off a.png", "a.png", plain, true),
            ("-s 1 1 1 -o 0 0 0 -mm 0 1 -bm 1.0 a b.png", "a b.png", plain, true),
            ("-s 2 2 a.png", "a.png", doubled, true),
            ("-o 0.5 a.png", "a.png", moved, true),
            ("-s 2 -1 1 -O .25 1 0 -CLAMP On a.png", "a.png", both, true),
            ("-s nan 2 a.png", "a.png", plain, false),
            ("-t 0 0 0 a.png", "a.png", plain, true),
            ("-t 0.1 a.png", "a.png", plain, false),
            ("-mm 0.2 1 a.png", "a.png", plain, false),
            ("-cc on -s 2 2 a.png", "a.png", doubled, false),
            ("-blendu off -blendv on -s 1 7.png", "7.png", plain, true),
            ("-s 1 1 1 1", "1", plain, true),
            ("-odd.png", "-odd.png", plain, true),
        ] {
            let expected = Map { name: name.as_bytes(), placement, complete };
            assert_eq!(Map::of(line.as_bytes()), expected, "{line}");
        }
    }

    #[test]
    fn placements_are_written_and_read_again() {
        let placement = Placement { scale: [2.0, 0.5], offset: [0.1, -3.0], clamp: true };
        let material = |name: &str, placement| Material {
            name: name.into(),
            image: Some(Image::File("f/1 2.png".into())),
            placement,
            ..Material::default()
        };
        let all = vec![material("a", placement), material("b", Placement::default())];
        let mut text = Vec::new();
        let materials = Materials { all: all.clone(), of_faces: vec![Some(0)] };
        write(&mut text, &materials, Path::new("f")).unwrap();
        let again = parse(Path::new("f/x.mtl"), &text);
        assert_eq!([&again["a"], &again["b"]], [&all[0], &all[1]]);
    }

    #[test]
    fn materials_of_every_spelling() {
        let text = "# made by hand\nKd 1 1 1\nnewmtl wall paper\r\nillum 2\nKd 0.5 0.25 1 # pale\n\
            map_Kd \"tex\\wall #2.png\"\nmap_Bump -bm 1 b.png\nnewmtl b\nkd 0.5\nKs 1 1 1\nnewmtl c\nKd 255 0 51\n\
            newmtl d\nKd spectral file.rfl 1\n\nmap_Kd\n";
        let all = parse(Path::new("some/where.mtl"), text.as_bytes());
        assert_eq!(all.len(), 4);
        assert_eq!(all["wall paper"].color, Some([0.5, 0.25, 1.0]));
        assert_eq!(all["wall paper"].image, Some(Image::File("some/tex/wall #2.png".into())));
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
