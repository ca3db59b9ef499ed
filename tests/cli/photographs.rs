//! `render --views sphere:N`: synthetic photographs, and `render --photographs`: those of a run, with its cut.

use std::fs;

use image::RgbImage;
use ndarray::{Array1, array};
use ndarray_npy::write_npy;

use crate::support::{Folder, names, stderr};

fn picture(folder: &Folder, name: &str) -> RgbImage {
    image::open(folder.path(name)).unwrap().into_rgb8()
}

/// The labels of two halves of torus:40x25, and their colors.
fn halves() -> Folder {
    let folder = Folder::new();
    let labels = Array1::from_shape_fn(1000, |k| i32::from(k >= 500));
    write_npy(folder.path("L.npy"), &labels).unwrap();
    folder.array("C.npy", &array![[0.8, 0.2, 0.2], [0.2, 0.3, 0.8]]);
    folder
}

const PHOTOGRAPH: &str = "render torus:40x25 --labels L.npy --means C.npy";

#[test]
fn photographs_of_labels_give_the_labels_back() {
    let folder = halves();
    let printed =
        folder.done(&format!("{PHOTOGRAPH} --views sphere:14:160x120 --noise 0.1 --out p"));
    assert_eq!(printed, "views       14 photographs\nwritten to  p\n");
    let mut expected: Vec<String> = (0..14).map(|i| format!("view-{i:03}.png")).collect();
    expected.push("views.toml".into());
    assert!(names(&folder.path("p")).into_iter().eq(expected));
    assert_eq!(picture(&folder, "p/view-013.png").dimensions(), (160, 120));

    folder
        .done("segment torus:40x25 --data views:p/views.toml --regions 2 --lambda 0.002 --out run");
    let answer = folder.answer("run");
    assert_eq!(answer.summary["views"]["views_used"], 14);
    let regions = answer.summary["region_parameters"].as_array().unwrap();
    let red = |p: usize| regions[p]["mean"][0].as_f64().unwrap();
    let first = usize::from(red(0) < red(1));
    assert!((red(first) - 0.8).abs() < 0.03 && (red(1 - first) - 0.2).abs() < 0.03);
    let right = answer.labels.iter().enumerate();
    let right = right.filter(|&(k, label)| (*label as usize == first) == (k < 500)).count();
    assert!(right >= 990, "{right}");

    // The sheet of the run is that of `render`, and a folder has each photograph.
    let printed = folder.done("render run --photographs --out sheet.png");
    assert_eq!(printed, "written to  sheet.png\n");
    let sheet = picture(&folder, "sheet.png");
    assert_eq!(sheet.dimensions(), (4 * 166 - 6, 3 * 126 - 6));
    let bytes = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_eq!(bytes("sheet.png"), bytes("run/views.png"));
    folder.done("render run --photographs --out each");
    let red = |image: &RgbImage| image.pixels().filter(|pixel| pixel.0 == [230, 0, 0]).count();
    assert_eq!(names(&folder.path("each")).len(), 14);
    for i in 0..14 {
        let [before, after] = [format!("p/view-{i:03}.png"), format!("each/regions-{i:03}.png")];
        let [before, after] = [before, after].map(|name| picture(&folder, &name));
        let changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a != b).count();
        assert!(changed <= red(&after) && red(&after) < 160 * 120 / 20);
    }
    assert!(red(&sheet) > 500);
    // With the photographs elsewhere.
    fs::rename(folder.path("p"), folder.path("moved")).unwrap();
    let output = folder.run("render run --photographs");
    assert!(stderr(&output).contains("p/views.toml, which are not there"), "{}", stderr(&output));
    folder.done("render run --photographs --data views:moved/views.toml --out again.png");
    assert_eq!(bytes("again.png"), bytes("sheet.png"));
    fs::create_dir(folder.path("cameras")).unwrap();
    fs::rename(folder.path("moved/views.toml"), folder.path("cameras/c.toml")).unwrap();
    let line =
        "render run --photographs --data views:cameras/c.toml --images moved --out images.png";
    folder.done(line);
    assert_eq!(bytes("images.png"), bytes("sheet.png"));
}

/// Every file has the same bytes.
#[test]
fn photographs_do_not_depend_on_the_threads() {
    let folder = halves();
    let line =
        format!("{PHOTOGRAPH} --views sphere:5:80x60 --noise 0.2 --light 1,-2,0.5 --samples 2");
    for threads in [1, 2] {
        folder.done(&format!("{line} --threads {threads} --out {threads}"));
    }
    for name in names(&folder.path("1")) {
        let bytes = [1, 2].map(|n| fs::read(folder.path(&format!("{n}/{name}"))).unwrap());
        assert!(bytes[0] == bytes[1], "{name}");
    }
    folder.done(&format!("{line} --noise-seed 1 --out other"));
    let bytes = |name: &str| fs::read(folder.path(name)).unwrap();
    assert!(bytes("1/view-000.png") != bytes("other/view-000.png"));
    assert_eq!(bytes("1/views.toml"), bytes("other/views.toml"));
}

/// Cameras of a file, whose images have the sizes if it has none itself; and colors of vertices.
#[test]
fn cameras_of_files_make_photographs() {
    let folder = Folder::new();
    folder.array("D.npy", &ndarray::Array2::from_shape_fn((289, 3), |(_, i)| 0.2 + 0.2 * i as f64));
    let camera = "40 0 31.5 0 40 23.5 0 0 1 1 0 0 0 -1 0 0 0 -1 -0.5 0.5 2";
    folder.write("a_par.txt", format!("1\na.png {camera}\n"));
    RgbImage::new(64, 48).save(folder.path("a.png")).unwrap();
    let line = "render grid:16x16 --data D.npy --views a_par.txt --background 1,0,0";
    folder.done(&format!("{line} --out p"));
    let photograph = picture(&folder, "p/view-000.png");
    assert_eq!(photograph.dimensions(), (64, 48));
    // The unit square covers 20 x 20 pixels.
    let inside = photograph.pixels().filter(|pixel| pixel.0 == [51, 102, 153]).count();
    let outside = photograph.pixels().filter(|pixel| pixel.0 == [255, 0, 0]).count();
    assert_eq!((inside, outside), (400, 64 * 48 - 400));
    // The cameras that are written are those that were read; an existing folder keeps its other files.
    folder.write("p/notes.txt", "mine");
    folder.done(
        &line
            .replace("a_par.txt", "p/views.toml")
            .replace(" 1,0,0", " 1,0,0 --ambient 0.8 --out p"),
    );
    let darker = picture(&folder, "p/view-000.png");
    assert_eq!(
        (darker.get_pixel(32, 24).0, darker.get_pixel(0, 0).0),
        ([41, 82, 122], [255, 0, 0])
    );
    assert!(names(&folder.path("p")).into_iter().eq(["notes.txt", "view-000.png", "views.toml"]));
    // A name of a viewpoint is one, whatever files there are.
    folder.write("front", "mine");
    folder.done("render grid:16x16 --data D.npy --views front --out front.png");
}

#[test]
fn views_without_the_mesh_are_reported() {
    let folder = halves();
    folder.done(&format!("{PHOTOGRAPH} --views sphere:2:40x30 --out p"));
    let text = fs::read_to_string(folder.path("p/views.toml")).unwrap();
    let position = text.rfind("t = [").unwrap();
    folder.write("away.toml", format!("{}t = [0.0, 0.0, -9.0]\n", &text[..position]));
    let output = folder.run(&format!("{PHOTOGRAPH} --views away.toml --out q"));
    let messages = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{messages}");
    assert!(
        messages.contains("1 photograph shows nothing of the mesh, first view-001.png"),
        "{messages}"
    );
    assert!(messages.contains("2000 faces reach behind 1 camera"), "{messages}");
}
