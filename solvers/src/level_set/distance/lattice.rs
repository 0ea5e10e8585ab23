//! A grid in the form that the inner loops of a signed distance want.

use crate::{Boundary, Grid};

/// Shape, strides and continuation of a grid.
pub(super) struct Lattice {
    pub shape: [usize; 3],
    pub strides: [usize; 3],
    pub periodic: bool,
    /// Periods along x, y, z (cells), infinite along axes without one.
    pub period: [f32; 3],
}

impl Lattice {
    pub(super) fn new(grid: Grid, boundary: Boundary) -> Self {
        let [nz, ny, nx] = grid.shape();
        let periodic = boundary == Boundary::Periodic;
        let period = [nx, ny, nz].map(|n| if periodic { n as f32 } else { f32::INFINITY });
        Self { shape: grid.shape(), strides: grid.strides(), periodic, period }
    }

    /// Farther than any two nodes are apart (cells).
    pub(super) fn diagonal(&self) -> f64 {
        self.shape.iter().filter(|&&n| n > 1).map(|&n| (n * n) as f64).sum::<f64>().sqrt()
    }

    pub(super) fn rows(&self) -> usize {
        self.shape[0] * self.shape[1]
    }

    /// Whether the contour consists of lines: both x and y have several nodes, z has one.
    pub(super) fn plane(&self) -> bool {
        self.shape[0] == 1 && self.shape[1] > 1 && self.shape[2] > 1
    }

    /// The node after `c` on an axis of `n`, if there is one.
    #[inline(always)]
    pub(super) fn next(&self, c: usize, n: usize) -> Option<usize> {
        if c + 1 < n { Some(c + 1) } else { (self.periodic && n > 1).then_some(0) }
    }

    /// The nodes `[k, j, i]` around the cell of a plane whose first node is `[j, i]`.
    pub(super) fn corners(&self, [j, i]: [u32; 2]) -> [[u32; 3]; 4] {
        let [_, ny, nx] = self.shape;
        let up = self.next(j as usize, ny).map_or(j, |c| c as u32);
        let right = self.next(i as usize, nx).map_or(i, |c| c as u32);
        [[0, j, i], [0, j, right], [0, up, i], [0, up, right]]
    }

    /// phi at a node at most one beyond the border, where it goes on as a parabola:
    /// also a field with mirrors at the border's cell faces is smooth up to the border,
    /// while its mirror image would falsify the derivatives of one without.
    pub(super) fn value(&self, phi: &[f64], node: [isize; 3]) -> f64 {
        let mut index = 0;
        for axis in 0..3 {
            let (n, c) = (self.shape[axis] as isize, node[axis]);
            if (0..n).contains(&c) || self.periodic || n == 1 {
                index += c.rem_euclid(n) as usize * self.strides[axis];
                continue;
            }
            let (border, inwards) = if c < 0 { (0, 1) } else { (n - 1, -1) };
            let at = |m: isize| {
                let mut node = node;
                node[axis] = border + m * inwards;
                self.value(phi, node)
            };
            return match n {
                2 => 2.0 * at(0) - at(1),
                _ => 3.0 * (at(0) - at(1)) + at(2),
            };
        }
        phi[index]
    }

    /// Four values along an axis of `n` nodes around the edge from `c`: a parabola that
    /// continues beyond the border is replaced by a line if it bends too much to be trusted.
    pub(super) fn limited(&self, mut f: [f64; 4], c: usize, n: usize) -> [f64; 4] {
        let slope = 0.5 * (f[2] - f[1]).abs();
        if !self.periodic && c == 0 && (f[0] - 2.0 * f[1] + f[2]).abs() > slope {
            f[0] = 2.0 * f[1] - f[2];
        }
        if !self.periodic && c + 2 == n && (f[1] - 2.0 * f[2] + f[3]).abs() > slope {
            f[3] = 2.0 * f[2] - f[1];
        }
        f
    }
}
