//! Tests of the panels: geometry of the grid, colors, alpha, color bars, captions, errors.

use image::{RgbImage, RgbaImage};
use nalgebra::Point3;

use super::*;
use crate::Mesh;
use crate::colormap::{categorical, sequential};
use crate::samples::shape;
use crate::sweep::with_threads;

const GREEN: [f64; 3] = [0.2, 0.6, 0.4];

/// A square of two triangles, in the plane z = 0 and `width` wide.
fn rectangle(width: f64) -> Mesh {
    let corners = [[0.0, 0.0], [width, 0.0], [width, 1.0], [0.0, 1.0]];
    let vertices = corners.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
    Mesh::new(vertices, vec![[0, 1, 2], [0, 2, 3]])
}

fn panel(shown: Shown) -> Panel {
    Panel { surface: 0, shown, caption: None }
}

fn page<'a>(surfaces: &'a [Surface<'a>], panels: &'a [Panel], views: &'a [View]) -> Panels<'a> {
    Panels {
        surfaces,
        panels,
        views,
        columns: None,
        row_headings: &[],
        column_headings: &[],
        width: "400px".parse().unwrap(),
        transparent: false,
    }
}

fn surface<'a>(mesh: &'a Mesh, colors: &'a [[f64; 3]], regions: Option<Regions>) -> Surface<'a> {
    Surface { mesh, data: Some(ShownData::Colors(colors)), regions, means: None, frame: None }
}

fn white(panels: &Panels) -> RgbImage {
    image::load_from_memory(&panels.png().unwrap()).unwrap().into_rgb8()
}

fn transparent(panels: Panels) -> RgbaImage {
    let bytes = Panels { transparent: true, ..panels }.png().unwrap();
    image::load_from_memory(&bytes).unwrap().into_rgba8()
}

fn bytes(color: [f64; 3]) -> [u8; 3] {
    color.map(|c| (255.0 * c).round() as u8)
}

/// The smallest rectangle that contains all pixels that are not white: left, top, right, bottom.
fn bounds(image: &RgbImage) -> [u32; 4] {
    let mut bounds = [u32::MAX, u32::MAX, 0, 0];
    for (x, y, _) in image.enumerate_pixels().filter(|(_, _, pixel)| pixel.0 != [255; 3]) {
        bounds = [bounds[0].min(x), bounds[1].min(y), bounds[2].max(x + 1), bounds[3].max(y + 1)];
    }
    bounds
}

const DATA: Shown = Shown::Data { cut: false };

#[test]
fn a_flat_mesh_fills_the_width_and_keeps_its_proportions() {
    let mesh = rectangle(4.0);
    let colors = [GREEN; 4];
    let surfaces = [surface(&mesh, &colors, None)];
    let image = white(&page(&surfaces, &[panel(DATA)], &[View::Auto]));
    let [left, top, right, bottom] = bounds(&image);
    assert_eq!(image.width(), 400);
    assert!(
        right - left >= 394 && bottom - top <= 100 && bottom - top >= 97,
        "{left} {right} {top} {bottom}"
    );
    // It is unlit.
    assert_eq!(image.get_pixel(200, image.height() / 2).0, bytes(GREEN));
}

#[test]
fn the_file_has_the_size_and_the_resolution_of_the_page() {
    let mesh = rectangle(4.0);
    let colors = [GREEN; 4];
    let surfaces = [surface(&mesh, &colors, None)];
    let panels = [panel(DATA)];
    let mut page = page(&surfaces, &panels, &[View::Auto]);
    page.width = PageWidth::default();
    for transparent in [false, true] {
        page.transparent = transparent;
        let bytes = page.png().unwrap();
        let decoder = ::png::Decoder::new(&bytes[..]);
        let info = decoder.read_info().unwrap().info().clone();
        assert_eq!(info.width, 2008);
        let dots = info.pixel_dims.unwrap();
        assert_eq!((dots.xppu, dots.yppu, dots.unit), (11_811, 11_811, ::png::Unit::Meter));
        let kind = if transparent { ::png::ColorType::Rgba } else { ::png::ColorType::Rgb };
        assert_eq!(info.color_type, kind);
    }
}

#[test]
fn widths_are_millimeters_or_pixels() {
    let pixels = |text: &str| text.parse::<PageWidth>().map(PageWidth::pixels);
    assert_eq!(pixels("170"), Ok(2008));
    assert_eq!(pixels("25.4mm"), Ok(300));
    assert_eq!(pixels("1004px"), Ok(1004));
    for wrong in ["", "mm", "170cm", "nan", "inf", "-85", "19", "1e9px", "421"] {
        assert!(pixels(wrong).is_err(), "{wrong}");
    }
}

/// An ellipsoid is three times as long as high: seen from its end it is as high as seen from its side.
#[test]
fn the_views_of_a_mesh_have_one_scale() {
    let mut mesh = shape("sphere:4");
    mesh.vertices.iter_mut().for_each(|x| x.x *= 3.0);
    let colors = vec![GREEN; mesh.vertices.len()];
    let surfaces = [surface(&mesh, &colors, None)];
    let views: Vec<View> = ["front", "x"].map(|view| view.parse().unwrap()).to_vec();
    let panels = [panel(DATA)];
    let stage = Stage::all(&surfaces, &views).swap_remove(0);
    let views_drawn = stage.draw(&[DATA], 50.0).swap_remove(0);
    let [side, end] = [0, 1].map(|i| [views_drawn[i].width(), views_drawn[i].height()]);
    let ratio = |a: u32, b: u32| f64::from(a) / f64::from(b);
    // The rest is perspective.
    assert!((0.9..1.1).contains(&ratio(side[1], end[1])), "{side:?} {end:?}");
    assert!(ratio(side[0], end[0]) > 2.2, "{side:?} {end:?}");
    assert!((0.97..1.03).contains(&ratio(end[0], end[1])), "{end:?}");
    // All of it fits on the page.
    let image = white(&page(&surfaces, &panels, &views));
    let [left, top, right, bottom] = bounds(&image);
    assert!(left > 0 && top > 0 && right < image.width() && bottom < image.height());
}

/// Two surfaces of one mesh have the views of the first, although their regions differ.
#[test]
fn surfaces_of_one_mesh_look_alike() {
    let mesh = shape("torus:24x16");
    let count = mesh.vertices.len();
    let colors = vec![GREEN; count];
    let regions = |side: f64| {
        let label = |x: &Point3<f64>| usize::from(side * x.x > 1.0);
        Regions::of_labels(&mesh.vertices.iter().map(label).collect::<Vec<_>>(), 2, None)
    };
    let surfaces =
        [surface(&mesh, &colors, Some(regions(1.0))), surface(&mesh, &colors, Some(regions(-1.0)))];
    let panels = [0, 1].map(|surface| Panel { surface, ..panel(DATA) });
    let image = white(&Panels { columns: Some(1), ..page(&surfaces, &panels, &[View::Auto]) });
    let gap = ROW_GAP as u32;
    let half = (image.height() - gap) / 2;
    for y in 0..half {
        for x in 0..400 {
            assert_eq!(image.get_pixel(x, y), image.get_pixel(x, y + half + gap), "{x} {y}");
        }
    }
}

#[test]
fn white_is_what_viewers_make_of_transparent_on_white() {
    let mesh = shape("torus:24x16");
    let colors = vec![GREEN; mesh.vertices.len()];
    let labels: Vec<usize> = mesh.vertices.iter().map(|x| usize::from(x.x > 0.2)).collect();
    let surfaces = [surface(&mesh, &colors, Some(Regions::of_labels(&labels, 2, None)))];
    let panels = [DATA, Shown::Means, Shown::Labels]
        .map(|shown| Panel { caption: Some("caption".into()), ..panel(shown) });
    let views = [View::Auto];
    let image = white(&page(&surfaces, &panels, &views));
    let clear = transparent(page(&surfaces, &panels, &views));
    let mut partial = 0;
    for (pixel, image::Rgba([r, g, b, alpha])) in image.pixels().zip(clear.pixels()) {
        partial += usize::from((1..255).contains(alpha));
        let alpha = f64::from(*alpha) / 255.0;
        let mixed = [r, g, b].map(|&c| f64::from(c) * alpha + 255.0 * (1.0 - alpha));
        for (found, mixed) in pixel.0.iter().zip(mixed) {
            assert!((f64::from(*found) - mixed).abs() <= 0.5 + 1e-9);
        }
    }
    assert!(partial > 1000);
}

/// The color of a pixel at the edge is that of the surface: no white shines through on a dark ground.
#[test]
fn edges_have_the_color_of_the_surface() {
    let mesh = rectangle(3.7);
    let colors = [GREEN; 4];
    let surfaces = [surface(&mesh, &colors, None)];
    let view = "20,10".parse().unwrap();
    let flat = transparent(page(&surfaces, &[panel(DATA)], &[View::Auto]));
    for image::Rgba([r, g, b, alpha]) in flat.pixels() {
        assert!(*alpha == 0 || [*r, *g, *b] == bytes(GREEN));
    }
    let turned = transparent(page(&surfaces, &[panel(DATA)], &[view]));
    let levels: std::collections::BTreeSet<u8> = turned.pixels().map(|pixel| pixel.0[3]).collect();
    assert!(levels.len() == 9, "{levels:?}");
}

#[test]
fn the_bytes_do_not_depend_on_the_threads() {
    let mesh = shape("torus:60x40");
    let count = mesh.vertices.len();
    let values: Vec<f64> = (0..count).map(|k| (k % 37) as f64).collect();
    let u: Vec<f64> = mesh
        .vertices
        .iter()
        .flat_map(|x| {
            let t = (0.5 + 0.4 * x.x).clamp(0.0, 1.0);
            [t, 1.0 - t]
        })
        .collect();
    let surfaces = [Surface {
        mesh: &mesh,
        data: Some(ShownData::Numbers { values: &values, range: [0.0, 36.0], label: "numbers" }),
        regions: Some(Regions::of_u(u, 2)),
        means: None,
        frame: None,
    }];
    let all = [
        DATA,
        Shown::Data { cut: true },
        Shown::Means,
        Shown::Labels,
        Shown::Column(1),
        Shown::Uncertainty,
    ]
    .map(|shown| Panel { caption: Some(shown.to_string()), ..panel(shown) });
    let views: Vec<View> = ["auto", "back"].map(|view| view.parse().unwrap()).to_vec();
    let draw = |threads: usize| {
        let page = Panels { width: "1200px".parse().unwrap(), ..page(&surfaces, &all, &views) };
        with_threads(Some(threads), || page.png().unwrap()).unwrap()
    };
    let one = draw(1);
    assert_eq!(one, draw(1));
    assert_eq!(one, draw(2));
    assert_eq!(one, draw(3));
}

/// A number is interpolated before it becomes a color: in the middle between 0 and 1, it is 1/2.
#[test]
fn columns_of_u_are_interpolated_as_numbers() {
    let mesh = rectangle(4.0);
    let u = [0.0, 1.0, 1.0, 0.0].iter().flat_map(|&t| [1.0 - t, t]).collect();
    let colors = [GREEN; 4];
    let surfaces = [surface(&mesh, &colors, Some(Regions::of_u(u, 2)))];
    for (p, t) in [(1, 0.25), (1, 0.5), (1, 0.9), (0, 0.25), (0, 0.9)] {
        let image = white(&page(&surfaces, &[panel(Shown::Column(p))], &[View::Auto]));
        let x = (2.0 + t * 396.0) as u32;
        let value = if p == 1 { t } else { 1.0 - t };
        let (found, expected) = (image.get_pixel(x, 40).0, bytes(sequential(value)));
        let near = found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 4);
        assert!(near, "{p} {t}: {found:?} {expected:?}");
    }
}

/// The uncertainty is 0 at one-hot vertices, and largest where all regions have the same share.
#[test]
fn uncertainty_ends_at_equal_shares() {
    let mesh = rectangle(4.0);
    let colors = [GREEN; 4];
    let third = [1.0 / 3.0; 3];
    let u = [[1.0, 0.0, 0.0], third, third, [0.0, 1.0, 0.0]].concat();
    let surfaces = [surface(&mesh, &colors, Some(Regions::of_u(u, 3)))];
    let image = white(&page(&surfaces, &[panel(Shown::Uncertainty)], &[View::Auto]));
    let near = |x: u32, color: [f64; 3]| {
        let found = image.get_pixel(x, 40).0;
        found.iter().zip(bytes(color)).all(|(a, b)| a.abs_diff(b) <= 6)
    };
    assert!(near(4, sequential(0.0)) && near(396, sequential(1.0)));
}

#[test]
fn regions_have_the_mean_of_their_data() {
    let mesh = rectangle(4.0);
    let [red, blue] = [[0.8, 0.2, 0.0], [0.0, 0.2, 0.8]];
    // The corners of the left and of the right side.
    let colors = [red, blue, blue, red];
    let labels = Regions::of_labels(&[0, 1, 1, 0], 2, None);
    let pixel = |surfaces: &[Surface], shown: Shown, x: u32| {
        white(&page(surfaces, &[panel(shown)], &[View::Auto])).get_pixel(x, 40).0
    };
    let surfaces = [surface(&mesh, &colors, Some(labels.clone()))];
    assert_eq!(pixel(&surfaces, Shown::Means, 50), bytes(red));
    assert_eq!(pixel(&surfaces, Shown::Means, 350), bytes(blue));
    assert_eq!(pixel(&surfaces, Shown::Labels, 350), bytes(categorical(1)));
    // The cut in the middle is red on means, and dark on the palette.
    let [r, g, b] = pixel(&surfaces, Shown::Means, 200);
    assert!(r > 200 && g < 60 && b < 60, "{r} {g} {b}");
    assert!(pixel(&surfaces, Shown::Labels, 200).iter().all(|&c| c < 60));

    let numbers =
        ShownData::Numbers { values: &[1.0, 3.0, 3.0, 1.0], range: [1.0, 5.0], label: "" };
    let surfaces = [Surface {
        mesh: &mesh,
        data: Some(numbers),
        regions: Some(labels.clone()),
        means: None,
        frame: None,
    }];
    let found = pixel(&surfaces, Shown::Means, 350);
    assert!(found.iter().zip(bytes(sequential(0.5))).all(|(a, b)| a.abs_diff(b) <= 1), "{found:?}");
    // Means that are given need no data.
    let means = Some(vec![GREEN, blue]);
    let surfaces = [Surface { mesh: &mesh, data: None, regions: Some(labels), means, frame: None }];
    assert_eq!(pixel(&surfaces, Shown::Means, 50), bytes(GREEN));
}

#[test]
fn color_bars_have_round_numbers() {
    let texts = |range: [f64; 2], length: f64| -> Vec<(f64, String)> {
        let labels = bar::labels(range, length).into_iter();
        labels.map(|(share, label)| ((1e6 * share).round() / 1e6, label.text)).collect()
    };
    let expected = |numbers: &[(f64, &str)]| -> Vec<(f64, String)> {
        numbers.iter().map(|&(share, text)| (share, text.to_owned())).collect()
    };
    assert_eq!(texts([0.0, 1.0], 300.0), expected(&[(0.0, "0"), (0.5, "0.5"), (1.0, "1")]));
    assert_eq!(
        texts([-20.0, 30.0], 300.0),
        expected(&[(0.0, "\u{2212}20"), (0.4, "0"), (0.8, "20")])
    );
    // A tiny bar has one number, a long one more.
    assert!(!texts([0.0, 1.0], 30.0).is_empty());
    assert!(texts([0.0, 1.0], 900.0).len() > 5);
    let tiny = bar::labels([0.0, 2e-7], 400.0);
    assert!(tiny.iter().any(|(_, label)| label.exponent.is_some()), "{tiny:?}");
}

/// A color bar shows the ends of the color map at its ends.
#[test]
fn a_color_bar_is_below_its_panel() {
    let mesh = rectangle(4.0);
    let values = [0.0, 1.0, 1.0, 0.0];
    let numbers = |range| ShownData::Numbers { values: &values, range, label: "heat in K" };
    for range in [[0.0, 1.0], [2.0, 2.0], [-1e-9, 1e9]] {
        let data = Some(numbers(range));
        let surfaces = [Surface { mesh: &mesh, data, regions: None, means: None, frame: None }];
        let image = white(&page(&surfaces, &[panel(DATA)], &[View::Auto]));
        let first = bytes(sequential(0.5 / 320.0));
        let bar = |y: u32| image.get_pixel(40, y).0 == first;
        let rows: Vec<u32> = (101..image.height()).filter(|&y| bar(y)).collect();
        assert_eq!(rows.len(), 20, "{range:?}: {rows:?}");
    }
}

#[test]
fn captions_are_lettered_if_there_are_several() {
    assert_eq!([0, 25, 26, 27, 701, 702].map(letters), ["a", "z", "aa", "ab", "zz", "aaa"]);
    let mesh = rectangle(4.0);
    let colors = [GREEN; 4];
    let surfaces = [surface(&mesh, &colors, None)];
    let with = |captions: &[Option<&str>]| {
        let panels: Vec<Panel> = captions
            .iter()
            .map(|caption| Panel { caption: caption.map(str::to_owned), ..panel(DATA) })
            .collect();
        let page = Panels { columns: Some(1), ..page(&surfaces, &panels, &[View::Auto]) };
        let stages = Stage::all(page.surfaces, page.views);
        let layout = Layout::new(&[vec![[2.0; 2]]], panels.len(), Some(1), 400.0, 0.0);
        let cells = page.cells(&stages, &layout);
        cells.into_iter().map(|cell| cell.caption.concat()).collect::<Vec<_>>()
    };
    assert_eq!(with(&[Some("data")]), ["data"]);
    assert_eq!(with(&[Some("data"), Some("more")]), ["(a) data", "(b) more"]);
    assert_eq!(with(&[Some("data"), None, Some("more")]), ["(a) data", "", "(b) more"]);
}

#[test]
fn the_grid_leaves_few_gaps() {
    let grid = |sizes: &[[f64; 2]], count: usize| {
        let layout = Layout::new(&[sizes.to_vec()], count, None, 2008.0, 0.0);
        (layout.columns, layout.stacked)
    };
    let square = [[1.0, 1.0]];
    assert_eq!(grid(&square, 1), (1, false));
    assert_eq!(grid(&square, 2), (2, false));
    assert_eq!(grid(&square, 3), (3, false));
    // Tall meshes stand in one row.
    assert_eq!(grid(&[[1.0, 3.0]], 5), (5, false));
    // Two views of each of three: below each other.
    assert_eq!(grid(&[[1.0, 1.0]; 2], 3), (3, true));
    // All is within the page.
    for count in 1..9 {
        for views in 1..4 {
            let sizes = vec![[1.0, 0.7]; views];
            let layout = Layout::new(&[sizes], count, None, 2008.0, 40.0);
            let columns = layout.columns as f64;
            let width = columns * layout.column_width + (columns - 1.0) * GAP + 40.0;
            assert!((width - 2008.0).abs() < 1e-6);
            let across = if layout.stacked { 1.0 } else { views as f64 };
            assert!(layout.scales[0] * across <= layout.column_width);
        }
    }
}

#[test]
fn headings_stand_above_columns_and_left_of_rows() {
    let mesh = rectangle(2.0);
    let colors = [GREEN; 4];
    let surfaces = [surface(&mesh, &colors, None)];
    let panels = vec![panel(DATA); 4];
    let texts = |texts: [&str; 2]| texts.map(str::to_owned);
    let (rows, columns) = (texts(["first", "second"]), texts(["data", "k-means"]));
    let page = Panels {
        columns: Some(2),
        row_headings: &rows,
        column_headings: &columns,
        ..page(&surfaces, &panels, &[View::Auto])
    };
    let image = white(&page);
    let ink = |xs: std::ops::Range<u32>, ys: std::ops::Range<u32>| {
        let dark = |x: u32, y: u32| image.get_pixel(x, y).0.iter().all(|&c| c < 120);
        ys.flat_map(|y| xs.clone().map(move |x| (x, y))).filter(|&(x, y)| dark(x, y)).count()
    };
    assert!(ink(0..40, 40..image.height() / 2) > 100);
    assert!(ink(40..200, 0..40) > 50 && ink(240..400, 0..40) > 50);
    let error = Panels { row_headings: &rows[..1], ..page }.png().unwrap_err().to_string();
    assert!(error.contains("2 rows and 2 columns"), "{error}");
}

#[test]
fn what_is_missing_is_an_error() {
    let mesh = rectangle(1.0);
    let colors = [GREEN; 4];
    let labels = || Some(Regions::of_labels(&[0, 1, 1, 0], 2, None));
    let u = Some(Regions::of_u(vec![0.5; 12], 3));
    let bare = Surface { mesh: &mesh, data: None, regions: None, means: None, frame: None };
    let labeled = Surface { regions: labels(), ..surface(&mesh, &colors, None) };
    let relaxed = Surface { regions: u, ..surface(&mesh, &colors, None) };
    let error = |surface: &Surface, shown| surface.check(shown).unwrap_err().to_string();
    assert!(error(&bare, DATA).contains("no data"));
    assert!(error(&bare, Shown::Means).contains("no data"));
    assert!(error(&bare, Shown::Labels).contains("no regions"));
    assert!(error(&labeled, Shown::Column(0)).contains("not U"));
    assert!(error(&labeled, Shown::Uncertainty).contains("not U"));
    assert!(error(&relaxed, Shown::Column(3)).contains("u:0 to u:2"));
    assert!(relaxed.check(Shown::Column(2)).is_ok());
    let surfaces = [labeled];
    let wrong = Panel { surface: 1, ..panel(DATA) };
    for (panels, views) in
        [(vec![wrong], vec![View::Auto]), (vec![], vec![View::Auto]), (vec![panel(DATA)], vec![])]
    {
        assert!(page(&surfaces, &panels, &views).png().is_err());
    }
}

#[test]
fn a_mesh_without_area_leaves_its_panel_empty() {
    let mesh = Mesh::new(vec![Point3::origin()], vec![[0, 0, 0]]);
    let colors = [GREEN];
    let surfaces = [surface(&mesh, &colors, None)];
    let panels = [panel(DATA)];
    assert!(white(&page(&surfaces, &panels, &[View::Auto])).pixels().all(|p| p.0 == [255; 3]));
}

#[test]
fn quantities_have_names() {
    for text in ["data", "data+cut", "means", "labels", "u:12", "uncertainty"] {
        assert_eq!(text.parse::<Shown>().unwrap().to_string(), text);
    }
    for wrong in ["", "u", "u:", "u:-1", "u:x", "Data", "label"] {
        assert!(wrong.parse::<Shown>().is_err(), "{wrong}");
    }
}

/// A half as large, at the right end of the frame: half as wide in the picture, and the right ends meet.
#[test]
fn surfaces_keep_their_places_in_a_frame() {
    let frame = shape("sphere:4");
    let mut half = shape("sphere:4").scaled(0.5);
    half.vertices.iter_mut().for_each(|x| x.x += 0.5);
    let colors = vec![GREEN; frame.vertices.len()];
    let (panels, views) = ([panel(Shown::Data { cut: false })], ["front".parse().unwrap()]);
    let drawn = |mesh: &Mesh| {
        let surfaces = [Surface { frame: Some(&frame), ..surface(mesh, &colors, None) }];
        let image = white(&page(&surfaces, &panels, &views));
        (image.dimensions(), bounds(&image))
    };
    let (size, [left, top, right, bottom]) = drawn(&frame);
    let (same, [half_left, half_top, half_right, half_bottom]) = drawn(&half);
    assert_eq!(size, same);
    let near = |a: u32, b: u32| a.abs_diff(b) <= (right - left) / 30;
    assert!(near(half_right, right) && near(half_left, left.midpoint(right)));
    assert!(near(half_bottom - half_top, (bottom - top) / 2));
    assert!(near(half_bottom + half_top, bottom + top));
}
