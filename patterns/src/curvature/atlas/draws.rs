//! Random parameters and the shapes that they make.

use super::config::Ranges;
use crate::curvature::Coefficients;
use crate::curvature::grow::{Grown, Growth, Shape};
use crate::{Error, Result, State};
use rayon::prelude::*;
use solvers::random::{stream, uniform};
use solvers::{Field, Grid, transport::PointCloud};

/// Draws that are grown together, whatever the number of threads.
pub(crate) const BATCH: usize = 8;

/// A viable shape of an atlas.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    /// Number of the draw.
    pub(crate) draw: usize,
    /// As [`super::NAMES`].
    pub(crate) parameters: [f64; 6],
    /// As [`crate::curvature::grow::MEASURES`].
    pub(crate) measures: [f64; 6],
    /// The curvature diagram, binned.
    pub(crate) diagram: PointCloud<2>,
    /// Every second voxel of the phase along each axis, -1 to 1 as 0 to 254; every voxel of
    /// a box of odd size.
    pub(crate) thumbnail: Vec<u8>,
}

/// Draws of parameters, numbered from 0.
#[derive(Clone, Debug)]
pub(crate) struct Draws {
    growth: Growth,
    ranges: Ranges,
    /// Side of the bins of the diagrams (1/length).
    cell: f64,
    seed: u64,
    /// Viable shapes, by number.
    pub(crate) members: Vec<Member>,
    /// Draws so far.
    pub(crate) drawn: usize,
    /// Draws refused: too diffuse, of one side, not finite.
    pub(crate) refused: [u64; 3],
}

/// Polynomial and mass of six parameters; a20 is 1.
pub(crate) fn coefficients([a11, a02, b10, b01, c, mass]: [f64; 6]) -> (Coefficients, f64) {
    (Coefficients { a20: 1.0, a11, a02, b10, b01, c }, mass)
}

impl Draws {
    pub(crate) fn new(growth: Growth, ranges: Ranges, cell: f64, seed: u64) -> Self {
        Self { growth, ranges, cell, seed, members: Vec::new(), drawn: 0, refused: [0; 3] }
    }

    /// The parameters of a draw.
    fn parameters(&self, draw: usize) -> [f64; 6] {
        let mut random = stream(self.seed, "atlas parameters", draw as u64);
        let mut parameters = [0.0; 6];
        for (value, [low, high]) in parameters.iter_mut().zip(self.ranges.list()) {
            *value = low + uniform(&mut random) * (high - low);
        }
        parameters
    }

    /// Seed of the noise that a draw starts from.
    fn noise(&self, draw: usize) -> u64 {
        use rand::Rng as _;
        stream(self.seed, "atlas noise", draw as u64).next_u64()
    }

    /// Grows the next draws, until there are `count` members or `most` draws.
    ///
    /// # Errors
    /// If coefficients are refused.
    pub(crate) fn advance(&mut self, count: usize, most: usize) -> Result<()> {
        let next = self.drawn..most.min(self.drawn + BATCH);
        let grow = |draw: usize| {
            let parameters = self.parameters(draw);
            let (polynomial, mass) = coefficients(parameters);
            Ok((draw, parameters, self.growth.grow(polynomial, mass, self.noise(draw))?))
        };
        let grown: Result<Vec<_>> = next.into_par_iter().map(grow).collect();
        for (draw, parameters, grown) in grown? {
            if self.members.len() == count {
                break;
            }
            self.drawn = draw + 1;
            match grown {
                Grown::Shape(shape) => {
                    let member = Member::new(draw, parameters, &shape, self.cell)?;
                    self.members.push(member);
                }
                Grown::Diffuse => self.refused[0] += 1,
                Grown::Empty => self.refused[1] += 1,
                Grown::Broken => self.refused[2] += 1,
            }
        }
        Ok(())
    }

    /// The phase of a member, as coarse as it is kept.
    pub(crate) fn phase(&self, member: &Member) -> Result<Field> {
        let grid = self.growth.grid()?;
        let stride = stride(grid);
        let shape = grid.shape().map(|n| n / stride);
        let coarse = Grid::new(&shape, self.growth.spacing * stride as f64)?;
        let values = member.thumbnail.iter().map(|&v| f64::from(v) / 127.0 - 1.0).collect();
        Ok(Field::from_vec(coarse, values)?)
    }

    pub(crate) fn save(&self, state: &mut State) {
        let of = |value: fn(&Member) -> &[f64; 6]| -> Vec<f64> {
            self.members.iter().flat_map(value).copied().collect()
        };
        let numbers: Vec<u64> = self.members.iter().map(|m| m.draw as u64).collect();
        let cells: Vec<u64> = self.members.iter().map(|m| m.diagram.len() as u64).collect();
        let thumbnails: Vec<u8> = self.members.iter().flat_map(|m| &m.thumbnail).copied().collect();
        state.put_u64("drawn", &[self.drawn as u64]);
        state.put_u64("refused", &self.refused);
        state.put_u64("draws", &numbers);
        state.put_f64("parameters", &of(|m| &m.parameters));
        state.put_f64("measures", &of(|m| &m.measures));
        state.put_u64("cells", &cells);
        let triples: Vec<f64> = self.members.iter().flat_map(Member::cells).flatten().collect();
        state.put_f64("diagrams", &triples);
        state.put_u8("thumbnails", &thumbnails);
    }

    pub(crate) fn restore(&mut self, state: &State) -> Result<()> {
        let draws = state.all_u64("draws")?;
        let cells = state.all_u64("cells")?;
        let parameters = state.all_f64("parameters")?.as_chunks::<6>().0;
        let measures = state.all_f64("measures")?.as_chunks::<6>().0;
        let thumbnails = state.all_u8("thumbnails")?;
        let mut triples = state.all_f64("diagrams")?.as_chunks::<3>().0;
        let grid = self.growth.grid()?;
        let voxels = grid.len() / stride(grid).pow(3);
        let n = draws.len();
        let lengths = [cells.len(), parameters.len(), measures.len(), thumbnails.len() / voxels];
        let refused = state.all_u64("refused")?;
        if lengths != [n; 4] || refused.len() != 3 {
            return Err(Error::Checkpoint("the shapes of the atlas are incomplete".into()));
        }
        self.drawn = state.one_u64("drawn")? as usize;
        self.refused.copy_from_slice(refused);
        self.members.clear();
        for k in 0..n {
            let Some((own, rest)) = triples.split_at_checked(cells[k] as usize) else {
                return Err(Error::Checkpoint("`diagrams` is too short".into()));
            };
            triples = rest;
            self.members.push(Member {
                draw: draws[k] as usize,
                parameters: parameters[k],
                measures: measures[k],
                diagram: cloud(own)?,
                thumbnail: thumbnails[k * voxels..][..voxels].to_vec(),
            });
        }
        Ok(())
    }
}

/// Voxels from one kept voxel to the next.
fn stride(grid: Grid) -> usize {
    if grid.shape().iter().all(|n| n % 2 == 0) { 2 } else { 1 }
}

/// A diagram from rows of kappa1, kappa2, weight.
pub(crate) fn cloud(rows: &[[f64; 3]]) -> Result<PointCloud<2>> {
    let points: Vec<[f64; 2]> = rows.iter().map(|r| [r[0], r[1]]).collect();
    let weights: Vec<f64> = rows.iter().map(|r| r[2]).collect();
    Ok(PointCloud::new(&points, &weights)?)
}

impl Member {
    fn new(draw: usize, parameters: [f64; 6], shape: &Shape, cell: f64) -> Result<Self> {
        let stride = stride(shape.phase.grid());
        let [nz, ny, nx] = shape.phase.grid().shape();
        let every = |n: usize| (0..n).step_by(stride);
        let u = shape.phase.as_slice();
        let voxel = |n: usize| ((u[n].clamp(-1.0, 1.0) + 1.0) * 127.0).round() as u8;
        let thumbnail = every(nz)
            .flat_map(|z| {
                every(ny).flat_map(move |y| every(nx).map(move |x| (z * ny + y) * nx + x))
            })
            .map(voxel)
            .collect();
        let diagram = shape.diagram.binned(cell)?;
        Ok(Self { draw, parameters, measures: shape.measures, diagram, thumbnail })
    }

    /// Rows kappa1, kappa2, weight of the diagram.
    pub(crate) fn cells(&self) -> impl Iterator<Item = [f64; 3]> {
        let diagram = &self.diagram;
        (0..diagram.len()).map(|n| {
            let [first, second] = diagram.point(n);
            [first, second, diagram.weights()[n]]
        })
    }
}
