//! Four by four blocks of a city, a height field over the unit square as photogrammetry from the air yields it.
//!
//! | region | | region | | region | |
//! |---|---|---|---|---|---|
//! | 0 | pavement | 4 | tree | 8 | chimney |
//! | 1 | road | 5 | facade | 9 | car |
//! | 2 | grass | 6 | flat roof | 10 | wall |
//! | 3 | water | 7 | gable roof | 11 | shed |
//!
//! Lengths are shares of the side of a block. Things rise from the ground by a ramp inside their outline, and the ramp of
//! a building is its facade.

use nalgebra::Point3;

/// Number of regions.
pub const PARTS: usize = 12;

const PAVEMENT: usize = 0;
const ROAD: usize = 1;
const GRASS: usize = 2;
const WATER: usize = 3;
const TREE: usize = 4;
const FACADE: usize = 5;
const FLAT_ROOF: usize = 6;
const GABLE_ROOF: usize = 7;
const CHIMNEY: usize = 8;
const CAR: usize = 9;
const WALL: usize = 10;
const SHED: usize = 11;

/// Blocks along each side.
const BLOCKS: usize = 4;

/// Half the width of a road.
const HALF_ROAD: f64 = 0.09;

/// The width of the ramp of a building, and of smaller things.
const RAMP: f64 = 0.045;
const SMALL_RAMP: f64 = 0.02;

#[derive(Clone, Copy)]
enum Block {
    Tower,
    Houses,
    Park,
    Parking,
}

/// Row by row along x.
const PLAN: [[Block; BLOCKS]; BLOCKS] = [
    [Block::Houses, Block::Tower, Block::Park, Block::Houses],
    [Block::Park, Block::Houses, Block::Parking, Block::Tower],
    [Block::Tower, Block::Parking, Block::Houses, Block::Park],
    [Block::Houses, Block::Park, Block::Tower, Block::Parking],
];

/// The region at (x, y), 0 to 1 each.
pub fn part(x: f64, y: f64) -> usize {
    at(x, y).0
}

/// The point above (x, y).
pub fn point(x: f64, y: f64) -> Point3<f64> {
    Point3::new(x, y, at(x, y).1 / BLOCKS as f64)
}

/// A rectangle with the sides parallel to the axes.
struct Rectangle {
    low: [f64; 2],
    high: [f64; 2],
}

impl Rectangle {
    const fn new(low: [f64; 2], high: [f64; 2]) -> Self {
        Rectangle { low, high }
    }

    /// The distance to the nearest side; negative outside.
    fn inside(&self, [x, y]: [f64; 2]) -> f64 {
        let [a, b] = [x - self.low[0], self.high[0] - x];
        let [c, d] = [y - self.low[1], self.high[1] - y];
        a.min(b).min(c).min(d)
    }
}

/// The region at (x, y), and the height.
fn at(x: f64, y: f64) -> (usize, f64) {
    let block = |x: f64| ((BLOCKS as f64 * x) as usize).min(BLOCKS - 1);
    let (i, j) = (block(x), block(y));
    let p = [BLOCKS as f64 * x - i as f64, BLOCKS as f64 * y - j as f64];
    if Rectangle::new([HALF_ROAD; 2], [1.0 - HALF_ROAD; 2]).inside(p) < 0.0 {
        // Parked at the southern side.
        let car = |a: f64| Rectangle::new([a, 0.02], [a + 0.12, 0.075]).inside(p);
        return risen(car(0.25).max(car(0.6)), 0.05, SMALL_RAMP, CAR).unwrap_or((ROAD, 0.0));
    }
    match PLAN[j][i] {
        Block::Tower => tower(p),
        Block::Houses => houses(p),
        Block::Park => park(p),
        Block::Parking => parking(p),
    }
}

/// A region and its height at a distance inside an outline; `None` outside.
fn risen(inside: f64, height: f64, ramp: f64, region: usize) -> Option<(usize, f64)> {
    (inside > 0.0).then(|| (region, height * (inside / ramp).min(1.0)))
}

fn tower(p: [f64; 2]) -> (usize, f64) {
    const HEIGHT: f64 = 0.45;
    let chimney = Rectangle::new([0.55, 0.55], [0.65, 0.65]).inside(p);
    if let Some((region, above)) = risen(chimney, 0.12, SMALL_RAMP, CHIMNEY) {
        return (region, HEIGHT + above);
    }
    match risen(Rectangle::new([0.22, 0.2], [0.78, 0.82]).inside(p), HEIGHT, RAMP, FLAT_ROOF) {
        Some((_, height)) if height < HEIGHT => (FACADE, height),
        Some(roof) => roof,
        None => (PAVEMENT, 0.0),
    }
}

fn houses(p: [f64; 2]) -> (usize, f64) {
    const EAVES: f64 = 0.16;
    for [west, east] in [[0.15, 0.44], [0.58, 0.86]] {
        let inside = Rectangle::new([west, 0.3], [east, 0.84]).inside(p);
        if inside <= 0.0 {
            continue;
        }
        if inside < RAMP {
            return (FACADE, EAVES * inside / RAMP);
        }
        let slope = (p[0] - west).min(east - p[0]) - RAMP;
        let roof = EAVES + 0.9 * slope;
        let chimney = Rectangle::new([west + 0.06, 0.6], [west + 0.13, 0.67]).inside(p);
        return match risen(chimney, 0.1, SMALL_RAMP, CHIMNEY) {
            Some((region, above)) => (region, roof + above),
            None => (GABLE_ROOF, roof),
        };
    }
    let shed = Rectangle::new([0.42, 0.13], [0.62, 0.24]).inside(p);
    let tree = crown(p, [0.25, 0.2], 0.07).or(crown(p, [0.76, 0.19], 0.065));
    risen(shed, 0.09, SMALL_RAMP, SHED).or(tree).unwrap_or((GRASS, 0.0))
}

fn park(p: [f64; 2]) -> (usize, f64) {
    const TREES: [[f64; 3]; 5] = [
        [0.22, 0.24, 0.09],
        [0.5, 0.2, 0.07],
        [0.76, 0.28, 0.1],
        [0.24, 0.78, 0.1],
        [0.46, 0.8, 0.07],
    ];
    let (dx, dy) = (p[0] - 0.6, p[1] - 0.6);
    if (dx / 0.24).hypot(dy / 0.16) < 1.0 {
        return (WATER, 0.0);
    }
    let tree = TREES.into_iter().find_map(|[x, y, radius]| crown(p, [x, y], radius));
    tree.unwrap_or((GRASS, 0.0))
}

/// The crown of a tree, half an ellipsoid.
fn crown(p: [f64; 2], center: [f64; 2], radius: f64) -> Option<(usize, f64)> {
    let r = (p[0] - center[0]).hypot(p[1] - center[1]) / radius;
    (r < 1.0).then(|| (TREE, 1.6 * radius * (1.0 - r * r).sqrt()))
}

fn parking(p: [f64; 2]) -> (usize, f64) {
    let inside = Rectangle::new([0.13, 0.13], [0.87, 0.87]).inside(p);
    let wall = inside.min(0.05 - inside);
    // The entrance.
    if wall > 0.0 && !(p[1] < 0.5 && (0.4..0.6).contains(&p[0])) {
        return risen(wall, 0.1, SMALL_RAMP, WALL).expect("it is inside");
    }
    let car = |a: f64, b: f64| Rectangle::new([a, b], [a + 0.06, b + 0.13]).inside(p);
    let row = |b: f64| (0..5).map(|i| car(0.23 + 0.11 * f64::from(i), b)).fold(-1.0, f64::max);
    risen(row(0.3).max(row(0.6)), 0.05, SMALL_RAMP, CAR).unwrap_or((PAVEMENT, 0.0))
}
