//! Fixed unknowns and springs.

use super::lattice::Layout;

/// Fixed unknowns and springs, by row of nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct Constraints {
    /// Places in the row of the fixed unknowns.
    pub fixed: PerRow<u32>,
    /// Places in the row and stiffness of the springs of free unknowns.
    pub springs: PerRow<(u32, f64)>,
}

/// Lists of items, one for each row.
#[derive(Clone, Debug, Default)]
pub(super) struct PerRow<T> {
    offsets: Vec<u32>,
    items: Vec<T>,
}

impl<T> PerRow<T> {
    /// From `(row, item)` in any order within `rows` rows.
    pub(super) fn new(rows: usize, mut items: Vec<(usize, T)>) -> Self {
        items.sort_by_key(|&(row, _)| row);
        let mut offsets = vec![0; rows + 1];
        for (row, _) in &items {
            offsets[row + 1] += 1;
        }
        for row in 0..rows {
            offsets[row + 1] += offsets[row];
        }
        Self { offsets, items: items.into_iter().map(|(_, item)| item).collect() }
    }

    pub(super) fn row(&self, row: usize) -> &[T] {
        &self.items[self.offsets[row] as usize..self.offsets[row + 1] as usize]
    }
}

impl Constraints {
    pub(super) fn new(layout: &Layout, fixed: &[bool], springs: &[f64]) -> Self {
        let rows = layout.rows();
        let at = |unknown| layout.place(unknown);
        let is_fixed = (0..fixed.len()).filter(|&u| fixed[u]).map(|u| (at(u).0, at(u).1 as u32));
        let free = |&(u, &s): &(usize, &f64)| s != 0.0 && !fixed[u];
        let spring = |(u, &s)| (at(u).0, (at(u).1 as u32, s));
        Self {
            fixed: PerRow::new(rows, is_fixed.collect()),
            springs: PerRow::new(
                rows,
                springs.iter().enumerate().filter(free).map(spring).collect(),
            ),
        }
    }

    /// Sets a vector to 0 at the fixed unknowns.
    pub(super) fn clear_fixed(&self, layout: &Layout, x: &mut [f64]) {
        for (row, x) in x.chunks_exact_mut(layout.row_len()).take(layout.rows()).enumerate() {
            self.fixed.row(row).iter().for_each(|&place| x[place as usize] = 0.0);
        }
    }
}
