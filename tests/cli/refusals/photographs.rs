//! Photographs that cannot be made or drawn into.

use ndarray::{Array1, array};
use ndarray_npy::write_npy;

use super::{folder, misuse, refuse};

#[test]
fn impossible_photographs_are_refused() {
    let folder = folder();
    let labels = |name: &str, labels: &[i32]| {
        write_npy(folder.path(name), &Array1::from(labels.to_vec())).unwrap();
    };
    labels("L.npy", &[0, 1, 2, 0]);
    labels("three.npy", &[0, 1, 1]);
    labels("negative.npy", &[0, 1, -1, 0]);
    folder.array("two.npy", &array![[0.1, 0.2, 0.3], [0.3, 0.2, 0.1]]);
    folder.array("gray.npy", &array![[0.1], [0.2], [0.3]]);
    folder.array("bright.npy", &array![[0.1, 0.2, 0.3], [0.3, 0.2, 1.1], [0.0, 0.0, 0.0]]);
    folder.write("text.txt", "v 0 0 0\n");
    folder.write(
        "bare_par.txt",
        "1\nb.png 40 0 31.5 0 40 23.5 0 0 1 1 0 0 0 -1 0 0 0 -1 -0.5 0.5 2\n",
    );
    let away = "[[view]]\nimage = \"a\"\nwidth = 64\nheight = 48\nK = [40, 0, 31.5, 0, 40, 23.5, 0, 0, 1]\n\
                R = [1, 0, 0, 0, -1, 0, 0, 0, -1]\nt = [-0.5, 0.5, -2.0]\n";
    folder.write("away.toml", away);
    folder.write("large.toml", away.replace("64", "7000000"));
    let line = "render square.obj --views sphere:3:40x30 --labels L.npy";
    for (options, parts) in [
        ("", ["--out DIR", ""]),
        ("--out file.txt/below", ["file.txt/below", "above it is a file"]),
        ("--out p --light 0,0,0", ["0,0,0", "not all 0"]),
        ("--out p --light nan,0,0", ["NaN,0,0", "finite"]),
        ("--out p --ambient -1", ["ambient light -1", "at least 0"]),
        ("--out p --noise -0.1", ["noise -0.1", "at least 0"]),
        ("--out p --noise inf", ["noise inf", "finite"]),
        ("--out p --background 0,0,2", ["background 0,0,2", "from 0 to 1"]),
        ("--out p --means two.npy", ["vertex 2 has the label 2", "only 2 regions"]),
        ("--out p --means gray.npy", ["gray.npy", "region 0 has no color"]),
        ("--out p --means bright.npy", ["bright.npy", "region 1 has no color"]),
        ("--out p --means missing.npy", ["missing.npy", "No such file"]),
        ("--out p --data D.npy", ["either --data or --labels", ""]),
        ("--out p --show labels", ["--show does not apply", ""]),
        ("--out p --transparent", ["--transparent does not apply", ""]),
    ] {
        folder.write("file.txt", "mine");
        refuse(&folder, &format!("{line} {options}"), &parts);
    }
    for (views, parts) in [
        ("text.txt", ["text.txt", "is not a file of cameras"]),
        ("bare_par.txt", ["b.png", "does not exist"]),
        ("away.toml", ["no view shows the mesh", ""]),
        ("large.toml", ["cannot have 7000000 x 48 pixels", "choose another size"]),
    ] {
        refuse(
            &folder,
            &line.replace("sphere:3:40x30", views).replace("L.npy", "L.npy --out p"),
            &parts,
        );
    }
    for (labels, parts) in [
        ("three.npy", ["three.npy", "one row per vertex"]),
        ("negative.npy", ["negative.npy", "label -1 in row 2"]),
        ("S.npy", ["S.npy", "2 axes"]),
    ] {
        refuse(&folder, &format!("{} --out p", line.replace("L.npy", labels)), &parts);
    }
    let mesh = "render square.obj --views sphere:3 --out p";
    refuse(&folder, mesh, &["square.obj", "--data FILE.npy"]);
    refuse(&folder, &format!("{mesh} --data D.npy --means two.npy"), &["--means needs --labels"]);
    std::fs::create_dir(folder.path("run")).unwrap();
    refuse(&folder, "render run --views sphere:3 --out p", &["run", "is a folder"]);
    for option in ["--noise 1", "--light 1,0,0", "--samples 2", "--means two.npy"] {
        let line = format!("render square.obj --u U.npy --show labels {option}");
        refuse(&folder, &line, &["needs cameras"]);
    }
}

#[test]
fn malformed_cameras_are_refused() {
    let folder = folder();
    for (views, part) in [
        ("sphere:0", "from 1 to 1000"),
        ("sphere:1001", "from 1 to 1000"),
        ("sphere:x", "from 1 to 1000"),
        ("sphere:-3", "from 1 to 1000"),
        ("sphere:", "from 1 to 1000"),
        ("sphere:3:40", "must be WxH"),
        ("sphere:3:0x30", "must be WxH"),
        ("sphere:3:40x30x2", "must be WxH"),
        ("sphere:3:-40x30", "must be WxH"),
        ("sphere:3:65536x65536", "must be WxH"),
        ("missing.toml", "a file that exists"),
    ] {
        misuse(&folder, &format!("render square.obj --views {views} --out p"), part);
    }
    for (option, part) in [
        ("--light 1,2", "three numbers"),
        ("--light x,y,z", "three numbers"),
        ("--background 0.5", "three numbers"),
        ("--samples 0", "0 is not in 1..=16"),
        ("--noise-seed -1", "--noise-seed"),
    ] {
        misuse(&folder, &format!("render square.obj --views sphere:3 --out p {option}"), part);
    }
}

#[test]
fn runs_without_views_have_no_photographs() {
    let folder = folder();
    folder.done("solve square.obj --costs S.npy --lambda 0.1 --no-preview --out run");
    std::fs::create_dir(folder.path("empty")).unwrap();
    for (line, parts) in [
        ("run", ["run", "did not segment views"]),
        ("empty", ["empty", "is not a result folder"]),
        ("square.obj", ["square.obj", "is not a result folder"]),
        ("run --data D.npy", ["--photographs needs --data views:FILE", ""]),
        ("run --data views:v.toml", ["v.toml", "No such file"]),
        ("run --data views:v.toml --out a.html", ["a.html", "a .png file, or a folder"]),
        ("run --data views:v.toml --out square.obj", ["square.obj", "is a file"]),
        ("run --noise 1", ["--noise needs cameras", ""]),
    ] {
        refuse(&folder, &format!("render {line} --photographs"), &parts);
    }
    misuse(&folder, "render run --photographs --views front", "cannot be used with");
    misuse(&folder, "render run --photographs --show labels", "cannot be used with");
}
