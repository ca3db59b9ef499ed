//! Invalid textures, and meshes that cannot have one.

use std::fs;
use std::io::Cursor;

use image::{ImageFormat, RgbImage};

use super::{folder, refuse};

const TEXTURED: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

fn encode(format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    RgbImage::new(64, 64).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn malformed_images_are_refused() {
    let folder = folder();
    folder.write("textured.obj", TEXTURED);
    let png = encode(ImageFormat::Png);
    let jpeg = encode(ImageFormat::Jpeg);
    let mut damaged = png.clone();
    // The width; the checksum of the header no longer fits.
    damaged[16..20].copy_from_slice(&u32::MAX.to_be_bytes());
    for (content, part) in [
        (Vec::new(), "is empty"),
        (b"P3 1 1 255 0 0 0".to_vec(), "neither a PNG nor a JPEG"),
        (b"GIF89a\x01\0\x01\0".to_vec(), "neither a PNG nor a JPEG"),
        (png[..8].to_vec(), "cannot decode"),
        (png[..40].to_vec(), "cannot decode"),
        (png[..png.len() / 2].to_vec(), "cannot decode"),
        (jpeg[..20].to_vec(), "cannot decode"),
        (damaged, "image"),
    ] {
        folder.write("a.png", content);
        let line = "segment textured.obj --data texture:a.png --regions 2 --out out";
        refuse(&folder, line, &["a.png", part]);
    }
}

#[test]
fn paths_that_are_not_image_files_are_refused() {
    let folder = folder();
    folder.write("textured.obj", TEXTURED);
    fs::create_dir(folder.path("folder.png")).unwrap();
    for (name, part) in [("missing.png", "No such file"), ("folder.png", "is a folder")] {
        let line = format!("segment textured.obj --data texture:{name} --regions 2 --out out");
        refuse(&folder, &line, &[name, part]);
    }
}

#[test]
fn meshes_without_texture_coordinates_and_colors_are_refused() {
    let folder = folder();
    folder.write("a.png", encode(ImageFormat::Png));
    for (line, part, what) in [
        (
            "segment square.obj --regions 2 --out out",
            "square.obj",
            "has neither colors nor textures",
        ),
        ("segment square.obj --data colors --regions 2 --out out", "square.obj", "has no colors"),
        ("segment torus:9x9 --regions 2 --out out", "torus:9x9", "has neither colors nor textures"),
        (
            "segment builtin:spot --data colors --regions 2 --out out",
            "builtin:spot",
            "has no colors",
        ),
    ] {
        refuse(&folder, line, &[part, what]);
    }
    let line = "segment square.obj --data texture:a.png --regions 2 --out out";
    refuse(&folder, line, &["square.obj", "texture coordinates"]);
}
