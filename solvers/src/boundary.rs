//! What stands beyond the border of a grid.

use serde::{Deserialize, Serialize};

/// Values beyond the border of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// Mirror at the cell faces of the border, zero flux: `u[-1] = u[0]`, `u[-2] = u[1]`.
    #[default]
    Neumann,
    /// The grid repeats itself: `u[-1] = u[n-1]`.
    Periodic,
    /// Linear continuation: `u[-1] = 2 u[0] - u[1]`.
    Extrapolate,
}

impl Boundary {
    /// The node inside `0..n` that stands for node `i`, which may lie up to `n`
    /// beyond either end; [`Boundary::Extrapolate`] answers with the nearest node.
    pub fn wrap(self, i: isize, n: usize) -> usize {
        let m = n as isize;
        let inside = match self {
            _ if (0..m).contains(&i) => i,
            Self::Neumann if i < 0 => -1 - i,
            Self::Neumann => 2 * m - 1 - i,
            Self::Periodic => i.rem_euclid(m),
            Self::Extrapolate => i,
        };
        inside.clamp(0, m - 1) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::Boundary::{Extrapolate, Neumann, Periodic};

    #[test]
    fn ghost_nodes() {
        assert_eq!([-2, -1, 0, 4, 5, 6].map(|i| Neumann.wrap(i, 5)), [1, 0, 0, 4, 4, 3]);
        assert_eq!([-2, -1, 0, 4, 5, 6].map(|i| Periodic.wrap(i, 5)), [3, 4, 0, 4, 0, 1]);
        assert_eq!([-2, -1, 0, 4, 5, 6].map(|i| Extrapolate.wrap(i, 5)), [0, 0, 0, 4, 4, 4]);
    }
}
