//! A field with what lies around its nodes, as samples at the corners of boxes.

use crate::{Boundary, Field};

/// What is added around the nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Frame {
    /// Nothing.
    Nodes,
    /// The border faces half a cell out, by mirroring.
    Faces,
    /// The faces, and a layer of outside just beyond them.
    Capped,
    /// The first node again after the last.
    Wrapped,
}

impl Frame {
    /// The frame whose boxes fill the domain exactly once.
    pub(crate) fn whole_domain(boundary: Boundary) -> Self {
        match boundary {
            Boundary::Periodic => Self::Wrapped,
            Boundary::Neumann | Boundary::Extrapolate => Self::Faces,
        }
    }

    /// Samples before and after the nodes of an axis.
    fn padding(self) -> [usize; 2] {
        match self {
            Self::Nodes => [0, 0],
            Self::Faces => [1, 1],
            Self::Capped => [2, 2],
            Self::Wrapped => [0, 1],
        }
    }
}

/// Values minus the level on a rectilinear lattice, row-major `[nz, ny, nx]`.
pub(crate) struct Samples {
    pub shape: [usize; 3],
    pub values: Vec<f64>,
    /// Positions along z, y, x (length).
    pub coordinates: [Vec<f64>; 3],
}

impl Samples {
    /// `skin` (cells) is how far the outside layer of [`Frame::Capped`] stands off the faces.
    pub(crate) fn new(field: &Field, level: f64, frame: Frame, skin: f64) -> Self {
        let grid = field.grid();
        let h = grid.spacing();
        let first = 3 - grid.dim();
        let full = grid.shape();
        // For each sample of an axis: its node, none outside, and its position.
        let axes: [Vec<(Option<usize>, f64)>; 3] = std::array::from_fn(|axis| {
            let n = full[axis];
            let [before, after] = if axis < first { [0, 0] } else { frame.padding() };
            (-(before as isize)..(n + after) as isize)
                .map(|i| {
                    let node = match frame {
                        Frame::Wrapped => Some(i as usize % n),
                        Frame::Capped if i < -1 || i > n as isize => None,
                        _ => Some(i.clamp(0, n as isize - 1) as usize),
                    };
                    let edge = if node.is_none() { 0.5 + skin } else { 0.5 };
                    let x = match frame {
                        Frame::Wrapped => i as f64,
                        _ => (i as f64).clamp(-edge, n as f64 - 1.0 + edge),
                    };
                    (node, x * h)
                })
                .collect()
        });
        let shape = [0, 1, 2].map(|a| axes[a].len());
        let mut values = Vec::with_capacity(shape.iter().product());
        let nodes = field.as_slice();
        for (k, _) in &axes[0] {
            for (j, _) in &axes[1] {
                let (Some(k), Some(j)) = (*k, *j) else {
                    values.extend(std::iter::repeat_n(f64::INFINITY, shape[2]));
                    continue;
                };
                let row = &nodes[grid.index(k, j, 0)..][..full[2]];
                values.extend(
                    axes[2].iter().map(|(i, _)| i.map_or(f64::INFINITY, |i| row[i] - level)),
                );
            }
        }
        let coordinates = axes.map(|axis| axis.into_iter().map(|(_, x)| x).collect());
        Self { shape, values, coordinates }
    }
}

/// Fraction of the way from `a` to `b` at which a linear function is 0; halfway to an outside sample.
pub(crate) fn fraction(a: f64, b: f64) -> f64 {
    if a.is_infinite() || b.is_infinite() { 0.5 } else { a / (a - b) }
}
