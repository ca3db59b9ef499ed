//! The page has what the panels show, within its size.

use nalgebra::Vector3;

use super::*;
use crate::mesh::extent::bounding_box;
use crate::render::panels::{Regions, ShownData, Surface};
use crate::render::view::View;
use crate::samples::shape;

fn page<'a>(surfaces: &'a [Surface<'a>], panels: &'a [Panel], views: &'a [View]) -> Panels<'a> {
    Panels {
        surfaces,
        panels,
        views,
        columns: None,
        row_headings: &[],
        column_headings: &[],
        width: Default::default(),
        transparent: false,
    }
}

/// Panels with captions.
fn showing(shown: &[Shown]) -> Vec<Panel> {
    let panel = |&shown: &Shown| Panel { surface: 0, shown, caption: Some(shown.caption()) };
    shown.iter().map(panel).collect()
}

fn data(html: &str) -> Value {
    let (_, rest) = html.split_once("type=\"application/json\">").unwrap();
    let json = rest.split_once("</script>").unwrap().0;
    serde_json::from_str::<Value>(json).unwrap()["figure"].clone()
}

fn bytes(text: &Value) -> Vec<u8> {
    BASE64_STANDARD.decode(text.as_str().unwrap()).unwrap()
}

fn numbers(text: &Value) -> Vec<u16> {
    bytes(text).chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

/// (1 + x) / 2 at each vertex, where x is its position in the unit ball, scaled as for a picture.
fn colors(mesh: &Mesh) -> Vec<[f64; 3]> {
    let bounds = bounding_box(mesh).unwrap();
    let center = |i: usize| 0.5 * (bounds.min[i] + bounds.max[i]);
    let unit = |x: f64, i: usize| 0.5 + (x - center(i)) / bounds.diagonal();
    mesh.vertices.iter().map(|x| [unit(x.x, 0), unit(x.y, 1), unit(x.z, 2)]).collect()
}

/// Positions and colors of the page agree where each color is its position.
fn assert_colored_by_position(figure: &Value, panel: usize) {
    let positions = numbers(&figure["surfaces"][0]["positions"]);
    let colors = bytes(&figure["panels"][panel]["colors"]);
    assert_eq!(positions.len(), colors.len());
    for (&x, &color) in positions.iter().zip(&colors) {
        assert!((f64::from(x) / 65535.0 - f64::from(color) / 255.0).abs() < 0.51 / 255.0);
    }
}

#[test]
fn a_page_has_the_surface_and_what_its_panels_show() {
    let mesh = shape("sphere:3");
    let colors = colors(&mesh);
    let labels: Vec<usize> = mesh.vertices.iter().map(|x| usize::from(x.z > 0.0)).collect();
    let surfaces = [Surface {
        mesh: &mesh,
        data: Some(ShownData::Colors(&colors)),
        regions: Some(Regions::of_labels(&labels, 2, None)),
        means: None,
        frame: None,
    }];
    let shown = [Shown::Data { cut: false }, Shown::Labels, Shown::Data { cut: true }];
    let (panels, views) = (showing(&shown), ["x".parse().unwrap()]);
    let html = page(&surfaces, &panels, &views).html("a </script><b>", "meshseg").unwrap();
    assert_eq!(
        html.matches("</script>").count(),
        web::page(&json!({})).matches("</script>").count()
    );
    let figure = data(&html);
    assert_eq!(figure["title"], "a </script><b>");
    assert_eq!(figure["surfaces"].as_array().unwrap().len(), 1);
    assert_eq!(figure["panels"][1]["caption"], "(b) regions");
    assert_colored_by_position(&figure, 0);
    let faces = numbers(&figure["surfaces"][0]["faces"]);
    assert_eq!(faces.len(), 3 * mesh.faces.len());
    // In the order in which faces reach the vertices.
    let mut order = Vec::new();
    for &v in mesh.faces.iter().flatten() {
        if !order.contains(&v) {
            order.push(v);
        }
    }
    assert!(faces.iter().zip(mesh.faces.as_flattened()).all(|(&i, &v)| order[usize::from(i)] == v));
    let found = bytes(&figure["panels"][1]["labels"]);
    assert!(found.iter().zip(&order).all(|(&label, &v)| usize::from(label) == labels[v as usize]));
    assert!(figure["panels"][0]["labels"].is_null() && figure["panels"][0]["cut"].is_null());
    assert_eq!(figure["panels"][2]["labels"], figure["panels"][1]["labels"]);
    let sharp: Vec<bool> =
        (0..3).map(|i| figure["panels"][i]["sharp"].as_bool().unwrap()).collect();
    assert_eq!(sharp, [false, true, false]);
    assert_eq!(figure["surfaces"][0]["view"]["towards"], json!([1.0, 0.0, 0.0]));
}

/// What is left of a mesh lies where it lay, has the colors that it had, and is oriented.
#[test]
fn large_surfaces_are_coarsened_to_a_size() {
    let mesh = shape("sphere:7");
    let colors = colors(&mesh);
    let surfaces = [Surface {
        mesh: &mesh,
        data: Some(ShownData::Colors(&colors)),
        regions: None,
        means: None,
        frame: None,
    }];
    for count in [1, 100] {
        let panels = showing(&vec![Shown::Data { cut: false }; count]);
        let html = page(&surfaces, &panels, &[View::Auto]).html("t", "meshseg").unwrap();
        assert!(html.len() < 13_800_000, "{}", html.len());
        let figure = data(&html);
        assert_colored_by_position(&figure, count - 1);
        let surface = &figure["surfaces"][0];
        assert_eq!(surface["vertices"], mesh.vertices.len());
        let points: Vec<Vector3<f64>> = numbers(&surface["positions"])
            .chunks(3)
            .map(|x| Vector3::from_fn(|i, _| f64::from(x[i]) / 32767.5 - 1.0))
            .collect();
        assert!(points.len() > 8_000 && points.len() <= MAX_VERTICES, "{}", points.len());
        for face in numbers(&surface["faces"]).chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|i| points[usize::from(face[i])]);
            assert!((b - a).cross(&(c - a)).dot(&a) > 0.0);
        }
    }
}

/// The faces of a soup share no vertex; those of confetti share no position either.
#[test]
fn soups_are_welded_and_confetti_is_refused() {
    let whole = shape("sphere:6");
    let soup = |size: f64| {
        let corners = |j: usize| {
            let corners = whole.corners(j);
            let center = (corners[0].coords + corners[1].coords + corners[2].coords) / 3.0;
            corners.map(|x| (center + size * (x.coords - center)).into())
        };
        let vertices: Vec<_> = (0..whole.faces.len()).flat_map(corners).collect();
        let faces = (0..vertices.len() as u32).step_by(3).map(|v| [v, v + 1, v + 2]);
        Mesh::new(vertices.clone(), faces.collect())
    };
    let html = |mesh: &Mesh| {
        let grays = vec![[0.5; 3]; mesh.vertices.len()];
        let data = Some(ShownData::Colors(&grays));
        let surfaces = [Surface { mesh, data, regions: None, means: None, frame: None }];
        page(&surfaces, &showing(&[Shown::Data { cut: false }]), &["x".parse().unwrap()])
            .html("t", "meshseg")
    };
    let exact = (0..whole.faces.len()).flat_map(|j| whole.corners(j)).collect();
    let exact = Mesh { vertices: exact, ..soup(1.0) };
    let figure = data(&html(&exact).unwrap());
    let points = numbers(&figure["surfaces"][0]["positions"]).len() / 3;
    assert_eq!(points, whole.vertices.len());
    let error = html(&soup(0.5)).unwrap_err().to_string();
    assert!(error.contains("in too many pieces"), "{error}");
}

#[test]
fn a_mesh_without_area_has_no_surface() {
    let mesh = Mesh::new(vec![nalgebra::Point3::origin()], vec![[0, 0, 0]]);
    let surfaces = [Surface {
        mesh: &mesh,
        data: Some(ShownData::Colors(&[[0.5; 3]])),
        regions: None,
        means: None,
        frame: None,
    }];
    let panels = showing(&[Shown::Data { cut: false }]);
    let figure = data(&page(&surfaces, &panels, &[View::Auto]).html("t", "meshseg").unwrap());
    assert!(figure["surfaces"][0].is_null() && figure["panels"][0]["surface"].is_null());
}

/// Surfaces of a film lie where they lay in their frame, and begin with one view.
#[test]
fn a_film_has_the_surfaces_in_their_frame() {
    let frame = shape("sphere:2");
    let tall = {
        let mut mesh = shape("sphere:2").scaled(0.5);
        mesh.vertices.iter_mut().for_each(|x| x.z *= 1.9);
        mesh
    };
    let colors = vec![[0.5; 3]; frame.vertices.len()];
    let surfaces = [&frame, &tall].map(|mesh| Surface {
        mesh,
        data: Some(ShownData::Colors(&colors)),
        regions: None,
        means: None,
        frame: Some(&frame),
    });
    let shown = Shown::Data { cut: false };
    let panels = [0, 1].map(|surface| Panel { surface, shown, caption: None });
    let headings = ["start", "end"].map(String::from);
    let views = ["front".parse().unwrap()];
    let grid =
        Panels { columns: Some(2), column_headings: &headings, ..page(&surfaces, &panels, &views) };
    let film = data(&grid.film("t", "meshseg").unwrap());
    assert_eq!((&film["film"], &film["column_headings"][1]), (&json!(true), &json!("end")));
    assert_eq!(film["surfaces"][0]["view"], film["surfaces"][1]["view"]);
    assert_eq!(data(&grid.html("t", "meshseg").unwrap())["film"], json!(false));
    let places = |i: usize| -> Vec<f64> {
        let numbers = numbers(&film["surfaces"][i]["positions"]);
        numbers.into_iter().map(|x| f64::from(x) / 32767.5 - 1.0).collect()
    };
    for (frame, tall) in places(0).chunks(3).zip(places(1).chunks(3)) {
        assert!(
            (tall[0] - 0.5 * frame[0]).abs() < 1e-4 && (tall[2] - 0.95 * frame[2]).abs() < 1e-4
        );
    }
}
