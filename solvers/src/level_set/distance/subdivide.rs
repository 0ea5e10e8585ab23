//! Cells in which the contour bends too much for one arc.

use super::Lattice;
use super::cells::{Arcs, joined, placed};
use super::crossing::{dot, lagrange, smooth};
use super::elements::Element;

/// Parts of a cell along each axis: chords of a circle of radius half a cell, the sharpest
/// bend between nodes, then stray by 2 (1.4 / 4)^2 / 8 = .03 cell at most.
const PARTS: usize = 4;

/// A bulge of the contour into a cell without any other crossing is followed so far.
const DEPTH: usize = 3;

/// A cell and the 4 x 4 nodes around it, whose bicubic interpolant it is subdivided by.
pub(super) struct Block<'a> {
    pub phi: &'a [f64],
    pub lattice: &'a Lattice,
    /// First node `[j, i]`.
    pub cell: [usize; 2],
}

/// The four values along a lower, right, upper or left edge.
type Lines = [[f64; 4]; 4];

impl Block<'_> {
    fn value(&self, dj: isize, di: isize) -> f64 {
        let [j, i] = self.cell.map(|c| c as isize);
        let [_, ny, nx] = self.lattice.shape.map(|n| n as isize);
        if j > 0 && i > 0 && j + 2 < ny && i + 2 < nx {
            return self.phi[((j + dj) * nx + i + di) as usize];
        }
        self.lattice.value(self.phi, [0, j + dj, i + di])
    }

    fn edges(&self) -> Lines {
        let along = |row: isize| std::array::from_fn(|m| self.value(row, m as isize - 1));
        let up = |column: isize| std::array::from_fn(|m| self.value(m as isize - 1, column));
        [along(0), up(1), along(1), up(0)]
    }

    /// Whether the contour crosses twice an edge whose ends have one sign.
    pub(super) fn bulges(&self, corners: [f64; 4]) -> bool {
        // Second differences that could pull an edge over 0 exceed 8 of the smaller end.
        let [a, b, c, d] = corners.map(f64::abs);
        let near = a.min(b).min(c).min(d);
        let steep = (corners[0] - corners[2]).abs().max((corners[1] - corners[3]).abs());
        near < 0.5 * steep && self.edges().iter().any(|&f| bulge(f))
    }

    /// Adds the contour of the bicubic interpolant in straight pieces; nothing if the
    /// values are not smooth enough for one.
    pub(super) fn add(&self, arcs: &mut Arcs, depth: usize) -> bool {
        let edges = self.edges();
        if !edges.iter().all(smooth) {
            return false;
        }
        self.march(arcs);
        if depth < DEPTH {
            let steps = [(-1, 0), (0, 1), (1, 0), (0, -1)];
            for ((dj, di), f) in steps.into_iter().zip(edges) {
                if bulge(f)
                    && let Some(cell) = self.beside(dj, di)
                {
                    let block = Block { cell, ..*self };
                    // A cell with crossings is built by itself.
                    let signs =
                        [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(j, i)| block.value(j, i) < 0.0);
                    if signs == [signs[0]; 4] {
                        block.add(arcs, depth + 1);
                    }
                }
            }
        }
        true
    }

    /// The cell at a step, if there is one.
    fn beside(&self, dj: isize, di: isize) -> Option<[usize; 2]> {
        let [_, ny, nx] = self.lattice.shape;
        let step = |c: usize, d: isize, n: usize| {
            let to = c as isize + d;
            if self.lattice.periodic {
                Some(to.rem_euclid(n as isize) as usize)
            } else {
                (to >= 0 && to + 1 < n as isize).then_some(to as usize)
            }
        };
        Some([step(self.cell[0], dj, ny)?, step(self.cell[1], di, nx)?])
    }

    /// Marching squares on the parts of the cell.
    fn march(&self, arcs: &mut Arcs) {
        let weights: [[f64; 4]; PARTS + 1] =
            std::array::from_fn(|m| lagrange(m as f64 / PARTS as f64)[0]);
        let rows: [[f64; 4]; 4] = std::array::from_fn(|m| {
            std::array::from_fn(|n| self.value(m as isize - 1, n as isize - 1))
        });
        let columns: [[f64; 4]; PARTS + 1] =
            std::array::from_fn(|p| std::array::from_fn(|m| dot(&weights[p], &rows[m])));
        let values: [[f64; PARTS + 1]; PARTS + 1] =
            std::array::from_fn(|q| std::array::from_fn(|p| dot(&weights[q], &columns[p])));
        let h = 1.0 / PARTS as f64;
        for (q, p) in (0..PARTS * PARTS).map(|m| (m / PARTS, m % PARTS)) {
            let f = [values[q][p], values[q][p + 1], values[q + 1][p + 1], values[q + 1][p]];
            let mut add = |a: usize, b: usize| {
                let end = |m: usize| {
                    let r = f[m] / (f[m] - f[(m + 1) % 4]);
                    let [x, y] = [[r, 0.0], [1.0, r], [1.0 - r, 1.0], [0.0, 1.0 - r]][m];
                    [h * (p as f64 + x), h * (q as f64 + y)]
                };
                arcs.push(placed(Element::arc(end(a), end(b), 0.0, [0.0; 2]), self.cell));
            };
            let crossed: [bool; 4] =
                std::array::from_fn(|m| (f[m] < 0.0) != (f[(m + 1) % 4] < 0.0));
            let mut ends = (0..4).filter(|&m| crossed[m]);
            match (ends.next(), ends.next(), ends.next()) {
                (Some(a), Some(b), None) => add(a, b),
                (Some(_), Some(_), Some(_)) => {
                    let pairs = if joined(f) { [(0, 1), (2, 3)] } else { [(0, 3), (1, 2)] };
                    pairs.into_iter().for_each(|(a, b)| add(a, b));
                }
                _ => {}
            }
        }
    }
}

/// Whether the parabola between the middle two values, of one sign, has both signs.
fn bulge(f: [f64; 4]) -> bool {
    let f = if f[1] < 0.0 { f.map(|v| -v) } else { f };
    let (slope, second) = (f[2] - f[1], 0.5 * (f[0] - f[1] - f[2] + f[3]));
    // Its least value f1 - (slope - second / 2)^2 / (2 second) lies at 1/2 - slope / second.
    let fall = slope - 0.5 * second;
    f[2] >= 0.0 && second > 2.0 * slope.abs() && fall * fall > 2.0 * second * f[1]
}
