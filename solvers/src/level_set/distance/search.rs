//! The search for edges on which the sign changes.

use super::Lattice;
use super::crossing::{self, Crossing};
use super::elements::{Element, Shape};

/// Rows that one task searches.
pub(super) const ROWS: usize = 32;

/// Nodes of a row that are looked at together.
const BLOCK: usize = 32;

/// Values compared at once.
const LANES: usize = 8;

/// What a task found in its rows.
#[derive(Default)]
pub(super) struct Found {
    /// In the plane, by rows.
    pub crossings: Vec<Crossing>,
    /// Elements with the nodes `[k, j, i]` around them.
    pub elements: Vec<(Element, [[u32; 3]; 2])>,
    /// In space, the bends of the elements.
    pub shapes: Vec<Shape>,
    /// Whether all values of its rows are finite.
    pub finite: bool,
    /// Signs of the blocks of a row and of the next ones along y and z.
    signs: [Vec<i8>; 3],
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
    found.finite = true;
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
        // The row above the last one is looked at already.
        let known = row > task * ROWS && j > 0;
        lines.scan(known, found);
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
    /// Notes the signs of blocks of this row, if they are not `known` from above the last, and of the next ones.
    fn scan(&self, known: bool, found: &mut Found) {
        let arch = pulp::Arch::new();
        let [here, above, behind] = &mut found.signs;
        if known {
            std::mem::swap(here, above);
        } else {
            found.finite &= arch.dispatch(Signs { line: self.here, signs: here });
        }
        for (line, signs) in [(self.above, above), (self.behind, behind)] {
            if let Some(line) = line {
                found.finite &= arch.dispatch(Signs { line, signs });
            }
        }
    }

    fn search(&self, phi: &[f64], lattice: &Lattice, found: &mut Found, table: &mut [u32]) {
        let nx = self.here.len();
        for block in 0..nx.div_ceil(BLOCK) {
            let (first, last) = (block * BLOCK, ((block + 1) * BLOCK).min(nx));
            let [sign, above, behind] = found.signs.each_ref().map(|s| s.get(block).copied());
            let same = |line: Option<&[f64]>, other| line.is_none() || other == sign;
            let beside = if last < nx { Some(last) } else { lattice.periodic.then_some(0) };
            let quiet = sign != Some(0)
                && same(self.above, above)
                && same(self.behind, behind)
                && beside.is_none_or(|b| (self.here[b] < 0.0) == (sign == Some(-1)));
            if !quiet {
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

/// Notes for each block of a row 1 if all values are positive, -1 if all are negative,
/// else 0, and tells whether all are finite.
struct Signs<'a> {
    line: &'a [f64],
    signs: &'a mut Vec<i8>,
}

impl pulp::NullaryFnOnce for Signs<'_> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        let (blocks, rest) = self.line.as_chunks::<BLOCK>();
        // 0 times a number is 0, times NaN or an infinity NaN.
        let mut zero = [0.0; LANES];
        self.signs.clear();
        for block in blocks {
            let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
            for values in block.as_chunks::<LANES>().0 {
                for m in 0..LANES {
                    let v = values[m];
                    low[m] = if v < low[m] { v } else { low[m] };
                    high[m] = if v > high[m] { v } else { high[m] };
                    zero[m] += 0.0 * v;
                }
            }
            let low = low.into_iter().fold(f64::INFINITY, f64::min);
            let high = high.into_iter().fold(f64::NEG_INFINITY, f64::max);
            self.signs.push(i8::from(low > 0.0) - i8::from(high < 0.0));
        }
        if !rest.is_empty() {
            let all = |sign: f64| rest.iter().all(|v| v * sign > 0.0);
            self.signs.push(i8::from(all(1.0)) - i8::from(all(-1.0)));
        }
        zero == [0.0; LANES] && rest.iter().all(|v| v.is_finite())
    }
}
