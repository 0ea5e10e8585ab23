//! The parameters of what was found, and its scores.

use super::Stages;
use anyhow::Result;
use patterns::{
    NoInputs,
    disocclusion::{
        Answer, Identifier, Ink, Match, Normal, Placement, Refined, Refiner,
        scores::{Score, by_iteration},
        simulate,
    },
};
use rayon::prelude::*;
use solvers::texture::{Descriptor, Masked};

/// Points of the curves of scores against iteration.
const SCORES: u64 = 60;

/// Generations of the search for the parameters of classes with and without chance.
const GENERATIONS: (u32, u32) = (5, 16);

/// Pixel error of a structure above which the next in the ranking are searched too, and how many.
const UNEXPLAINED: f64 = 0.005;
const RIVALS: usize = 2;

/// Generations after which a rival that is behind what the first had come to by then is left.
const RACE: usize = 4;

/// A picture that was compared with every class.
pub(super) struct Case<'a> {
    pub(super) identifier: &'a Identifier,
    pub(super) normal: &'a Normal,
    /// Wavelength of the picture (pixels), if it has statistics.
    pub(super) wavelength: Option<f64>,
    pub(super) seed: u64,
}

/// How long a search may be.
pub(super) struct Limits<'a> {
    /// Most generations, if not the usual.
    pub(super) generations: Option<u32>,
    pub(super) stages: &'a Stages,
    /// Whether there is time left.
    pub(super) time: &'a dyn Fn() -> bool,
}

/// What the search for parameters found, and how long it was.
pub(crate) struct Search {
    pub(crate) found: Refined,
    pub(crate) generations: u32,
    /// Candidates that were run.
    pub(crate) tried: usize,
    /// Least cost after each generation.
    costs: Vec<f64>,
}

impl Case<'_> {
    /// Searches the parameters of the first of the ranking. What is visible of two structures can
    /// look alike until their parameters are right: those that follow are searched too where the
    /// first does not explain the picture, and the ranking is put in the order of the errors.
    pub(super) fn refine(
        &self,
        answer: &mut Answer,
        limits: &Limits<'_>,
    ) -> Result<Option<Search>> {
        if answer.none || answer.ranking.is_empty() {
            return Ok(None);
        }
        let mut searches = vec![self.search(&answer.ranking[0], limits, &[])?];
        for rival in answer.ranking.iter().skip(1).take(RIVALS) {
            let unexplained = |s: &Search| s.found.cost.is_some_and(|cost| cost > UNEXPLAINED);
            let possible = rival.angle.is_some() && rival.distance <= 1.0;
            if !(possible && searches.iter().all(unexplained) && (limits.time)()) {
                break;
            }
            let search = self.search(rival, limits, &searches[0].costs)?;
            searches.push(search);
        }
        for (found, search) in answer.ranking.iter_mut().zip(&searches) {
            found.angle = search.found.angle;
        }
        if searches.len() > 1 {
            let cost = |s: &Search| s.found.cost.unwrap_or(f64::INFINITY);
            answer.decide(&searches.iter().map(cost).collect::<Vec<_>>());
            searches.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        }
        Ok(searches.into_iter().next())
    }

    /// Generations of the search for parameters, while there is time and it is not behind
    /// `others` in the race.
    fn search(&self, found: &Match, limits: &Limits<'_>, others: &[f64]) -> Result<Search> {
        let mut search = Refiner::new(self.identifier, self.normal, found, self.seed)?;
        let class = self.identifier.class(found);
        let usual = if class.free_seeds { GENERATIONS.0 } else { GENERATIONS.1 };
        let mut costs: Vec<f64> = Vec::new();
        for n in 0..limits.generations.unwrap_or(usual) {
            let race = costs.get(RACE - 1).zip(others.get(RACE - 1));
            let behind = race.is_some_and(|(own, other)| own > other);
            if !(limits.time)() || behind {
                break;
            }
            limits.stages.say(&format!(
                "searching parameters of {}, generation {}",
                class.name,
                n + 1
            ));
            limits.stages.check()?;
            let Some(generation) = search.step(&NoInputs)? else { break };
            costs.push(generation.best);
        }
        let tried = search.tried().len();
        Ok(Search { found: search.finish(), generations: costs.len() as u32, tried, costs })
    }

    /// How the run of a class lies in the picture.
    fn placement(&self, found: &Match, pattern: &Ink) -> Result<Placement> {
        let mut placement = Placement::of(found);
        if self.identifier.class(found).free_seeds {
            let all = vec![true; pattern.ink.len()];
            let own = Descriptor::new(&Masked::new(pattern.shape, &pattern.ink, &all)?);
            let pair = own.zip(self.wavelength);
            let ratio = pair.map_or(1.0, |(own, picture)| own.wavelength / picture);
            // Pictures at the class's own scale keep their pixels.
            placement.scale = if (ratio - 1.0).abs() < 0.1 { 1.0 } else { ratio };
        }
        Ok(placement)
    }

    /// The paper's scores along the run of a class, about [`SCORES`] and that of its end.
    pub(super) fn scores(&self, found: &Match, point: &[f64]) -> Result<Vec<Score>> {
        let class = self.identifier.class(found);
        let placement = if class.free_seeds {
            self.placement(found, &simulate(class, point, self.seed, &NoInputs)?)?
        } else {
            Placement::of(found)
        };
        Ok(by_iteration(self.normal, placement, (class, point, self.seed), SCORES, &NoInputs)?)
    }

    /// The last scores of the first `count` classes of the ranking.
    pub(super) fn candidates(&self, ranking: &[Match], count: usize) -> Result<Vec<Score>> {
        let last = |found: &Match| {
            let class = self.identifier.class(found);
            let end = simulate(class, &found.point, self.seed, &NoInputs)?;
            let placed = self.placement(found, &end)?.place(&end, self.normal.shape);
            Ok(Score::new(self.normal, &placed, 0))
        };
        ranking[..count.min(ranking.len())].par_iter().with_max_len(1).map(last).collect()
    }
}
