//! What the owner of vertices and faces tells a part that holds them too, after every pass.

use std::ops::Range;

use super::lanes::Real;
use super::layout::Window;
use super::part::Part;

pub struct HaloMessage<T> {
    /// The number of the receiver.
    pub to: usize,
    /// Blocks that the sender owns and the receiver holds.
    vertices: Range<usize>,
    faces: Range<usize>,
    u: Vec<T>,
    kq: Vec<T>,
    q: Vec<T>,
}

impl<T: Real> HaloMessage<T> {
    /// All that are ever needed from the owner of one window to those of others.
    pub fn from(sender: usize, windows: &[Window]) -> Vec<Self> {
        let from = &windows[sender];
        let message = |(to, window): (usize, &Window)| {
            let vertices = common(&from.own, &window.vertices());
            let faces = common(&from.own_faces, &window.held_faces);
            let needed = to != sender && !(vertices.is_empty() && faces.is_empty());
            let (u, kq, q) = (Vec::new(), Vec::new(), Vec::new());
            needed.then_some(HaloMessage { to, vertices, faces, u, kq, q })
        };
        windows.iter().enumerate().filter_map(message).collect()
    }

    pub fn write(&mut self, from: &Part<T>) {
        let (vertices, faces) = (from.places(&self.vertices), from.face_places(&self.faces));
        let m = from.m;
        self.u.clear();
        self.u.extend_from_slice(&from.u()[vertices.start * m..vertices.end * m]);
        self.kq.clear();
        self.kq.extend_from_slice(&from.kq()[vertices.start * m..vertices.end * m]);
        self.q.clear();
        self.q.extend_from_slice(&from.q()[faces.start * 2 * m..faces.end * 2 * m]);
    }

    pub fn read(&self, to: &mut Part<T>) {
        let (vertices, faces) = (to.places(&self.vertices), to.face_places(&self.faces));
        let m = to.m;
        let (numbers, ..) = to.numbers();
        numbers.u[vertices.start * m..vertices.end * m].copy_from_slice(&self.u);
        numbers.kq[vertices.start * m..vertices.end * m].copy_from_slice(&self.kq);
        numbers.q[faces.start * 2 * m..faces.end * 2 * m].copy_from_slice(&self.q);
    }
}

fn common(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    a.start.max(b.start)..a.end.min(b.end)
}
