//! FitzHugh and Nagumo's equations where the resting state is unstable to patterns (Turing regime).

use super::{Kinetics, explicit_double, range, reaction};
use crate::Preset;
use solvers::diffusion::explicit::{Cell, Real};

/// The reaction of one cell.
pub struct FitzHughNagumo;

impl Cell<2, 3> for FitzHughNagumo {
    #[inline(always)]
    fn rates<T: Real>([u, v]: [T; 2], [epsilon, gamma, delta]: [T; 3]) -> [T; 2] {
        [u - u * u * u - v, epsilon * (u - gamma * v - delta)]
    }
}

/// Registry entry.
pub static KINETICS: Kinetics = Kinetics {
    name: "fitzhugh-nagumo",
    equations: "u: u - u^3 - v; v: epsilon (u - gamma v - delta)",
    source: "FitzHugh 1961; Nagumo et al. 1962; Hagberg and Meron 1994",
    species: &["u", "v"],
    parameters: &[
        range("epsilon", 0.0, 100.0),
        range("gamma", 0.0, 10.0),
        range("delta", -10.0, 10.0),
    ],
    defaults: DEFAULTS,
    presets: PRESETS,
    explicit: explicit_double::<FitzHughNagumo, 2, 3>,
    linear: None,
    reaction: reaction::<FitzHughNagumo, 2, 3>,
};

const DEFAULTS: &str = r#"
size = [128, 128]
iterations = 8000
dt = 0.1
boundary = "periodic"
clamp = false
diffusion = { u = 0.5, v = 3.0 }
initial = { u = 0.0, v = 0.0 }
ink = { species = "u", level = "mean", below = false }
curve = { speed = "off" }
perturbation = [{ target = "u", kind = "noise", amplitude = 0.01, region = "all" }]
"#;

pub(crate) const PRESETS: &[Preset] = &[
    Preset {
        name: "fitzhugh-nagumo-labyrinth",
        about: "Symmetric labyrinth",
        config: "kinetics = 'fitzhugh-nagumo'\n\
                 parameters = { epsilon = 2.0, gamma = 0.75, delta = 0.0 }",
    },
    Preset {
        name: "fitzhugh-nagumo-holes",
        about: "Holes and stripes side by side",
        config: "kinetics = 'fitzhugh-nagumo'\n\
                 parameters = { epsilon = 2.0, gamma = 0.75, delta = 0.02 }",
    },
];
