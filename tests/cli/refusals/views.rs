//! Views that are no views, and options that do not apply.

use image::RgbImage;

use super::{folder, misuse, refuse};

const VIEW: &str = "[[view]]\nimage = \"a.png\"\nK = [40, 0, 31.5, 0, 40, 23.5, 0, 0, 1]\n\
                    R = [1, 0, 0, 0, -1, 0, 0, 0, -1]\nt = [-0.5, 0.5, 2.0]\n";

#[test]
fn views_that_do_not_fit_are_refused() {
    let folder = folder();
    let line = "segment square.obj --data views:v.toml --regions 2 --out out";
    refuse(&folder, line, &["v.toml"]);
    folder.write("v.toml", VIEW);
    refuse(&folder, line, &["a.png", "does not exist", "--images"]);
    RgbImage::new(64, 48).save(folder.path("a.png")).unwrap();
    for (from, to, part) in [
        ("[[view]]", "[[views]]", "is not a file of cameras"),
        ("image", "imag", "line 2: unknown field"),
        ("40, 0, 31.5", "0, 0, 31.5", "a.png: K is singular"),
        ("1, 0, 0, 0, -1, 0, 0, 0, -1", "1, 0, 0, 0, 1, 0, 0, 0, -1", "R mirrors the scene"),
        ("1, 0, 0, 0, -1, 0, 0, 0, -1", "1, 0, 0, 0, 1, 0, 0, 0, 1", "see the back of the surface"),
        (
            "K =",
            "width = 640\nheight = 480\nK =",
            "64 x 48 pixels, but its camera is for 640 x 480",
        ),
        ("-0.5, 0.5, 2.0", "90.0, 0.5, 2.0", "no view shows the surface; check"),
        ("-0.5, 0.5, 2.0", "-0.5, 0.5, -2.0", "behind the cameras"),
    ] {
        folder.write("v.toml", VIEW.replacen(from, to, 1));
        refuse(&folder, line, &[if part.starts_with("64") { "a.png" } else { "v.toml" }, part]);
    }
    folder.write("v.toml", VIEW);
    let with = |options: &str| format!("{line} {options}");
    refuse(&folder, &with("--border 24"), &["lower --border"]);
    refuse(&folder, &with("--pure 200"), &["lower --pure"]);
    refuse(&folder, &with("--grazing 1.5"), &["--grazing 1.5", "cosine"]);
    refuse(&folder, &with("--grazing nan"), &["--grazing NaN", "cosine"]);
    refuse(&folder, &with("--images nowhere"), &["nowhere", "does not exist"]);
    refuse(&folder, &with("--mass voronoi"), &["--mass voronoi", "leave --mass out"]);
    misuse(&folder, &with("--pure 0"), "--pure");
    misuse(&folder, &with("--weights area"), "pixel, angle, unit");
    misuse(&folder, &line.replace("v.toml", ""), "views:FILE");
    for option in ["--images a", "--weights unit", "--pure 2", "--border 2", "--samples 2"] {
        let line = format!("segment square.obj --data D.npy --regions 2 --out out {option}");
        refuse(&folder, &line, &["needs --data views:FILE"]);
    }
}
