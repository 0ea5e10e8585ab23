//! Which model made a pattern of which only a part is seen, and with which parameters.
//!
//! [`normalize()`] turns a picture into ink and paper, [`Identifier::identify`] compares it
//! with the classes of a [`Database`]: classes whose seed is free by the statistics of
//! [`solvers::texture`], against a [`Calibration`]; classes without chance pixel by pixel.

mod calibration;
mod candidate;
mod class;
mod classify;
mod database;
pub mod degrade;
mod detect;
pub mod fill;
pub mod foreign;
mod normalize;
mod pixels;
mod place;
mod quality;
mod refine;
pub mod scores;

pub use calibration::{Calibration, PATTERNS, built_in, samples};
pub use candidate::{Ink, simulate};
pub use class::{Class, Range, Values};
pub use classify::{Classifier, Ranked, Sample};
pub use database::{BUILT_IN, Database};
pub use detect::{Detection, Occluder, detect};
pub use normalize::{Normal, at_mean, grey_levels, normalize, reduced};
pub use pixels::{Agreement, agree};
pub use place::Placement;
pub use quality::Quality;
pub use refine::{Generation, Refined, Refiner, Tried};

use crate::{Error, Inputs, Result};
use solvers::{Field, texture::Descriptor};

/// Least correlation at which a class without chance is taken: pictures of other classes and
/// of no class stay below.
const LEAST_CORRELATION: f64 = 0.72;

/// By how much a difference of two structures' correlations speaks for one of them (logarithm of
/// the odds per unit).
const STEEPNESS: f64 = 30.0;

/// A class's own distances, times the first, limit how far its pictures may lie; not less
/// than the second nor more than the third, which the nearest foreign pictures exceed.
const LIMIT: (f64, f64, f64) = (1.5, 70.0, 320.0);

/// Part of a class's calibration that its limit lets through before the factor.
const KEPT: f64 = 0.98;

/// Pixels to a wavelength that pictures keep when they are looked at in fewer pixels, as coarse as
/// the finest classes are, and the least number of rows and columns.
const COARSE: (f64, usize) = (8.0, 64);

/// Compares pictures with a database.
pub struct Identifier {
    database: Database,
    /// Classes by statistics, in the order of the classifier.
    free: Vec<usize>,
    classifier: Classifier,
    samples: Vec<Sample>,
    limits: Vec<f64>,
    candidates: pixels::Candidates,
}

/// What a picture was found to be.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Every class that was compared, the likeliest first.
    pub ranking: Vec<Match>,
    /// Whether none of the classes made it: the first of the ranking is too far away.
    pub none: bool,
    /// Wavelength of the visible part (pixels), if it has statistics.
    pub wavelength: Option<f64>,
}

impl Answer {
    /// Orders the first classes of the ranking, structures whose parameters were searched, by the
    /// pixel errors `costs` that they came to, and shares their confidence out anew.
    pub fn decide(&mut self, costs: &[f64]) {
        let searched = costs.len().min(self.ranking.len());
        let total: f64 = self.ranking[..searched].iter().map(|m| m.confidence).sum();
        let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
        // Where the two colours are about as frequent, a pixel error of e lowers the correlation
        // by 2 e.
        let odds: Vec<f64> =
            costs.iter().map(|cost| libm::exp(-2.0 * STEEPNESS * (cost - least))).collect();
        let sum: f64 = odds.iter().sum();
        let mut order: Vec<usize> = (0..searched).collect();
        order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
        let decided: Vec<Match> = order
            .iter()
            .map(|&n| Match { confidence: total * odds[n] / sum, ..self.ranking[n].clone() })
            .collect();
        self.ranking[..searched].clone_from_slice(&decided);
    }
}

/// A class of an [`Answer`].
#[derive(Clone, Debug)]
pub struct Match {
    /// Index in the database.
    pub class: usize,
    /// Probability of the class if one of the classes made the picture.
    pub confidence: f64,
    /// Squared distance of the statistics over the class's limit, or for a class without
    /// chance (1 - correlation) over its limit: above 1 the class is ruled out.
    pub distance: f64,
    /// The squared distance itself (scatters of the calibration); none for a class without chance.
    pub square: Option<f64>,
    /// Whether ink and paper are exchanged.
    pub inverted: bool,
    /// Shares of the class's ranges that fit best.
    pub point: Vec<f64>,
    /// How far the picture is turned from the class's frame (radians), where there is one.
    pub angle: Option<f64>,
}

/// A picture in as many pixels as suit the class that was found.
pub struct Scaled {
    /// Pixels of the given picture along a side of one of these.
    pub factor: usize,
    /// The picture.
    pub picture: Field,
    /// What is visible.
    pub visible: Vec<bool>,
    /// Its ink and paper.
    pub normal: Normal,
    /// What it was found to be.
    pub answer: Answer,
}

impl Identifier {
    /// Prepares the comparison with every class of `database`.
    ///
    /// # Errors
    /// [`Error::Config`] if a class with a free seed is not in `calibration`.
    pub fn new(database: Database, calibration: &Calibration) -> Result<Self> {
        let free: Vec<usize> =
            (0..database.classes.len()).filter(|&c| database.classes[c].free_seeds).collect();
        let classes: Vec<&Class> = free.iter().map(|&c| &database.classes[c]).collect();
        let samples = calibration.select(&classes);
        if let Some(class) = (0..classes.len()).find(|&c| !samples.iter().any(|s| s.class == c)) {
            let reason = format!("`{}` is not calibrated", classes[class].name);
            return Err(Error::config("calibration", reason));
        }
        let classifier = Classifier::new(&samples, classes.len())?;
        let limits = limits(&classifier, &samples, classes.len());
        let candidates = pixels::Candidates::new(database.classes.len());
        Ok(Self { database, free, classifier, samples, limits, candidates })
    }

    /// The classes.
    pub fn database(&self) -> &Database {
        &self.database
    }

    /// Splits a picture into ink and paper, at the mean of its grey levels if a class is nearer
    /// then, and compares it with every class.
    ///
    /// # Errors
    /// As [`normalize()`] and [`Identifier::identify`].
    pub fn identify_picture(
        &self,
        picture: &Field,
        visible: &[bool],
        inputs: &(dyn Inputs + Sync),
    ) -> Result<(Normal, Answer)> {
        let normal = normalize(picture, visible)?;
        let answer = self.identify(&normal, inputs)?;
        let Some(other) = at_mean(picture, &normal) else { return Ok((normal, answer)) };
        let second = self.identify(&other, inputs)?;
        let distance = |a: &Answer| a.ranking.first().map_or(f64::INFINITY, |m| m.distance);
        match distance(&second) < distance(&answer) {
            true => Ok((other, second)),
            false => Ok((normal, answer)),
        }
    }

    /// [`Identifier::identify_picture`] of a picture and, if a class made it, of it in fewer
    /// pixels, down to eight a wavelength: statistics are those of a class's own cells, so that
    /// a fine drawing of a coarse pattern resembles another class more. The nearest answer is
    /// taken; what no class made stays so, as with every scale one would seem nearer by chance.
    ///
    /// # Errors
    /// As [`Identifier::identify_picture`].
    pub fn identify_at_scales(
        &self,
        picture: &Field,
        visible: &[bool],
        inputs: &(dyn Inputs + Sync),
    ) -> Result<Scaled> {
        let (normal, answer) = self.identify_picture(picture, visible, inputs)?;
        let square = |answer: &Answer| answer.ranking.first().filter(|_| !answer.none)?.square;
        let most = answer.wavelength.map_or(1, |wavelength| (wavelength / COARSE.0) as usize);
        let (own, seen) = (picture.clone(), visible.to_vec());
        let mut best = Scaled { factor: 1, picture: own, visible: seen, normal, answer };
        let [_, ny, nx] = picture.grid().shape();
        for factor in 2..=most.min(ny.min(nx) / COARSE.1) {
            let Some(least) = square(&best.answer) else { break };
            let (picture, visible) = reduced(picture, visible, factor)?;
            // Too little may be left to be seen.
            let Ok((normal, answer)) = self.identify_picture(&picture, &visible, inputs) else {
                break;
            };
            if square(&answer).is_some_and(|s| s < least) {
                best = Scaled { factor, picture, visible, normal, answer };
            }
        }
        Ok(best)
    }

    /// Compares the visible part of a picture with every class; runs the classes without
    /// chance whose frame has its proportions.
    ///
    /// # Errors
    /// What a model refuses or meets on its way.
    pub fn identify(&self, normal: &Normal, inputs: &(dyn Inputs + Sync)) -> Result<Answer> {
        let descriptor = Descriptor::new(&normal.masked()?);
        let mut ranking: Vec<Match> =
            descriptor.iter().flat_map(|d| self.by_statistics(d)).collect();
        let fixed: Vec<(usize, &Class)> =
            self.database.classes.iter().enumerate().filter(|(_, c)| !c.free_seeds).collect();
        let agreements = pixels::rank(normal, &fixed, &self.candidates, inputs)?;
        let family = |a: &Agreement| &self.database.classes[a.class].family;
        let other = agreements.iter().find(|a| family(a) != family(&agreements[0]));
        let second = other.map_or(0.0, |a| a.correlation);
        let certain = agreements.first().is_some_and(|a| a.correlation >= LEAST_CORRELATION);
        for (n, agreement) in agreements.into_iter().enumerate() {
            let c = agreement.correlation;
            // Its closeness to another family is what speaks against the first.
            let confidence = match (certain, n) {
                (true, 0) => 1.0 / (1.0 + libm::exp(-STEEPNESS * (c - second))),
                _ => 0.0,
            };
            ranking.push(Match {
                class: agreement.class,
                confidence,
                distance: (1.0 - c) / (1.0 - LEAST_CORRELATION),
                square: None,
                inverted: agreement.inverted,
                point: agreement.point,
                angle: Some(agreement.angle),
            });
        }
        if certain {
            let first = ranking.iter().filter(|m| m.angle.is_some()).map(|m| m.confidence);
            let rest = 1.0 - first.fold(0.0, f64::max);
            ranking.iter_mut().filter(|m| m.angle.is_none()).for_each(|m| m.confidence *= rest);
            ranking.sort_by_key(|m| m.angle.is_none());
        }
        let none = ranking.first().is_none_or(|m| m.distance > 1.0);
        Ok(Answer { ranking, none, wavelength: descriptor.map(|d| d.wavelength) })
    }

    /// The class of an answer.
    pub fn class(&self, found: &Match) -> &Class {
        &self.database.classes[found.class]
    }

    /// Estimates of the shares of a class's ranges, not held inside them: the summary statistics
    /// of a picture. Empty for a class without chance.
    pub fn summary(&self, class: usize, descriptor: &Descriptor, inverted: bool) -> Vec<f64> {
        let index = self.free.iter().position(|&c| c == class);
        index.map_or_else(Vec::new, |n| self.classifier.summary(n, inverted, &descriptor.values))
    }

    /// Standard error of the estimates of [`Identifier::summary`]; of a class without chance the
    /// half distance between the points that are run to rank it.
    pub fn deviations(&self, class: usize) -> Vec<f64> {
        match self.free.iter().position(|&c| c == class) {
            Some(n) => self.classifier.deviations(n, &self.samples),
            None => pixels::deviations(&self.database.classes[class]),
        }
    }

    fn by_statistics(&self, descriptor: &Descriptor) -> Vec<Match> {
        let ranked = self.classifier.rank(&descriptor.values);
        let found = ranked.into_iter().map(|r| Match {
            class: self.free[r.class],
            confidence: r.probability,
            distance: r.distance / self.limits[r.class],
            square: Some(r.distance),
            inverted: r.inverted,
            point: r.point,
            angle: None,
        });
        found.collect()
    }
}

/// How far pictures of each class may lie from it.
fn limits(classifier: &Classifier, samples: &[Sample], classes: usize) -> Vec<f64> {
    let mut distances = vec![Vec::new(); classes];
    for sample in samples {
        let own = classifier.rank(&sample.values).into_iter().find(|r| r.class == sample.class);
        distances[sample.class].extend(own.map(|r| r.distance));
    }
    let limit = |mut list: Vec<f64>| {
        list.sort_by(f64::total_cmp);
        let kept = list[((KEPT * list.len() as f64) as usize).min(list.len() - 1)];
        (LIMIT.0 * kept).clamp(LIMIT.1, LIMIT.2)
    };
    distances.into_iter().map(limit).collect()
}

#[cfg(test)]
mod tests;
