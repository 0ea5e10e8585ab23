//! Schnakenberg's trimolecular reaction.

use super::{Kinetics, explicit_double, range, reaction};
use crate::Preset;
use solvers::diffusion::explicit::{Cell, Real};

/// The reaction of one cell.
pub struct Schnakenberg;

impl Cell<2, 2> for Schnakenberg {
    #[inline(always)]
    fn rates<T: Real>([u, v]: [T; 2], [a, b]: [T; 2]) -> [T; 2] {
        let reaction = u * u * v;
        [a - u + reaction, b - reaction]
    }
}

/// Registry entry.
pub static KINETICS: Kinetics = Kinetics {
    name: "schnakenberg",
    equations: "u: a - u + u^2 v; v: b - u^2 v",
    source: "Schnakenberg 1979; Murray 2003",
    species: &["u", "v"],
    parameters: &[range("a", 0.0, 10.0), range("b", 0.0, 10.0)],
    defaults: DEFAULTS,
    presets: PRESETS,
    explicit: explicit_double::<Schnakenberg, 2, 2>,
    linear: None,
    reaction: reaction::<Schnakenberg, 2, 2>,
};

const DEFAULTS: &str = r#"
size = [128, 128]
iterations = 8000
dt = 0.04
boundary = "periodic"
clamp = true
diffusion = { u = 0.4, v = 8.0 }
ink = { species = "u", level = "mean", below = false }
curve = { speed = "off" }
perturbation = [{ target = "u", kind = "noise", amplitude = 0.01, region = "all" }]
"#;

pub(crate) const PRESETS: &[Preset] = &[
    Preset {
        name: "schnakenberg-spots",
        about: "Hexagons of spots",
        config: "kinetics = 'schnakenberg'\n\
                 parameters = { a = 0.1, b = 0.9 }\n\
                 initial = { u = 1.0, v = 0.9 }",
    },
    Preset {
        name: "schnakenberg-worms",
        about: "Short worms",
        config: "kinetics = 'schnakenberg'\n\
                 parameters = { a = 0.25, b = 1.2 }\n\
                 initial = { u = 1.45, v = 0.5707 }",
    },
    Preset {
        name: "schnakenberg-growing-row",
        about: "Peaks of a row that split each time its length has doubled: 4, 8, 16",
        config: "kinetics = 'schnakenberg'\n\
                 size = [128]\n\
                 boundary = 'neumann'\n\
                 iterations = 11000\n\
                 dt = 0.02\n\
                 stepper = 'semi-implicit'\n\
                 parameters = { a = 0.1, b = 0.9 }\n\
                 diffusion = { u = 40.0, v = 800.0 }\n\
                 initial = { u = 1.0, v = 0.9 }\n\
                 growth = { law = 'exponential', rate = 0.01 }\n\
                 snapshots = [3466, 6931, 10397]",
    },
    Preset {
        name: "schnakenberg-growing-spots",
        about: "Spots that divide on a plane of four times the length in the end",
        config: "kinetics = 'schnakenberg'\n\
                 boundary = 'neumann'\n\
                 iterations = 77000\n\
                 dt = 0.0018\n\
                 parameters = { a = 0.1, b = 0.9 }\n\
                 diffusion = { u = 10.0, v = 200.0 }\n\
                 initial = { u = 1.0, v = 0.9 }\n\
                 growth = { law = 'exponential', rate = 0.01 }",
    },
];
