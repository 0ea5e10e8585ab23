//! The stages of an inference: atlas, nearest shapes, search, proof.

use super::config::Config;
use super::proof::{self, Found};
use super::query::Query;
use super::search::{Search, TOGETHER, Target};
use super::view;
use crate::curvature::atlas::{Draws, NAMES, cloud};
use crate::{Artifact, Context, Error, Image, Metric, Result, Run, State, Status};
use rayon::prelude::*;
use solvers::transport::{CoarseSinkhorn, PointCloud, PreparedCloud};

/// Columns of `shapes.npy` of an atlas that are parameters.
const PARAMETERS: usize = 6;

/// Parameters of an atlas's shapes with their diagrams.
type Known = Vec<([f64; 6], PointCloud<2>)>;

struct Inference {
    config: Config,
    seed: u64,
    query: Query,
    transport: CoarseSinkhorn,
    wanted: PreparedCloud<2>,
    /// The atlas that was given; none if one is drawn.
    given: Option<Known>,
    draws: Draws,
    /// Nearest shapes of the atlas: parameters and distances, the nearest first.
    nearest: Vec<([f64; 6], f64)>,
    search: Option<Search>,
    found: Option<Found>,
    steps: u64,
}

/// Starts a run, its checks before any work.
pub(super) fn begin(table: &toml::Table, context: &Context<'_>) -> Result<Box<dyn Run>> {
    // Where a part of `growth` is given, the rest is as usual here, not as in an atlas.
    let mut whole = crate::to_table(&Config::default());
    crate::overlay(&mut whole, table.clone());
    let config: Config = crate::from_table(&whole)?;
    config.check()?;
    config.growth.check_memory("growth.size", TOGETHER, context)?;
    let given = config.atlas.as_ref().map(|folder| read_atlas(folder, context)).transpose()?;
    let query = Query::read(&config, context)?;
    let finest = config.growth.spacing.min(config.spacing());
    let transport = config.distance.transport(finest)?;
    let wanted = transport.prepare(&query.cloud)?;
    let (growth, ranges) = (config.growth.clone(), config.ranges.clone());
    let draws = Draws::new(growth, ranges, config.distance.cell, context.seed);
    Ok(Box::new(Inference {
        config,
        seed: context.seed,
        query,
        transport,
        wanted,
        given,
        draws,
        nearest: Vec::new(),
        search: None,
        found: None,
        steps: 0,
    }))
}

/// Parameters and diagrams of the output folder of an atlas.
fn read_atlas(folder: &str, context: &Context<'_>) -> Result<Known> {
    let read = |name: &str| context.inputs.field("atlas", &format!("{folder}/{name}"));
    let refuse = |name: &str, reason: &str| Error::Input {
        key: "atlas".into(),
        reason: format!("`{folder}/{name}` {reason}"),
    };
    let (shapes, diagrams) = (read("shapes.npy")?, read("diagrams.npy")?);
    let &[count, columns] = shapes.grid().axes() else {
        return Err(refuse("shapes.npy", "is no table"));
    };
    if columns < PARAMETERS {
        return Err(refuse("shapes.npy", "has fewer columns than parameters"));
    }
    let (rows, rest) = diagrams.as_slice().as_chunks::<4>();
    if !rest.is_empty() || diagrams.grid().axes().last() != Some(&4) {
        return Err(refuse("diagrams.npy", "has not four columns"));
    }
    let mut known = Vec::with_capacity(count);
    for own in rows.chunk_by(|a, b| a[0] == b[0]) {
        let n = own[0][0] as usize;
        if own[0][0] != known.len() as f64 || n >= count {
            return Err(refuse("diagrams.npy", "does not follow the shapes of shapes.npy"));
        }
        let cells: Vec<[f64; 3]> = own.iter().map(|r| [r[1], r[2], r[3]]).collect();
        let parameters: [f64; 6] = std::array::from_fn(|k| shapes.as_slice()[n * columns + k]);
        known.push((parameters, cloud(&cells)?));
    }
    if known.is_empty() {
        return Err(refuse("diagrams.npy", "has no shape"));
    }
    Ok(known)
}

impl Inference {
    fn drawing(&self) -> bool {
        self.given.is_none()
            && self.draws.members.len() < self.config.count
            && self.draws.drawn < 20 * self.config.count
    }

    fn rank(&mut self) -> Result<()> {
        let own = self.draws.members.iter().map(|m| (m.parameters, &m.diagram));
        let given = self.given.iter().flatten().map(|(parameters, cloud)| (*parameters, cloud));
        let all: Vec<([f64; 6], &PointCloud<2>)> = given.chain(own).collect();
        let distance = |(parameters, cloud): &([f64; 6], &PointCloud<2>)| {
            let other = self.transport.prepare(cloud)?;
            let distance = self.transport.divergence(&self.wanted, &other).abs().sqrt();
            Ok((*parameters, distance))
        };
        let ranked: Result<Vec<([f64; 6], f64)>> = all.par_iter().map(distance).collect();
        let mut ranked = ranked?;
        ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
        ranked.truncate(self.config.nearest);
        self.nearest = ranked;
        Ok(())
    }

    fn start_search(&mut self) -> Result<()> {
        if self.nearest.is_empty() {
            return Err(Error::config("count", "the atlas has no shape"));
        }
        let nearest: Vec<[f64; 6]> = self.nearest.iter().map(|n| n.0).collect();
        self.search = Some(Search::new(&self.config, &nearest, self.query.mass));
        Ok(())
    }

    /// A generation, or the proof after the last.
    fn go_on(&mut self, search: &mut Search) -> Result<Status> {
        let Self { config, wanted, transport, seed, .. } = &*self;
        let target = Target { config, wanted, transport, seed: *seed };
        if search.told.is_empty() || (search.generations() as u64) < config.generations {
            search.advance(target)?;
            return Ok(Status::Running);
        }
        self.found = Found::new(search, target)?;
        Ok(if self.found.is_some() { Status::Done } else { Status::NotConverged })
    }
}

impl Run for Inference {
    fn step(&mut self) -> Result<Status> {
        self.steps += 1;
        if self.drawing() {
            self.draws.advance(self.config.count, 20 * self.config.count)?;
            return Ok(Status::Running);
        }
        if self.nearest.is_empty() {
            self.rank()?;
            self.start_search()?;
            return Ok(Status::Running);
        }
        if let Some(mut search) = self.search.take() {
            let status = self.go_on(&mut search);
            self.search = Some(search);
            return status;
        }
        Ok(Status::NotConverged)
    }

    fn iterations(&self) -> u64 {
        self.steps
    }

    fn max_iterations(&self) -> u64 {
        let draws = if self.given.is_some() { 0 } else { 20 * self.config.count as u64 / 8 + 1 };
        draws + self.config.generations + 3
    }

    fn expected_iterations(&self) -> u64 {
        let draws = if self.given.is_some() { 0 } else { self.config.count as u64 / 4 };
        draws + self.config.generations + 3
    }

    fn config(&self) -> toml::Table {
        crate::to_table(&self.config)
    }

    fn metrics(&self) -> Vec<Metric> {
        let mut metrics = vec![
            Metric::new("shape_mass", self.query.mass, "1"),
            Metric::new("shape_area_density", self.query.area, "1/length"),
        ];
        if let Some((_, distance)) = self.nearest.first() {
            metrics.push(Metric::new("nearest_distance", *distance, "1/length"));
        }
        if let Some(found) = &self.found {
            metrics.push(Metric::new("distance", found.distance, "1/length"));
            metrics.push(Metric::new("distance_other_noise", found.again, "1/length"));
            metrics.push(Metric::new("distance_of_noises", found.floor, "1/length"));
            metrics.push(Metric::new("a20", 1.0, "1"));
            for (name, value) in NAMES.iter().zip(found.parameters) {
                metrics.push(Metric::new(name, value, "1"));
            }
            for (name, [low, high]) in NAMES.iter().zip(found.ranges) {
                metrics.push(Metric::new(&format!("{name}_low"), low, "1"));
                metrics.push(Metric::new(&format!("{name}_high"), high, "1"));
            }
        }
        metrics
    }

    fn observe(&self) -> Vec<Metric> {
        let generations = self.search.as_ref().map_or(0, Search::generations);
        let near = self.nearest.first().map_or(f64::NAN, |n| n.1);
        let best = self.search.as_ref().and_then(Search::best).map_or(near, |b| b.distance);
        vec![
            Metric::new("shapes", self.draws.members.len() as f64, "1"),
            Metric::new("generations", generations as f64, "1"),
            Metric::new("best_distance", best, "1/length"),
        ]
    }

    fn artifacts(&self) -> Vec<Artifact> {
        view::artifacts(&self.query, &self.nearest, self.search.as_ref(), self.found.as_ref())
    }

    fn frame(&self) -> Option<Image> {
        None
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = vec![format!("the shape is {}", self.query.note)];
        let [low, high] = self.config.ranges.list()[PARAMETERS - 1];
        let mass = self.query.mass;
        if !(low..=high).contains(&mass) {
            notes.push(format!(
                "the shape's mass {mass:.3} is outside the atlas's range [{low}, {high}]"
            ));
        }
        if let Some(search) = &self.search {
            let ended = search.generations() as u64 >= self.config.generations;
            match &self.found {
                Some(found) => notes.extend(found.notes(search)),
                None if ended => notes.push(proof::refused(search)),
                None => {}
            }
        }
        notes
    }

    fn save(&self) -> State {
        let mut state = State::default();
        self.draws.save(&mut state);
        state.put_u64("steps", &[self.steps]);
        let nearest: Vec<f64> =
            self.nearest.iter().flat_map(|(p, d)| p.iter().copied().chain([*d])).collect();
        state.put_f64("nearest", &nearest);
        let told = self.search.as_ref().map_or_else(Vec::new, |s| s.told.concat());
        let lengths = self.search.iter().flat_map(|s| s.told.iter().map(|v| v.len() as u64));
        state.put_f64("told", &told);
        state.put_u64("told_lengths", &lengths.collect::<Vec<u64>>());
        state
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        self.draws.restore(state)?;
        self.steps = state.one_u64("steps")?;
        let (rows, rest) = state.all_f64("nearest")?.as_chunks::<7>();
        if !rest.is_empty() {
            return Err(Error::Checkpoint("`nearest` has half a row".into()));
        }
        self.nearest =
            rows.iter().map(|row| (std::array::from_fn(|k| row[k]), row[PARAMETERS])).collect();
        if self.nearest.is_empty() {
            return Ok(());
        }
        self.start_search()?;
        let mut told = state.all_f64("told")?;
        for &length in state.all_u64("told_lengths")? {
            let Some((values, rest)) = told.split_at_checked(length as usize) else {
                return Err(Error::Checkpoint("`told` has half a generation".into()));
            };
            told = rest;
            if let Some(search) = &mut self.search {
                search.repeat(&self.config, self.seed, values.to_vec())?;
            }
        }
        if !told.is_empty() {
            return Err(Error::Checkpoint("`told` is longer than its generations".into()));
        }
        Ok(())
    }
}
