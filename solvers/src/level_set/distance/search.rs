//! The search for edges on which the sign changes.

use super::Lattice;
use super::crossing::{self, Crossing};
use super::elements::{Element, Shape};

/// Rows that one task searches.
pub(super) const ROWS: usize = 32;

/// What a task found in its rows.
#[derive(Default)]
pub(super) struct Found {
    /// In the plane, by rows.
    pub crossings: Vec<Crossing>,
    /// Elements with the nodes `[k, j, i]` around them.
    pub elements: Vec<(Element, [[u32; 3]; 2])>,
    /// In space, the bends of the elements.
    pub shapes: Vec<Shape>,
}

/// Finds the crossings on the edges that start in the rows of `task`, and nodes at exactly 0.
///
/// `table` gets the number of the crossing on each crossed edge of a plane: two
/// entries a node, the edge along x first. Entries of other edges are left as they are.
pub(super) fn search(
    phi: &[f64],
    lattice: &Lattice,
    task: usize,
    found: &mut Found,
    table: &mut [u32],
) {
    found.crossings.clear();
    found.elements.clear();
    found.shapes.clear();
    let [_, ny, nx] = lattice.shape;
    for row in task * ROWS..((task + 1) * ROWS).min(lattice.rows()) {
        let (k, j) = (row / ny, row % ny);
        let line = |k: usize, j: usize| &phi[(k * ny + j) * nx..][..nx];
        let lines = Lines {
            place: [k, j],
            here: line(k, j),
            above: lattice.next(j, ny).map(|up| line(k, up)),
            behind: lattice.next(k, lattice.shape[0]).map(|back| line(back, j)),
        };
        let entries = if lattice.plane() { 2 * nx } else { 0 };
        let table = &mut table[entries * (row - task * ROWS)..][..entries];
        lines.search(phi, lattice, found, table);
    }
}

/// A row and the next ones along y and z.
struct Lines<'a> {
    place: [usize; 2],
    here: &'a [f64],
    above: Option<&'a [f64]>,
    behind: Option<&'a [f64]>,
}

impl Lines<'_> {
    fn search(&self, phi: &[f64], lattice: &Lattice, found: &mut Found, table: &mut [u32]) {
        const BLOCK: usize = 32;
        let Self { here, above, behind, .. } = *self;
        let nx = here.len();
        for first in (0..nx).step_by(BLOCK) {
            let last = (first + BLOCK).min(nx);
            let block = &here[first..last];
            let beside = &here[(first + 1).min(nx)..(last + 1).min(nx)];
            let seam = lattice.periodic && last == nx;
            let quiet =
                |other: Option<&[f64]>| other.is_none_or(|o| !differ(block, &o[first..last]));
            let no_zero = !block.iter().fold(false, |any, &v| any | (v == 0.0));
            if seam || !no_zero || differ(block, beside) || !quiet(above) || !quiet(behind) {
                (first..last).for_each(|i| self.node(phi, lattice, i, found, table));
            }
        }
    }

    /// The crossings on the edges from node `i`.
    #[inline]
    fn node(&self, phi: &[f64], lattice: &Lattice, i: usize, found: &mut Found, table: &mut [u32]) {
        let [k, j] = self.place;
        let value = self.here[i];
        let crosses = |other: f64| (value < 0.0) != (other < 0.0);
        let beside = lattice.next(i, self.here.len());
        let edges = [
            beside.is_some_and(|b| crosses(self.here[b])),
            self.above.is_some_and(|line| crosses(line[i])),
            self.behind.is_some_and(|line| crosses(line[i])),
        ];
        let node = [k, j, i].map(|c| c as u32);
        if value == 0.0 {
            let [z, y, x] = node.map(f64::from);
            found.elements.push((Element::point([x, y, z]), [node; 2]));
            if !lattice.plane() {
                found.shapes.push([0.0; 6]);
            }
        }
        for (m, _) in edges.into_iter().enumerate().filter(|&(_, crossed)| crossed) {
            if lattice.plane() {
                table[2 * i + m] = found.crossings.len() as u32;
                found.crossings.push(crossing::in_plane(phi, lattice, [j, i], m == 1));
            } else {
                let axis = 2 - m;
                let (element, shape) = crossing::in_space(phi, lattice, [k, j, i], axis);
                let mut other = node;
                other[axis] = (other[axis] + 1) % lattice.shape[axis] as u32;
                found.elements.push((element, [node, other]));
                found.shapes.push(shape);
            }
        }
    }
}

/// Whether the signs of two slices differ anywhere, up to the shorter.
#[inline(always)]
fn differ(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).fold(false, |any, (&a, &b)| any | ((a < 0.0) != (b < 0.0)))
}
