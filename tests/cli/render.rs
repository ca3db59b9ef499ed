//! `meshseg render`: pictures of meshes and of runs.

use std::fs;

use image::RgbImage;
use ndarray::{Array1, Array2};
use ndarray_npy::write_npy;

use crate::support::{Folder, SQUARE_OBJ, stderr};

fn picture(folder: &Folder, name: &str) -> RgbImage {
    image::open(folder.path(name)).unwrap().into_rgb8()
}

/// A torus with two regions: the folder `run`, and its costs.
fn solved() -> Folder {
    let folder = Folder::new();
    let side = |k: usize, p: usize| f64::from(u8::from((k < 500) == (p == 0)));
    folder.array("S.npy", &Array2::from_shape_fn((1000, 2), |(k, p)| side(k, p)));
    folder.done("solve torus:40x25 --costs S.npy --lambda 0.05 --no-preview --out run");
    folder
}

#[test]
fn a_run_has_its_regions_and_their_u() {
    let folder = solved();
    let listing = crate::support::names(&folder.path("run"));
    let printed = folder.done("render run");
    assert_eq!(printed, "written to  render.png\n");
    let image = picture(&folder, "render.png");
    assert_eq!(image.width(), 2008);
    // Nothing is left behind, neither here nor there.
    assert_eq!(crate::support::names(&folder.path("run")), listing);
    let here = crate::support::names(&folder.path(""));
    assert_eq!(here.into_iter().collect::<Vec<_>>(), ["S.npy", "render.png", "run"]);

    folder.done(
        "render run --show labels,u:0,u:1,uncertainty --views front,30,20 --width 85 --out u.png",
    );
    assert_eq!(picture(&folder, "u.png").width(), 1004);
    // The same from the mesh and its U, and from the labels as far as they go.
    folder.done("render run --show labels --out a.png");
    folder.done("render torus:40x25 --u run/u.npy --show labels --out b.png");
    assert_eq!(fs::read(folder.path("a.png")).unwrap(), fs::read(folder.path("b.png")).unwrap());
    folder.done("render torus:40x25 --labels run/labels.npy --out c.png");
    assert_eq!(picture(&folder, "c.png").width(), 2008);
}

#[test]
fn the_data_of_a_run_are_read_again_if_they_can_be() {
    let folder = Folder::new();
    let data = Array1::from_shape_fn(1000, |k| if k < 500 { 0.2 } else { 0.9 });
    write_npy(folder.path("d.npy"), &data).unwrap();
    folder.done("segment torus:40x25 --data d.npy --regions 2 --no-preview --out run");
    folder.done("render run --out default.png");
    folder.done("render run --data d.npy --show data,means,labels --out named.png");
    folder.done("render torus:40x25 --data d.npy --u run/u.npy --out mesh.png");
    let bytes = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_eq!(bytes("default.png"), bytes("named.png"));
    assert_eq!(bytes("default.png"), bytes("mesh.png"));
    // Without the file the means remain, in the colors that they had.
    fs::remove_file(folder.path("d.npy")).unwrap();
    folder.done("render run --out rest.png");
    folder.done("render run --show means,labels --out means.png");
    assert_eq!(bytes("rest.png"), bytes("means.png"));

    folder.done("segment torus:40x25 --data curvature --regions 2 --no-preview --out bends");
    folder.done("render bends --out default.png");
    folder.done("render torus:40x25 --data curvature --u bends/u.npy --out mesh.png");
    assert_eq!(bytes("default.png"), bytes("mesh.png"));
}

/// A page has the same panels, and is whole without its folder or a network.
#[test]
fn a_run_is_also_a_page() {
    let folder = solved();
    assert_eq!(folder.done("render run --out run.html"), "written to  run.html\n");
    let page = fs::read_to_string(folder.path("run.html")).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.contains("\"caption\":\"regions\""));
    folder.done("render run --show labels,u:0 --views back,front --out two.HTML");
    assert!(fs::read_to_string(folder.path("two.HTML")).unwrap().contains("(b) u of region 0"));
    let output = folder.run("render run --out run.svg");
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("ends in .png or .html"), "{}", stderr(&output));
}

#[test]
fn pictures_do_not_depend_on_the_threads() {
    let folder = solved();
    for ground in ["", "--transparent"] {
        let line = format!("render run --show labels,u:0,uncertainty --views auto,back {ground}");
        for threads in [1, 2, 5] {
            folder.done(&format!("{line} --threads {threads} --out {threads}.png"));
        }
        let bytes = [1, 2, 5].map(|n| fs::read(folder.path(&format!("{n}.png"))).unwrap());
        assert!(bytes[0] == bytes[1] && bytes[0] == bytes[2]);
    }
}

/// A run of an experiment keeps its labels, the certainty of its vertices, and a surface with the data.
#[test]
fn runs_of_experiments_are_drawn() {
    let folder = Folder::new();
    folder.write(
        "small.toml",
        "stop = { gap = 1e-2, max-iterations = 300 }\n[[instance]]\nmesh = \"torus:24x16\"\ndata = \
         \"waves\"\nregions = 4\nlambda = 0.01\n[[solver]]\nname = \"chambolle-pock\"\n",
    );
    folder.done("experiment run small.toml --results results");
    let runs = folder.path("results/small/runs");
    let id = crate::support::names(&runs).into_iter().find(|name| !name.starts_with('.')).unwrap();
    let run = format!("results/small/runs/{id}");
    folder.done(&format!("render {run} --out default.png"));
    folder.done(&format!("render {run} --show data,means,labels --out all.png"));
    let bytes = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_eq!(bytes("default.png"), bytes("all.png"));
    folder.done(&format!("render {run} --show uncertainty,data+cut --out more.png"));
    let output = folder.run(&format!("render {run} --show u:0"));
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("only the labels are known"), "{}", stderr(&output));
}

#[test]
fn meshes_are_drawn_with_their_own_data() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE_OBJ);
    folder.write("colored.obj", SQUARE_OBJ.replace(" 0\n", " 0 0.2 0.4 0.6\n"));
    folder.done("render colored.obj --columns 3 --out colored.png");
    let image = picture(&folder, "colored.png");
    assert_eq!(image.get_pixel(1004, image.height() / 2).0, [51, 102, 153]);
    folder.array("D.npy", &ndarray::array![[0.0], [1.0], [1.0], [0.0]]);
    folder.done("render square.obj --data D.npy --width 60 --transparent --out numbers.png");
    let image = image::open(folder.path("numbers.png")).unwrap().into_rgba8();
    assert_eq!((image.width(), image.get_pixel(0, 0).0[3]), (709, 0));
    // An existing file is replaced.
    folder.done("render colored.obj --width 60 --out numbers.png");
    assert_eq!(picture(&folder, "numbers.png").get_pixel(300, 200).0, [51, 102, 153]);
}

/// What a mask leaves out is not drawn, for labels of faces and of vertices, and is said.
#[test]
fn what_a_mask_leaves_out_is_not_drawn() {
    let folder = Folder::new();
    let p = Array2::from_shape_fn((200, 2), |(j, p)| if (j < 120) == (p == 0) { 0.9 } else { 0.1 });
    folder.array("P.npy", &p);
    // The upper half of the square.
    let mask: Array1<i32> = (0..200).map(|j| i32::from(j >= 100)).collect();
    write_npy(folder.path("M.npy"), &mask).unwrap();
    for on in ["faces", "vertices"] {
        folder.done(&format!(
            "segment grid:10x10 --probabilities P.npy --mask M.npy --on {on} --lambda 0.01 --no-preview --out {on}"
        ));
        let output = folder.run(&format!("render {on} --show labels --width 400px --out {on}.png"));
        let said = stderr(&output);
        assert!(output.status.success(), "{on}: {said}");
        assert!(said.contains("100 of 200 faces are left out by the mask"), "{on}: {said}");
        // Twice as wide as it is high.
        let picture = picture(&folder, &format!("{on}.png"));
        let colored = |x: u32, y: u32| {
            let [r, g, b] = picture.get_pixel(x, y).0;
            r.max(g).max(b) - r.min(g).min(b) > 60
        };
        let columns = (0..picture.width()).filter(|&x| (0..60).any(|y| colored(x, y))).count();
        let middle = picture.width() / 2;
        let rows = (0..picture.height()).take_while(|&y| y < 20 || colored(middle, y)).count();
        assert!(columns > 300 && rows < 260, "{on}: {columns} x {rows}");
    }
}
