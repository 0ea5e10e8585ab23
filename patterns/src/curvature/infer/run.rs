//! The stages of an inference: atlas, nearest shapes, search, proof.

use super::config::Config;
use super::query::Query;
use super::search::{self, Search};
use super::view;
use crate::curvature::atlas::{Draws, NAMES, cloud};
use crate::curvature::grow::Shape;
use crate::{Artifact, Context, Error, Image, Metric, Result, Run, State, Status};
use rayon::prelude::*;
use solvers::transport::{CoarseSinkhorn, PointCloud, PreparedCloud};

/// Columns of `shapes.npy` of an atlas that are parameters.
const PARAMETERS: usize = 6;

/// Shapes that are grown together: candidates of a generation, or draws of an atlas.
const TOGETHER: usize = 8;

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

/// What the parameters that were found grow.
pub(super) struct Found {
    pub(super) parameters: [f64; 6],
    pub(super) shape: Box<Shape>,
    /// Distance from the given shape.
    pub(super) distance: f64,
    /// Distance from the given shape if it grows from other noise.
    pub(super) again: f64,
    /// Distance between the shapes of the two noises.
    pub(super) floor: f64,
}

/// Starts a run, its checks before any work.
pub(super) fn begin(table: &toml::Table, context: &Context<'_>) -> Result<Box<dyn Run>> {
    let config: Config = crate::from_table(table)?;
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
        let Some(&(start, _)) = self.nearest.first() else {
            return Err(Error::config("count", "the atlas has no shape"));
        };
        self.search = Some(Search::new(&self.config, start, self.seed)?);
        Ok(())
    }

    /// Grows the parameters that were found, from two noises.
    fn prove(&mut self) -> Result<()> {
        let Some(&(mut first, _)) = self.nearest.first() else { return Ok(()) };
        first[PARAMETERS - 1] = self.query.mass;
        let mut near = (first, self.grown_distance(first)?);
        if let Some((point, value)) = self.search.as_ref().and_then(Search::best)
            && value < near.1
        {
            near = (Search::parameters(&self.config, point, self.query.mass), value);
        }
        let parameters = near.0;
        let grow = |seed: u64| search::grow(&self.config, parameters, seed);
        let (one, two) = rayon::join(|| grow(self.seed), || grow(self.seed.wrapping_add(1)));
        let (Some(shape), Some(other)) = (one?, two?) else { return Ok(()) };
        let distance = |shape: &Shape, from: &PreparedCloud<2>| {
            search::distance(Some(shape), from, &self.transport, &self.config)
        };
        let own = self.transport.prepare(&shape.diagram)?;
        self.found = Some(Found {
            parameters,
            distance: distance(&shape, &self.wanted)?,
            again: distance(&other, &self.wanted)?,
            floor: distance(&other, &own)?,
            shape,
        });
        Ok(())
    }

    /// Distance of what some parameters grow from the given shape.
    fn grown_distance(&self, parameters: [f64; 6]) -> Result<f64> {
        let shape = search::grow(&self.config, parameters, self.seed)?;
        search::distance(shape.as_deref(), &self.wanted, &self.transport, &self.config)
    }

    fn generations(&self) -> u64 {
        self.search.as_ref().map_or(0, |search| search.told.len() as u64)
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
        if let Some(search) = &mut self.search
            && (search.told.len() as u64) < self.config.generations
        {
            let (wanted, mass) = (&self.wanted, self.query.mass);
            search.generation(&self.config, wanted, &self.transport, mass, self.seed)?;
            return Ok(Status::Running);
        }
        self.prove()?;
        Ok(if self.found.is_some() { Status::Done } else { Status::NotConverged })
    }

    fn iterations(&self) -> u64 {
        self.steps
    }

    fn max_iterations(&self) -> u64 {
        let draws = if self.given.is_some() { 0 } else { 20 * self.config.count as u64 / 8 + 1 };
        draws + self.config.generations + 2
    }

    fn expected_iterations(&self) -> u64 {
        let draws = if self.given.is_some() { 0 } else { self.config.count as u64 / 4 };
        draws + self.config.generations + 2
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
            if let Some(search) = &self.search {
                let spread = search.spread(&self.config, self.query.mass);
                for (name, value) in NAMES.iter().zip(spread) {
                    metrics.push(Metric::new(&format!("{name}_spread"), value, "1"));
                }
            }
        }
        metrics
    }

    fn observe(&self) -> Vec<Metric> {
        let near = self.nearest.first().map_or(f64::NAN, |n| n.1);
        let best = self.search.as_ref().and_then(Search::best).map_or(near, |b| b.1.min(near));
        vec![
            Metric::new("shapes", self.draws.members.len() as f64, "1"),
            Metric::new("generations", self.generations() as f64, "1"),
            Metric::new("best_distance", best, "1/length"),
        ]
    }

    fn artifacts(&self) -> Vec<Artifact> {
        let told = self.search.as_ref().map_or(&[][..], |search| &search.told);
        view::artifacts(&self.query, &self.nearest, told, self.found.as_ref())
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
        let population = self.search.as_ref().map_or(0, Search::population);
        state.put_f64("told", &told);
        state.put_u64("population", &[population as u64]);
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
        let population = state.one_u64("population")?.max(1) as usize;
        if let Some(search) = &mut self.search {
            for values in state.all_f64("told")?.chunks(population) {
                search.repeat(values.to_vec())?;
            }
        }
        Ok(())
    }
}
