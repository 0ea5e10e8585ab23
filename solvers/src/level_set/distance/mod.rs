//! Signed distance to the zero contour of a field, exact to third order next to the contour.
//!
//! 1. On every grid edge where the sign changes, the crossing of the cubic
//!    through four values, with normal and curvature there (second-order patches).
//! 2. The nearest patch of every node, by sweeps of element numbers along the axes.
//! 3. The distance to that patch, an osculating arc of 1.5 cells.
//!
//! Cost O(nodes), about 20 ns a node, after the first call without allocation.
//!
//! | symbol | code        | meaning                                   | unit     |
//! |--------|-------------|-------------------------------------------|----------|
//! | d      | `distance`  | signed distance, negative inside          | length   |
//! | n      | `normal`    | grad phi / abs(grad phi) on the contour   | 1        |
//! | kappa  | `curvature` | div n                                     | 1/length |

mod elements;
mod measure;
mod sources;
mod sweep;

pub use sources::{from_image, from_mask, from_polylines};

use crate::{Boundary, Error, Field, Grid, Result};
use elements::{Element, Shape};
use rayon::prelude::*;
use sweep::{Lane, Seed, Sites};

/// Grids of fewer nodes are worked on by one thread: waking another takes about as long.
const PARALLEL_NODES: usize = 1 << 15;

/// Rows that one task searches for crossings.
const ROWS_PER_TASK: usize = 32;

/// What [`Redistance`] computes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RedistanceOptions {
    /// Continuation beyond the border; distances wrap around a periodic grid.
    pub boundary: Boundary,
    /// Width (length) beyond which only the sign is wanted: the result is clipped
    /// to `[-band, band]`, which saves time. `None` is no limit.
    pub band: Option<f64>,
}

/// Turns fields into signed distances; keeps its memory between calls.
///
/// ```
/// use solvers::level_set::{Redistance, RedistanceOptions};
/// use solvers::{Field, Grid};
/// let grid = Grid::new(&[64, 64], 1.0)?;
/// let mut phi = Field::from_fn(grid, |[x, y, _]| (x - 30.0).powi(2) + (y - 30.0).powi(2) - 400.0);
/// Redistance::new(grid, RedistanceOptions::default())?.apply(&mut phi)?;
/// assert!((phi.at(0, 30, 60) - 10.0).abs() < 0.01); // 30 from the centre of a circle of radius 20
/// # Ok::<(), solvers::Error>(())
/// ```
pub struct Redistance {
    grid: Grid,
    lattice: Lattice,
    /// In cells.
    band: Option<f64>,
    tasks: Vec<Vec<(Element, Shape, [[u32; 3]; 2])>>,
    pieces: Pieces,
    /// Finds of the sweeps along y and z, and of those along x.
    lanes: [Lane; 2],
}

impl std::fmt::Debug for Redistance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Redistance").field("grid", &self.grid).finish_non_exhaustive()
    }
}

/// The contour in pieces, with the nodes that know them from the start.
#[derive(Default)]
struct Pieces {
    elements: Vec<Element>,
    shapes: Vec<Shape>,
    points: Vec<[f32; 3]>,
    seeds: Vec<Seed>,
}

/// Shape, strides and continuation of a grid, in the form that inner loops want.
struct Lattice {
    shape: [usize; 3],
    strides: [usize; 3],
    boundary: Boundary,
    periodic: bool,
    /// Periods along x, y, z (cells), infinite along axes without one.
    period: [f32; 3],
}

impl Lattice {
    fn new(grid: Grid, boundary: Boundary) -> Self {
        let [nz, ny, nx] = grid.shape();
        let periodic = boundary == Boundary::Periodic;
        let period = [nx, ny, nz].map(|n| if periodic { n as f32 } else { f32::INFINITY });
        Self { shape: grid.shape(), strides: grid.strides(), boundary, periodic, period }
    }

    /// Farther than any two nodes are apart (cells).
    fn diagonal(&self) -> f64 {
        self.shape.iter().filter(|&&n| n > 1).map(|&n| (n * n) as f64).sum::<f64>().sqrt()
    }

    fn rows(&self) -> usize {
        self.shape[0] * self.shape[1]
    }

    fn wrap(&self, i: isize, n: usize) -> usize {
        if n == 1 { 0 } else { self.boundary.wrap(i.clamp(-(n as isize), 2 * n as isize - 1), n) }
    }
}

impl Redistance {
    /// Prepares for fields on `grid`.
    ///
    /// # Errors
    /// If the band is not positive, or the grid has 2^32 nodes or more.
    pub fn new(grid: Grid, options: RedistanceOptions) -> Result<Self> {
        if let Some(band) = options.band
            && !(band > 0.0)
        {
            return Err(Error::out_of_range("band", band, "(0, inf)"));
        }
        if grid.len() >= u32::MAX as usize / 4 {
            return Err(Error::TooLarge {
                name: "grid of a signed distance".into(),
                shape: grid.axes().to_vec(),
                needed: format!("{} node numbers", grid.len()),
                available: "2^30 of them".into(),
            });
        }
        let lattice = Lattice::new(grid, options.boundary);
        let tasks = lattice.rows().div_ceil(ROWS_PER_TASK);
        Ok(Self {
            grid,
            band: options.band.map(|band| band / grid.spacing()),
            tasks: (0..tasks).map(|_| Vec::new()).collect(),
            pieces: Pieces::default(),
            lanes: [Lane::new(grid.len()), Lane::new(grid.len())],
            lattice,
        })
    }

    /// Replaces `phi` by the signed distance to its zero contour: the same signs, `|grad phi| = 1`.
    ///
    /// Nodes at exactly 0 stay 0 and belong to the contour. A field without
    /// contour keeps its sign and gets the band as magnitude, or without a band
    /// the grid's diagonal, which is farther than any contour can be. Error of
    /// the distance next to a smooth contour: O(h^3).
    ///
    /// # Errors
    /// If `phi` lives on another grid or holds NaN or infinities.
    pub fn apply(&mut self, phi: &mut Field) -> Result<()> {
        phi.check_shape("phi", self.grid)?;
        check_finite(phi)?;
        self.find_pieces(phi.as_slice());
        self.measure(phi.as_mut_slice(), false);
        Ok(())
    }

    /// Finds the patches of the contour, tasks in parallel, in the order of the rows.
    fn find_pieces(&mut self, phi: &[f64]) {
        let lattice = &self.lattice;
        let search = |(task, found): (usize, &mut Vec<(Element, Shape, [[u32; 3]; 2])>)| {
            found.clear();
            let last = ((task + 1) * ROWS_PER_TASK).min(lattice.rows());
            for row in task * ROWS_PER_TASK..last {
                search_row(phi, lattice, row, found);
            }
        };
        if phi.len() < PARALLEL_NODES {
            self.tasks.iter_mut().enumerate().for_each(search);
        } else {
            self.tasks.par_iter_mut().enumerate().for_each(search);
        }
        self.pieces.clear();
        for &(element, shape, nodes) in self.tasks.iter().flatten() {
            self.pieces.push(element, shape, &nodes);
        }
    }

    /// Nearest pieces and the distances to them; signs are those of `phi`.
    fn measure(&mut self, phi: &mut [f64], chained: bool) {
        let Self { grid, lattice, band, pieces, lanes, .. } = self;
        // A node within the band sees some piece's point within the band plus a cell.
        let reach = band.map_or(f32::INFINITY, |band| ((band + 1.0) * (band + 1.0)) as f32);
        let sites = Sites { lattice, points: &pieces.points, seeds: &pieces.seeds, reach };
        let parallel = phi.len() >= PARALLEL_NODES;
        let [yz, x] = lanes;
        if parallel {
            rayon::join(|| sites.sweep_yz(yz), || sites.sweep_x(x));
        } else {
            sites.sweep_yz(yz);
            sites.sweep_x(x);
        }
        let far = band.unwrap_or_else(|| lattice.diagonal());
        let finish =
            measure::Finish { lattice, pieces, lanes, far, chained, spacing: grid.spacing() };
        finish.run(phi, parallel);
    }
}

/// Refuses NaN; an any-reduction without branches is several times faster than a search.
fn check_finite(phi: &Field) -> Result<()> {
    let bad = |values: &[f64]| values.iter().fold(false, |bad, v| bad | !v.is_finite());
    let values = phi.as_slice();
    let any = if values.len() < PARALLEL_NODES {
        bad(values)
    } else {
        values.par_chunks(1 << 14).any(bad)
    };
    if !any {
        return Ok(());
    }
    let n = values.iter().position(|v| !v.is_finite()).unwrap_or_default();
    Err(Error::Invalid(format!(
        "phi is {} at node {}; a signed distance needs finite values",
        values[n],
        phi.grid().name_node(n)
    )))
}

/// Adds the patches on the edges that start in `row`.
fn search_row(
    phi: &[f64],
    lattice: &Lattice,
    row: usize,
    found: &mut Vec<(Element, Shape, [[u32; 3]; 2])>,
) {
    let [_, ny, nx] = lattice.shape;
    let (k, j) = (row / ny, row % ny);
    let here = &phi[row * nx..][..nx];
    // The next node along each axis, if there is one.
    let next = |c: usize, n: usize| match c + 1 < n {
        true => Some(c + 1),
        false => (lattice.periodic && n > 1).then_some(0),
    };
    let (up, back) = (next(j, ny), next(k, lattice.shape[0]));
    let above = up.map(|j| &phi[(k * ny + j) * nx..][..nx]);
    let behind = back.map(|k| &phi[(k * ny + j) * nx..][..nx]);
    const BLOCK: usize = 32;
    for first in (0..nx).step_by(BLOCK) {
        let last = (first + BLOCK).min(nx);
        let block = &here[first..last];
        let beside = &here[(first + 1).min(nx)..(last + 1).min(nx)];
        let seam = lattice.periodic && last == nx;
        let quiet = |other: Option<&[f64]>| other.is_none_or(|o| !differ(block, &o[first..last]));
        let no_zero = !block.iter().fold(false, |any, &v| any | (v == 0.0));
        if !seam && no_zero && !differ(block, beside) && quiet(above) && quiet(behind) {
            continue;
        }
        for i in first..last {
            let node = [k, j, i];
            let n = row * nx + i;
            let mut add = |axis: usize, place: usize, other: f64| {
                if (phi[n] < 0.0) != (other < 0.0) {
                    let mut beyond = node;
                    beyond[axis] = place;
                    let (element, shape) = elements::on_edge(phi, lattice, node, axis);
                    found.push((element, shape, [node, beyond].map(|c| c.map(|c| c as u32))));
                }
            };
            if let Some(other) = next(i, nx) {
                add(2, other, here[other]);
            }
            if let (Some(above), Some(up)) = (above, up) {
                add(1, up, above[i]);
            }
            if let (Some(behind), Some(back)) = (behind, back) {
                add(0, back, behind[i]);
            }
            if phi[n] == 0.0 {
                let point = [i as f64, j as f64, k as f64];
                found.push((Element::point(point), [0.0; 6], [node.map(|c| c as u32); 2]));
            }
        }
    }
}

/// Whether the signs of two slices differ anywhere, up to the shorter.
#[inline(always)]
fn differ(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).fold(false, |any, (&a, &b)| any | ((a < 0.0) != (b < 0.0)))
}

impl Pieces {
    fn clear(&mut self) {
        self.elements.clear();
        self.shapes.clear();
        self.points.clear();
        self.seeds.clear();
        // Number 0: no element, infinitely far.
        self.elements.push(Element::point([f64::INFINITY; 3]));
        self.shapes.push([0.0; 6]);
        self.points.push([f32::INFINITY; 3]);
    }

    fn push(&mut self, element: Element, shape: Shape, nodes: &[[u32; 3]]) {
        let number = self.elements.len() as u32;
        self.points.push(element.point.map(|c| c as f32));
        self.elements.push(element);
        self.shapes.push(shape);
        self.seeds.extend(nodes.iter().map(|&node| Seed { node, element: number }));
    }
}

/// Replaces `phi` by the signed distance to its zero contour; see [`Redistance::apply`].
///
/// # Errors
/// As [`Redistance::new`] and [`Redistance::apply`].
pub fn redistance(phi: &mut Field, boundary: Boundary) -> Result<()> {
    let options = RedistanceOptions { boundary, band: None };
    Redistance::new(phi.grid(), options)?.apply(phi)
}
