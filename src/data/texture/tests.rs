//! Images are checked texel by texel, means against exact integrals.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{
    DynamicImage, GrayImage, ImageBuffer, ImageFormat, Luma, Rgb, RgbImage, Rgba, RgbaImage,
};
use nalgebra::Point3;

use super::sample::Footprint;
use super::*;
use crate::error::{Error, Result};
use crate::mesh::{Image, Material, Materials, Mesh, Placement};

const FACE: [[f64; 2]; 3] = [[0.1, 0.2], [0.3, 0.2], [0.1, 0.4]];

fn encode(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn texture(image: impl Into<DynamicImage>) -> Texture {
    Texture::decode(&encode(image, ImageFormat::Png), Path::new("t.png")).unwrap()
}

/// 2 x 2: red, green above blue, white.
fn four() -> RgbImage {
    let texels = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
    RgbImage::from_raw(2, 2, texels.concat()).unwrap()
}

/// Red is the column, green the row, so that a bilinear color encodes its position.
fn ramp(n: u32) -> RgbImage {
    RgbImage::from_fn(n, n, |i, row| Rgb([i as u8, row as u8, 77]))
}

fn corners(texture: &mut Texture, uv: [[f64; 2]; 3], texel: Texel) -> [[f64; 3]; 3] {
    let footprint = Footprint::new(&uv, texture.extent(), texture.clamp, 64);
    texture.reach(footprint.level);
    texture.of_corners(&footprint, texel)
}

/// The color at a point: that of a tiny face around it.
fn sample(texture: &mut Texture, [u, v]: [f64; 2]) -> [f64; 3] {
    corners(texture, [[u, v]; 3], Texel::Vertex)[0]
}

fn error(bytes: &[u8]) -> String {
    let message = Texture::decode(bytes, Path::new("t.png")).err().unwrap().to_string();
    assert!(message.starts_with("t.png: ") && !message.contains('\n'), "{message}");
    message
}

fn assert_near(a: [f64; 3], b: [f64; 3], tolerance: f64) {
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= tolerance, "{a} and {b}");
    }
}

#[test]
fn texel_centers_return_their_texels_and_v_points_up() {
    let mut texture = texture(four());
    assert_eq!(sample(&mut texture, [0.25, 0.75]), [1.0, 0.0, 0.0]);
    assert_eq!(sample(&mut texture, [0.75, 0.75]), [0.0, 1.0, 0.0]);
    assert_eq!(sample(&mut texture, [0.25, 0.25]), [0.0, 0.0, 1.0]);
    assert_eq!(sample(&mut texture, [0.75, 0.25]), [1.0, 1.0, 1.0]);
    assert_eq!(sample(&mut texture, [0.5, 0.5]), [0.5; 3]);
}

/// Colors repeat in every tile; within a tile the opposite edge has no influence.
#[test]
fn edges_clamp_in_every_tile() {
    let mut texture = texture(four());
    assert_eq!(sample(&mut texture, [0.0, 1.0]), [1.0, 0.0, 0.0]);
    assert_eq!(sample(&mut texture, [1.0, 1.0]), [0.0, 1.0, 0.0]);
    assert_eq!(sample(&mut texture, [0.0, 0.0]), [0.0, 0.0, 1.0]);
    assert_eq!(sample(&mut texture, [1.0, 0.0]), [1.0; 3]);
    for uv in [[0.3, 0.9], [0.6, 0.4], [0.99, 0.01]] {
        let shifted = sample(&mut texture, [uv[0] + 3.0, uv[1] - 2.0]);
        assert_near(sample(&mut texture, uv), shifted, 1e-12);
    }
    // A face of one tile, up to a texel, at its border.
    let right = corners(&mut texture, [[0.2, 0.9], [1.0, 0.9], [1.1, 0.9]], Texel::Vertex);
    assert_eq!((right[1], right[2]), ([0.0, 1.0, 0.0], [0.0, 1.0, 0.0]));
}

/// On a face across the border of tiles the image is repeated.
#[test]
fn images_repeat_on_faces_across_a_border() {
    let mut texture = texture(ramp(16));
    let across = corners(&mut texture, [[-0.25, 0.5], [0.5, 0.5], [0.0, 0.5]], Texel::Vertex);
    assert_near(across[0], sample(&mut texture, [0.75, 0.5]), 1e-12);
    assert_near(across[1], sample(&mut texture, [0.5, 0.5]), 1e-12);
    // Half of the first column, half of the last.
    assert!((across[2][0] * 255.0 - 7.5).abs() < 1e-12);
    let tiled = corners(&mut texture, [[0.0, 0.0], [3.75, 0.25], [0.0, 4.0]], Texel::Vertex);
    assert_near(tiled[1], sample(&mut texture, [0.75, 0.25]), 1e-12);
}

#[test]
fn gray_deep_palettes_and_transparent_images_keep_their_values() {
    let mut gray = texture(GrayImage::from_pixel(3, 1, Luma([51])));
    assert_eq!(sample(&mut gray, [0.4, 0.2]), [0.2; 3]);
    let deep: ImageBuffer<Rgb<u16>, _> = ImageBuffer::from_pixel(1, 1, Rgb([1, 0, 65535]));
    assert_eq!(sample(&mut texture(deep), [0.0, 0.0]), [1.0 / 65535.0, 0.0, 1.0]);
    let clear = RgbaImage::from_pixel(2, 2, Rgba([255, 51, 0, 0]));
    assert_eq!(sample(&mut texture(clear), [0.1, 0.1]), [1.0, 0.2, 0.0]);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 3, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_palette(vec![255, 51, 0, 0, 51, 255]);
    encoder.write_header().unwrap().write_image_data(&[0b0100_0000]).unwrap();
    let mut palette = Texture::decode(&bytes, Path::new("t.png")).unwrap();
    assert_eq!(sample(&mut palette, [0.0, 0.0]), [1.0, 0.2, 0.0]);
    assert_eq!(sample(&mut palette, [0.5, 0.0]), [0.0, 0.2, 1.0]);
}

#[test]
fn jpeg_images_are_read() {
    let bytes = encode(RgbImage::from_pixel(16, 16, Rgb([128; 3])), ImageFormat::Jpeg);
    let mut texture = Texture::decode(&bytes, Path::new("t.jpg")).unwrap();
    assert_near(sample(&mut texture, [0.5, 0.5]), [0.5; 3], 0.02);
}

/// The image is half as wide as in the file and approximates the means: a ramp consists of low frequencies.
#[test]
fn large_jpeg_images_are_shrunk_and_turned() {
    const SIZE: [u32; 2] = [8_321, 8_205];
    let level = |i: u32, j: u32| (i / 64 + j / 128) as u8;
    let ramp = GrayImage::from_fn(SIZE[0], SIZE[1], |i, j| Luma([level(i, j)]));
    let bytes = encode(ramp, ImageFormat::Jpeg);
    let decoded = decode::jpeg(&bytes, Path::new("t.jpg"), Turn::Upright).unwrap();
    assert_eq!([decoded.width, decoded.height, decoded.k], [SIZE[0], SIZE[1], 1]);
    let [width, height] = SIZE.map(|length| length.div_ceil(2));
    let decode::Texels::Eight(texels) = decoded.texels else { panic!("8 bits") };
    assert_eq!(texels.len(), (width * height) as usize);
    let at = |i: u32, j: u32| texels[(j * width + i) as usize];
    for (i, j) in [(0, 0), (17, 4000), (4160, 0), (2000, 2001), (4160, 4102)] {
        let there = i32::from(level(2 * i, 2 * j));
        assert!(at(i, j).iter().all(|&c| (i32::from(c) - there).abs() <= 3), "{i} {j}");
    }
    // The orientation of a camera held upright: columns from the left become rows from the top.
    let mut turned = bytes;
    let exif =
        b"\xff\xe1\0\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    turned.splice(2..2, *exif);
    let decoded = decode::jpeg(&turned, Path::new("t.jpg"), Turn::Upright).unwrap();
    assert_eq!([decoded.width, decoded.height, decoded.k], [SIZE[1], SIZE[0], 1]);
    let decode::Texels::Eight(upright) = decoded.texels else { panic!("8 bits") };
    for (i, j) in [(0, 0), (17, 4000), (2000, 2001), (4160, 4102)] {
        assert_eq!(upright[(i * height + height - 1 - j) as usize], at(i, j), "{i} {j}");
    }
}

/// A bilinear color is linear in the coordinates, so its mean over a share is its value at the share's centroid:
/// (22 a + 7 b + 7 c) / 36 at corner a.
#[test]
fn means_of_a_linear_image_are_exact_in_every_size_of_face() {
    let mut texture = texture(ramp(128));
    for size in [1e-3, 0.01, 0.1, 0.6] {
        let uv = [[0.2, 0.1], [0.2 + size, 0.1 + 0.3 * size], [0.2 + 0.1 * size, 0.1 + size]];
        let means = corners(&mut texture, uv, Texel::Mean);
        for i in 0..3 {
            let point = [0, 1].map(|axis| {
                (22.0 * uv[i][axis] + 7.0 * uv[(i + 1) % 3][axis] + 7.0 * uv[(i + 2) % 3][axis])
                    / 36.0
            });
            assert_near(means[i], sample(&mut texture, point), 1e-12);
        }
    }
}

/// Stripes of one texel alias at points; their means are gray, whether each texel is sampled or a smaller image is
/// used.
#[test]
fn means_of_fine_stripes_are_gray() {
    let stripes = RgbImage::from_fn(256, 256, |i, _| Rgb([if i % 2 == 0 { 0 } else { 255 }; 3]));
    let mut texture = texture(stripes);
    let uv = [[0.02, 0.02], [0.95, 0.02], [0.02, 0.95]];
    for most in [4, 16, 200] {
        let footprint = Footprint::new(&uv, texture.extent(), texture.clamp, most);
        texture.reach(footprint.level);
        for color in texture.of_corners(&footprint, Texel::Mean) {
            assert_near(color, [0.5; 3], 0.02);
        }
    }
    assert_eq!(Footprint::new(&uv, texture.extent(), texture.clamp, 200).level, 0);
    assert!(Footprint::new(&uv, texture.extent(), texture.clamp, 4).level >= 5);
}

#[test]
fn other_files_give_one_clear_line() {
    assert!(error(b"").contains("neither"));
    assert!(error(b"solid cube").contains("neither"));
    assert!(error(b"GIF89a0000000000").contains("neither"));
    let png = encode(RgbImage::new(64, 64), ImageFormat::Png);
    let jpeg = encode(RgbImage::new(64, 64), ImageFormat::Jpeg);
    for cut in [8, 20, 40, png.len() / 2] {
        assert!(error(&png[..cut]).contains("cannot decode"), "{cut}");
    }
    assert!(error(&jpeg[..20]).contains("cannot decode"));
    let folder = Texture::open(Path::new("."), Turn::AsStored).err().unwrap().to_string();
    assert!(folder.contains("is a folder") && !folder.contains('\n'));
    let missing = Texture::open(Path::new("no-such.png"), Turn::AsStored).err().unwrap();
    assert!(missing.to_string().starts_with("no-such.png: "));
}

/// A PNG image of one pixel whose header declares another size.
fn with_size(width: u32, height: u32) -> Vec<u8> {
    let mut png = encode(RgbImage::new(1, 1), ImageFormat::Png);
    let ihdr = 12..29;
    png[16..20].copy_from_slice(&width.to_be_bytes());
    png[20..24].copy_from_slice(&height.to_be_bytes());
    let checksum = crc(&png[ihdr.clone()]);
    png[ihdr.end..ihdr.end + 4].copy_from_slice(&checksum.to_be_bytes());
    png
}

/// CRC-32 of a PNG chunk.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |mut c: u32, &byte| {
        c ^= u32::from(byte);
        for _ in 0..8 {
            c = if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
        }
        c
    })
}

#[test]
fn a_header_that_declares_more_than_the_file_holds_is_refused() {
    assert!(error(&with_size(0x8000, 0x8000)).contains("declares 32768 x 32768"));
    assert!(error(&with_size(1 << 20, 1 << 20)).contains("too large"));
    assert!(error(&with_size(0, 4)).contains("image"));
    // A frame header of 65535 x 65535.
    let mut jpeg = encode(RgbImage::new(8, 8), ImageFormat::Jpeg);
    let frame = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0xff; 4]);
    assert!(error(&jpeg).contains("declares 65535 x 65535"));
}

/// 10,000 x 10,000 gray pixels in rows: the result has half the width and consists of means.
#[test]
fn large_images_are_shrunk_while_they_are_read() {
    const N: u32 = 10_000;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, N, N);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().unwrap();
    let mut stream = writer.stream_writer().unwrap();
    let row: Vec<u8> = (0..N).map(|i| if i < N / 2 { 51 } else { 102 }).collect();
    for _ in 0..N {
        std::io::Write::write_all(&mut stream, &row).unwrap();
    }
    stream.finish().unwrap();
    drop(writer);
    let mut texture = Texture::decode(&bytes, Path::new("t.png")).unwrap();
    assert_eq!((texture.width, texture.shrunk(), texture.extent()), (N, 1, [5000.0; 2]));
    assert_eq!(sample(&mut texture, [0.25, 0.9]), [0.2; 3]);
    assert_eq!(sample(&mut texture, [0.75, 0.1]), [0.4; 3]);
}

/// Two faces with a common edge, and a vertex in no face.
fn pair() -> Mesh {
    let corners =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -3.0, 0.0], [9.0, 9.0, 9.0]];
    Mesh::new(corners.map(Point3::from).to_vec(), vec![[0, 1, 2], [0, 3, 1]])
}

/// A folder with images of one color each.
fn folder(images: &[(&str, [u8; 3])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, color) in images {
        RgbImage::from_pixel(4, 4, Rgb(*color)).save(folder.path().join(name)).unwrap();
    }
    folder
}

fn paint(mesh: &Mesh, paints: Paints) -> Result<Painted> {
    paints.colors(mesh, Texel::Mean, true)
}

#[test]
fn a_seam_averages_its_sides_by_area() {
    let mesh = pair();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("four.png");
    four().save(&path).unwrap();
    let uv = [[[0.25, 0.75]; 3], [[0.75, 0.75]; 3]];
    let paints = Paints::of_image(Content::File(path.clone(), Turn::AsStored), &uv);
    let colors = paint(&mesh, paints).unwrap().colors;
    assert_eq!(colors[2], [1.0, 0.0, 0.0]);
    assert_eq!(colors[3], [0.0, 1.0, 0.0]);
    assert_eq!(colors[0], [0.25, 0.75, 0.0]);
    assert_eq!(colors[4], [0.5; 3]);
    // A face without coordinates is unknown, but vertices that it shares with others are known.
    let uv = [[[0.25, 0.75]; 3], [[f64::NAN; 2]; 3]];
    let paints = Paints::of_image(Content::File(path.clone(), Turn::AsStored), &uv);
    let colors = paint(&mesh, paints).unwrap().colors;
    assert_eq!((colors[0], colors[4]), ([1.0, 0.0, 0.0], [0.5; 3]));
    assert!(colors[3].iter().all(|c| c.is_nan()));
    let uv = [[[f64::NAN; 2]; 3]; 2];
    let error =
        paint(&mesh, Paints::of_image(Content::File(path, Turn::AsStored), &uv)).err().unwrap();
    assert!(error.to_string().contains("2 have no texture coordinates"), "{error}");
}

fn materials(folder: &Path, of_faces: [Option<u32>; 2]) -> Materials {
    let material = |name: &str, color, image: Option<&str>| Material {
        name: name.into(),
        color,
        image: image.map(|image| Image::File(folder.join(image))),
        placement: Placement::default(),
    };
    Materials {
        all: vec![
            material("roof", None, Some("roof.png")),
            material("wall", Some([0.8; 3]), Some("wall.png")),
            material("door", Some([0.2, 0.4, 0.6]), None),
        ],
        of_faces: of_faces.to_vec(),
    }
}

#[test]
fn each_face_takes_the_image_or_the_color_of_its_material() {
    let mut mesh = pair();
    let folder = folder(&[("roof.png", [255, 0, 0]), ("wall.png", [0, 0, 255])]);
    let uv = [FACE; 2];
    let mut colors = |of_faces, given: Option<&str>| {
        let materials = materials(folder.path(), of_faces);
        mesh.materials = Some(materials.clone());
        let given = given.map(|name| folder.path().join(name));
        let paints = Paints::of_materials(&mesh, &materials, &uv, given.as_deref());
        paint(&mesh, paints).map(|painted| (painted.colors[2], painted.colors[3]))
    };
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(colors([Some(0), Some(1)], None).unwrap(), (red, blue));
    assert_eq!(colors([Some(1), Some(0)], Some("roof.png")).unwrap(), (blue, red));
    let (of_roof, of_door) = colors([Some(0), Some(2)], None).unwrap();
    assert_eq!(of_roof, red);
    assert_near(of_door, [0.2, 0.4, 0.6], 1e-15);
    assert!(colors([Some(0), None], None).unwrap().1[0].is_nan());
    assert!(colors([None, None], None).is_err());
}

/// Images inside the file of the mesh give the colors that files give; a given file of their name takes their place.
#[test]
fn images_inside_the_mesh_are_painted_as_files_are() {
    let mut mesh = pair();
    let folder = folder(&[("roof.png", [255, 0, 0]), ("wall.png", [0, 0, 255])]);
    let mut all = materials(folder.path(), [Some(0), Some(1)]);
    let of_files = paint(&mesh, Paints::of_materials(&mesh, &all, &[FACE; 2], None)).unwrap();
    for material in &mut all.all {
        if let Some(Image::File(path)) = &material.image {
            let bytes = std::fs::read(path).unwrap().into();
            material.image = Some(Image::Inside(path.file_name().unwrap().into(), bytes));
        }
    }
    mesh.materials = Some(all.clone());
    let inside = paint(&mesh, Paints::of_materials(&mesh, &all, &[FACE; 2], None)).unwrap();
    assert_eq!(format!("{:?}", inside.colors), format!("{:?}", of_files.colors));
    assert_eq!(inside.images, ["roof.png", "wall.png"]);
    std::fs::copy(folder.path().join("wall.png"), folder.path().join("ROOF.png")).unwrap();
    let given = folder.path().join("ROOF.png");
    let paints = Paints::of_materials(&mesh, &all, &[FACE; 2], Some(&given));
    assert_eq!(paint(&mesh, paints).unwrap().colors[2], [0.0, 0.0, 1.0]);
}

/// A requested image must be readable; otherwise the remaining images are used.
#[test]
fn a_missing_image_is_named_with_its_material() {
    let mut mesh = pair();
    let folder = folder(&[("roof.png", [255, 0, 0])]);
    let materials = materials(folder.path(), [Some(0), Some(1)]);
    mesh.materials = Some(materials.clone());
    let uv = [FACE; 2];
    let paints = || Paints::of_materials(&mesh, &materials, &uv, None);
    let error = paints().colors(&mesh, Texel::Mean, true).err().unwrap().to_string();
    assert!(error.contains("material wall") && error.contains("wall.png"), "{error}");
    let colors = paints().colors(&mesh, Texel::Mean, false).unwrap().colors;
    assert!(colors[2] == [1.0, 0.0, 0.0] && colors[3][0].is_nan());
    // Images are found next to the given one, wherever the materials say they are.
    let moved = super::tests::materials(Path::new("elsewhere"), [Some(0), Some(0)]);
    let given = folder.path().join("wall.png");
    let paints = Paints::of_materials(&mesh, &moved, &uv, Some(&given));
    assert_eq!(paint(&mesh, paints).unwrap().colors[3], [1.0, 0.0, 0.0]);
}

#[test]
fn each_tile_has_its_own_image() {
    let mesh = pair();
    let folder = folder(&[
        ("skin.1001.png", [255, 0, 0]),
        ("skin.1012.png", [0, 0, 255]),
        ("brick_1024.png", [0, 255, 0]),
    ]);
    let moved = |du: f64, dv: f64| FACE.map(|[u, v]| [u + du, v + dv]);
    let colors = |name: &str, uv: [[[f64; 2]; 3]; 2]| {
        let path: PathBuf = folder.path().join(name);
        let colors =
            paint(&mesh, Paints::of_image(Content::File(path, Turn::AsStored), &uv))?.colors;
        Ok::<_, Error>((colors[2], colors[3]))
    };
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    for name in ["skin.1001.png", "skin.1012.png", "skin.<UDIM>.png"] {
        assert_eq!(colors(name, [FACE, moved(1.0, 1.0)]).unwrap(), (red, blue), "{name}");
        // A missing tile is unknown.
        let (known, unknown) = colors(name, [FACE, moved(1.0, 0.0)]).unwrap();
        assert_eq!(known, red);
        assert!(unknown[0].is_nan(), "{name}");
    }
    assert!(colors("skin.1001.png", [moved(-1.0, 0.0); 2]).is_err());
    // A tile with its own coordinates, and a number that is a size.
    assert_eq!(colors("skin.1012.png", [FACE; 2]).unwrap(), (blue, blue));
    let green = [0.0, 1.0, 0.0];
    assert_eq!(colors("brick_1024.png", [FACE, moved(3.0, 2.0)]).unwrap(), (green, green));
}

/// Red at the left, blue at the right, in one image that two materials place in different ways.
#[test]
fn placements_scale_and_move_coordinates_and_clamp() {
    let mesh = pair();
    let folder = tempfile::tempdir().unwrap();
    let half = |i: u32, _: u32| Rgb(if i < 2 { [255, 0, 0] } else { [0, 0, 255] });
    for name in ["half.png", "half.1001.png"] {
        RgbImage::from_fn(4, 4, half).save(folder.path().join(name)).unwrap();
    }
    let colors = |name: &str, placements: [Placement; 2], uv: [[[f64; 2]; 3]; 2]| {
        let mut materials = materials(folder.path(), [Some(0), Some(1)]);
        for (material, placement) in materials.all.iter_mut().zip(placements) {
            material.image = Some(Image::File(folder.path().join(name)));
            material.placement = placement;
        }
        let painted = paint(&mesh, Paints::of_materials(&mesh, &materials, &uv, None)).unwrap();
        (painted.colors[2], painted.colors[3])
    };
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let plain = Placement::default();
    let at = |u: f64| [[[u, 0.5]; 3]; 2];
    let moved = Placement { offset: [0.5, 0.0], ..plain };
    assert_eq!(colors("half.png", [plain, moved], at(0.2)), (red, blue));
    let scaled = Placement { scale: [3.0, 1.0], ..plain };
    assert_eq!(colors("half.png", [plain, scaled], at(0.3)), (red, blue));
    let both = Placement { scale: [3.0, 1.0], offset: [-0.7, 0.0], ..plain };
    assert_eq!(colors("half.png", [scaled, both], at(0.3)), (blue, red));
    let clamped = Placement { clamp: true, ..plain };
    assert_eq!(colors("half.png", [plain, clamped], at(1.3)), (red, blue));
    assert_eq!(colors("half.png", [plain, clamped], at(-0.3)), (blue, red));
    // A clamped image has no tiles, and its edges extend as far as a face reaches.
    assert_eq!(colors("half.1001.png", [clamped; 2], at(7.3)), (blue, blue));
    let wide = [[[1.2, 0.5], [9.4, 0.5], [5.0, 0.5]]; 2];
    assert_eq!(colors("half.png", [clamped; 2], wide), (blue, blue));
}

#[test]
fn colors_of_faces_take_precedence_over_those_of_materials() {
    let mut mesh = pair();
    mesh.materials = Some(materials(Path::new(""), [Some(2), Some(1)]));
    assert_eq!(color_of_face(&mesh, 0), Some([0.2, 0.4, 0.6]));
    mesh.face_colors = Some(vec![[0.1; 3], [f64::NAN; 3]]);
    assert_eq!(color_of_face(&mesh, 0), Some([0.1; 3]));
    assert_eq!(color_of_face(&mesh, 1), Some([0.8; 3]));
    mesh.materials = None;
    assert_eq!(color_of_face(&mesh, 1), None);
}
