//! The optimizers behind one door.

use super::{
    config::{Config, Objective, Optimizer, Rules},
    design::Design,
};
use crate::{Error, Result};
use serde::{Serialize, de::DeserializeOwned};
use solvers::optimize::{
    Artificial, Bounds, Gcmma, GcmmaConfig, Mma, MmaConfig, OcConfig, OptimalityCriteria, Verdict,
};

/// Functions of a design and their gradients: the greatest of `objectives` is made small
/// while `volume <= target`.
pub(super) struct Functions {
    /// Value and gradient of each objective.
    pub(super) objectives: Vec<(f64, Vec<f64>)>,
    /// Mean density less its target, and its gradient.
    pub(super) volume: (f64, Vec<f64>),
}

impl Functions {
    /// Room for `count` objectives of `n` variables.
    pub(super) fn new(count: usize, n: usize) -> Self {
        Self { objectives: vec![(0.0, vec![0.0; n]); count], volume: (0.0, vec![0.0; n]) }
    }

    /// The greatest objective; NaN if one of them is.
    pub(super) fn greatest(&self) -> f64 {
        let values = self.objectives.iter().map(|(f, _)| *f);
        values.fold(f64::NEG_INFINITY, |a, f| if f.is_nan() { f } else { a.max(f) })
    }
}

/// What updates the design.
pub(super) enum Update {
    Oc(Box<OptimalityCriteria>),
    Mma(Box<Mma>),
    Gcmma(Box<Gcmma>),
}

impl Update {
    /// `objectives` functions of which the greatest counts.
    pub(super) fn new(
        config: &Config,
        design: &Design,
        n: usize,
        objectives: usize,
    ) -> Result<Self> {
        let mut bounds = Bounds::uniform(n, design.least(), 1.0)?;
        for element in 0..n {
            if let Some(value) = design.fixed(element) {
                bounds.fix(element, value)?;
            }
        }
        let artificial = || match objectives {
            1 => Artificial::standard(1),
            count => Artificial::min_max(count, 1),
        };
        match config.optimizer {
            Optimizer::Oc => {
                let by = |what: &str| {
                    let reason = format!("`oc` cannot make {what} small; choose `mma` or `gcmma`");
                    Err(Error::config("optimizer", reason))
                };
                if objectives > 1 {
                    return by("the greatest of several objectives");
                }
                if config.objective == Objective::Stress {
                    return by("stresses");
                }
                let rules = match config.rules {
                    Rules::Lines99 => OcConfig::top99(),
                    Rules::Lines88 => OcConfig::top88(),
                };
                // Where more material does harm (mechanisms, weight) the slope's sign is not given.
                let weight = !config.problem.body_force.is_empty();
                let open = config.objective == Objective::Displacement || weight;
                let floor = open.then_some(1e-10);
                let oc = OcConfig {
                    move_limit: config.move_limit,
                    damping: config.damping,
                    floor,
                    ..rules
                };
                Ok(Self::Oc(Box::new(OptimalityCriteria::new(bounds, oc)?)))
            }
            Optimizer::Mma => {
                let mut mma = MmaConfig::default();
                mma.limits.move_limit = config.move_limit;
                Ok(Self::Mma(Box::new(Mma::new(bounds, artificial(), mma)?)))
            }
            Optimizer::Gcmma => {
                let mut gcmma = GcmmaConfig::default();
                gcmma.limits.move_limit = config.move_limit;
                Ok(Self::Gcmma(Box::new(Gcmma::new(bounds, artificial(), gcmma)?)))
            }
        }
    }

    /// The next design by moving asymptotes; `scale` brings the objectives to the order of 10,
    /// `evaluate` gives objectives and volume of a trial.
    pub(super) fn moving_asymptotes(
        &mut self,
        x: &[f64],
        scale: f64,
        functions: &Functions,
        mut evaluate: impl FnMut(&[f64]) -> Result<(Vec<f64>, f64)>,
    ) -> Result<Vec<f64>> {
        // The greatest of several is at least 0 in the method: objectives that may be
        // negative are lifted, by as much for a trial as for the point it starts from.
        let size = functions.objectives.iter().map(|(f, _)| (f * scale).abs()).fold(0.0, f64::max);
        let lift = Lift { scale, offset: 1.0 + 3.0 * size };
        let Packed { f0, df0, g, dg } = &Packed::new(functions, lift);
        match self {
            Self::Oc(_) => Err(Error::config("optimizer", "`oc` has no asymptotes")),
            Self::Mma(mma) => Ok(mma.step(x, *f0, df0, g, dg)?.to_vec()),
            Self::Gcmma(gcmma) => {
                let mut trial = gcmma.propose(x, *f0, df0, g, dg)?.to_vec();
                loop {
                    let (objectives, volume) = evaluate(&trial)?;
                    let (f0, g) = Packed::values(&objectives, volume, lift);
                    if gcmma.accept(f0, &g)? != Verdict::Tighten {
                        return Ok(trial);
                    }
                    trial = gcmma.trial().map(<[f64]>::to_vec).unwrap_or(trial);
                }
            }
        }
    }

    /// The state, as text that keeps every bit.
    pub(super) fn save(&self) -> Vec<u8> {
        match self {
            Self::Oc(_) => Vec::new(),
            Self::Mma(mma) => text(mma.as_ref()),
            Self::Gcmma(gcmma) => text(gcmma.as_ref()),
        }
    }

    pub(super) fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        match self {
            Self::Oc(_) => {}
            Self::Mma(mma) => **mma = parse(bytes)?,
            Self::Gcmma(gcmma) => **gcmma = parse(bytes)?,
        }
        Ok(())
    }
}

fn text(value: &impl Serialize) -> Vec<u8> {
    // Structs of numbers and lists always serialize.
    toml::to_string(value).unwrap_or_default().into_bytes()
}

fn parse<T: DeserializeOwned>(bytes: &[u8]) -> Result<T> {
    let text = std::str::from_utf8(bytes).map_err(|error| Error::Checkpoint(error.to_string()))?;
    toml::from_str(text).map_err(|error| Error::Checkpoint(error.to_string()))
}

/// How objectives are brought to the range that the methods like.
#[derive(Clone, Copy)]
struct Lift {
    scale: f64,
    /// Added to each of several objectives.
    offset: f64,
}

/// The functions as the methods take them.
struct Packed {
    f0: f64,
    df0: Vec<f64>,
    g: Vec<f64>,
    dg: Vec<f64>,
}

impl Packed {
    fn values(objectives: &[f64], volume: f64, lift: Lift) -> (f64, Vec<f64>) {
        match objectives {
            [only] => (only * lift.scale, vec![volume]),
            several => {
                let lifted = several.iter().map(|f| f * lift.scale + lift.offset);
                (0.0, lifted.chain([volume]).collect())
            }
        }
    }

    fn new(functions: &Functions, lift: Lift) -> Self {
        let values: Vec<f64> = functions.objectives.iter().map(|(f, _)| *f).collect();
        let (f0, g) = Self::values(&values, functions.volume.0, lift);
        let scaled =
            |gradient: &[f64]| gradient.iter().map(|d| d * lift.scale).collect::<Vec<f64>>();
        let volume = functions.volume.1.iter().copied();
        match functions.objectives.as_slice() {
            [(_, gradient)] => Self { f0, df0: scaled(gradient), g, dg: volume.collect() },
            several => {
                let gradients = several.iter().flat_map(|(_, gradient)| scaled(gradient));
                let dg = gradients.chain(volume).collect();
                Self { f0, df0: vec![0.0; functions.volume.1.len()], g, dg }
            }
        }
    }
}
