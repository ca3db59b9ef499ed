//! The boundaries between cells as polylines, and their file format: OBJ with `l` elements.

use std::io::{self, Write};

use nalgebra::Point3;

use super::cells::{Cells, SEVERAL};
use super::face::Side;
use crate::mesh::Incidence;

/// The contour.
#[derive(Clone, Debug, PartialEq)]
pub struct Contours {
    /// The points of all polylines, each once.
    pub points: Vec<Point3<f64>>,
    /// By ascending pairs of regions.
    pub polylines: Vec<Polyline>,
}

/// A part of the contour between two regions. It is closed, or ends at the boundary of the mesh or where other parts
/// meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// The regions on both sides, ascending.
    pub regions: [usize; 2],
    /// Indices into the points; the first is also the last if it is closed.
    pub points: Vec<u32>,
    /// In units of the mesh.
    pub length: f64,
}

impl Polyline {
    /// Whether it is a loop.
    pub fn is_closed(&self) -> bool {
        self.points.first() == self.points.last()
    }
}

/// An edge between two cells.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Segment {
    /// Ascending.
    pub regions: [u8; 2],
    /// The indices of its points.
    pub ends: [u32; 2],
}

impl Contours {
    /// Segments joined to polylines; `point` has `count` points.
    pub(super) fn of_segments(
        mut segments: Vec<Segment>,
        count: usize,
        point: impl Fn(u32) -> Point3<f64>,
    ) -> Self {
        segments.sort_unstable_by_key(|segment| segment.regions);
        let (points, polylines) = joined(&segments, count);
        let points: Vec<Point3<f64>> = points.into_iter().map(point).collect();
        let mut contours = Contours { points, polylines };
        for polyline in &mut contours.polylines {
            let x = |&i: &u32| contours.points[i as usize];
            polyline.length =
                polyline.points.windows(2).map(|ends| (x(&ends[1]) - x(&ends[0])).norm()).sum();
        }
        contours
    }
}

impl Cells<'_> {
    /// The boundaries between the cells.
    pub fn contours(&self) -> Contours {
        let count = self.mesh.vertices.len() + self.points.len();
        Contours::of_segments(self.segments(), count, |id| self.point(id))
    }

    fn segments(&self) -> Vec<Segment> {
        let mut segments = Vec::new();
        for face in &self.divided {
            for cell in &face.cells {
                for (i, &(n, side)) in cell.corners.iter().enumerate() {
                    let to = cell.corners[(i + 1) % cell.corners.len()].0;
                    let ends = [n, to].map(|n| face.nodes[n].id);
                    if let Side::Region(r) = side
                        && cell.region < r
                        && ends[0] != ends[1]
                    {
                        segments.push(Segment { regions: [cell.region as u8, r as u8], ends });
                    }
                }
            }
        }
        self.add_ties(&mut segments);
        segments
    }

    /// Adds the parts of edges with different cells on both sides, along which these regions tie.
    fn add_ties(&self, segments: &mut Vec<Segment>) {
        // Parts of edges, with the region of a face there.
        let mut parts: Vec<([u32; 2], u8)> = Vec::new();
        let mut add = |a: u32, b: u32, p: u8| parts.push(([a.min(b), a.max(b)], p));
        let tie = |a: u32, b: u32| {
            (self.largest[a as usize] & self.largest[b as usize]).count_ones() >= 2
        };
        for (face, &p) in self.mesh.faces.iter().zip(&self.whole).filter(|&(_, &p)| p != SEVERAL) {
            for i in 0..3 {
                let (a, b) = (face[i], face[(i + 1) % 3]);
                if tie(a, b) {
                    add(a, b, p);
                }
            }
        }
        let count = self.mesh.vertices.len();
        for face in &self.divided {
            for cell in &face.cells {
                for (i, &(n, side)) in cell.corners.iter().enumerate() {
                    let to = cell.corners[(i + 1) % cell.corners.len()].0;
                    let [a, b] = [n, to].map(|n| face.nodes[n].id);
                    let is_whole = (a as usize) < count && (b as usize) < count;
                    if matches!(side, Side::Border(_)) && (!is_whole || tie(a, b)) {
                        add(a, b, cell.region as u8);
                    }
                }
            }
        }
        parts.sort_unstable();
        parts.dedup();
        for same_edge in parts.chunk_by(|(a, _), (b, _)| a == b) {
            for (i, &(ends, p)) in same_edge.iter().enumerate() {
                let others = same_edge[i + 1..].iter();
                segments.extend(others.map(|&(_, r)| Segment { regions: [p, r], ends }));
            }
        }
    }
}

/// The nodes of the segments, and the segments joined at nodes where just two of them meet, of the same regions.
fn joined(segments: &[Segment], count: usize) -> (Vec<u32>, Vec<Polyline>) {
    let mut index = vec![u32::MAX; count];
    let mut nodes = Vec::new();
    let ends: Vec<[u32; 2]> = segments
        .iter()
        .map(|segment| {
            segment.ends.map(|id| {
                let known = &mut index[id as usize];
                if *known == u32::MAX {
                    *known = nodes.len() as u32;
                    nodes.push(id);
                }
                *known
            })
        })
        .collect();
    let at = Incidence::in_ranges(&[0, nodes.len()], &ends, |i, _| i as u32);
    // The segment after segment i in a polyline through a node.
    let next = |i: usize, node: u32| match *at.at(node as usize) {
        [a, b] if segments[a as usize].regions == segments[b as usize].regions => {
            Some((if a as usize == i { b } else { a }) as usize)
        }
        _ => None,
    };
    let mut used = vec![false; segments.len()];
    let follow = |used: &mut [bool], first: usize, from: u32| {
        let (mut i, mut points) = (first, vec![from]);
        loop {
            used[i] = true;
            let [a, b] = ends[i];
            let node = if points.last() == Some(&a) { b } else { a };
            points.push(node);
            match next(i, node) {
                Some(after) if !used[after] => i = after,
                _ => break,
            }
        }
        Polyline { regions: segments[first].regions.map(usize::from), points, length: 0.0 }
    };
    let mut polylines = Vec::new();
    // Paths first, so that the rest are loops.
    for (i, ends) in ends.iter().enumerate() {
        for &end in ends {
            if !used[i] && next(i, end).is_none() {
                polylines.push(follow(&mut used, i, end));
            }
        }
    }
    for (i, &[a, _]) in ends.iter().enumerate() {
        if !used[i] {
            polylines.push(follow(&mut used, i, a));
        }
    }
    polylines.sort_by_key(|polyline| polyline.regions);
    (nodes, polylines)
}

impl Contours {
    /// The length of all polylines.
    pub fn length(&self) -> f64 {
        // An empty sum is -0.
        self.polylines.iter().fold(0.0, |sum, polyline| sum + polyline.length)
    }

    /// Writes OBJ: the points as `v`, and for each pair of regions a group of polylines as `l`, each with its length in a
    /// comment. Numbers have the fewest digits that are read back to the same bits.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "# polylines between regions; total length {}", self.length())?;
        for x in &self.points {
            writeln!(out, "v {} {} {}", x.x, x.y, x.z)?;
        }
        for pair in self.polylines.chunk_by(|a, b| a.regions == b.regions) {
            let [p, r] = pair[0].regions;
            let length: f64 = pair.iter().map(|polyline| polyline.length).sum();
            writeln!(out, "g region-{p}-{r}\n# length {length}")?;
            for polyline in pair {
                let kind = if polyline.is_closed() { "closed" } else { "open" };
                writeln!(out, "# {kind}, length {}", polyline.length)?;
                write!(out, "l")?;
                for &i in &polyline.points {
                    write!(out, " {}", u64::from(i) + 1)?;
                }
                writeln!(out)?;
            }
        }
        Ok(())
    }
}
