//! The stages of an atlas: shapes, distances, map.

use super::config::Config;
use super::draws::{BATCH, Draws};
use super::view;
use crate::{Artifact, Context, Error, Image, Metric, Result, Run, State, Status};
use ndarray::Array2;
use rayon::prelude::*;
use solvers::cluster::{Clusters, Hdbscan};
use solvers::embed::Umap;
use solvers::transport::PreparedCloud;

/// Distances that are measured in a step, at least.
const PAIRS: usize = 256;

/// Fewest shapes that make a map.
const LEAST: usize = 3;

/// Share of draws that is expected to be viable.
const VIABLE: f64 = 0.55;

struct Atlas {
    config: Config,
    draws: Draws,
    /// Diagrams made ready, once all shapes are there.
    ready: Vec<PreparedCloud<2>>,
    /// Row i: distances from shape i to those after it.
    rows: Vec<Vec<f64>>,
    map: Option<Drawn>,
    steps: u64,
}

/// Where the shapes lie on the map, and their clusters.
pub(super) struct Drawn {
    pub(super) positions: Vec<[f64; 2]>,
    pub(super) clusters: Clusters,
    pub(super) distances: Array2<f64>,
}

/// Starts a run, its checks before any work.
pub(super) fn begin(table: &toml::Table, context: &Context<'_>) -> Result<Box<dyn Run>> {
    let config: Config = crate::from_table(table)?;
    config.check()?;
    config.growth.check_memory("growth.size", BATCH, context)?;
    let needed = (config.count * config.count * 16) as u64;
    if needed > context.memory {
        let reason = format!(
            "distances among {} shapes need {:.1} GiB of memory",
            config.count,
            needed as f64 / 1024.0_f64.powi(3)
        );
        return Err(Error::config("count", reason));
    }
    let (growth, ranges) = (config.growth.clone(), config.ranges.clone());
    let draws = Draws::new(growth, ranges, config.distance.cell, context.seed);
    let (ready, rows) = (Vec::new(), Vec::new());
    Ok(Box::new(Atlas { config, draws, ready, rows, map: None, steps: 0 }))
}

impl Atlas {
    fn growing(&self) -> bool {
        self.draws.members.len() < self.config.count && self.draws.drawn < self.config.most_draws()
    }

    /// Measures some rows of the matrix of distances.
    fn measure(&mut self) -> Result<()> {
        let transport = self.config.distance.transport(self.config.growth.spacing)?;
        let members = &self.draws.members;
        if self.ready.len() < members.len() {
            let ready: Result<Vec<_>> = members
                .par_iter()
                .map(|m| transport.prepare(&m.diagram).map_err(Error::from))
                .collect();
            self.ready = ready?;
        }
        let (first, n) = (self.rows.len(), members.len());
        let (mut last, mut pairs) = (first, 0);
        while last < n && pairs < PAIRS {
            pairs += n - 1 - last;
            last += 1;
        }
        let all: Vec<(usize, usize)> =
            (first..last).flat_map(|i| (i + 1..n).map(move |j| (i, j))).collect();
        let distance = |&(i, j): &(usize, usize)| {
            transport.divergence(&self.ready[i], &self.ready[j]).abs().sqrt()
        };
        let distances: Vec<f64> = all.par_iter().map(distance).collect();
        let mut rest = distances.as_slice();
        for i in first..last {
            let (row, after) = rest.split_at(n - 1 - i);
            self.rows.push(row.to_vec());
            rest = after;
        }
        Ok(())
    }

    fn draw_map(&self) -> Result<Drawn> {
        let n = self.rows.len();
        let distances = Array2::from_shape_fn((n, n), |(i, j)| match i.cmp(&j) {
            std::cmp::Ordering::Less => self.rows[i][j - i - 1],
            std::cmp::Ordering::Equal => 0.0,
            std::cmp::Ordering::Greater => self.rows[j][i - j - 1],
        });
        let map = &self.config.map;
        let umap = Umap {
            neighbors: map.neighbors,
            min_dist: map.min_dist,
            spread: map.spread,
            seed: map.seed,
            ..Umap::default()
        };
        let positions = umap.embed(distances.view())?;
        let apart = Array2::from_shape_fn((n, n), |(i, j)| {
            let [a, b] = [positions[i], positions[j]];
            libm::hypot(a[0] - b[0], a[1] - b[1])
        });
        let hdbscan = Hdbscan { min_cluster_size: map.cluster, min_samples: map.samples };
        let clusters = hdbscan.labels(apart.view())?;
        Ok(Drawn { positions, clusters, distances })
    }

    /// Steps of all stages if `viable` of the draws are.
    fn steps(&self, viable: f64) -> u64 {
        let n = self.config.count;
        let draws = (n as f64 / viable).min(self.config.most_draws() as f64);
        let rows = (n * (n - 1) / 2).div_ceil(PAIRS);
        (draws / BATCH as f64).ceil() as u64 + rows as u64 + 1
    }
}

impl Run for Atlas {
    fn step(&mut self) -> Result<Status> {
        self.steps += 1;
        if self.growing() {
            self.draws.advance(self.config.count, self.config.most_draws())?;
            return Ok(Status::Running);
        }
        let found = self.draws.members.len();
        if found < LEAST {
            return Ok(Status::NotConverged);
        }
        if self.rows.len() < found {
            self.measure()?;
            return Ok(Status::Running);
        }
        self.map = Some(self.draw_map()?);
        let whole = found == self.config.count;
        Ok(if whole { Status::Done } else { Status::NotConverged })
    }

    fn iterations(&self) -> u64 {
        self.steps
    }

    fn max_iterations(&self) -> u64 {
        let least = self.config.count as f64 / self.config.most_draws() as f64;
        // The last row is empty and may take a step of its own.
        self.steps(least) + 1
    }

    fn expected_iterations(&self) -> u64 {
        self.steps(VIABLE)
    }

    fn config(&self) -> toml::Table {
        crate::to_table(&self.config)
    }

    fn metrics(&self) -> Vec<Metric> {
        let mut metrics = self.observe();
        for (name, count) in ["refused_diffuse", "refused_one_sided", "refused_not_finite"]
            .iter()
            .zip(self.draws.refused)
        {
            metrics.push(Metric::new(name, count as f64, "1"));
        }
        if let Some(map) = &self.map {
            let noise = map.clusters.labels.iter().filter(|label| label.is_none()).count();
            metrics.push(Metric::new("clusters", map.clusters.count as f64, "1"));
            metrics.push(Metric::new("outside_clusters", noise as f64, "1"));
        }
        metrics
    }

    fn observe(&self) -> Vec<Metric> {
        let pairs: usize = self.rows.iter().map(Vec::len).sum();
        vec![
            Metric::new("draws", self.draws.drawn as f64, "1"),
            Metric::new("shapes", self.draws.members.len() as f64, "1"),
            Metric::new("distances", pairs as f64, "1"),
        ]
    }

    fn artifacts(&self) -> Vec<Artifact> {
        view::artifacts(&self.draws, self.map.as_ref(), &self.config)
    }

    fn frame(&self) -> Option<Image> {
        None
    }

    fn save(&self) -> State {
        let mut state = State::default();
        self.draws.save(&mut state);
        state.put_u64("steps", &[self.steps]);
        state.put_u64("rows", &[self.rows.len() as u64]);
        state.put_f64("distances", &self.rows.concat());
        state
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        self.draws.restore(state)?;
        self.steps = state.one_u64("steps")?;
        let mut distances = state.all_f64("distances")?;
        let n = self.draws.members.len();
        self.rows.clear();
        for i in 0..state.one_u64("rows")? as usize {
            let split = n.checked_sub(i + 1).and_then(|length| distances.split_at_checked(length));
            let Some((row, rest)) = split else {
                return Err(Error::Checkpoint("`distances` is too short".into()));
            };
            self.rows.push(row.to_vec());
            distances = rest;
        }
        Ok(())
    }
}
