//! A pattern of the class by itself: its concentrations, scale, and how the species go together.

use super::super::class::Class;
use crate::{Artifact, Colors, Context, Error, Inputs, Result, Status};
use solvers::texture::{Descriptor, Masked};
use toml::{Table, Value};

/// Classes of concentration over which the other species are averaged.
const BINS: usize = 24;

/// What one run of a class shows.
pub(super) struct Reference {
    /// Configuration of the run.
    pub(super) config: Table,
    /// Concentrations of the species whose border is the ink's, sorted.
    pub(super) sorted: Vec<f64>,
    /// Its concentration at the border, and whether ink is below.
    pub(super) level: f64,
    pub(super) below: bool,
    /// Its mean in paper and in ink.
    pub(super) means: [f64; 2],
    /// Its standard deviation.
    pub(super) deviation: f64,
    /// Wavelength (cells), if the run has one.
    pub(super) wavelength: Option<f64>,
    /// Mean of each species, in the order of the kinetics, by class of concentration.
    by_class: Vec<[f64; BINS]>,
    /// Index of the ink's species.
    pub(super) species: usize,
}

impl Reference {
    /// Runs `class` at `point` to its end.
    pub(super) fn new(
        class: &Class,
        point: &[f64],
        seed: u64,
        inputs: &dyn Inputs,
    ) -> Result<Self> {
        let context = Context { seed, inputs, memory: 1 << 30 };
        let mut run = (class.model.start)(&class.configure(point)?, &context)?;
        while run.step()? == Status::Running {}
        let config = run.config();
        let mut names = Vec::new();
        let mut fields = Vec::new();
        for artifact in run.artifacts() {
            if let Artifact::Image(image) = artifact
                && image.colors == Colors::Sequential
                && !image.name.contains('-')
            {
                names.push(image.name);
                fields.push(image.field);
            }
        }
        let ink = config.get("ink").and_then(Value::as_table);
        let wanted = ink.and_then(|ink| ink.get("species")).and_then(Value::as_str);
        let below = ink.and_then(|ink| ink.get("below")).and_then(Value::as_bool);
        let species = names.iter().position(|name| Some(name.as_str()) == wanted);
        let (Some(species), Some(below)) = (species, below) else {
            return Err(Error::config("ink", "the model shows no concentration of its species"));
        };
        let c = &fields[species];
        let (mean, deviation) = c.mean_std();
        let level = ink.and_then(|ink| ink.get("level")).and_then(Value::as_float);
        let level = level.unwrap_or(mean);
        let is_ink: Vec<bool> = c.as_slice().iter().map(|&c| (c < level) == below).collect();
        let [_, ny, nx] = c.grid().shape();
        let all = vec![true; is_ink.len()];
        let wavelength = Descriptor::new(&Masked::new([ny, nx], &is_ink, &all)?)
            .map(|descriptor| descriptor.wavelength);
        let mut means = [0.0, 1.0].map(|side| {
            let own = c.as_slice().iter().zip(&is_ink);
            let own = own.filter(|(_, ink)| f64::from(u8::from(**ink)) == side);
            let (sum, count) = own.fold((0.0, 0.0), |(s, n), (c, _)| (s + c, n + 1.0));
            if count > 0.0 { sum / count } else { f64::NAN }
        });
        if means.iter().any(|mean| mean.is_nan()) || deviation.is_nan() || deviation <= 0.0 {
            let reason = format!("`{}` makes no pattern at these parameters", class.name);
            return Err(Error::config("parameters", reason));
        }
        if below != (means[1] < means[0]) {
            means.swap(0, 1);
        }
        let mut sorted = c.as_slice().to_vec();
        sorted.sort_by(f64::total_cmp);
        let by_class = fields.iter().map(|f| averages(&sorted, c.as_slice(), f.as_slice()));
        let by_class = by_class.collect();
        Ok(Self { config, level, below, means, deviation, wavelength, by_class, species, sorted })
    }

    /// Number of species.
    pub(super) fn count(&self) -> usize {
        self.by_class.len()
    }

    /// Mean concentration of species `s` where the ink's species has concentration `c`.
    pub(super) fn mean(&self, s: usize, c: f64) -> f64 {
        if s == self.species {
            return c;
        }
        let (low, high) = (self.sorted[0], self.sorted[self.sorted.len() - 1]);
        let x = ((c - low) / (high - low) * BINS as f64 - 0.5).clamp(0.0, BINS as f64 - 1.0);
        let n = (x as usize).min(BINS - 2);
        let t = x - n as f64;
        (1.0 - t) * self.by_class[s][n] + t * self.by_class[s][n + 1]
    }

    /// Concentration below which the share `rank` of the pattern lies.
    pub(super) fn quantile(&self, rank: f64) -> f64 {
        let x = rank.clamp(0.0, 1.0) * (self.sorted.len() - 1) as f64;
        let n = (x as usize).min(self.sorted.len() - 2);
        let t = x - n as f64;
        (1.0 - t) * self.sorted[n] + t * self.sorted[n + 1]
    }
}

/// Means of `other` by equal classes of `c`; empty classes repeat the one before.
fn averages(sorted: &[f64], c: &[f64], other: &[f64]) -> [f64; BINS] {
    let (low, high) = (sorted[0], sorted[sorted.len() - 1]);
    let mut sums = [(0.0, 0.0); BINS];
    for (c, v) in c.iter().zip(other) {
        let n = (((c - low) / (high - low) * BINS as f64) as usize).min(BINS - 1);
        sums[n] = (sums[n].0 + v, sums[n].1 + 1.0);
    }
    let mut last = other.iter().sum::<f64>() / other.len() as f64;
    sums.map(|(sum, count)| {
        if count > 0.0 {
            last = sum / count;
        }
        last
    })
}
