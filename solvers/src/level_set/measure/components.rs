//! Connected components and Euler numbers of masks, by union-find.

use crate::{Boundary, Error, Grid, Result};

/// Components of a mask.
#[derive(Clone, Debug, PartialEq)]
pub struct Components {
    /// Label of each node: 0 where the mask is false, else 1, 2, ... in the order of first nodes.
    pub labels: Vec<u32>,
    /// Number of nodes of labels 1, 2, ...
    pub sizes: Vec<usize>,
}

/// Labels the components of `mask`: nodes joined through faces (4 neighbours in the plane, 6 in space).
///
/// Linear time. [`Boundary::Periodic`] joins opposite borders.
///
/// # Errors
/// If `mask` has not one entry for each node of `grid` (row-major).
pub fn label_components(mask: &[bool], grid: Grid, boundary: Boundary) -> Result<Components> {
    if mask.len() != grid.len() {
        return Err(Error::Shape {
            name: "mask".into(),
            actual: vec![mask.len()],
            expected: grid.axes().to_vec(),
        });
    }
    Ok(label(mask, grid, boundary, false))
}

/// As [`label_components`]; `corners` joins nodes through edges and corners too.
pub(super) fn label(mask: &[bool], grid: Grid, boundary: Boundary, corners: bool) -> Components {
    let steps = steps(grid, corners);
    // Parent of each node; roots are the first nodes of their components.
    let mut parent: Vec<u32> = (0..mask.len() as u32).collect();
    for n in (0..mask.len()).filter(|&n| mask[n]) {
        for &step in &steps {
            if let Some(other) = neighbour(grid, boundary, n, step)
                && mask[other]
            {
                let (a, b) = (find(&mut parent, n as u32), find(&mut parent, other as u32));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut labels = vec![0; mask.len()];
    let mut sizes = Vec::new();
    for n in (0..mask.len()).filter(|&n| mask[n]) {
        let root = find(&mut parent, n as u32) as usize;
        if root == n {
            sizes.push(0);
            labels[n] = sizes.len() as u32;
        }
        labels[n] = labels[root];
        sizes[labels[n] as usize - 1] += 1;
    }
    Components { labels, sizes }
}

fn find(parent: &mut [u32], mut n: u32) -> u32 {
    while parent[n as usize] != n {
        parent[n as usize] = parent[parent[n as usize] as usize];
        n = parent[n as usize];
    }
    n
}

/// Steps (z, y, x) to half of the neighbours: those before a node.
fn steps(grid: Grid, corners: bool) -> Vec<[isize; 3]> {
    let shape = grid.shape();
    let mut steps = Vec::new();
    for code in 0..13 {
        let step: [isize; 3] = [code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1];
        let faces = step.iter().filter(|&&s| s != 0).count() == 1;
        let possible = (0..3).all(|a| step[a] == 0 || shape[a] > 1);
        if possible && (faces || corners) {
            steps.push(step);
        }
    }
    steps
}

/// The node one step away, if there is one.
fn neighbour(grid: Grid, boundary: Boundary, n: usize, step: [isize; 3]) -> Option<usize> {
    let shape = grid.shape();
    let node = grid.node(n);
    let mut other = [0; 3];
    for a in 0..3 {
        let (c, m) = (node[a] as isize + step[a], shape[a] as isize);
        if boundary != Boundary::Periodic && !(0..m).contains(&c) {
            return None;
        }
        other[a] = c.rem_euclid(m) as usize;
    }
    Some(grid.index(other[0], other[1], other[2]))
}

/// Euler number of the complex of inside nodes, the edges, squares and cubes between them.
pub(super) fn euler_number(mask: &[bool], grid: Grid, boundary: Boundary) -> i64 {
    let shape = grid.shape();
    let mut sum = 0;
    // Bits of a cell: whether it extends along z, y, x.
    for cell in 0..8_usize {
        let extends = [cell >> 2 & 1, cell >> 1 & 1, cell & 1];
        if (0..3).any(|a| extends[a] == 1 && shape[a] == 1) {
            continue;
        }
        let corners: Vec<[isize; 3]> = (0..8_usize)
            .filter(|corner| corner & !cell == 0)
            .map(|corner| [4, 2, 1].map(|bit| isize::from(corner & bit != 0)))
            .collect();
        let full = |n: &usize| {
            mask[*n]
                && corners
                    .iter()
                    .all(|&c| neighbour(grid, boundary, *n, c).is_some_and(|m| mask[m]))
        };
        let count = (0..mask.len()).filter(full).count() as i64;
        sum += if cell.count_ones() % 2 == 0 { count } else { -count };
    }
    sum
}

/// Components of the outside, joined through corners too, that do not reach the border.
pub(super) fn cavities(inside: &[bool], grid: Grid, boundary: Boundary) -> usize {
    let outside: Vec<bool> = inside.iter().map(|&i| !i).collect();
    let found = label(&outside, grid, boundary, true);
    if boundary == Boundary::Periodic {
        return found.sizes.len().saturating_sub(1);
    }
    let mut open = vec![false; found.sizes.len() + 1];
    open[0] = true;
    let shape = grid.shape();
    for (n, &label) in found.labels.iter().enumerate() {
        let node = grid.node(n);
        if (0..3).any(|a| node[a] == 0 || node[a] + 1 == shape[a]) {
            open[label as usize] = true;
        }
    }
    open.iter().filter(|&&o| !o).count()
}
