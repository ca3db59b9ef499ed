//! Vertices that lie in one place but are not shared, as exporters leave them along the seams of texture charts or
//! at every corner, cut a surface apart: across them there is no gradient, so that cuts are free. A weld merges
//! the vertices
//!
//! ```text
//! v ~ w   if   |x_v - x_w| <= tolerance   and whatever follows by transitivity;   tolerance 0: x_v = x_w, -0 = 0
//! ```
//!
//! onto the first of each class. Values of the merged are means by their barycentric cells, so that integrals are
//! kept: sum_v a_v s_v. Vertices in no face stay apart. Equal positions are found by a hash table; near ones on a
//! grid: what shares a cell of side tolerance / sqrt(3) is merged unseen, and blocks of 4 x 4 x 4 cells are hashed,
//! so that the at most 124 cells around another one lie in eight blocks. Both in O(V) time.
//!
//! Reference for the grid: J. L. Bentley, D. F. Stanat, E. H. Williams, *The complexity of finding fixed-radius
//! near neighbors*, Information Processing Letters 6(6), 1977.

use nalgebra::Point3;

use super::Mesh;
use super::geometry::barycentric_areas;
use super::order::sorted_by;
use super::partition::Partition;
use super::statistics::{bounding_box, components};
use crate::sweep;

/// A mesh whose coincident vertices are merged, and where each vertex went.
#[derive(Clone, Debug, PartialEq)]
pub struct Weld {
    /// For each vertex of the mesh as it was, its number in the welded one.
    pub of: Vec<u32>,
    /// Vertices in the order of their first appearance, with the mean colors of what was merged; faces as they
    /// were, with all that belongs to them. Faces that collapsed are still there.
    pub mesh: Mesh,
    /// How many vertices are gone.
    pub merged: usize,
    /// How many vertices these were merged onto.
    pub onto: usize,
    /// Edges with more than two faces, no side of which had more before: sheets that lie on each other or touch.
    pub new_non_manifold_edges: usize,
    /// The barycentric cells of the mesh as it was.
    areas: Vec<f64>,
}

impl Weld {
    /// Merges the vertices at equal positions; none if there are no two.
    pub fn exact(mesh: &Mesh) -> Option<Self> {
        firsts(mesh).map(|first| Weld::onto(mesh, &first))
    }

    /// Merges the vertices within a tolerance, a length; none if there are no two. Panics if it is negative or
    /// not finite.
    pub fn within(mesh: &Mesh, tolerance: f64) -> Option<Self> {
        assert!(tolerance >= 0.0 && tolerance.is_finite());
        let exact = firsts(mesh);
        if tolerance == 0.0 {
            return exact.map(|first| Weld::onto(mesh, &first));
        }
        let first = near(mesh, exact, tolerance);
        (moved(&first) > 0).then(|| Weld::onto(mesh, &first))
    }

    /// Merges every vertex onto the one that it has in `first`, which comes no later and stays itself.
    fn onto(mesh: &Mesh, first: &[u32]) -> Self {
        let mut of = Vec::with_capacity(first.len());
        let mut vertices = Vec::new();
        let mut merged_onto = vec![false; first.len()];
        for (v, &first) in first.iter().enumerate() {
            if first as usize == v {
                of.push(vertices.len() as u32);
                vertices.push(mesh.vertices[v]);
            } else {
                of.push(of[first as usize]);
                merged_onto[first as usize] = true;
            }
        }
        let faces = sweep::collect(
            mesh.faces.len(),
            #[inline(always)]
            |j| mesh.faces[j].map(|v| of[v as usize]),
        );
        let mut weld = Weld {
            merged: of.len() - vertices.len(),
            onto: merged_onto.iter().filter(|&&onto| onto).count(),
            new_non_manifold_edges: new_non_manifold_edges(mesh, &of, first, &merged_onto),
            areas: barycentric_areas(mesh),
            mesh: Mesh {
                vertices,
                faces,
                colors: None,
                face_colors: mesh.face_colors.clone(),
                uv: mesh.uv.clone(),
                materials: mesh.materials.clone(),
            },
            of,
        };
        weld.mesh.colors = mesh.colors.as_ref().map(|colors| {
            let means = weld.means(colors.as_flattened(), 3);
            means.as_chunks::<3>().0.to_vec()
        });
        weld
    }

    /// The means of values at the vertices of the mesh as it was, d a vertex, by its barycentric cells.
    pub fn means(&self, values: &[f64], d: usize) -> Vec<f64> {
        self.means_by(values, d, &self.areas)
    }

    /// The means by other weights. Rows with a NaN are unknown and left out; where nothing is known the mean is
    /// NaN, where nothing has weight all count alike. Means of equal rows are these rows, to the bit.
    pub fn means_by(&self, values: &[f64], d: usize, weights: &[f64]) -> Vec<f64> {
        assert_eq!(values.len(), d * self.of.len());
        let row = |v: u32| &values[v as usize * d..][..d];
        let by_class = sorted_by(&self.of, self.mesh.vertices.len());
        let mut means = Vec::with_capacity(self.mesh.vertices.len() * d);
        for class in by_class.chunk_by(|&v, &w| self.of[v as usize] == self.of[w as usize]) {
            let known = || class.iter().filter(|&&v| row(v).iter().all(|x| !x.is_nan()));
            match known().next() {
                None => means.extend(std::iter::repeat_n(f64::NAN, d)),
                Some(&first) if known().all(|&v| row(v) == row(first)) => means.extend(row(first)),
                Some(_) => {
                    let total: f64 = known().map(|&v| weights[v as usize]).sum();
                    let weight = |v: u32| if total > 0.0 { weights[v as usize] } else { 1.0 };
                    let weighty = || known().filter(|&&v| weight(v) > 0.0);
                    let total: f64 = weighty().map(|&v| weight(v)).sum();
                    means.extend(
                        (0..d).map(|i| {
                            weighty().map(|&v| weight(v) * row(v)[i]).sum::<f64>() / total
                        }),
                    );
                }
            }
        }
        means
    }

    /// Values at the welded vertices for each vertex of the mesh as it was.
    pub fn spread<T: Copy + Send + Sync>(&self, values: &[T]) -> Vec<T> {
        sweep::collect(
            self.of.len(),
            #[inline(always)]
            |v| values[self.of[v] as usize],
        )
    }
}

/// How many vertices of faces lie at the position of an earlier one: what [`Weld::exact`] merges.
pub fn coincident(mesh: &Mesh) -> usize {
    firsts(mesh).map_or(0, |first| moved(&first))
}

/// What so many coincident vertices mean, in words.
pub fn free_cuts(coincident: usize) -> String {
    format!(
        "{coincident} vertices lie at the positions of others, and cuts along such seams are free"
    )
}

/// How many [`Weld::within`] merges.
pub fn coincident_within(mesh: &Mesh, tolerance: f64) -> usize {
    moved(&near(mesh, firsts(mesh), tolerance))
}

fn moved(first: &[u32]) -> usize {
    (0..).zip(first).filter(|&(v, &first): &(u32, _)| v != first).count()
}

/// Whether a mesh falls apart into about as many components as it has faces, as a soup of triangles does.
pub fn is_shattered(mesh: &Mesh) -> bool {
    let faces = mesh.faces.len();
    // Each component has three vertices of its own, which nearly all meshes have not enough of.
    faces > 2 && mesh.vertices.len() >= 3 * (faces / 2) && 2 * components(mesh) > faces
}

/// Of tolerances from 0 to 1e-4 of the bounding box's diagonal the first at which a shattered mesh is shattered no
/// more, if no face collapses.
pub fn mending_tolerance(mesh: &Mesh) -> Option<f64> {
    let diagonal = bounding_box(mesh).map_or(0.0, |corners| corners.diagonal());
    [0.0, 1e-6, 1e-5, 1e-4].map(|share| share * diagonal).into_iter().find(|&tolerance| {
        Weld::within(mesh, tolerance).is_some_and(|weld| {
            let collapsed = |j: &usize| weld.mesh.is_degenerate(*j) && !mesh.is_degenerate(*j);
            !is_shattered(&weld.mesh) && !(0..mesh.faces.len()).any(|j| collapsed(&j))
        })
    })
}

/// The vertices that faces refer to.
fn referenced(mesh: &Mesh) -> Vec<bool> {
    let mut referenced = vec![false; mesh.vertices.len()];
    mesh.faces.iter().flatten().for_each(|&v| referenced[v as usize] = true);
    referenced
}

/// For each vertex the first one at its position, none if each is alone; of the vertices in faces.
fn firsts(mesh: &Mesh) -> Option<Vec<u32>> {
    let pairs = equal_pairs(&mesh.vertices, |_| true);
    if pairs.is_empty() {
        return None;
    }
    let referenced = referenced(mesh);
    let pairs = equal_pairs(&mesh.vertices, |v| referenced[v]);
    let mut first: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for &[v, earlier] in &pairs {
        first[v as usize] = earlier;
    }
    (!pairs.is_empty()).then_some(first)
}

/// Each of the vertices at whose position an earlier one is, and the first of these.
///
/// Every thread has a table for the positions whose hashes fall to it.
fn equal_pairs(points: &[Point3<f64>], counts: impl Fn(usize) -> bool + Sync) -> Vec<[u32; 2]> {
    // -0 + 0 = 0, so that both zeros have the same bits.
    let bits = |v: usize| [points[v].x, points[v].y, points[v].z].map(|x| (x + 0.0).to_bits());
    let hashes = sweep::collect(
        points.len(),
        #[inline(always)]
        |v| hash(bits(v)),
    );
    let parts = sweep::ranges(points.len()).len() - 1;
    let part_of = |hash: u64| ((u128::from(hash) * parts as u128) >> 64) as usize;
    let pairs = sweep::results((0..parts).collect(), |part| {
        let mine = || {
            let all = hashes.iter().enumerate();
            all.filter(|&(v, &hash)| part_of(hash) == part && counts(v))
        };
        let mut table = Table::for_at_most(mine().count());
        let mut pairs = Vec::new();
        for (v, &hash) in mine() {
            let first = table.find_or_insert(hash, v as u32, |w| bits(w as usize) == bits(v));
            if first as usize != v {
                pairs.push([v as u32, first]);
            }
        }
        pairs
    });
    pairs.concat()
}

/// For each vertex the first one of its class within a tolerance.
fn near(mesh: &Mesh, exact: Option<Vec<u32>>, tolerance: f64) -> Vec<u32> {
    let vertices = mesh.vertices.len() as u32;
    let mut joined = Partition::new(mesh.vertices.len());
    for (v, &first) in (0..).zip(exact.iter().flatten()) {
        joined.join(v, first);
    }
    let referenced = referenced(mesh);
    let mut grid = Grid::new(&mesh.vertices, tolerance);
    for v in (0..vertices).filter(|&v| referenced[v as usize]) {
        if exact.as_ref().is_none_or(|first| first[v as usize] == v) {
            grid.add(v, &mut joined);
        }
    }
    grid.join_neighbors(&mut joined);
    (0..vertices).map(|v| joined.root(v)).collect()
}

/// Of the side of a cell over the tolerance: a little below 1 / sqrt(3), for rounding.
const SIDE: f64 = 0.577;

/// No more cells than this along half an axis, so that their numbers are exact.
const MOST_CELLS: f64 = (1_u64 << 40) as f64;

/// A vertex or cell that is not there.
const NONE: u32 = u32::MAX;

/// Points in cells, and cells in blocks of 4 x 4 x 4.
struct Grid<'a> {
    points: &'a [Point3<f64>],
    tolerance: f64,
    side: f64,
    cells: Vec<Cell>,
    /// The first cell of each block.
    blocks: Table,
    /// The next vertex of the same cell.
    next: Vec<u32>,
}

struct Cell {
    place: [i64; 3],
    /// Its first vertex, and its last so far.
    first: u32,
    last: u32,
    /// The next cell of the same block, [`NONE`] at the last.
    next: u32,
}

impl Cell {
    fn block(&self) -> [i64; 3] {
        self.place.map(|i| i >> 2)
    }
}

impl<'a> Grid<'a> {
    fn new(points: &'a [Point3<f64>], tolerance: f64) -> Self {
        let largest = points.iter().map(|x| x.coords.amax()).fold(0.0, f64::max);
        Grid {
            points,
            tolerance,
            side: (SIDE * tolerance).max(largest / MOST_CELLS),
            cells: Vec::new(),
            blocks: Table::for_at_most(points.len()),
            next: vec![NONE; points.len()],
        }
    }

    fn points_of(&self, cell: u32) -> impl Iterator<Item = &'a Point3<f64>> + '_ {
        let chain = |&v: &u32| Some(self.next[v as usize]).filter(|&v| v != NONE);
        let vertices = std::iter::successors(Some(self.cells[cell as usize].first), chain);
        vertices.map(|v| &self.points[v as usize])
    }

    /// The cells of a block.
    fn cells_of(&self, block: [i64; 3]) -> impl Iterator<Item = u32> + '_ {
        let chain = |&cell: &u32| Some(self.cells[cell as usize].next).filter(|&cell| cell != NONE);
        let same = |cell: u32| self.cells[cell as usize].block() == block;
        std::iter::successors(self.blocks.find(hash_of(block), same), chain)
    }

    /// Joins a vertex with those in its cell.
    fn add(&mut self, v: u32, joined: &mut Partition) {
        let x = self.points[v as usize];
        let place = [x.x, x.y, x.z].map(|x| (x / self.side).floor() as i64);
        let block = place.map(|i| i >> 2);
        let same = |&cell: &u32| self.cells[cell as usize].place == place;
        let found = self.cells_of(block).find(same);
        if let Some(cell) = found {
            return self.add_to(cell, v, joined);
        }
        let end = self.cells_of(block).last();
        let new = self.cells.len() as u32;
        self.cells.push(Cell { place, first: v, last: v, next: NONE });
        match end {
            Some(end) => self.cells[end as usize].next = new,
            None => {
                self.blocks.find_or_insert(hash_of(block), new, |_| false);
            }
        }
    }

    fn add_to(&mut self, cell: u32, v: u32, joined: &mut Partition) {
        let x = &self.points[v as usize];
        if self.side <= SIDE * self.tolerance {
            joined.join(v, self.cells[cell as usize].first);
        } else {
            // A cell that is as fine as numbers allow is wider than the tolerance; nearly nothing shares it.
            let mut w = self.cells[cell as usize].first;
            while w != NONE {
                if (x - self.points[w as usize]).norm() <= self.tolerance {
                    joined.join(v, w);
                }
                w = self.next[w as usize];
            }
        }
        let last = std::mem::replace(&mut self.cells[cell as usize].last, v);
        self.next[last as usize] = v;
    }

    /// Joins what lies within the tolerance in different cells.
    fn join_neighbors(&self, joined: &mut Partition) {
        for (cell, this) in (0..).zip(&self.cells) {
            // What is up to two cells away to either side lies in two blocks.
            let blocks = this.place.map(|i| [(i - 2) >> 2, (i + 2) >> 2]);
            for corner in 0..8 {
                let block = [0, 1, 2].map(|axis| blocks[axis][corner >> axis & 1]);
                for other in self.cells_of(block).filter(|&other| other > cell) {
                    let there = &self.cells[other as usize];
                    let far = |axis: usize| (there.place[axis] - this.place[axis]).abs() > 2;
                    if !(0..3).any(far)
                        && joined.root(this.first) != joined.root(there.first)
                        && self.touch(cell, other)
                    {
                        joined.join(this.first, there.first);
                    }
                }
            }
        }
    }

    /// Whether a vertex of one cell lies within the tolerance of one of the other.
    fn touch(&self, cell: u32, other: u32) -> bool {
        let Some(&first) = self.points_of(other).next() else { return false };
        let bounds =
            self.points_of(other).fold((first, first), |(low, high), x| (low.inf(x), high.sup(x)));
        let near_bounds =
            |x: &Point3<f64>| (x - x.sup(&bounds.0).inf(&bounds.1)).norm() <= self.tolerance;
        self.points_of(cell)
            .filter(|x| near_bounds(x))
            .any(|x| self.points_of(other).any(|y| (x - y).norm() <= self.tolerance))
    }
}

/// Open addressing: who was first with an equal key.
struct Table {
    /// The upper half of the hash, and a number; all ones where nobody is.
    slots: Vec<u64>,
}

const FREE: u64 = u64::MAX;

impl Table {
    fn for_at_most(n: usize) -> Self {
        Table { slots: vec![FREE; (2 * n).next_power_of_two()] }
    }

    /// The slot of the one whose hash this is and who is the same, or the free one that waits for it.
    #[inline(always)]
    fn slot(&self, hash: u64, same: impl Fn(u32) -> bool) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        loop {
            let taken = self.slots[slot];
            if taken == FREE || (taken >> 32 == hash >> 32 && same(taken as u32)) {
                return slot;
            }
            slot = (slot + 1) & mask;
        }
    }

    fn find(&self, hash: u64, same: impl Fn(u32) -> bool) -> Option<u32> {
        let taken = self.slots[self.slot(hash, same)];
        (taken != FREE).then_some(taken as u32)
    }

    #[inline(always)]
    fn find_or_insert(&mut self, hash: u64, new: u32, same: impl Fn(u32) -> bool) -> u32 {
        let slot = self.slot(hash, same);
        if self.slots[slot] == FREE {
            self.slots[slot] = hash >> 32 << 32 | u64::from(new);
        }
        self.slots[slot] as u32
    }
}

fn hash_of(place: [i64; 3]) -> u64 {
    hash(place.map(i64::cast_unsigned))
}

/// Products whose upper halves are folded onto the lower ones: coordinates have zeros at their ends.
#[inline(always)]
fn hash(words: [u64; 3]) -> u64 {
    words.into_iter().fold(0x9e37_79b9_7f4a_7c15, |hash, word| {
        let product = u128::from(hash ^ word) * 0xd6e8_feb8_6659_fd93;
        (product as u64 ^ (product >> 64) as u64).wrapping_add(0x2545_f491_4f6c_dd1d)
    })
}

/// Edges of the welded mesh with more than two proper faces, whose sides had at most two each before.
fn new_non_manifold_edges(mesh: &Mesh, of: &[u32], first: &[u32], merged_onto: &[bool]) -> usize {
    // Only edges at which something was merged have faces that they had not before.
    let changed = |v: u32| merged_onto[first[v as usize] as usize];
    let mut sides: Vec<[[u32; 2]; 2]> = (mesh.faces.iter())
        .filter(|face| {
            let [a, b, c] = face.map(|v| of[v as usize]);
            a != b && b != c && c != a
        })
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .filter(|&[a, b]| changed(a) || changed(b))
        .map(|side| {
            let ascending = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
            [ascending(side.map(|v| of[v as usize])), ascending(side)]
        })
        .collect();
    sides.sort_unstable();
    sides
        .chunk_by(|a, b| a[0] == b[0])
        .filter(|edge| {
            edge.len() > 2 && edge.chunk_by(|a, b| a[1] == b[1]).all(|side| side.len() <= 2)
        })
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Statistics;
    use crate::samples::{bumpy, disjoint, random_vector, rng, shape, shuffled, zoo};
    use crate::sweep::with_threads;
    use rand::RngExt;

    /// Every face with vertices of its own, and the vertex that each of these was.
    fn taken_apart(mesh: &Mesh) -> (Mesh, Vec<u32>) {
        let before = mesh.faces.as_flattened().to_vec();
        let vertices = before.iter().map(|&v| mesh.vertices[v as usize]).collect();
        let faces = (0..mesh.faces.len() as u32).map(|j| [3 * j, 3 * j + 1, 3 * j + 2]).collect();
        (Mesh::new(vertices, faces), before)
    }

    #[test]
    fn what_was_taken_apart_comes_together() {
        for (name, mesh) in zoo() {
            let (apart, before) = taken_apart(&mesh);
            let weld = Weld::exact(&apart).unwrap();
            let whole = Statistics::of(&mesh);
            let again = Statistics::of(&weld.mesh);
            assert_eq!(again.vertices, whole.vertices - whole.unreferenced_vertices, "{name}");
            assert_eq!(again.euler_characteristic, whole.euler_characteristic, "{name}");
            assert_eq!(
                (again.components, again.boundary_edges, again.inconsistent_edges),
                (whole.components, whole.boundary_edges, whole.inconsistent_edges),
                "{name}"
            );
            assert_eq!(weld.merged, apart.vertices.len() - again.vertices, "{name}");
            for (v, &k) in before.iter().enumerate() {
                let now = weld.mesh.vertices[weld.of[v] as usize];
                assert_eq!(now, mesh.vertices[k as usize], "{name}");
            }
            assert!(weld.mesh.faces.iter().zip(&mesh.faces).all(|(now, face)| {
                now.map(|v| weld.mesh.vertices[v as usize])
                    == face.map(|v| mesh.vertices[v as usize])
            }));
            assert!(Weld::exact(&weld.mesh).is_none(), "{name}");
        }
    }

    #[test]
    fn the_first_of_each_class_stays_and_both_zeros_are_one() {
        let points =
            [[0.0, 1.0, 0.0], [5.0; 3], [-0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [5.0; 3], [5.0; 3]];
        let mut mesh = Mesh::new(points.map(Point3::from).to_vec(), vec![[0, 1, 3], [2, 3, 4]]);
        let weld = Weld::exact(&mesh).unwrap();
        // The last is in no face.
        assert_eq!(weld.of, [0, 1, 0, 2, 1, 3]);
        assert_eq!((weld.merged, weld.onto, coincident(&mesh)), (2, 2, 2));
        assert_eq!(weld.mesh.faces, [[0, 1, 2], [0, 2, 1]]);
        assert_eq!(weld.spread(&[7, 8, 9, 10]), [7, 8, 7, 9, 8, 10]);
        mesh.vertices.iter_mut().for_each(|x| x.x += 1.0);
        assert_eq!(Weld::exact(&mesh).unwrap().of, weld.of);
    }

    /// Against all pairs of points, at scales where numbers end, with clusters and lattices.
    #[test]
    fn a_grid_finds_what_all_pairs_find() {
        let mut rng = rng(211);
        for (case, scale) in [1.0, 1e-30, 1e30, 1.0, 1.0, 1e4].into_iter().enumerate() {
            for tolerance in [1e-300, 1e-9, 1e-3, 0.03, 0.2, 1.0, 10.0] {
                let points: Vec<Point3<f64>> = (0..300)
                    .map(|k| {
                        let x = random_vector(&mut rng);
                        let place = match case {
                            3 => x.map(|x| (8.0 * x).round() / 8.0),
                            4 => x * 0.01 + nalgebra::Vector3::repeat(f64::from(k % 5) * 0.2),
                            5 => x * 1e-9 + nalgebra::Vector3::repeat(1.0),
                            _ => x,
                        };
                        Point3::from(place * scale)
                    })
                    .collect();
                let tolerance = tolerance * scale;
                let faces = (0..100).map(|j| [3 * j, 3 * j + 1, 3 * j + 2]).collect();
                let mesh = Mesh::new(points.clone(), faces);
                let mut joined = Partition::new(points.len());
                for (a, x) in (0..).zip(&points) {
                    for (b, y) in (0..a).zip(&points) {
                        if (x - y).norm() <= tolerance {
                            joined.join(a, b);
                        }
                    }
                }
                let expected: Vec<u32> = (0..points.len() as u32).map(|v| joined.root(v)).collect();
                assert_eq!(near(&mesh, firsts(&mesh), tolerance), expected, "{case} {tolerance:e}");
            }
        }
    }

    /// A tolerance that spans many vertices takes no time that grows with their square.
    #[test]
    fn large_tolerances_end() {
        let two = disjoint([shape("torus:400x250"), {
            let mut other = shape("torus:400x250");
            other.vertices.iter_mut().for_each(|x| x.x += 2.0);
            other
        }]);
        for tolerance in [1e-3, 0.1, 1.0, 100.0] {
            let begin = std::time::Instant::now();
            let weld = Weld::within(&two, tolerance);
            assert!(begin.elapsed().as_secs() < 10, "{tolerance}");
            if tolerance >= 0.1 {
                let surfaces = if tolerance < 10.0 { 2 } else { 1 };
                assert_eq!(weld.unwrap().mesh.vertices.len(), surfaces);
            }
        }
    }

    #[test]
    fn the_same_with_any_number_of_threads() {
        let (apart, _) = taken_apart(&shuffled(&bumpy(60), &mut rng(3)).0);
        let one = with_threads(Some(1), || Weld::exact(&apart)).unwrap();
        for threads in [2, 3, 7] {
            assert_eq!(with_threads(Some(threads), || Weld::exact(&apart)).unwrap(), one);
        }
        assert_eq!(Weld::within(&apart, 1e-12), one);
    }

    #[test]
    fn means_keep_integrals_and_leave_out_what_is_unknown() {
        let (mut apart, before) = taken_apart(&bumpy(12));
        let mut rng = rng(9);
        let colors: Vec<[f64; 3]> =
            (0..before.len()).map(|_| [0; 3].map(|_| rng.random_range(0.0..1.0))).collect();
        apart.colors = Some(colors.clone());
        let weld = Weld::exact(&apart).unwrap();
        let means = weld.mesh.colors.clone().unwrap();
        let integral = |mesh: &Mesh, colors: &[[f64; 3]], i: usize| {
            let terms = barycentric_areas(mesh).into_iter().zip(colors);
            terms.map(|(a, color)| a * color[i]).sum::<f64>()
        };
        for i in 0..3 {
            let (whole, sum) = (integral(&apart, &colors, i), integral(&weld.mesh, &means, i));
            assert!((whole - sum).abs() < 1e-14 * whole.abs());
        }
        // The same at all copies is the same, to the bit.
        let of_place: Vec<f64> = before.iter().map(|&k| 0.1 + f64::from(k) / 3.0).collect();
        let same = weld.spread(&weld.means(&of_place, 1));
        assert_eq!(same, of_place);
        // One of the copies known is enough.
        let seldom: Vec<f64> = (0..before.len())
            .map(|v| if weld.of[..v].contains(&weld.of[v]) { f64::NAN } else { 4.5 })
            .collect();
        assert!(weld.means(&seldom, 1).iter().all(|&x| x == 4.5));
        assert!(weld.means(&vec![f64::NAN; before.len()], 1).iter().all(|x| x.is_nan()));
        // Forbidden at one is forbidden.
        let mut costs = vec![1.0; before.len()];
        costs[5] = f64::INFINITY;
        assert_eq!(weld.means(&costs, 1)[weld.of[5] as usize], f64::INFINITY);
        let unweighted = weld.means_by(&costs, 1, &vec![0.0; before.len()]);
        assert_eq!(unweighted[weld.of[5] as usize], f64::INFINITY);
        assert!(unweighted.iter().all(|x| !x.is_nan()));
    }

    #[test]
    fn sheets_on_each_other_become_non_manifold() {
        let grid = shape("grid:4x3");
        let mut back = grid.clone();
        back.faces.iter_mut().for_each(|face| face.swap(1, 2));
        let weld = Weld::exact(&disjoint([grid.clone(), back])).unwrap();
        let inner = Statistics::of(&grid).edges - Statistics::of(&grid).boundary_edges;
        assert_eq!(weld.new_non_manifold_edges, inner);
        // Touching in a vertex makes none, and what was there before is not new.
        let mut beside = grid.clone();
        beside.vertices.iter_mut().for_each(|x| *x += nalgebra::Vector3::new(1.0, 0.75, 0.0));
        let weld = Weld::exact(&disjoint([grid, beside])).unwrap();
        assert_eq!((weld.merged, weld.new_non_manifold_edges), (1, 0));
        let (mut seam, _) = taken_apart(&shape("sphere:1"));
        assert_eq!(Weld::exact(&seam).unwrap().new_non_manifold_edges, 0);
        let points = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, -1.0, 0.0],
            [0.0; 3],
        ];
        seam = Mesh::new(
            points.map(Point3::from).to_vec(),
            vec![[0, 1, 2], [0, 1, 3], [0, 1, 4], [5, 2, 3]],
        );
        assert_eq!(Weld::exact(&seam).unwrap().new_non_manifold_edges, 0);
    }

    #[test]
    fn soups_are_shattered_and_mended_at_the_least_tolerance() {
        let sphere = shape("sphere:3");
        let (mut soup, _) = taken_apart(&sphere);
        assert!(!is_shattered(&sphere) && is_shattered(&soup));
        assert_eq!(mending_tolerance(&soup), Some(0.0));
        let mut rng = rng(2);
        soup.vertices.iter_mut().for_each(|x| *x += 1e-7 * random_vector(&mut rng));
        let tolerance = mending_tolerance(&soup).unwrap();
        assert!((1e-7..1e-5).contains(&tolerance), "{tolerance}");
        assert_eq!(
            Weld::within(&soup, tolerance).unwrap().mesh.vertices.len(),
            sphere.vertices.len()
        );
        // Two triangles far apart are two triangles.
        assert!(!is_shattered(&disjoint([shape("grid:1x1"), shape("grid:1x1")])));
        let mut far = taken_apart(&sphere).0;
        for (j, x) in far.vertices.iter_mut().enumerate() {
            x.x += 10.0 * (j / 3) as f64;
        }
        assert!(is_shattered(&far) && mending_tolerance(&far).is_none());
    }
}
