//! The contour within the cells of a plane: arcs from edge to edge.

use super::Lattice;
use super::crossing::Crossing;
use super::elements::{Element, HALF_ANGLE};
use super::search::{Found, ROWS};
use super::subdivide::Block;

/// Cells whose end normals lean away from those of the arc by more than this (times the
/// arc's length in cells) are subdivided: the contour strays from the arc by at most an
/// eighth of that, .025 cell.
const LEAN: f64 = 0.2;

/// Half-length of an arc to a far node (cells): the sweeps may miss the nearest arc for
/// its neighbour, whose middle is up to about this far from the foot point.
const OVERLAP: f64 = 0.75;

/// Crossings and the field that they were found in.
pub(super) struct Cells<'a> {
    pub phi: &'a [f64],
    pub lattice: &'a Lattice,
    pub found: &'a [Found],
    pub table: &'a [u32],
}

/// An end of an arc: place within the cell and the crossing there.
type End<'a> = ([f64; 2], &'a Crossing);

/// Elements and the cells `[j, i]` of their first nodes.
pub(super) type Arcs = Vec<(Element, [u32; 2])>;

impl<'a> Cells<'a> {
    /// Adds the arcs in the cells whose first crossing lies in the rows of `task`.
    pub(super) fn build(&self, task: usize, arcs: &mut Arcs) {
        arcs.clear();
        let [_, ny, nx] = self.lattice.shape;
        for found in &self.found[task].crossings {
            let [j, i] = found.node.map(|c| c as usize);
            // Each cell is built at the first of its lower, left and right edge that crosses.
            if !found.upright {
                if self.lattice.next(j, ny).is_some() {
                    self.cell([j, i], arcs);
                }
            } else {
                if self.lattice.next(i, nx).is_some_and(|b| !self.crosses([j, i], [j, b])) {
                    self.cell([j, i], arcs);
                }
                let left = match i {
                    0 => self.lattice.periodic.then_some(nx - 1),
                    _ => Some(i - 1),
                };
                let up = self.lattice.next(j, ny);
                if let (Some(left), Some(up)) = (left, up)
                    && !self.crosses([j, left], [j, i])
                    && !self.crosses([j, left], [up, left])
                {
                    self.cell([j, left], arcs);
                }
            }
            self.border(found, arcs);
        }
    }

    fn at(&self, [j, i]: [usize; 2]) -> f64 {
        self.phi[j * self.lattice.shape[2] + i]
    }

    fn crosses(&self, a: [usize; 2], b: [usize; 2]) -> bool {
        (self.at(a) < 0.0) != (self.at(b) < 0.0)
    }

    fn crossing(&self, [j, i]: [usize; 2], upright: bool) -> &'a Crossing {
        let entry = 2 * (j * self.lattice.shape[2] + i) + usize::from(upright);
        &self.found[j / ROWS].crossings[self.table[entry] as usize]
    }

    /// Arcs in the cell whose first node is `[j, i]`.
    fn cell(&self, [j, i]: [usize; 2], arcs: &mut Arcs) {
        let [_, ny, nx] = self.lattice.shape;
        let (Some(up), Some(right)) = (self.lattice.next(j, ny), self.lattice.next(i, nx)) else {
            return;
        };
        // Counter-clockwise from the first node.
        let corners = [[j, i], [j, right], [up, right], [up, i]].map(|node| self.at(node));
        let inside = corners.map(|v| v < 0.0);
        // Lower, right, upper and left edge.
        let edges: [Option<End>; 4] = std::array::from_fn(|m| {
            (inside[m] != inside[(m + 1) % 4]).then(|| {
                let (node, upright) =
                    [([j, i], false), ([j, right], true), ([up, i], false), ([j, i], true)][m];
                let crossing = self.crossing(node, upright);
                let r = crossing.r;
                ([[r, 0.0], [1.0, r], [r, 1.0], [0.0, r]][m], crossing)
            })
        });
        let mut ends = edges.iter().flatten();
        let (Some(&a), Some(&b), None) = (ends.next(), ends.next(), ends.next()) else {
            if let [Some(lower), Some(right), Some(upper), Some(left)] = edges {
                self.saddle([j, i], corners, [lower, right, upper, left], arcs);
            }
            return;
        };
        let block = Block { phi: self.phi, lattice: self.lattice, cell: [j, i] };
        match arc(a, b) {
            Some(arc) if !block.bulges(corners) => {
                arcs.push(placed(arc.overlapping(OVERLAP), [j, i]))
            }
            _ if block.add(arcs, 0) => {}
            _ => arcs.push(placed(Element::arc(a.0, b.0, 0.0, a.1.normal), [j, i])),
        }
    }

    /// A cell with crossings on all edges.
    fn saddle(&self, cell: [usize; 2], corners: [f64; 4], edges: [End; 4], arcs: &mut Arcs) {
        let block = Block { phi: self.phi, lattice: self.lattice, cell };
        if block.add(arcs, 0) {
            return;
        }
        let [lower, right, upper, left] = edges;
        let pairs = match joined(corners) {
            true => [(lower, right), (upper, left)],
            false => [(lower, left), (right, upper)],
        };
        for (a, b) in pairs {
            arcs.push(placed(Element::arc(a.0, b.0, 0.0, a.1.normal), cell));
        }
    }

    /// Continues an arc that ends on the outermost nodes to the border, half a cell farther.
    fn border(&self, end: &Crossing, arcs: &mut Arcs) {
        let [_, ny, nx] = self.lattice.shape;
        let [j, i] = end.node.map(|c| c as usize);
        let (c, n) = if end.upright { (i, nx) } else { (j, ny) };
        if self.lattice.periodic || (c > 0 && c + 1 < n) {
            return;
        }
        let outwards = if c == 0 { -1.0 } else { 1.0 };
        let axis = usize::from(!end.upright);
        let mut a = [0.0; 2];
        a[1 - axis] = end.r;
        let mut tangent = [0.0; 2];
        tangent[axis] = outwards;
        let mut curvature = 0.0;
        if end.smooth {
            let [x, y] = end.normal;
            tangent = if outwards * [-y, x][axis] < 0.0 { [y, -x] } else { [-y, x] };
            curvature = end.curvature;
        }
        // A contour almost along the border is not followed all the way.
        let s = (0.5 / tangent[axis].abs()).min(1.0);
        if (curvature * s).abs() > HALF_ANGLE {
            curvature = 0.0;
        }
        let bend = 0.5 * curvature * s * s;
        let b = std::array::from_fn(|m| a[m] + s * tangent[m] - bend * end.normal[m]);
        arcs.push(placed(Element::arc(a, b, curvature, end.normal), [j, i]));
    }
}

/// Whether the negative corners of a cell with four crossings are joined through its
/// middle: the sign of the bilinear interpolant at its saddle.
pub(super) fn joined(f: [f64; 4]) -> bool {
    // Corners 0 and 2 have one sign, 1 and 3 the other.
    let sum = (f[0] + f[2]) - (f[1] + f[3]);
    let middle = (f[0] * f[2] - f[1] * f[3]) / sum;
    (middle < 0.0) == (f[0] < 0.0)
}

/// The arc between two smooth ends, if it leaves them along their tangents.
fn arc(a: End, b: End) -> Option<Element> {
    if !(a.1.smooth && b.1.smooth) {
        return None;
    }
    let chord = [b.0[0] - a.0[0], b.0[1] - a.0[1]];
    let curvature = 0.5 * (a.1.curvature + b.1.curvature);
    // Along the chord the normal of an arc goes from -k L / 2 to k L / 2.
    let turn = 0.5 * curvature * (chord[0] * chord[0] + chord[1] * chord[1]);
    let lean = |n: [f64; 2]| n[0] * chord[0] + n[1] * chord[1];
    let (first, last) = (lean(a.1.normal) + turn, lean(b.1.normal) - turn);
    let towards = [a.1.normal[0] + b.1.normal[0], a.1.normal[1] + b.1.normal[1]];
    let same = a.1.normal[0] * b.1.normal[0] + a.1.normal[1] * b.1.normal[1] > 0.0;
    let length = (chord[0] * chord[0] + chord[1] * chord[1]).sqrt();
    let fits = first.abs() <= LEAN && last.abs() <= LEAN;
    (fits && same && 0.5 * curvature.abs() * length <= HALF_ANGLE)
        .then(|| Element::arc(a.0, b.0, curvature, towards).between([a.1.normal, b.1.normal]))
}

/// Moves an element from a cell's corner to its place in the plane.
pub(super) fn placed(mut element: Element, [j, i]: [usize; 2]) -> (Element, [u32; 2]) {
    element.point[0] += i as f64;
    element.point[1] += j as f64;
    (element, [j as u32, i as u32])
}
