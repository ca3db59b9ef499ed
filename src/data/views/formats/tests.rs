//! The same cameras through every format, and damaged files.

use std::path::PathBuf;

use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use tempfile::TempDir;

use super::*;
use crate::optics::pinhole::Pinhole;
use crate::samples::{random_rotation, random_vector, rng};

const K: [f64; 9] = [510.0, 0.0, 301.5, 0.0, 520.0, 222.25, 0.0, 0.0, 1.0];

struct Pose {
    r: Matrix3<f64>,
    t: Vector3<f64>,
}

fn poses() -> Vec<Pose> {
    let mut rng = rng(12);
    let mut pose = || Pose { r: *random_rotation(&mut rng).matrix(), t: random_vector(&mut rng) };
    (0..3).map(|_| pose()).collect()
}

fn rows(m: &Matrix3<f64>) -> [f64; 9] {
    std::array::from_fn(|i| m[(i / 3, i % 3)])
}

fn words(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!(" {x:?}")).collect()
}

fn middlebury() -> String {
    let line = |(i, pose): (usize, &Pose)| {
        format!("{i}.png{}{}{}\n", words(&K), words(&rows(&pose.r)), words(pose.t.as_slice()))
    };
    "3\n".to_owned() + &poses().iter().enumerate().map(line).collect::<String>()
}

fn own() -> String {
    let view = |(i, Pose { r, t }): (usize, &Pose)| {
        let (r, t) = (rows(r), t.as_slice());
        format!(
            "[[view]]\nimage = \"{i}.png\"\nwidth = 640\nheight = 480\nK = {K:?}\nR = {r:?}\nt = {t:?}\n"
        )
    };
    poses().iter().enumerate().map(view).collect()
}

/// With a camera that is turned and moved on its platform.
fn openmvs(version: u32) -> Vec<u8> {
    let mut rng = rng(3);
    let (on_r, on_c) = (*random_rotation(&mut rng).matrix(), random_vector(&mut rng));
    let mut bytes = b"MVSI".to_vec();
    let number = |bytes: &mut Vec<u8>, x: u32| bytes.extend(x.to_le_bytes());
    let count = |bytes: &mut Vec<u8>, x: u64| bytes.extend(x.to_le_bytes());
    let floats = |bytes: &mut Vec<u8>, x: &[f64]| {
        x.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    };
    let text = |bytes: &mut Vec<u8>, text: &str| {
        count(bytes, text.len() as u64);
        bytes.extend(text.as_bytes());
    };
    number(&mut bytes, version);
    number(&mut bytes, 0);
    count(&mut bytes, 1);
    text(&mut bytes, "platform");
    count(&mut bytes, 1);
    text(&mut bytes, "camera");
    if version > 3 {
        text(&mut bytes, "visible");
    }
    number(&mut bytes, 640);
    number(&mut bytes, 480);
    floats(&mut bytes, &K);
    floats(&mut bytes, &rows(&on_r));
    floats(&mut bytes, on_c.as_slice());
    count(&mut bytes, 3);
    for Pose { r, t } in poses() {
        // R = R_c R_p and -R^T t = R_p^T C_c + C_p.
        let on_world = on_r.transpose() * r;
        floats(&mut bytes, &rows(&on_world));
        floats(&mut bytes, (-(r.transpose() * t) - on_world.transpose() * on_c).as_slice());
    }
    count(&mut bytes, 4);
    for i in 0..4_u32 {
        text(&mut bytes, &format!("{i}.png"));
        if version > 4 {
            text(&mut bytes, "");
        }
        number(&mut bytes, 0);
        number(&mut bytes, 0);
        // The last image has no pose.
        number(&mut bytes, if i < 3 { i } else { u32::MAX });
        if version > 2 {
            number(&mut bytes, i);
        }
        if version > 6 {
            bytes.extend([0; 12]);
            count(&mut bytes, 2);
            bytes.extend([1; 56]);
        }
    }
    bytes
}

const CAMERAS: &str = "# Camera list\n7 PINHOLE 640 480 510 520 302 222.75\n";

fn colmap_images() -> String {
    let line = |(i, Pose { r, t }): (usize, &Pose)| {
        let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*r));
        let q = [q.w, q.i, q.j, q.k];
        format!("{}{}{} 7 {i}.png\n1.0 2.0 -1\n", i + 1, words(&q), words(t.as_slice()))
    };
    let lines: String = poses().iter().enumerate().map(line).collect();
    "# Image list\n".to_owned() + &lines
}

fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).unwrap());
    folder
}

fn read_as(name: &str, bytes: &[u8]) -> Result<ViewFile> {
    let folder = folder(&[(name, bytes)]);
    read(&folder.path().join(name))
}

fn colmap(cameras: &str, images: &str) -> Result<ViewFile> {
    let folder = folder(&[("cameras.txt", cameras.as_bytes()), ("images.txt", images.as_bytes())]);
    read(folder.path())
}

/// All formats have the same cameras, whatever the names of the files.
#[test]
fn every_format_has_the_same_cameras() {
    let found = [
        read_as("a", middlebury().as_bytes()).unwrap(),
        read_as("b.txt", own().as_bytes()).unwrap(),
        colmap(CAMERAS, &colmap_images()).unwrap(),
        read_as("c", &openmvs(1)).unwrap(),
        read_as("c", &openmvs(3)).unwrap(),
        read_as("c", &openmvs(4)).unwrap(),
        read_as("c", &openmvs(7)).unwrap(),
    ];
    for ViewFile { format, views, warnings } in &found {
        assert_eq!(views.len(), 3, "{format}");
        assert_eq!(warnings.len(), usize::from(*format == "OpenMVS"));
        for (i, (view, Pose { r, t })) in views.iter().zip(poses()).enumerate() {
            assert_eq!(view.image, format!("{i}.png"));
            assert!(view.size == Some([640, 480]) || *format == "Middlebury");
            let x = Vector3::new(0.3, -0.2, 0.1) - r.transpose() * (t - 5.0 * Vector3::z());
            let at: Vector3<f64> = Matrix3::from_row_slice(&K) * (r * x + t);
            let seen = view.camera.project(Point3::from(x));
            let error = (seen.x - at.x / at.z).hypot(seen.y - at.y / at.z);
            assert!(error <= 1e-9, "{format}: {error}");
        }
    }
}

/// Bit by bit, whatever the names of the images.
#[test]
fn written_views_are_read_again() {
    let pinhole = |Pose { r, t }: &Pose| {
        let k = Matrix3::from_row_slice(&K);
        Pinhole::new(k / 3.0, *r, *t * 1e-3 / 7.0).unwrap()
    };
    let poses = poses();
    let view = |(i, image): (usize, &str)| View {
        image: image.into(),
        mask: (i == 0).then(|| "mask \u{e9}.png".into()),
        background: (i == 2).then(|| "behind.png".into()),
        size: (i < 2).then_some([640, 481]),
        camera: pinhole(&poses[i]),
    };
    let names = ["a b.png", "folder\\\"quoted\" 'name'.png", "line\nbreak \u{7f}.jpg"];
    let views: Vec<View> = names.into_iter().enumerate().map(view).collect();
    let found = read_as("views.toml", to_toml(&views).as_bytes()).unwrap();
    assert_eq!((found.format, found.views), ("TOML", views));
}

fn refused(found: Result<ViewFile>, clause: &str) {
    let message = found.err().unwrap().to_string();
    assert!(message.contains(clause) && !message.contains('\n'), "{message}");
}

/// Cut off at any byte, or with one changed, a file is refused or read, without a panic.
#[test]
fn damaged_files_are_refused() {
    let whole = openmvs(7);
    let path = PathBuf::from("scene.mvs");
    for end in 4..whole.len() {
        refused(openmvs_of(&path, &whole[..end]), "is cut off");
    }
    for at in 4..whole.len() {
        let mut changed = whole.clone();
        changed[at] = 0xff;
        drop(openmvs_of(&path, &changed));
    }
    let text = middlebury();
    for end in 1..text.len() - 25 {
        refused(read_as("a", &text.as_bytes()[..end]), "");
    }
    let last_line = text.trim_end().rfind('\n').unwrap();
    refused(read_as("a", &text.as_bytes()[..last_line]), "declares 3 views but has 2");
    refused(read_as("a", &text.as_bytes()[..last_line + 90]), "line 4");
    let text = own();
    refused(read_as("a", &text.as_bytes()[..text.len() - 20]), "line 21");
}

fn openmvs_of(path: &Path, bytes: &[u8]) -> Result<ViewFile> {
    let (views, warnings) = openmvs::read(path, bytes)?;
    Ok(ViewFile { format: "OpenMVS", views, warnings })
}

#[test]
fn files_of_no_cameras_are_refused() {
    refused(read_as("a", b"v 0 0 0\n"), "is not a file of cameras");
    refused(read_as("a", b"\xff\xfe\x00"), "is not a file of cameras");
    refused(read_as("a", b"0\n"), "has no views");
    refused(read_as("cameras.bin", b"\x01\x00"), "binary COLMAP");
    refused(read_as("a", b"MVSI\x08\0\0\0\0\0\0\0"), "version 8");
    refused(
        read_as("a", &[b"MVSI\x03\0\0\0\0\0\0\0".as_slice(), &[0; 16]].concat()),
        "has no views",
    );
    let changed = |from: &str, to: &str| read_as("a", own().replacen(from, to, 1).as_bytes());
    refused(changed("image", "picture"), "line 2: unknown field `picture`");
    refused(changed("510.0, ", ""), "line 5: invalid length 8");
    refused(changed("510.0", "0.0"), "K is singular");
    refused(changed("width = 640\n", ""), "needs both width and height");
    let mirrored = "R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]\nX = [";
    refused(changed("R = [", mirrored), "unknown field `X`");
    let [r] = [rows(&poses()[0].r)];
    let reversed = [-r[0], -r[1], -r[2], r[3], r[4], r[5], r[6], r[7], r[8]];
    refused(changed(&format!("{r:?}"), &format!("{reversed:?}")), "R mirrors the scene");
}

#[test]
fn lens_distortion_is_refused_unless_it_is_zero() {
    let images = colmap_images();
    let with = |camera: &str| colmap(&format!("7 {camera}\n"), &images);
    assert!(with("SIMPLE_PINHOLE 640 480 510 302 222.75").is_ok());
    assert!(with("OPENCV 640 480 510 520 302 222.75 0 0 0 0").is_ok());
    refused(with("OPENCV 640 480 510 520 302 222.75 0.1 0 0 0"), "lens distortion; undistort");
    refused(with("OPENCV_FISHEYE 640 480 510 520 302 222.75 0 0 0 0"), "lens distortion");
    refused(with("FOV 640 480 510 520 302 222.75 0.9"), "FOV has lens distortion");
    refused(with("PINHOLE 640 480 510 520 302"), "needs 4 parameters");
    refused(with("PINHOLE 640 x 510 520 302 2"), "numbers of pixels");
    refused(with("PINHOLE 640"), "needs CAMERA_ID");
    refused(colmap("8 SIMPLE_PINHOLE 640 480 510 302 222\n", &images), "camera 7 is not in");
    refused(colmap(CAMERAS, "1 0 0 0 0 0 0 0 7 a.png\n"), "quaternion is zero");
    refused(colmap(CAMERAS, "1 1 0 0 0 0 0 0 7\n"), "line 1: needs IMAGE_ID");
    let blanks = colmap(CAMERAS, "1 1 0 0 0 0 0 5 7 a b.png\n\n").unwrap();
    assert_eq!(blanks.views[0].image, "a b.png");
}
