//! `segment --data views:FILE`: a flat square in two colors, seen by one camera from above.

use image::{Rgb, RgbImage};

use crate::support::{Folder, stderr};

const RED: [u8; 3] = [200, 40, 40];
const BLUE: [u8; 3] = [40, 40, 200];

/// The camera sees the unit square in 20 x 20 pixels in the middle of 64 x 48; the left half of the image is red.
fn scene() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("images")).unwrap();
    let half = |x: u32, _| Rgb(if x < 32 { RED } else { BLUE });
    RgbImage::from_fn(64, 48, half).save(folder.path("images/a.png")).unwrap();
    let camera = "K = [40, 0, 31.5, 0, 40, 23.5, 0, 0, 1]\nR = [1, 0, 0, 0, -1, 0, 0, 0, -1]\nt = [-0.5, 0.5, 2]\n";
    folder.write("v.toml", format!("[[view]]\nimage = \"images/a.png\"\n{camera}"));
    folder
}

const SEGMENT: &str = "segment grid:16x16 --regions 2 --lambda 0.001 --no-preview";

#[test]
fn regions_have_the_colors_of_their_pixels() {
    let folder = scene();
    folder.done(&format!("{SEGMENT} --data views:v.toml --threads 1 --out one"));
    folder.done(&format!("{SEGMENT} --data views:v.toml --threads 2 --out two"));
    let [one, two] = ["one", "two"].map(|name| folder.answer(name));
    assert_eq!(one.u, two.u);
    let views = &one.summary["views"];
    assert_eq!((&views["views_used"], &views["pixels_used"]), (&1.into(), &400.into()));
    assert_eq!((&views["unseen_share"], &views["weights"]), (&0.0.into(), &"pixel".into()));
    let regions = one.summary["region_parameters"].as_array().unwrap();
    let mut red: Vec<f64> =
        regions.iter().map(|region| region["mean"][0].as_f64().unwrap()).collect();
    red.sort_by(f64::total_cmp);
    // The cut is between two columns of vertices, so that a column of pixels mixes.
    assert!((red[0] - 40.0 / 255.0).abs() < 0.05 && (red[1] - 200.0 / 255.0).abs() < 0.05);
    // Given means are used as they are.
    let given = "segment grid:16x16 --lambda 0.001 --data views:v.toml --means one/summary.json";
    folder.done(&format!("{given} --no-preview --out given"));
    let energy = folder.answer("given").number("energy");
    assert!((energy - one.number("energy")).abs() <= 2e-4 * energy);
}

#[test]
fn cameras_of_colmap_give_the_same() {
    let folder = scene();
    folder.done(&format!("{SEGMENT} --data views:v.toml --out own"));
    std::fs::create_dir(folder.path("model")).unwrap();
    // Pixel centers at 1/2, and half a turn about the x axis.
    folder.write("model/cameras.txt", "1 SIMPLE_PINHOLE 64 48 40 32 24\n");
    folder.write("model/images.txt", "1 0 1 0 0 -0.5 0.5 2 1 a.png\n\n");
    folder.done(&format!("{SEGMENT} --data views:model --images images --out colmap"));
    assert_eq!(folder.answer("own").u, folder.answer("colmap").u);
}

#[test]
fn other_models_see_the_means_and_say_so() {
    let folder = scene();
    let output = folder.run(&format!("{SEGMENT} --data views:v.toml --model l1 --out l1"));
    let messages = stderr(&output);
    assert!(messages.contains("1 of 1 views (TOML) show the surface in 400 pixels"), "{messages}");
    assert!(messages.contains("l1 sees the mean color of the pixels"), "{messages}");
    assert_eq!(output.status.code(), Some(0));
}
