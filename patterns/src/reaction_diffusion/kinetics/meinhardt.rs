//! Meinhardt's five chemicals: two states that exclude each other locally and need each other
//! at a distance, so that stripes form. Constants as in Turk's textures: c = .01.

use super::{Kinetics, explicit_double, range, reaction};
use crate::Preset;
use solvers::diffusion::explicit::{Cell, Real};

/// The reaction of one cell.
pub struct Meinhardt;

impl Cell<5, 4> for Meinhardt {
    #[inline(always)]
    fn rates<T: Real>([g1, g2, s1, s2, r]: [T; 5], [alpha, beta, gamma, c]: [T; 4]) -> [T; 5] {
        let (made1, made2) = (c * s2 * g1 * g1, c * s1 * g2 * g2);
        [
            made1 / r - alpha * g1,
            made2 / r - alpha * g2,
            gamma * (g1 - s1),
            gamma * (g2 - s2),
            made1 + made2 - beta * r,
        ]
    }
}

/// Registry entry.
pub static KINETICS: Kinetics = Kinetics {
    name: "meinhardt",
    equations: "g1: c s2 g1^2 / r - alpha g1; g2: c s1 g2^2 / r - alpha g2; s1: gamma (g1 - s1); s2: gamma (g2 - s2); r: c s2 g1^2 + c s1 g2^2 - beta r",
    source: "Meinhardt 1982, chapter 12; Turk 1991",
    species: &["g1", "g2", "s1", "s2", "r"],
    parameters: &[
        range("alpha", 0.0, 1.0),
        range("beta", 0.0, 1.0),
        range("gamma", 0.0, 1.0),
        range("c", 0.0, 1.0),
    ],
    defaults: DEFAULTS,
    presets: PRESETS,
    explicit: explicit_double::<Meinhardt, 5, 4>,
    linear: None,
    reaction: reaction::<Meinhardt, 5, 4>,
};

const DEFAULTS: &str = r#"
size = [80, 80]
iterations = 8000
dt = 0.5
parameters = { alpha = 0.04, beta = 0.06, gamma = 0.04, c = 0.01 }
diffusion = { g1 = 0.009, g2 = 0.009, s1 = 0.2, s2 = 0.2, r = 0.0 }
initial = { g1 = 0.75, g2 = 0.75, s1 = 0.75, s2 = 0.75, r = 0.140625 }
ink = { species = "g1", level = 0.75, below = false }
curve = { speed = "off" }
"#;

pub(crate) const PRESETS: &[Preset] = &[
    Preset {
        name: "meinhardt-stripes",
        about: "Clean stripes that spread from an edge",
        config: "kinetics = 'meinhardt'\n\
                 perturbation = [{ target = 'g1', kind = 'add', amplitude = 0.02, region = 'edge' }]",
    },
    Preset {
        name: "meinhardt-patches",
        about: "Irregular patches from noise",
        config: "kinetics = 'meinhardt'\n\
                 perturbation = [{ target = 'g1', kind = 'noise', amplitude = 0.02, region = 'all' }]",
    },
];
