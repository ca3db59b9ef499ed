//! Surfaces that are cut along seams: welded automatically or on request, and otherwise counted in a warning.

use std::path::{Path, PathBuf};

use meshseg::Mesh;
use meshseg::mesh::{Shape, Weld, io};
use ndarray::{Array2, Axis};

use crate::support::{Answer, Folder, costs, stderr};

pub fn shape(text: &str) -> Mesh {
    text.parse::<Shape>().unwrap().mesh()
}

/// A file from `tests/cases`.
pub fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name)
}

/// Cuts a mesh into charts: one copy of a vertex for each chart of its faces, in the order of the faces.
pub fn cut(mesh: &Mesh, chart: impl Fn(usize) -> usize) -> (Mesh, Vec<usize>) {
    let mut of = std::collections::HashMap::new();
    let mut before = Vec::new();
    let faces = (mesh.faces.iter().enumerate())
        .map(|(j, face)| {
            face.map(|v| {
                *of.entry((v, chart(j))).or_insert_with(|| {
                    before.push(v as usize);
                    before.len() as u32 - 1
                })
            })
        })
        .collect();
    let vertices = before.iter().map(|&v| mesh.vertices[v]).collect();
    let colors = mesh.colors.as_ref().map(|colors| before.iter().map(|&v| colors[v]).collect());
    (Mesh { vertices, faces, colors, ..Mesh::default() }, before)
}

/// A torus with two noisy 8-bit colors, and the true label of each vertex.
fn two_colors() -> (Mesh, Vec<i32>) {
    let mut mesh = shape("torus:60x38");
    let truth: Vec<i32> = mesh.vertices.iter().map(|x| i32::from(x.x > 0.02)).collect();
    let noise = |k: usize, i: usize| ((k * 7919 + i * 104_729) % 101) as f64 - 50.0;
    let color = |(k, &label): (usize, &i32)| {
        [0, 1, 2].map(|i| ((if label == 1 { 180.0 } else { 80.0 }) + noise(k, i)) / 255.0)
    };
    mesh.colors = Some(truth.iter().enumerate().map(color).collect());
    (mesh, truth)
}

/// Number of wrong labels, up to an exchange of the two labels.
pub fn wrong(answer: &Answer, truth: &[i32]) -> usize {
    let differ =
        |flip: i32| answer.labels.iter().zip(truth).filter(|(a, b)| **a != **b ^ flip).count();
    differ(0).min(differ(1))
}

#[test]
fn segment_welds_seams_and_finds_the_regions_of_the_shared_mesh() {
    let folder = Folder::new();
    let (shared, truth) = two_colors();
    let quadrant = |j: usize| {
        let [x, ..] = shared.corners(j);
        usize::from(x.y > 0.01) + 2 * usize::from(x.x > 0.02)
    };
    io::write(&folder.path("shared.ply"), &shared).unwrap();
    let line =
        |name: &str| format!("segment {name}.ply --regions 2 --no-preview --gap 1e-6 --out {name}");
    let output = folder.run(&line("shared"));
    assert!(!stderr(&output).contains("weld"), "{}", stderr(&output));
    let whole = folder.answer("shared");
    assert_eq!(wrong(&whole, &truth), 0);
    assert_eq!(whole.summary["welded_vertices"], 0);

    for (name, (mesh, before)) in
        [("charts", cut(&shared, quadrant)), ("soup", cut(&shared, |j| j))]
    {
        io::write(&folder.path(&format!("{name}.ply")), &mesh).unwrap();
        let output = folder.run(&line(name));
        assert_eq!(output.status.code(), Some(0));
        let weld = Weld::exact(&mesh).unwrap();
        let expected = format!(
            "welded {} vertices onto {} others at the same positions (--no-weld keeps them separate)",
            mesh.vertices.len() - shared.vertices.len(),
            weld.onto
        );
        assert!(stderr(&output).contains(&expected), "{}", stderr(&output));
        assert!(!stderr(&output).contains("WARN"), "{}", stderr(&output));

        // Results refer to the vertices of the file and equal those of the shared mesh.
        let answer = folder.answer(name);
        answer.assert_consistent();
        assert_eq!(answer.u.nrows(), mesh.vertices.len());
        assert_eq!(answer.number("vertices"), mesh.vertices.len() as f64);
        let again = io::read(&folder.path(&format!("{name}/segmented.ply"))).unwrap();
        assert_eq!((again.vertices, again.faces), (mesh.vertices.clone(), mesh.faces.clone()));
        let meant: Vec<i32> = before.iter().map(|&k| truth[k]).collect();
        assert_eq!(wrong(&answer, &meant), 0, "{name}");
        for (key, tolerance) in [("energy", 2e-6), ("lambda", 1e-12), ("area", 1e-12)] {
            let (a, b) = (answer.number(key), whole.number(key));
            assert!((a - b).abs() <= tolerance * b, "{name}: {key} {a} {b}");
        }

        // Without welding, cuts along seams are free: the energy is below the bound of the whole surface. The saving is
        // measured relative to E - B, which cuts can change: here 5 % with charts and 26 % with single faces. Relative
        // to E it is only 0.7 % with charts, since B, which no cut changes, is most of E.
        folder.done(&format!("{} --no-weld", line(name)));
        let unwelded = folder.answer(name);
        let [bound, baseline] = ["dual_bound", "baseline"].map(|key| whole.number(key));
        let saved = bound - unwelded.number("energy");
        assert!(saved > 0.05 * (bound - baseline), "{name}: {saved}");
    }
}

/// Data from files have rows for the vertices of the mesh file, textures have coordinates at the corners of the faces.
#[test]
fn data_of_every_kind_are_welded() {
    let folder = Folder::new();
    let (shared, truth) = two_colors();
    let (mut soup, before) = cut(&shared, |j| j);
    let colors = shared.colors.as_ref().unwrap();
    let rows = Array2::from_shape_fn((before.len(), 3), |(v, i)| colors[before[v]][i]);
    folder.array("data.npy", &rows);
    soup.colors = None;
    let uv = |v: u32| {
        let t = if truth[before[v as usize]] == 1 { 0.75 } else { 0.25 };
        [t, 0.5]
    };
    soup.uv = Some(soup.faces.iter().map(|face| face.map(uv)).collect());
    io::write(&folder.path("soup.obj"), &soup).unwrap();
    image::RgbImage::from_fn(16, 1, |x, _| image::Rgb([if x < 8 { 60 } else { 200 }; 3]))
        .save(folder.path("image.png"))
        .unwrap();
    let meant: Vec<i32> = before.iter().map(|&k| truth[k]).collect();
    for data in ["data.npy", "texture:image.png"] {
        folder.done(&format!("segment soup.obj --data {data} --regions 2 --out out"));
        assert_eq!(wrong(&folder.answer("out"), &meant), 0, "{data}");
    }
    // Data with rows for the welded vertices are refused.
    folder.array("few.npy", &rows.select(Axis(0), &[0, 1, 2]));
    let output = folder.run("segment soup.obj --data few.npy --regions 2 --out few");
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains(&format!("{} vertices", soup.vertices.len())));
}

/// A triangle soup in text form whose shared corners differ in their last digits.
fn nearly_shared() -> String {
    let mesh = shape("grid:20x20").scaled(37.3);
    let mut text = String::from("solid part\n");
    let mut count = 0_u32;
    for j in 0..mesh.faces.len() {
        text += "facet normal 0 0 1\nouter loop\n";
        for x in mesh.corners(j) {
            let mut off = || {
                count += 1;
                1e-6 * (f64::from(count * 7919 % 1009) / 1009.0 - 0.5)
            };
            text += &format!("vertex {:e} {:e} {:e}\n", x.x + off(), x.y + off(), x.z + off());
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid part\n"
}

#[test]
fn nearly_equal_corners_are_counted_and_welded_on_request() {
    let folder = Folder::new();
    folder.write("part.stl", nearly_shared());
    let output = folder.run("mesh info part.stl");
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let line = |name: &str, count: usize| {
        let found = text.lines().find(|line| line.starts_with(name)).unwrap();
        assert!(found.ends_with(&format!(" {count}")), "{found}");
    };
    line("components", 800);
    line("coincident vertices", 0);
    line("nearly coincident vertices", 2400 - 441);
    let expected = "hardly any of the 800 faces share a vertex, so cuts between them are free; weld nearly \
                equal vertices with --weld 5.3e-5";
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));

    let json: serde_json::Value =
        serde_json::from_str(&folder.done("mesh info part.stl --json")).unwrap();
    assert_eq!(json["nearly_coincident_vertices"], 1959);

    folder.array("data.npy", &costs(2400, 1));
    let segment = "segment part.stl --data data.npy --regions 2 --no-preview --out out";
    let output = folder.run(segment);
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    let output = folder.run(&format!("{segment} --weld 5.3e-5"));
    // Two corners of the grid belong to one face only.
    let expected = "welded 1959 vertices onto 439 others within a distance of 5.3e-5";
    assert!(
        stderr(&output).contains(expected) && !stderr(&output).contains("hardly"),
        "{}",
        stderr(&output)
    );
    folder.answer("out").assert_consistent();
    assert_eq!(folder.answer("out").number("welded_vertices"), 1959.0);

    folder.done("mesh convert part.stl --weld 5.3e-5 --out whole.ply");
    let whole = io::read(&folder.path("whole.ply")).unwrap();
    assert_eq!((whole.vertices.len(), whole.faces.len()), (441, 800));
    let output = folder.run("mesh info whole.ply");
    assert!(stderr(&output).is_empty());
}

#[test]
fn tolerances_that_are_no_lengths_or_leave_no_face_are_refused() {
    let folder = Folder::new();
    folder.write("square.obj", crate::support::SQUARE_OBJ);
    folder.array("S.npy", &costs(4, 2));
    for verb in [
        "segment square.obj --data S.npy --regions 2 --out out",
        "solve square.obj --costs S.npy --lambda 1 --out out",
        "mesh convert square.obj --out out.ply",
    ] {
        for (tolerance, part) in [
            ("-1", "must be a finite number, 0 or more"),
            ("nan", "must be a finite number, 0 or more"),
            ("inf", "must be a finite number, 0 or more"),
            ("10", "leaves no face with an area"),
        ] {
            let before = folder.listing();
            let output = folder.run(&format!("{verb} --weld {tolerance}"));
            let message = stderr(&output);
            assert_eq!(output.status.code(), Some(1), "{verb} {tolerance}: {message}");
            assert!(message.starts_with("error: --weld ") && message.contains(part), "{message}");
            assert_eq!(message.lines().count(), 1, "{message}");
            assert_eq!(folder.listing(), before);
        }
        let output = folder.run(&format!("{verb} --weld 0.1"));
        let messages = stderr(&output);
        assert!(output.status.success() && messages.matches("weld").count() == 1, "{messages}");
        assert!(
            messages.contains("welded 0 vertices: no two vertices of faces lie within 0.1"),
            "{messages}"
        );
    }
    let output = folder.run("segment square.obj --regions 2 --weld 1 --no-weld --out out");
    assert_eq!(output.status.code(), Some(2));
    // A face that collapses is left out: a sliver whose short side is below the tolerance.
    folder.write("sliver.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 1 0.99999 0\nf 1 2 4\nf 1 4 3\n");
    let output = folder.run("mesh convert sliver.obj --weld 1e-4 --out one.ply");
    assert!(stderr(&output).contains("1 face collapsed"), "{}", stderr(&output));
    assert_eq!(io::read(&folder.path("one.ply")).unwrap().faces.len(), 1);
    folder.array("d.npy", &costs(4, 1));
    let output = folder.run("segment sliver.obj --weld 1e-4 --data d.npy --regions 2 --out sliver");
    assert!(stderr(&output).contains("1 face without area was left out"), "{}", stderr(&output));
    assert_eq!(folder.answer("sliver").u.nrows(), 4);
}

/// Positions are equal up to rounding: welding equal ones merges nothing, and a warning names a sufficient tolerance.
#[test]
fn a_weld_that_leaves_seams_names_a_sufficient_tolerance() {
    let folder = Folder::new();
    let rounded = |chart: fn(usize) -> usize| {
        let (mut mesh, _) = cut(&shape("grid:6x5"), chart);
        (0..).zip(&mut mesh.vertices).for_each(|(v, x)| x.z = 1e-8 * f64::from(v));
        mesh
    };
    // Separate faces; two halves.
    for mesh in [rounded(|j| j), rounded(|j| j % 60 / 30)] {
        io::write(&folder.path("m.ply"), &mesh).unwrap();
        folder.array("S.npy", &costs(mesh.vertices.len(), 2));
        folder.array("U.npy", &Array2::from_elem((mesh.vertices.len(), 2), 0.5));
        for verb in [
            "solve m.ply --costs S.npy --lambda 0.01 --no-preview --out out",
            "evaluate m.ply --costs S.npy --lambda 0.01 --u U.npy",
            "mesh convert m.ply --out out.ply",
            "segment m.ply --data S.npy --regions 2 --lambda 0.01 --no-preview --out out",
        ] {
            let messages = stderr(&folder.run(&format!("{verb} --weld")));
            assert!(messages.contains("welded 0 vertices"), "{verb}: {messages}");
            let (_, tolerance) = messages.rsplit_once("with --weld ").expect(&messages);
            let mended = stderr(&folder.run(&format!("{verb} --weld {}", tolerance.trim())));
            assert!(!mended.contains("welded 0") && !mended.contains("free"), "{verb}: {mended}");
        }
    }
}

/// Two sides of a leaf at the same positions.
#[test]
fn a_warning_reports_overlapping_sheets() {
    let folder = Folder::new();
    let grid = shape("grid:6x5");
    let mut leaf = grid.clone();
    let n = grid.vertices.len() as u32;
    leaf.vertices.extend(grid.vertices.clone());
    leaf.faces.extend(grid.faces.iter().map(|[a, b, c]| [a + n, c + n, b + n]));
    leaf.colors =
        Some((0..2 * n).map(|v| if v < n { [0.0, 1.0, 0.0] } else { [0.5, 0.25, 0.0] }).collect());
    io::write(&folder.path("leaf.ply"), &leaf).unwrap();
    let line = "segment leaf.ply --regions 2 --no-preview --out out";
    let output = folder.run(line);
    // Inner edges of a grid: all except the boundary.
    let edges = 6 * 6 + 5 * 7 + 30 - 22;
    let expected = format!("welding created {edges} edges with more than two faces");
    assert!(stderr(&output).contains(&expected), "{}", stderr(&output));
    assert!(stderr(&output).contains("--no-weld keeps them separate"));
    let output = folder.run(&format!("{line} --no-weld"));
    assert!(!stderr(&output).contains("weld"), "{}", stderr(&output));
    let labels = folder.answer("out").labels;
    assert!(
        (0..n as usize).all(|v| labels[v] == labels[0] && labels[v + n as usize] == 1 - labels[0])
    );
}

/// `solve` and other verbs that take a mesh as it is warn about coincident vertices.
#[test]
fn verbs_that_do_not_weld_count_coincident_vertices() {
    let folder = Folder::new();
    let shared = shape("torus:30x19");
    let (soup, before) = cut(&shared, |j| j / 100);
    io::write(&folder.path("shared.ply"), &shared).unwrap();
    io::write(&folder.path("cut.ply"), &soup).unwrap();
    let s = costs(shared.vertices.len(), 3);
    folder.array("S.npy", &s);
    folder.array("cut.npy", &s.select(Axis(0), &before));
    let merged = soup.vertices.len() - shared.vertices.len();
    let expected = format!(
        "{merged} vertices lie at the positions of others, and cuts along such seams are free"
    );

    let solve = "--lambda 0.05 --gap 1e-7 --no-preview";
    for (mass, within) in [("barycentric", 1e-12), ("voronoi", 1e-12), ("consistent", 1e-12)] {
        let whole =
            folder.solve(&format!("shared.ply --costs S.npy --mass {mass} {solve}"), "whole");
        let output = folder
            .run(&format!("solve cut.ply --costs cut.npy --mass {mass} {solve} --out unwelded"));
        assert!(
            stderr(&output).contains(&expected) && stderr(&output).contains("--weld"),
            "{}",
            stderr(&output)
        );
        let unwelded = folder.answer("unwelded");
        assert!(unwelded.summary["warnings"].to_string().contains(&expected));
        assert!(unwelded.number("energy") < whole.number("energy") - 1e-4);

        let output = folder.run(&format!(
            "solve cut.ply --costs cut.npy --weld --mass {mass} {solve} --out welded"
        ));
        let message = format!("welded {merged} vertices onto");
        assert!(
            stderr(&output).contains(&message) && !stderr(&output).contains("WARN"),
            "{}",
            stderr(&output)
        );
        let welded = folder.answer("welded");
        welded.assert_consistent();
        assert_eq!(welded.u.nrows(), soup.vertices.len());
        let (a, b) = (welded.number("energy"), whole.number("energy"));
        assert!((a - b).abs() <= 2e-7 * b, "{a} {b}");
        for (v, &k) in before.iter().enumerate() {
            let first = before.iter().position(|&other| other == k).unwrap();
            let error = &welded.u.row(v) - &welded.u.row(first);
            assert!(error.iter().all(|x| x.abs() <= within));
        }
    }
    // A given U also has rows for the vertices of the file.
    folder.done(&format!(
        "solve cut.ply --costs cut.npy --weld {solve} --init welded/u.npy --out again"
    ));
    folder.answer("again").assert_consistent();

    for line in [
        "evaluate cut.ply --costs cut.npy --lambda 0.05 --u welded/u.npy",
        "operators cut.ply --out operators",
        "problem export cut.ply --costs cut.npy --lambda 0.05 --out problem.npz",
    ] {
        let output = folder.run(line);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{line}: {message}");
        let remedy = match line.starts_with("evaluate") {
            true => "weld them with --weld",
            false => "weld them with `meshseg mesh convert --weld`",
        };
        assert!(message.contains(&expected) && message.contains(remedy), "{message}");
        let whole = folder.run(&line.replace("cut.", "shared.").replace("shared.npy", "S.npy"));
        assert!(!stderr(&whole).contains("positions"), "{}", stderr(&whole));
    }
    folder.done("mesh convert cut.ply --weld --out back.ply");
    let back = io::read(&folder.path("back.ply")).unwrap();
    assert_eq!(
        (back.vertices.len(), back.faces.len()),
        (shared.vertices.len(), shared.faces.len())
    );
}

/// The results of `solve --weld` have rows for the vertices of the file, and `evaluate --weld` computes the same
/// numbers from them, even if faces collapse and the copies of a vertex have different costs.
#[test]
fn a_welded_solution_is_evaluated_as_it_was_certified() {
    let folder = Folder::new();
    let (mut soup, _) = cut(&shape("torus:20x13"), |j| j / 50);
    // Nearly equal copies, and a face that loses its area when welded.
    soup.vertices.iter_mut().step_by(3).for_each(|x| x.x += 1e-7);
    let [a, b, _] = soup.faces[0];
    let copy = soup.vertices[b as usize];
    soup.vertices.push(copy + nalgebra::Vector3::repeat(1e-7));
    soup.faces.insert(7, [a, b, soup.vertices.len() as u32 - 1]);
    io::write(&folder.path("cut.ply"), &soup).unwrap();
    folder.array("S.npy", &costs(soup.vertices.len(), 3));
    for mass in ["barycentric", "voronoi", "consistent"] {
        let problem = format!("cut.ply --costs S.npy --lambda 0.02 --mass {mass} --weld 1e-6");
        let answer =
            folder.solve(&format!("{problem} --save q --rounding argmax --no-preview"), mass);
        let q: Array2<f64> = ndarray_npy::read_npy(folder.path(mass).join("q.npy")).unwrap();
        assert_eq!(q.dim(), (2 * soup.faces.len(), 3));
        assert!(q.slice(ndarray::s![14..16, ..]).iter().all(|&q| q == 0.0));
        let output = folder.run(&format!("evaluate {problem} --u {mass}/u.npy --q {mass}/q.npy"));
        let messages = stderr(&output);
        assert!(output.status.success() && messages.contains("welded "), "{messages}");
        assert!(!messages.contains("of U differ"), "{messages}");
        let evaluation: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        for key in ["energy", "dual_bound", "rounded_energy", "area", "vertices", "faces"] {
            let (x, y) = (evaluation[key].as_f64().unwrap(), answer.number(key));
            assert!((x - y).abs() <= 1e-12 * y.abs(), "{mass}: {key} {x} {y}");
        }
        let gap = evaluation["relative_gap"].as_f64().unwrap();
        assert!((gap - answer.number("relative_gap")).abs() < 1e-10, "{mass}: {gap}");
    }
    // A U of the unwelded mesh has several rows at one position.
    folder.array(
        "U.npy",
        &Array2::from_shape_fn((soup.vertices.len(), 3), |(k, p)| f64::from(k % 3 == p)),
    );
    let line = "evaluate cut.ply --costs S.npy --lambda 0.02 --u U.npy --weld 1e-6";
    let messages = stderr(&folder.run(line));
    assert!(
        messages.contains("rows of U differ from those of the vertices they are merged with"),
        "{messages}"
    );
    for tolerance in ["nan", "-1", "1e9"] {
        let output = folder.run(&line.replace("1e-6", tolerance));
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).starts_with("error: --weld "), "{}", stderr(&output));
    }
}

/// f = M S on the welded mesh, where S are area-weighted means: every mass preserves the integral of the costs, even if
/// the copies of a vertex have different costs.
#[test]
fn welded_costs_are_integrated_on_the_welded_mesh() {
    let folder = Folder::new();
    let (soup, _) = cut(&shape("torus:20x13"), |j| j / 50);
    let weld = Weld::exact(&soup).unwrap();
    io::write(&folder.path("cut.ply"), &soup).unwrap();
    io::write(&folder.path("whole.ply"), &weld.mesh).unwrap();
    let s = costs(soup.vertices.len(), 2);
    folder.array("S.npy", &s);
    let means = weld.means(s.as_slice().unwrap(), 2);
    folder.array("means.npy", &Array2::from_shape_vec((means.len() / 2, 2), means).unwrap());
    let u = |n: usize, one: &dyn Fn(usize) -> bool| {
        Array2::from_shape_fn((n, 2), |(k, p)| f64::from(one(k) == (p == 0)))
    };
    let ring = |v: &nalgebra::Point3<f64>| v.x > 0.01;
    folder.array("all.npy", &u(soup.vertices.len(), &|_| true));
    folder.array("cut_u.npy", &u(soup.vertices.len(), &|k| ring(&soup.vertices[k])));
    folder.array("whole_u.npy", &u(weld.mesh.vertices.len(), &|k| ring(&weld.mesh.vertices[k])));
    let number = |line: &str, key: &str| {
        let text = folder.done(&format!("evaluate {line} --lambda 0.02 --dual-steps 0"));
        serde_json::from_str::<serde_json::Value>(&text).unwrap()[key].as_f64().unwrap()
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
    for mass in ["barycentric", "voronoi", "consistent"] {
        let of_cut = format!("cut.ply --costs S.npy --mass {mass} --u");
        let integral = |weld: &str| number(&format!("{of_cut} all.npy {weld}"), "data_term");
        near(integral("--weld"), integral(""));
        if mass != "voronoi" {
            let whole = format!("whole.ply --costs means.npy --mass {mass} --u whole_u.npy");
            for key in ["data_term", "energy"] {
                near(number(&format!("{of_cut} cut_u.npy --weld"), key), number(&whole, key));
            }
        }
    }
}

#[test]
fn an_experiment_warns_about_coincident_vertices() {
    let folder = Folder::new();
    let (soup, _) = cut(&shape("torus:12x9"), |j| j / 20);
    io::write(&folder.path("cut.ply"), &soup).unwrap();
    folder.write(
        "e.toml",
        "# ?\nstop = { gap = 1e-2, max-iterations = 50 }\n[[instance]]\nmesh = \"cut.ply\"\ndata = \"waves\"\n\
         regions = 2\nlambda = 0.01\n[[solver]]\nname = \"chambolle-pock\"\n[[figure]]\nname = \"f\"\nkind = \"decay\"\n",
    );
    let output = folder.run("experiment run e.toml --results results");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("lie at the positions of others"), "{}", stderr(&output));
}
