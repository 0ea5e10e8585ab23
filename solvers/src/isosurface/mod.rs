//! Level lines and level surfaces of fields.
//!
//! Everywhere a node belongs to the inside if its value is below the level.

mod lines;
mod samples;
mod triangles;

pub use lines::{closed_contours, contour_lines};
pub use triangles::{Surface, surface, triangulate};

pub(crate) use lines::cut;
pub(crate) use samples::{Frame, Samples};
pub(crate) use triangles::{Visit, march};

/// A line through points of the plane, with the region `phi < level` on its left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polyline {
    /// Points `[x, y]` (length); a closed line does not repeat its first point.
    pub points: Vec<[f64; 2]>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
}

impl Polyline {
    /// Length of the line.
    pub fn length(&self) -> f64 {
        self.sides().map(|(p, q)| (q[0] - p[0]).hypot(q[1] - p[1])).sum()
    }

    /// Area enclosed (length^2): positive if the inside is `phi < level`, negative for a hole; 0 if open.
    pub fn area(&self) -> f64 {
        if !self.closed || self.points.is_empty() {
            return 0.0;
        }
        let o = self.points[0];
        let twice = |(p, q): ([f64; 2], [f64; 2])| {
            (p[0] - o[0]) * (q[1] - o[1]) - (q[0] - o[0]) * (p[1] - o[1])
        };
        0.5 * self.sides().map(twice).sum::<f64>()
    }

    /// Consecutive points, the last and the first included if the line is closed.
    pub fn sides(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
        let n = self.points.len();
        let count = if self.closed { n } else { n.saturating_sub(1) };
        (0..count).map(move |m| (self.points[m], self.points[(m + 1) % n]))
    }
}

/// What happens where the inside reaches the border of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Caps {
    /// The surface ends at the outermost nodes.
    #[default]
    Open,
    /// The surface is closed along the border, half a cell beyond the outermost nodes.
    Closed,
    /// The first nodes follow the last: the box is `[0, n h]` along each axis of n nodes, and
    /// the surface ends at its faces, so that copies side by side go on in one another.
    Periodic,
    /// The same box, with the surface closed along its faces.
    PeriodicClosed,
}
