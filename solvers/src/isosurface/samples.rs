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
    /// The same, and a layer of outside just beyond.
    WrappedCapped,
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
            Self::WrappedCapped => [1, 2],
        }
    }
}

/// How far outside the layer is where the face is inside, as part of how far that is inside.
const FAINT: f64 = 1e-4;

/// Values minus the level on a rectilinear lattice, row-major `[nz, ny, nx]`.
pub(crate) struct Samples {
    pub shape: [usize; 3],
    pub values: Vec<f64>,
    /// Positions along z, y, x (length).
    pub coordinates: [Vec<f64>; 3],
}

impl Samples {
    /// `skin` (cells) is how far the layer of outside stands off the faces.
    ///
    /// In a layer without thickness samples are infinite. In one that has some they repeat the
    /// face's, what is inside being a little outside: so that oblique edges are cut where the
    /// face is, and caps end where the surface does.
    pub(crate) fn new(field: &Field, level: f64, frame: Frame, skin: f64) -> Self {
        let grid = field.grid();
        let h = grid.spacing();
        let first = 3 - grid.dim();
        let full = grid.shape();
        // For each sample of an axis: its node, whether it is outside, and its position.
        let axes: [Vec<(usize, bool, f64)>; 3] = std::array::from_fn(|axis| {
            let n = full[axis];
            let [before, after] = if axis < first { [0, 0] } else { frame.padding() };
            (-(before as isize)..(n + after) as isize)
                .map(|i| {
                    let last = n as isize - 1;
                    let wrapped = matches!(frame, Frame::Wrapped | Frame::WrappedCapped);
                    let node = if wrapped { i.rem_euclid(last + 1) } else { i.clamp(0, last) };
                    // The faces, as far beyond the nodes.
                    let [low, high] =
                        if wrapped { [0.0, n as f64] } else { [-0.5, n as f64 - 0.5] };
                    let outside = match frame {
                        Frame::Capped => i < -1 || i > n as isize,
                        Frame::WrappedCapped => i < 0 || i > n as isize,
                        _ => false,
                    };
                    let skin = if outside { skin } else { 0.0 };
                    let x = (i as f64).clamp(low - skin, high + skin);
                    // A sample beyond a face repeats the face's.
                    let node = match frame {
                        Frame::WrappedCapped if outside => 0,
                        _ => node as usize,
                    };
                    (node, outside, x * h)
                })
                .collect()
        });
        let shape = [0, 1, 2].map(|a| axes[a].len());
        let mut values = Vec::with_capacity(shape.iter().product());
        let nodes = field.as_slice();
        let beyond = |v: f64| match v {
            _ if skin == 0.0 => f64::INFINITY,
            _ if v < 0.0 => -FAINT * v,
            _ => v,
        };
        for &(k, above, _) in &axes[0] {
            for &(j, behind, _) in &axes[1] {
                let row = &nodes[grid.index(k, j, 0)..][..full[2]];
                values.extend(axes[2].iter().map(|&(i, beside, _)| {
                    let v = row[i] - level;
                    if above || behind || beside { beyond(v) } else { v }
                }));
            }
        }
        let coordinates = axes.map(|axis| axis.into_iter().map(|(_, _, x)| x).collect());
        Self { shape, values, coordinates }
    }
}

/// Fraction of the way from `a` to `b` at which a linear function is 0; halfway to an outside sample.
pub(crate) fn fraction(a: f64, b: f64) -> f64 {
    if a.is_infinite() || b.is_infinite() { 0.5 } else { a / (a - b) }
}
