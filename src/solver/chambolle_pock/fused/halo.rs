//! Messages that the owner of vertices and faces sends after every pass to each part that holds them in its border.

use std::ops::Range;

use super::lanes::Real;
use super::layout::Window;
use super::part::Part;

pub struct HaloMessage<T> {
    /// The index of the receiver.
    pub to: usize,
    /// Blocks of vertices that the sender owns and the receiver holds.
    vertices: Range<usize>,
    /// Blocks of faces, likewise.
    faces: Range<usize>,
    u: Vec<T>,
    kq: Vec<T>,
    q: Vec<T>,
}

impl<T: Real> HaloMessage<T> {
    /// All messages that the owner of one window ever sends, still empty.
    pub fn from(sender: usize, windows: &[Window]) -> Vec<Self> {
        let from = &windows[sender];
        let message = |(to, window): (usize, &Window)| {
            let vertices = intersection(&from.own, &window.held_vertices());
            let faces = intersection(&from.own_faces, &window.held_faces);
            let needed = to != sender && !(vertices.is_empty() && faces.is_empty());
            let (u, kq, q) = (Vec::new(), Vec::new(), Vec::new());
            needed.then_some(HaloMessage { to, vertices, faces, u, kq, q })
        };
        windows.iter().enumerate().filter_map(message).collect()
    }

    pub fn write(&mut self, from: &Part<T>) {
        let (vertices, faces) = (from.vertex_slots(&self.vertices), from.face_slots(&self.faces));
        let m = from.m;
        self.u.clear();
        self.u.extend_from_slice(&from.u()[vertices.start * m..vertices.end * m]);
        self.kq.clear();
        self.kq.extend_from_slice(&from.kq()[vertices.start * m..vertices.end * m]);
        self.q.clear();
        self.q.extend_from_slice(&from.q()[faces.start * 2 * m..faces.end * 2 * m]);
    }

    pub fn read(&self, to: &mut Part<T>) {
        let (vertices, faces) = (to.vertex_slots(&self.vertices), to.face_slots(&self.faces));
        let m = to.m;
        let (arrays, ..) = to.arrays();
        arrays.u[vertices.start * m..vertices.end * m].copy_from_slice(&self.u);
        arrays.kq[vertices.start * m..vertices.end * m].copy_from_slice(&self.kq);
        arrays.q[faces.start * 2 * m..faces.end * 2 * m].copy_from_slice(&self.q);
    }
}

fn intersection(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    a.start.max(b.start)..a.end.min(b.end)
}
