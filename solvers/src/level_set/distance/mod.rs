//! Signed distance to the zero contour of a field, exact to third order next to the contour.
//!
//! 1. On every grid edge where the sign changes, the crossing of the cubic through four
//!    values, with normal and curvature there.
//! 2. In the plane, an arc across each cell from crossing to crossing; where the contour
//!    bends too much for that, chords of the cell's bicubic interpolant; in space,
//!    a round patch at each crossing. These are the elements.
//! 3. The distance to the nearest element: near it and in narrow bands among all
//!    (in the plane), elsewhere to the one found by sweeps of element numbers along the axes.
//!
//! Beyond the outermost nodes contours go on straight for half a cell.
//! Cost O(nodes), about 25 ns a node, after the first call without allocation; in a
//! narrow band of a few cells about 3 ns a node and half a microsecond an element.
//!
//! | symbol | code        | meaning                                   | unit     |
//! |--------|-------------|-------------------------------------------|----------|
//! | d      | `distance`  | signed distance, negative inside          | length   |
//! | n      | `normal`    | grad phi / abs(grad phi) on the contour   | 1        |
//! | kappa  | `curvature` | div n                                     | 1/length |

mod cells;
mod crossing;
mod elements;
mod front;
mod lattice;
mod measure;
mod scatter;
mod search;
mod sources;
mod subdivide;
mod sweep;

pub use sources::{from_image, from_mask, from_polylines};

use crate::{Boundary, Error, Field, Grid, Result};
use cells::{Arcs, Cells};
use elements::{Element, Shape};
use lattice::Lattice;
use measure::{Fill, Finish, Roots};
use rayon::prelude::*;
use scatter::{Bins, Scatter};
use search::Found;
use sweep::{Lane, Seed, Sites};

/// Grids of fewer nodes are worked on by one thread: waking another takes about as long.
const PARALLEL_NODES: usize = 1 << 15;

/// Nodes up to this distance (cells) measure every element around. Beyond it the sweeps'
/// find counts; an element whose middle stands half a diagonal beside the foot point is
/// sqrt(4^2 + .5) - 4 = .06 cell too far.
const NEAR: f64 = 4.0;

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
    found: Vec<Found>,
    /// For each node of a plane the numbers of the crossings on its two edges; else one for each task.
    table: Vec<u32>,
    arcs: Vec<Arcs>,
    pieces: Pieces,
    /// Finds of the sweeps along y and z, and of those along x.
    lanes: [Lane; 2],
    bins: Bins,
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

impl Redistance {
    /// Prepares for fields on `grid`.
    ///
    /// # Errors
    /// If the band is not positive, or the grid has 2^32 nodes or more.
    pub fn new(grid: Grid, options: RedistanceOptions) -> Result<Self> {
        if let Some(band) = options.band
            && (band.is_nan() || band <= 0.0)
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
        let tasks = lattice.rows().div_ceil(search::ROWS);
        Ok(Self {
            grid,
            band: options.band.map(|band| band / grid.spacing()),
            found: (0..tasks).map(|_| Found::default()).collect(),
            table: vec![0; if lattice.plane() { 2 * grid.len() } else { tasks }],
            arcs: vec![Arcs::new(); if lattice.plane() { tasks } else { 0 }],
            bins: Bins::default(),
            pieces: Pieces::default(),
            lanes: [Lane::new(&lattice, false), Lane::new(&lattice, true)],
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
        if !self.find_pieces(phi.as_slice()) {
            return Err(not_finite(phi));
        }
        self.measure(phi.as_mut_slice());
        Ok(())
    }

    /// Finds the elements of the contour, tasks in parallel, in the order of the rows;
    /// false if some value is not finite.
    fn find_pieces(&mut self, phi: &[f64]) -> bool {
        let Self { lattice, found, table, arcs, pieces, band, .. } = self;
        let parallel = phi.len() >= PARALLEL_NODES;
        let width = if lattice.plane() { 2 * lattice.shape[2] * search::ROWS } else { 1 };
        let find = |(task, (found, table)): (usize, (&mut Found, &mut [u32]))| {
            search::search(phi, lattice, task, found, table);
        };
        if parallel {
            found.par_iter_mut().zip(table.par_chunks_mut(width)).enumerate().for_each(find);
        } else {
            found.iter_mut().zip(table.chunks_mut(width)).enumerate().for_each(find);
        }
        if !found.iter().all(|found| found.finite) {
            return false;
        }
        let cells = Cells { phi, lattice, found, table };
        let build = |(task, arcs): (usize, &mut Arcs)| cells.build(task, arcs);
        if parallel && lattice.plane() {
            arcs.par_iter_mut().enumerate().for_each(build);
        } else if lattice.plane() {
            arcs.iter_mut().enumerate().for_each(build);
        }
        pieces.clear();
        let count = found.iter().map(|found| found.elements.len()).sum::<usize>()
            + arcs.iter().map(|arcs| arcs.len()).sum::<usize>();
        // Only sweeps need to know where to start.
        let sweeps = !pays(lattice, count, *band);
        for found in found.iter() {
            for (m, &(element, nodes)) in found.elements.iter().enumerate() {
                let nodes = if sweeps { &nodes[..] } else { &[] };
                pieces.push(element, nodes, found.shapes.get(m).copied());
            }
        }
        for &(element, cell) in arcs.iter().flatten() {
            let corners = if sweeps { &lattice.corners(cell)[..] } else { &[] };
            pieces.push(element, corners, None);
        }
        true
    }

    /// Distances to the nearest elements; signs are those of `phi`.
    fn measure(&mut self, phi: &mut [f64]) {
        let Self { grid, lattice, band, pieces, lanes, bins, .. } = self;
        let parallel = phi.len() >= PARALLEL_NODES;
        let plane = lattice.plane();
        let direct = pays(lattice, pieces.elements.len() - 1, *band);
        if plane {
            bins.fill(pieces, lattice);
        }
        if !direct {
            // A node within the band sees some element's middle within the band plus a cell.
            let reach = band.map_or(f32::INFINITY, |band| ((band + 1.0) * (band + 1.0)) as f32);
            let sites = Sites { lattice, points: &pieces.points, seeds: &pieces.seeds, reach };
            let [yz, x] = &mut *lanes;
            if parallel {
                rayon::join(|| sites.sweep_yz(yz), || sites.sweep_x(x));
            } else {
                sites.sweep_yz(yz);
                sites.sweep_x(x);
            }
        }
        let far = band.unwrap_or_else(|| lattice.diagonal());
        let spacing = grid.spacing();
        // Overlapping elements look up to .14 cell too near: NEAR reaches them all.
        let near = (NEAR - 0.5) * (NEAR - 0.5);
        let finish = Finish { lattice, pieces, lanes, far: far * far, near };
        let rows = scatter::ROWS * lattice.shape[2];
        let reach = if direct { far } else { NEAR };
        let chunk = |(number, values): (usize, &mut [f64])| {
            let first = number * scatter::ROWS;
            let arch = pulp::Arch::new();
            if direct {
                arch.dispatch(Fill { values, square: far * far });
            } else {
                finish.run(first, values);
            }
            if plane {
                let elements = &pieces.elements;
                let values = &mut *values;
                arch.dispatch(Scatter { lattice, elements, bins, reach, first, values });
            }
            arch.dispatch(Roots { values, far, spacing });
        };
        if parallel {
            phi.par_chunks_mut(rows).enumerate().for_each(chunk);
        } else {
            phi.chunks_mut(rows).enumerate().for_each(chunk);
        }
    }
}

/// Whether measuring all nodes within the band of each element costs less than sweeps, in
/// units of one such measurement: sweeps cost 40 a node and 130 an element. On an 80 x 80
/// grid of spots of 1.5 cells (2725 elements) both took the same time at a band of 6; the rule
/// changes over at 6.5. Longer contours have slender arcs, which measure fewer nodes: there the
/// rule is on the safe side. Around a periodic grid an element reaches a node only once.
fn pays(lattice: &Lattice, elements: usize, band: Option<f64>) -> bool {
    let [_, ny, nx] = lattice.shape;
    let Some(band) = band.filter(|_| lattice.plane()) else { return false };
    let fits = !lattice.periodic || band + 2.0 < nx.min(ny) as f64;
    let around = (2.0 * band + 2.0) * (2.0 * band + 2.0) - 130.0;
    fits && elements as f64 * around < 40.0 * (nx * ny) as f64
}

/// Names the first value that is not finite.
fn not_finite(phi: &Field) -> Error {
    let n = phi.as_slice().iter().position(|v| !v.is_finite()).unwrap_or_default();
    Error::Invalid(format!(
        "phi is {} at node {}; a signed distance needs finite values",
        phi.as_slice()[n],
        phi.grid().name_node(n)
    ))
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

    /// Adds an element that `nodes` know from the start; in space with its bends.
    fn push(&mut self, element: Element, nodes: &[[u32; 3]], shape: Option<Shape>) {
        let number = self.elements.len() as u32;
        self.points.push(element.point.map(|c| c as f32));
        self.elements.push(element);
        self.shapes.extend(shape);
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
