//! Images and textures on surfaces: which image a face has, how a vertex samples it, and what is reported.

use std::fs;
use std::path::Path;

use image::{Rgb, RgbImage, Rgba, RgbaImage};
use meshseg::mesh::source;

use crate::support::{Answer, Folder, stderr};

/// A folder with the files of a case.
fn case(name: &str) -> Folder {
    let folder = Folder::new();
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name);
    for file in fs::read_dir(files).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), folder.path(file.file_name().to_str().unwrap())).unwrap();
    }
    folder
}

/// The results of `segment`, and its messages.
fn segment(folder: &Folder, arguments: &str) -> (Answer, String) {
    let output = folder.run(&format!("segment {arguments} --no-preview --out out"));
    let messages = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{arguments}\n{messages}");
    let answer = folder.answer("out");
    answer.assert_consistent();
    (answer, messages)
}

/// The error message, which has one line.
fn refused(folder: &Folder, arguments: &str) -> String {
    let output = folder.run(&format!("segment {arguments} --no-preview --out refused"));
    let messages = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{arguments}\n{messages}");
    assert!(!folder.path("refused").exists());
    let lines = messages.lines().filter(|line| line.starts_with("error: "));
    assert_eq!(lines.count(), 1, "{messages}");
    messages
}

fn shares(answer: &Answer) -> Vec<f64> {
    let regions = answer.summary["region_parameters"].as_array().unwrap();
    regions.iter().map(|region| region["share"].as_f64().unwrap()).collect()
}

fn half_and_half(answer: &Answer) {
    assert!(shares(answer).iter().all(|share| (0.45..0.55).contains(share)), "{}", answer.summary);
}

#[test]
fn each_face_takes_the_image_of_its_material() {
    for (name, mesh, image) in [
        ("02-obj-two-materials", "house.obj", "roof.png"),
        ("13-ply-texnumber", "model.ply", "page0.png"),
    ] {
        let folder = case(name);
        let (own, _) = segment(&folder, &format!("{mesh} --regions 2"));
        half_and_half(&own);
        let (all, _) = segment(&folder, &format!("{mesh} --data texture --regions 2"));
        assert_eq!(own.labels, all.labels);
        let (given, messages) =
            segment(&folder, &format!("{mesh} --data texture:{image} --regions 2"));
        assert_eq!(own.labels, given.labels);
        assert!(messages.contains("one of 2 images"), "{messages}");
        // A given image replaces all others, which is reported.
        fs::copy(folder.path(image), folder.path("other.png")).unwrap();
        let (one, messages) =
            segment(&folder, &format!("{mesh} --data texture:other.png --regions 2"));
        assert!(shares(&one).contains(&1.0), "{}", one.summary);
        assert!(messages.contains("not one of the 2 images"), "{messages}");
    }
}

/// It is an error if it was requested, and a warning if it comes with the mesh.
#[test]
fn a_missing_image() {
    let folder = case("02-obj-two-materials");
    fs::remove_file(folder.path("wall.png")).unwrap();
    let messages = refused(&folder, "house.obj --data texture --regions 2");
    assert!(messages.contains("wall") && messages.contains("wall.png: No such file"), "{messages}");
    let folder = case("47-white-colors");
    fs::remove_file(folder.path("atlas.png")).unwrap();
    let (_, messages) = segment(&folder, "model.obj --regions 2");
    assert!(messages.contains("atlas.png: No such file"), "{messages}");
}

#[test]
fn faces_without_coordinates_are_unknown() {
    let folder = case("10-obj-some-uv");
    let (answer, messages) = segment(&folder, "model.obj --data texture:atlas.png --regions 2");
    assert!(messages.contains("no texture coordinates"), "{messages}");
    assert!(shares(&answer).iter().all(|share| *share > 0.1), "{}", answer.summary);
}

#[test]
fn tiles_are_found_next_to_the_first() {
    let folder = case("16-udim");
    for image in ["tex.1001.png", "tex.1002.png", "tex.<UDIM>.png"] {
        let (answer, _) =
            segment(&folder, &format!("model.obj --data texture:{image} --regions 2"));
        half_and_half(&answer);
    }
}

/// The image is red on the left and blue on the right; only the middle column is a mixture.
#[test]
fn the_edges_of_an_image_do_not_mix() {
    let folder = case("26-wrap-u1");
    let mesh = source(folder.path("terrain.obj")).unwrap();
    for texel in ["mean", "vertex"] {
        let line = format!("terrain.obj --data texture:ortho.png --regions 3 --texel {texel}");
        let (answer, _) = segment(&folder, &line);
        for (x, label) in mesh.vertices.iter().zip(&answer.labels) {
            let alike = mesh.vertices.iter().zip(&answer.labels).all(|(y, other)| {
                label == other || ((x.x - 0.5) * (y.x - 0.5) <= 1e-6 && x.x != y.x)
            });
            assert!(alike, "{texel}: {x} has the label {label}");
        }
    }
}

/// A blue window in a red wall of two faces affects the means, and a hint reports that the mesh is too coarse.
#[test]
fn an_image_finer_than_the_mesh_is_averaged_and_reported() {
    let folder = case("41-coarse-texture");
    let (answer, messages) = segment(&folder, "wall.obj --data texture:wall.png --regions 2");
    assert!(shares(&answer).iter().all(|share| *share > 0.1), "{}", answer.summary);
    let hint = "meshseg mesh convert wall.obj --out finer.obj --subdivide 8";
    assert!(messages.contains(hint), "{messages}");
    folder.done("mesh convert wall.obj --out finer.obj --subdivide 6");
    let (answer, _) = segment(&folder, "finer.obj --data texture:wall.png --regions 2");
    let window = 150.0 * 250.0 / (0.96 * 512.0_f64).powi(2);
    let nearest = shares(&answer).iter().map(|share| (share - window).abs()).fold(1.0, f64::min);
    assert!(nearest < 0.01, "{}", answer.summary);
}

#[test]
fn textures_take_precedence_over_constant_colors() {
    let folder = case("47-white-colors");
    let (answer, messages) = segment(&folder, "model.obj --regions 2");
    assert_eq!(answer.summary["data"], "texture atlas.png");
    assert!(messages.contains("--data colors"), "{messages}");
    assert!(shares(&answer).iter().all(|share| *share > 0.1), "{}", answer.summary);
}

#[test]
fn colors_of_materials_are_data() {
    let folder = case("40-materials-kd");
    for choice in ["", "--data colors"] {
        let (answer, _) = segment(&folder, &format!("toy.obj --regions 2 {choice}"));
        assert_eq!(answer.summary["data"], "colors of faces");
        half_and_half(&answer);
    }
}

/// 16384 x 16384 gray pixels in a small file, 800 MB as colors.
#[test]
fn an_atlas_of_16k() {
    const N: u32 = 1 << 14;
    let folder = case("26-wrap-u1");
    let file = fs::File::create(folder.path("atlas.png")).unwrap();
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), N, N);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().unwrap();
    let mut stream = writer.stream_writer().unwrap();
    let row: Vec<u8> = (0..N).map(|i| if i < N / 2 { 40 } else { 200 }).collect();
    for _ in 0..N {
        std::io::Write::write_all(&mut stream, &row).unwrap();
    }
    stream.finish().unwrap();
    drop(writer);
    let (answer, messages) = segment(&folder, "terrain.obj --data texture:atlas.png --regions 2");
    half_and_half(&answer);
    assert!(messages.contains("16384 x 16384 pixels was shrunk by a factor of 2"), "{messages}");
}

/// Colors of transparent pixels are read as stored, and a warning says so.
#[test]
fn transparent_pixels_are_counted() {
    let folder = Folder::new();
    let save = |name: &str, alpha: u8| {
        let pixel = |i, _| if i < 15 { Rgba([0, 0, 0, alpha]) } else { Rgba([255; 4]) };
        RgbaImage::from_fn(60, 40, pixel).save(folder.path(name)).unwrap();
    };
    save("clear.png", 0);
    save("glass.png", 254);
    save("opaque.png", 255);
    for (name, share) in [("clear", true), ("glass", true), ("opaque", false)] {
        let line = format!("grid:30x20 --data image:{name}.png --regions 2");
        let (answer, messages) = segment(&folder, &line);
        let expected = format!("{name}.png: 600 of 2400 pixels are fully or partly transparent");
        assert_eq!(messages.contains(&expected), share, "{messages}");
        assert_eq!(messages.contains("transparent"), share, "{messages}");
        let quarter = agreement(&answer, "grid:30x20", |x| x[0] < 0.25);
        assert!(quarter > 0.95, "{name}: {quarter}");
    }
}

/// An image that is black on the left and white on the right, from column `border` of 60 on.
fn two_parts(folder: &Folder, name: &str, border: u32) {
    RgbImage::from_fn(60, 40, |i, _| Rgb([if i < border { 0 } else { 255 }; 3]))
        .save(folder.path(name))
        .unwrap();
}

fn two_halves(folder: &Folder) {
    two_parts(folder, "halves.png", 30);
}

/// The share of vertices that have the label of the darker region exactly where `dark` is true.
fn agreement(answer: &Answer, mesh: &str, dark: impl Fn([f64; 3]) -> bool) -> f64 {
    let regions = answer.summary["region_parameters"].as_array().unwrap();
    let black = regions.iter().position(|region| region["mean"][0].as_f64().unwrap() < 0.5);
    let black = black.unwrap() as i32;
    let mesh = source(mesh).unwrap();
    let right = mesh
        .vertices
        .iter()
        .zip(&answer.labels)
        .filter(|(x, label)| (**label == black) == dark([x.x, x.y, x.z]));
    right.count() as f64 / answer.labels.len() as f64
}

#[test]
fn every_projection_puts_the_image_where_it_should_be() {
    let folder = Folder::new();
    two_halves(&folder);
    type Dark = fn([f64; 3]) -> bool;
    for (mesh, project, dark, expected) in [
        ("grid:61x41", "", (|[x, ..]| x < 0.5) as Dark, "projected onto xy"),
        ("grid:61x41", "--project -x,y", |[x, ..]| x > 0.5, "projected onto -x,y"),
        (
            "grid:41x61",
            "--project y,-x --fit stretch",
            |[_, y, _]| y < 0.5 * 61.0 / 41.0,
            "projected onto y,-x",
        ),
        ("torus:60x30", "", |[_, y, _]| y > 0.0, "texture coordinates"),
        ("sphere:4", "", |[_, y, _]| y < 0.0, "texture coordinates"),
        ("sphere:4", "--project xz", |[x, ..]| x < 0.0, "projected onto xz"),
        ("sphere:4", "--project cylinder", |[_, y, _]| y < 0.0, "cylinder"),
        ("sphere:4", "--project sphere:x", |[_, _, z]| z < 0.0, "sphere"),
    ] {
        let line = format!("{mesh} --data image:halves.png {project} --regions 2");
        let (answer, lines) = segment(&folder, &line);
        assert!(lines.contains(expected), "{line}: {lines}");
        let right = agreement(&answer, mesh, dark);
        assert!(right > 0.95, "{line}: {right}");
    }
    let (_, messages) = segment(&folder, "grid:40x40 --data image:halves.png --regions 2");
    assert!(
        messages.contains("image 60 x 40 projected onto xy, 33.3 % of its width cropped"),
        "{messages}"
    );
}

/// A file written by `generate` takes the image in the same way as the shape.
#[test]
fn generated_shapes_have_texture_coordinates() {
    let folder = Folder::new();
    // No vertex lies on the border, where it could take either label.
    two_parts(&folder, "parts.png", 27);
    for shape in ["torus:24x12", "sphere:3", "grid:8x8"] {
        let (of_shape, _) =
            segment(&folder, &format!("{shape} --data texture:parts.png --regions 2"));
        for file in ["shape.obj", "shape.ply"] {
            folder.done(&format!("mesh generate {shape} --out {file}"));
            assert!(
                folder
                    .done(&format!("mesh info {file}"))
                    .contains("texture coordinates            yes")
            );
            let (of_file, _) =
                segment(&folder, &format!("{file} --data texture:parts.png --regions 2"));
            assert_eq!(of_shape.labels, of_file.labels, "{shape} as {file}");
        }
        let output = folder.run(&format!("mesh generate {shape} --out shape.off"));
        assert!(!stderr(&output).contains("WARN"), "{}", stderr(&output));
    }
}

#[test]
fn errors_list_the_possible_choices() {
    let folder = Folder::new();
    two_halves(&folder);
    folder.write("bare.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    for (line, parts) in [
        (
            "bare.off",
            ["bare.off: has neither colors nor textures", "--data image:IMAGE --project xy"],
        ),
        (
            "bare.off --data texture",
            ["has no texture coordinates", "--data image:IMAGE --project xy"],
        ),
        ("bare.off --data texture:halves.png", ["has no texture coordinates", "--data curvature"]),
        (
            "bare.off --data image:halves.png",
            ["bare.off: has no texture coordinates", "--project xy, xz, yz"],
        ),
        (
            "bare.off --data image:halves.png --project yz",
            ["bare.off: has no extent along z", "--project"],
        ),
        ("bare.off --data image:none.png --project xy", ["none.png: No such file", "error"]),
        ("grid:4x4 --data texture", ["has no material with an image", "--data texture:IMAGE"]),
        (
            "grid:4x4 --data colors",
            ["has no colors of vertices, faces or materials", "--data image:IMAGE"],
        ),
        ("builtin:spot --data colors", ["has no colors", "--data texture, "]),
        (
            "grid:4x4 --data curvature --project xy",
            ["--project needs an image", "--data image:IMAGE"],
        ),
    ] {
        let messages = refused(&folder, &format!("{line} --regions 2"));
        assert!(parts.iter().all(|part| messages.contains(part)), "{line}: {messages}");
    }
    let output =
        folder.run("segment grid:4x4 --data image:halves.png --project xx --regions 2 --out out");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("x,-z"), "{}", stderr(&output));
}

/// A run of an experiment is made again if its images change: images of materials, tiles, and colors in material
/// libraries.
#[test]
fn the_name_of_a_run_depends_on_its_images() {
    for (name, mesh, data, image) in [
        ("02-obj-two-materials", "house.obj", "own", "wall.png"),
        ("02-obj-two-materials", "house.obj", "texture", "wall.png"),
        ("02-obj-two-materials", "house.obj", "texture:roof.png", "wall.png"),
        ("13-ply-texnumber", "model.ply", "own", "page1.png"),
        ("16-udim", "model.obj", "texture:tex.1001.png", "tex.1002.png"),
        ("16-udim", "model.obj", "texture:tex.<UDIM>.png", "tex.1002.png"),
        ("26-wrap-u1", "terrain.obj", "image:ortho.png", "ortho.png"),
    ] {
        let folder = case(name);
        folder.write("e.toml", experiment(mesh, data));
        let made = || folder.done("experiment run e.toml");
        assert!(made().contains("made          1"), "{name} {data}");
        assert!(made().contains("made          0"), "{name} {data}");
        // Changes one pixel, so that the image can still be segmented.
        let mut changed = image::open(folder.path(image)).unwrap().into_rgb8();
        changed.put_pixel(1, 1, Rgb([1, 2, 3]));
        changed.save(folder.path(image)).unwrap();
        assert!(made().contains("made          1"), "{name} {data}: {image}");
        assert!(made().contains("made          0"), "{name} {data}");
    }
    for (name, mesh, library, from, to) in [
        ("40-materials-kd", "toy.obj", "toy.mtl", "Kd ", "Kd 0.125 "),
        ("02-obj-two-materials", "house.obj", "house.mtl", "map_Kd roof", "map_Kd -o 0.1 roof"),
    ] {
        let folder = case(name);
        folder.write("e.toml", experiment(mesh, "own"));
        let made = || folder.done("experiment run e.toml");
        made();
        let text = fs::read_to_string(folder.path(library)).unwrap();
        folder.write(library, format!("{text}\n# A remark.\n"));
        assert!(made().contains("made          0"), "{name}");
        folder.write(library, text.replacen(from, to, 1));
        assert!(made().contains("made          1"), "{name}");
    }
    // A missing image is an error if it was requested.
    let folder = case("02-obj-two-materials");
    fs::remove_file(folder.path("wall.png")).unwrap();
    folder.write("e.toml", experiment("house.obj", "texture"));
    let output = folder.run("experiment run e.toml");
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("wall.png: No such file"), "{}", stderr(&output));
    folder.write("e.toml", experiment("house.obj", "own"));
    assert!(folder.done("experiment run e.toml").contains("made          1"));
}

fn experiment(mesh: &str, data: &str) -> String {
    format!(
        "# ?\nstop = {{ gap = 1e-2, max-iterations = 50 }}\n[[instance]]\nmesh = {mesh:?}\ndata = {data:?}\nregions = 2\n\
         lambda = 0.01\n[[solver]]\nname = \"chambolle-pock\"\n[[figure]]\nname = \"f\"\nkind = \"decay\"\n"
    )
}

/// A JPEG file as written by a phone: the pixels of the sensor, and their orientation.
fn turned_photo(folder: &Folder, name: &str, orientation: u8) {
    let mut jpeg = Vec::new();
    let image = RgbImage::from_fn(64, 48, |i, _| Rgb([if i < 32 { 0 } else { 255 }; 3]));
    image.write_to(&mut std::io::Cursor::new(&mut jpeg), image::ImageFormat::Jpeg).unwrap();
    // One entry of a TIFF directory: tag 0x112, a short, once.
    let mut exif =
        b"\xff\xe1\0\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
    assert_eq!(exif.len(), 2 + 0x22);
    jpeg.splice(2..2, exif);
    folder.write(name, jpeg);
}

/// Photos that are projected onto a surface are turned upright; textures use the pixels as stored.
#[test]
fn photos_are_turned_by_their_orientation() {
    let folder = Folder::new();
    type Dark = fn([f64; 3]) -> bool;
    for (orientation, mesh, dark) in [
        (1, "grid:64x48", (|[x, ..]| x < 0.5) as Dark),
        (2, "grid:64x48", |[x, ..]| x > 0.5),
        (3, "grid:64x48", |[x, ..]| x > 0.5),
        (6, "grid:48x64", |[_, y, _]| y > 0.5 * 64.0 / 48.0),
        (8, "grid:48x64", |[_, y, _]| y < 0.5 * 64.0 / 48.0),
    ] {
        turned_photo(&folder, "photo.jpg", orientation);
        let (answer, messages) =
            segment(&folder, &format!("{mesh} --data image:photo.jpg --regions 2"));
        assert!(!messages.contains("EXIF") && !messages.contains("cropped"), "{messages}");
        let right = agreement(&answer, mesh, dark);
        assert!(right > 0.97, "{orientation}: {right}");
        let (answer, messages) =
            segment(&folder, "grid:64x48 --data texture:photo.jpg --regions 2");
        assert_eq!(
            messages.contains("EXIF orientation is ignored"),
            orientation != 1,
            "{messages}"
        );
        assert!(agreement(&answer, "grid:64x48", |[x, ..]| x < 0.5) > 0.97, "{orientation}");
    }
}

/// The image is red on the left and blue on the right, on [0, 1]^2.
#[test]
fn materials_place_their_images() {
    let folder = case("26-wrap-u1");
    let terrain = fs::read_to_string(folder.path("terrain.obj")).unwrap();
    folder.write("placed.obj", format!("mtllib placed.mtl\nusemtl ground\n{terrain}"));
    let mesh = source(folder.path("placed.obj")).unwrap();
    type Left = fn(f64) -> bool;
    for (options, left, warned) in [
        ("", (|x| x < 0.5) as Left, false),
        ("-o 0.5 0 0", |x| x > 0.5, false),
        ("-s -1 1 1", |x| x > 0.5, false),
        ("-s 2 1 1", |x| (2.0 * x) % 1.0 < 0.5, false),
        ("-s 2 1 1 -clamp on", |x| x < 0.25, false),
        ("-s 2 1 1 -o -0.5 -clamp on", |x| x < 0.5, false),
        ("-t 0.1 0 0", |x| x < 0.5, true),
        ("-mm 0.1 1", |x| x < 0.5, true),
    ] {
        folder.write("placed.mtl", format!("newmtl ground\nmap_Kd {options} ortho.png\n"));
        let (answer, messages) =
            segment(&folder, "placed.obj --regions 2 --lambda 1e-4 --texel vertex");
        // Away from the borders of the image and of its halves.
        let at: Vec<_> = (mesh.vertices.iter().zip(&answer.labels))
            .filter(|(v, _)| {
                (8.0 * v.x - (8.0 * v.x).round()).abs() > 0.1 || v.x * 8.0 % 2.0 == 1.0
            })
            .filter(|(v, _)| [0.0, 0.25, 0.5, 0.75, 1.0].iter().all(|b| (v.x - b).abs() > 0.03))
            .map(|(v, &label)| (left(v.x), label))
            .collect();
        let of_left = at.iter().find(|(left, _)| *left).unwrap().1;
        assert!(at.iter().all(|&(left, label)| left == (label == of_left)), "{options}: {at:?}");
        assert_eq!(messages.contains("options of map_Kd"), warned, "{options}: {messages}");
    }
}

/// A checkerboard of 16 x 16 fields of 4 texels on a mesh of 4 x 4 cells: every vertex takes the same mean, until edges
/// are as short as texels.
#[test]
fn a_fine_texture_is_segmented_after_subdivision_to_its_texels() {
    let folder = Folder::new();
    let is_white = |x: u32, y: u32| (x / 4 + y / 4).is_multiple_of(2);
    let color = |x, y| if is_white(x, y) { Rgb([255; 3]) } else { Rgb([0; 3]) };
    RgbImage::from_fn(64, 64, color).save(folder.path("checker.png")).unwrap();
    folder.done("mesh generate grid:4x4 --out grid.obj");
    let grid = fs::read_to_string(folder.path("grid.obj")).unwrap();
    folder.write("board.obj", format!("mtllib board.mtl\nusemtl board\n{grid}"));
    folder.write("board.mtl", "newmtl board\nmap_Kd checker.png\n");
    // The share of the vertices within fields that have the label of their field.
    let right = |mesh: &str| {
        let (answer, _) = segment(&folder, &format!("{mesh} --regions 2 --lambda 1e-4"));
        let mesh = source(folder.path(mesh)).unwrap();
        let (mut inside, mut white) = (0, 0);
        for (x, &label) in mesh.vertices.iter().zip(&answer.labels) {
            let [x, y] = [x.x, 1.0 - x.y].map(|t| 64.0 * t);
            if [x, y].iter().all(|t| (0.9..3.1).contains(&(t % 4.0))) {
                inside += 1;
                white += i32::from((label == 1) == is_white(x as u32, y as u32));
            }
        }
        f64::from(white.max(inside - white)) / f64::from(inside)
    };
    folder.done("mesh convert board.obj --out fine.obj --to-texel");
    assert_eq!(right("fine.obj"), 1.0);
    let (coarse, _) = segment(&folder, "board.obj --regions 2 --lambda 1e-4");
    assert!(shares(&coarse).iter().any(|share| *share < 0.1), "{}", coarse.summary);
    // With another placement, the same coordinates span twice as many texels.
    folder.write("board.mtl", "newmtl board\nmap_Kd -s 2 2 2 checker.png\n");
    let faces = |mesh: &str| source(folder.path(mesh)).unwrap().faces.len();
    folder.done("mesh convert board.obj --out two.obj --to-texel 2");
    assert_eq!(faces("two.obj"), faces("fine.obj"));
}

#[test]
fn meshes_without_an_image_have_no_texels() {
    let folder = Folder::new();
    folder.done("mesh generate grid:4x4 --out grid.obj");
    folder.write("big.mtl", "newmtl big\nmap_Kd big.png\n");
    RgbImage::new(64, 64).save(folder.path("big.png")).unwrap();
    let grid = fs::read_to_string(folder.path("grid.obj")).unwrap();
    folder.write("big.obj", format!("mtllib big.mtl\nusemtl big\n{grid}"));
    for (arguments, parts) in [
        ("torus:8x6", ["torus:8x6: has no", "--subdivide"]),
        ("grid.obj", ["no material with an image", "--subdivide"]),
        ("grid.obj --to-texel=0", ["--to-texel 0.0", "above 0"]),
        ("grid.obj --to-texel=nan", ["--to-texel NaN", "above 0"]),
        ("big.obj --to-texel=0.01", ["more than 50000000 faces", "--to-texel 1 is possible"]),
    ] {
        let option = if arguments.contains("--to-texel") { "" } else { "--to-texel" };
        let output = folder.run(&format!("mesh convert {arguments} --out out.ply {option}"));
        let messages = stderr(&output);
        assert_eq!((output.status.code(), messages.lines().count()), (Some(1), 1), "{messages}");
        assert!(parts.iter().all(|part| messages.contains(part)), "{messages}");
        assert!(!folder.path("out.ply").exists());
    }
}
