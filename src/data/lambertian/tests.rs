//! Planted lights and albedos are found, and costs never increase.

use rand::RngExt;

use super::*;
use crate::data::Radiance;
use crate::data::constant::Mean;
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::geometry::{barycentric_areas, vertex_normals};
use crate::samples::{
    bumpy, fitted_energy, random_data, rng, shape, to_fit, with_isolated_vertices,
};

const RHO: [[f64; 3]; 3] = [[0.9, 0.3, 0.2], [0.2, 0.7, 0.3], [0.3, 0.3, 0.8]];

fn albedos(light: Vector3<f64>, ambient: f64) -> Vec<Albedo> {
    let light = light.normalize().into();
    RHO.map(|rho| Albedo { albedo: rho.to_vec(), light, ambient }).to_vec()
}

/// Three bands of height on a sphere, and their colors in this light.
fn lit_bands(mesh: &Mesh, mu: &[Albedo]) -> (Data, Vec<Row<3>>) {
    let normals = vertex_normals(mesh);
    let region = |k: usize| match mesh.vertices[k].z {
        z if z < -0.4 => 0,
        z if z < 0.3 => 1,
        _ => 2,
    };
    let mut values = Vec::new();
    for (k, normal) in normals.iter().enumerate() {
        let mu = &mu[region(k)];
        let h = mu.ambient + normal.dot(&Vector3::from(mu.light)).max(0.0);
        values.extend(mu.albedo.iter().map(|rho| h * rho));
    }
    let u = (0..mesh.vertices.len()).map(|k| Row::one_hot(region(k))).collect();
    (Data::new(3, values).unwrap(), u)
}

fn masses(mesh: &Mesh, u: &[Row<3>]) -> Vec<Row<3>> {
    u.iter().zip(barycentric_areas(mesh)).map(|(&u, a)| u * a).collect()
}

fn fitted(model: &Lambertian<'_>, weights: Weights<'_>, mut mu: Vec<Albedo>) -> Vec<Albedo> {
    for _ in 0..20 {
        model.fit(weights, &mut mu).unwrap();
    }
    mu
}

fn assert_close(found: &[Albedo], planted: &[Albedo], tolerance: f64) {
    for (a, b) in found.iter().zip(planted) {
        let light = (Vector3::from(a.light) - Vector3::from(b.light)).norm();
        let rho = squared_distance(&a.albedo, 1.0, &b.albedo).sqrt();
        let errors = [light, (a.ambient - b.ambient).abs(), rho];
        assert!(errors.iter().all(|error| *error <= tolerance), "{errors:?}");
    }
}

/// L = 0 and alpha = 1 leave the colors as they are.
#[test]
fn ambient_light_alone_is_radiance() {
    let mesh = bumpy(6);
    let n = mesh.vertices.len();
    let data = random_data(n, 3, 5);
    let numbers = random_data(n, 2, 6);
    let evidence = Evidence { density: numbers.column(0), variance: numbers.column(1) };
    let normals = vertex_normals(&mesh);
    let given = Illumination { light: Some(Vector3::zeros()), ambient: Some(1.0) };
    let model = Lambertian::new(&data, Some(&evidence), &normals, given).unwrap();
    let radiance = Radiance::new(&data, &evidence);
    let mut lit: Vec<Albedo> = albedos(Vector3::x(), 1.0);
    lit.iter_mut().for_each(|mu| mu.light = [0.0; 3]);
    let mut means: Vec<Mean> = RHO.map(|rho| Mean { mean: rho.to_vec() }).to_vec();
    assert_eq!(model.costs::<3>(&lit), radiance.costs::<3>(&means));
    let u: Vec<f64> = (0..3 * n).map(|i| ((i * 7919) % 13) as f64).collect();
    model.fit(Weights::new(&u, 3), &mut lit).unwrap();
    radiance.fit(Weights::new(&u, 3), &mut means).unwrap();
    for (a, b) in lit.iter().zip(&means) {
        assert!(squared_distance(&a.albedo, 1.0, &b.mean) <= 1e-28);
    }
}

/// Moving one channel of an albedo by d increases the energy by exactly d^2 int u_p r h^2.
#[test]
fn the_albedos_are_the_minimizers() {
    for (mesh, data, u, mass) in to_fit(121) {
        let normals = vertex_normals(&mesh);
        let [light, ambient] = [Vector3::new(1.0, -2.0, 2.0) / 3.0, Vector3::x() * 0.4];
        let given = Illumination { light: Some(light), ambient: Some(ambient.x) };
        let model = Lambertian::new(&data, None, &normals, given).unwrap();
        let quadrature = mass.on(&mesh);
        let energy = |mu: &[Albedo]| fitted_energy(&model, &quadrature, &u, mu);
        let mut mu = vec![Albedo { albedo: vec![0.5; 2], light: light.into(), ambient: 0.4 }; 3];
        let before = energy(&mu);
        let weights = quadrature.integrate(&u);
        model.fit(Weights::of(&weights), &mut mu).unwrap();
        let minimum = energy(&mu);
        assert!(minimum < before);
        let h = model.shading(&mu[0]);
        for p in 0..3 {
            let lit: f64 = weights.iter().zip(&h).map(|(w, h)| w.0[p] * h * h).sum();
            for (i, d) in [(0, 1e-2), (1, -0.2)] {
                let mut moved = mu.clone();
                moved[p].albedo[i] += d;
                let rise = energy(&moved) - minimum;
                assert!((rise - d * d * lit).abs() <= 1e-12 * before, "{mass:?}, {d}");
            }
        }
        assert_eq!(model.fit(Weights::of(&weights), &mut mu).unwrap(), 0.0);
    }
}

/// For the true labels, the light and the albedos of noise-free colors are found from a light in another direction; so is
/// what is not given of them.
#[test]
fn a_planted_light_is_found() {
    let mesh = shape("sphere:4");
    let normals = vertex_normals(&mesh);
    for ambient in [0.0, 0.15, 0.6] {
        let planted = albedos(Vector3::new(0.3, 1.0, 0.1), ambient);
        let (data, u) = lit_bands(&mesh, &planted);
        let weights = masses(&mesh, &u);
        let light = Vector3::from(planted[0].light);
        for given in [
            Illumination::default(),
            Illumination { light: Some(light), ambient: None },
            Illumination { light: None, ambient: Some(ambient) },
        ] {
            let model = Lambertian::new(&data, None, &normals, given).unwrap();
            let mut mu = albedos(given.light.unwrap_or(Vector3::new(1.0, 1.0, 0.0)), 0.1);
            mu.iter_mut().for_each(|mu| mu.ambient = given.ambient.unwrap_or(0.1));
            assert_close(&fitted(&model, Weights::of(&weights), mu), &planted, 1e-6);
        }
    }
}

/// Without a known light, the start finds it up to what the albedos hide; for one region exactly.
#[test]
fn the_start_finds_the_light() {
    let mesh = shape("sphere:4");
    let normals = vertex_normals(&mesh);
    let area = barycentric_areas(&mesh);
    let direction = Vector3::new(-0.5, 0.2, -1.0).normalize();
    let mut planted = albedos(direction, 0.2);
    let start = |planted: &[Albedo]| {
        let (data, _) = lit_bands(&mesh, planted);
        let model = Lambertian::new(&data, None, &normals, Illumination::default()).unwrap();
        model.start(Initial::KMeans, 3, &area, &mut rng(1)).unwrap()
    };
    let angle = |mu: &Albedo| Vector3::from(mu.light).angle(&direction).to_degrees();
    assert!(start(&planted).iter().all(|mu| angle(mu) < 15.0), "{:?}", start(&planted));
    planted = vec![planted[1].clone(); 3];
    for mu in start(&planted) {
        assert!(angle(&mu) < 0.1 && (mu.ambient - 0.2).abs() < 2e-3, "{mu:?}");
        assert!(squared_distance(&mu.albedo, 1.0, &planted[0].albedo).sqrt() < 5e-3, "{mu:?}");
    }
}

/// Whatever the data and the labels, a fit never increases the costs, and its numbers stay finite.
#[test]
fn costs_never_increase() {
    let plane = shape("grid:6x6");
    for (mesh, given) in [
        (shape("sphere:2"), Illumination::default()),
        (bumpy(5), Illumination { light: None, ambient: Some(0.3) }),
        (plane, Illumination::default()),
        (with_isolated_vertices(bumpy(4)), Illumination::default()),
    ] {
        let normals = vertex_normals(&mesh);
        let mut data = random_data(mesh.vertices.len(), 2, 9);
        data.values.chunks_mut(2).step_by(5).for_each(|row| row.fill(f64::NAN));
        let model = Lambertian::new(&data, None, &normals, given).unwrap();
        let mut rng = rng(4);
        let numbers: Vec<f64> = (0..3 * data.len()).map(|_| rng.random()).collect();
        let weights = Weights::new(&numbers, 3);
        let mut mu = model.start(Initial::Random, 3, &numbers[..data.len()], &mut rng).unwrap();
        let mut costs = model.costs_of(weights, &mu);
        for _ in 0..30 {
            model.fit(weights, &mut mu).unwrap();
            let now = model.costs_of(weights, &mu);
            assert!(now <= costs * (1.0 + 1e-12), "{now} after {costs}");
            costs = now;
        }
        model.check(&mu).unwrap();
    }
}

/// A region that the light does not reach keeps its albedo, and a dim one stays below the largest.
#[test]
fn regions_in_the_dark_keep_their_albedos() {
    let normals = [Vector3::z(), Vector3::z(), -Vector3::z(), Vector3::new(1.0, 0.0, 0.3)];
    let data = Data::new(1, vec![0.4, 0.8, 0.1, 0.9]).unwrap();
    let given = Illumination { light: Some(Vector3::z()), ambient: Some(0.0) };
    let model = Lambertian::new(&data, None, &normals, given).unwrap();
    let mut mu = vec![Albedo { albedo: vec![0.5], light: Vector3::z().into(), ambient: 0.0 }; 3];
    let u =
        [Row([1.0, 0.0, 0.0]), Row([1.0, 0.0, 0.0]), Row([0.0, 1.0, 0.0]), Row([0.0, 0.0, 1.0])];
    let change = model.fit(Weights::of(&u), &mut mu).unwrap();
    // .9 / .3 exceeds 1.5 times .9.
    let found = [0, 1, 2].map(|p| mu[p].albedo[0]);
    assert_eq!(found, [(0.4 + 0.8) / 2.0, 0.5, MAX_ALBEDO * 0.9]);
    assert_eq!(change, MAX_ALBEDO * 0.9 - 0.5);
}

/// Where the light reaches all vertices, int r h c of the coarse data is that of the fine ones.
#[test]
fn statistics_and_normals_restrict_by_sums() {
    let mesh = with_isolated_vertices(bumpy(12));
    let data = random_data(mesh.vertices.len(), 2, 7);
    let normals = vertex_normals(&mesh);
    let model = Lambertian::new(&data, None, &normals, Illumination::default()).unwrap();
    let weights = barycentric_areas(&mesh);
    let level = mesh.coarsened();
    let coarse = level.restricted(&weights, |k| model.is_known(k));
    let restricted = model.restricted(&level, &weights, &coarse);
    let mu = Albedo { albedo: vec![1.0; 2], light: [0.0, 0.0, 1.0], ambient: 0.2 };
    let total = |model: &Lambertian<'_>, weights: &[f64]| -> f64 {
        let h = model.shading(&mu);
        (0..weights.len()).map(|k| weights[k] * model.pixels.at(k).0 * h[k]).sum()
    };
    assert!(normals.iter().all(|normal| normal.z >= 0.0));
    let [fine, coarse] = [total(&model, &weights), total(&restricted, &coarse)];
    assert!((fine - coarse).abs() <= 1e-13 * fine, "{fine} {coarse}");
}

/// Scaling the light, and the albedos inversely, changes neither costs nor distances.
#[test]
fn distances_do_not_depend_on_the_unit_of_light() {
    let mu = albedos(Vector3::new(1.0, 2.0, 2.0), 0.3);
    let scaled = |mu: &Albedo| Albedo {
        albedo: mu.albedo.iter().map(|rho| rho / 8.0).collect(),
        light: mu.light.map(|x| 8.0 * x),
        ambient: 8.0 * mu.ambient,
    };
    let [a, b] = [&mu[0], &mu[1]];
    assert_eq!(Lambertian::distance(a, b), Lambertian::distance(&scaled(a), &scaled(b)));
}

/// Colors that show no light have none, and the albedos are their means; a given ambient light far above the true one, and
/// light that reaches no vertex, end as well.
#[test]
fn colors_without_shading_need_no_light() {
    let mesh = shape("sphere:2");
    let normals = vertex_normals(&mesh);
    let area = barycentric_areas(&mesh);
    let constant = Data::new(2, [0.5, 0.25].repeat(area.len())).unwrap();
    let model = Lambertian::new(&constant, None, &normals, Illumination::default()).unwrap();
    for mu in model.start(Initial::KMeans, 2, &area, &mut rng(1)).unwrap() {
        assert_eq!((mu.light, mu.ambient), ([0.0; 3], 1.0));
        assert!(squared_distance(&mu.albedo, 1.0, &[0.5, 0.25]) <= 1e-20, "{mu:?}");
    }
    let (data, u) = lit_bands(&mesh, &albedos(Vector3::x(), 0.3));
    let weights = masses(&mesh, &u);
    for ambient in [20.0, 1e3, 1e12, 1e300] {
        let given = Illumination { light: None, ambient: Some(ambient) };
        let model = Lambertian::new(&data, None, &normals, given).unwrap();
        let mut mu = model.start(Initial::KMeans, 3, &area, &mut rng(1)).unwrap();
        model.fit(Weights::of(&weights), &mut mu).unwrap();
        assert!(
            mu.iter().all(|mu| mu.ambient == ambient && mu.albedo.iter().all(|x| x.is_finite()))
        );
    }
    let below = vec![-Vector3::z(); area.len()];
    let given = Illumination { light: Some(Vector3::z()), ambient: Some(0.0) };
    let model = Lambertian::new(&data, None, &below, given).unwrap();
    let message = model.start(Initial::KMeans, 3, &area, &mut rng(1)).unwrap_err().to_string();
    assert!(message.contains("no light falls on"), "{message}");
}

#[test]
fn parameters_that_are_not_those_of_one_light_are_refused() {
    let mesh = bumpy(3);
    let data = random_data(mesh.vertices.len(), 3, 7);
    let normals = vertex_normals(&mesh);
    let model = Lambertian::new(&data, None, &normals, Illumination::default()).unwrap();
    let fails = |change: &dyn Fn(&mut Albedo), clause: &str| {
        let mut mu = albedos(Vector3::x(), 0.1);
        change(&mut mu[1]);
        let message = model.check(&mu).unwrap_err().to_string();
        assert!(message.contains(clause), "{message}");
    };
    fails(&|mu| mu.ambient = 0.2, "region 1 has another light");
    fails(&|mu| mu.ambient = -0.2, "ambient light -0.2");
    fails(&|mu| mu.light = [0.0, 1.0, 0.0], "region 1 has another light");
    fails(&|mu| mu.light = [f64::NAN; 3], "a light that is not finite");
    fails(&|mu| mu.albedo = vec![0.1; 2], "2 numbers for data of 3 columns");
    let dark = Data::new(1, vec![0.0; data.len()]).unwrap();
    let message = Lambertian::new(&dark, None, &normals, Illumination::default());
    assert!(message.err().unwrap().to_string().contains("no datum is above 0"));
}
