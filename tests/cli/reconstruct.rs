//! `reconstruct`: a surface from photographs, from outside.

use ndarray::{Array1, array};
use ndarray_npy::write_npy;

use crate::support::{Folder, names, stderr};

/// Photographs of a sphere with two halves, in front of a bright background.
fn photographs() -> Folder {
    let folder = Folder::new();
    // Vertices of sphere:3 do not tell their places; half of the faces of the icosahedron have these.
    let labels = Array1::from_shape_fn(642, |k| i32::from(k % 2 == 0));
    write_npy(folder.path("L.npy"), &labels).unwrap();
    folder.array("C.npy", &array![[0.8, 0.2, 0.2], [0.2, 0.3, 0.7]]);
    let line = "render sphere:3 --labels L.npy --means C.npy --background 0.9,0.9,0.9 --views sphere:8:80x60 --out p";
    folder.done(line);
    folder
}

const RUN: &str = "reconstruct --views p/views.toml --regions 2 --background 0.9,0.9,0.9";

#[test]
fn a_sphere_is_found_from_its_photographs() {
    let folder = photographs();
    let printed = folder
        .done(&format!("{RUN} --levels 2 --steps 20 --truth sphere:4 --lambda 1e-4 --out run"));
    assert!(
        printed.contains("certified for it") && printed.contains("see run/views.png"),
        "{printed}"
    );
    let files = ["labels.npy", "mesh.ply", "preview.png", "summary.json", "trace.csv", "u.npy"];
    let mut expected: Vec<String> = files.map(String::from).to_vec();
    expected.push("views.png".into());
    assert!(names(&folder.path("run")).into_iter().eq(expected));
    let answer = folder.answer("run");
    assert!(answer.number("silhouette_iou") > 0.98);
    assert!(answer.summary["distances"]["mean"].as_f64().unwrap() < 3e-3, "{printed}");
    assert_eq!(answer.labels.len(), answer.number("vertices") as usize);
    assert_eq!(answer.summary["levels"].as_array().unwrap().len(), 2);
    assert!(answer.summary["labels"]["relative_gap"].as_f64().unwrap() <= 1e-4);
    let energy = answer.column("energy");
    assert_eq!(energy.len(), answer.number("steps") as usize);
    assert!(energy[energy.len() - 1] < energy[0]);
    // The mesh can be the start of the next reconstruction, and is a surface for segmentations.
    folder
        .done(&format!("{RUN} --start run/mesh.ply --levels 1 --steps 2 --no-preview --out next"));
    assert!(!names(&folder.path("next")).contains("views.png"));
    folder.done(
        "segment run/mesh.ply --data views:p/views.toml --regions 2 --lambda 1e-3 --no-preview --out seg",
    );
}

/// Masks are what is seen of the surface: one region, white on black.
#[test]
fn silhouettes_need_no_colors() {
    let folder = photographs();
    let views = std::fs::read_to_string(folder.path("p/views.toml")).unwrap();
    // The photographs themselves: bright is outside.
    for i in 0..8 {
        let image = image::open(folder.path(&format!("p/view-{i:03}.png"))).unwrap().into_rgb8();
        let mask = image::RgbImage::from_fn(80, 60, |x, y| {
            let dark = image.get_pixel(x, y).0.iter().any(|&c| c < 200);
            image::Rgb([if dark { 255 } else { 0 }; 3])
        });
        mask.save(folder.path(&format!("p/mask-{i:03}.png"))).unwrap();
    }
    let mut i = -1;
    let masked = views.lines().map(|line| {
        i += i32::from(line.starts_with("[[view]]"));
        match line.starts_with("image") {
            true => format!("{line}\nmask = \"mask-{i:03}.png\"\n"),
            false => format!("{line}\n"),
        }
    });
    folder.write("p/masked.toml", masked.collect::<String>());
    for start in ["sphere", "box", "hull"] {
        let line =
            "reconstruct --views p/masked.toml --regions 1 --levels 1 --steps 100 --truth sphere:4";
        let printed = folder.done(&format!("{line} --start {start} --out {start}"));
        let answer = folder.answer(start);
        assert_eq!(answer.summary["background"], "masks");
        assert!(answer.number("silhouette_iou") > 0.9, "{start}: {printed}");
        assert!(answer.summary["labels"].is_null());
    }
}

/// What is wrong with a surface is said, with what to do next.
#[test]
fn surfaces_that_are_wrong_come_with_warnings() {
    let folder = photographs();
    let warned = |line: &str, clause: &str| {
        let output = folder.run(&format!("{line} --levels 1 --steps 2 --no-preview --out run"));
        assert!(output.status.success(), "{line}\n{}", stderr(&output));
        assert!(stderr(&output).contains(clause), "{line}\n{}", stderr(&output));
        let answer = folder.answer("run");
        let warnings = answer.summary["warnings"].as_array().unwrap();
        assert!(warnings.iter().any(|warning| warning.as_str().unwrap().contains(clause)));
    };
    warned(&format!("{RUN} --start sphere:0,0,0,0.05"), "give a --start nearer to it");
    warned(
        "reconstruct --views p/views.toml --regions 2 --background 0,0,0",
        "% of the images, so that nothing bounds the surface",
    );
    warned(&format!("{RUN} --start sphere:1,0,0,3.9"), "reach behind");
    warned(&format!("{RUN} --regions 16").replace("--regions 2 ", ""), "try fewer --regions");
}

#[test]
fn bad_input_is_refused_in_one_line() {
    let folder = photographs();
    let views = std::fs::read_to_string(folder.path("p/views.toml")).unwrap();
    let first = &views[..views.rfind("[[view]]").unwrap()];
    let one = &first[..first[1..].find("[[view]]").unwrap() + 1];
    folder.write("p/one.toml", one);
    let zeros = views.lines().map(|line| match line.starts_with("K =") {
        true => "K = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]\n".to_owned(),
        false => format!("{line}\n"),
    });
    folder.write("p/singular.toml", zeros.collect::<String>());
    folder.write("p/size.toml", views.replace("width = 80", "width = 81"));
    let before = folder.listing();
    let refuse = |line: &str, clause: &str| {
        let output = folder.run(&format!("{line} --out out"));
        let message = stderr(&output);
        let last = message.lines().last().unwrap_or("");
        assert_eq!(output.status.code(), Some(1), "{line}\n{message}");
        assert!(last.starts_with("error: ") && last.contains(clause), "{line}\n{message}");
    };
    let of =
        |file: &str| format!("reconstruct --views p/{file} --regions 2 --background 0.9,0.9,0.9");
    refuse(&of("one.toml"), "same direction");
    refuse(&format!("{} --start sphere:0,0,0,1", of("one.toml")), "at least two");
    refuse(&of("singular.toml"), "singular");
    refuse(&of("size.toml"), "80 x 60 pixels");
    refuse(&of("none.toml"), "none.toml");
    refuse(&format!("{RUN} --start sphere:90,0,0,1"), "no view sees the start");
    refuse(&format!("{RUN} --start sphere:0,0,0,9"), "behind every camera");
    refuse(&format!("{RUN} --truth nothing.ply"), "nothing.ply");
    refuse(&format!("{RUN} --start nothing.ply"), "nothing.ply");
    refuse(&format!("{RUN} --light 1,0,0"), "--model albedo");
    refuse(&format!("{RUN} --model albedo"), "--light");
    refuse(&format!("{RUN} --lambda -1"), "lambda");
    refuse(&format!("{RUN} --split 0.5"), "split");
    refuse(&format!("{RUN} --metric nan"), "metric");
    refuse(&format!("{RUN} --metric 6e8"), "at most 5e8");
    refuse(&format!("{RUN} --roughness -1"), "roughness");
    let line = "reconstruct --views p/views.toml --regions 1 --background";
    refuse(&format!("{line} masks"), "has no mask");
    refuse(&format!("{line} images"), "has no background");
    write_npy(folder.path("zero.npy"), &Array1::<i32>::zeros(42)).unwrap();
    folder.array("gray.npy", &array![[0.7, 0.7, 0.7], [0.7, 0.7, 0.7]]);
    let gray = "--labels zero.npy --means gray.npy --background 0.7,0.7,0.7 --out gray";
    folder.done(&format!("render sphere:1 --views p/views.toml {gray}"));
    let line = "reconstruct --views gray/views.toml --regions 2 --background 0.7,0.7,0.7";
    refuse(line, "color of the background");
    assert_eq!(folder.run(&format!("{RUN} --regions 0 --out out")).status.code(), Some(2));
    let after = folder.listing();
    assert!(after.difference(&before).all(|(path, _)| !path.starts_with(folder.path("out"))));
}
