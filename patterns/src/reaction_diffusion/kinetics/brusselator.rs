//! The Brusselator of Prigogine and Lefever.

use super::{Kinetics, explicit_double, range, reaction};
use crate::Preset;
use solvers::diffusion::explicit::{Cell, Real};

/// The reaction of one cell.
pub struct Brusselator;

impl Cell<2, 2> for Brusselator {
    #[inline(always)]
    fn rates<T: Real>([u, v]: [T; 2], [a, b]: [T; 2]) -> [T; 2] {
        let reaction = u * u * v;
        [a - (b + T::from_f64(1.0)) * u + reaction, b * u - reaction]
    }
}

/// Registry entry.
pub static KINETICS: Kinetics = Kinetics {
    name: "brusselator",
    equations: "u: a - (b + 1) u + u^2 v; v: b u - u^2 v",
    source: "Prigogine and Lefever 1968; De Wit 1999",
    species: &["u", "v"],
    parameters: &[range("a", 0.0, 100.0), range("b", 0.0, 100.0)],
    defaults: DEFAULTS,
    presets: PRESETS,
    explicit: explicit_double::<Brusselator, 2, 2>,
    linear: None,
    reaction: reaction::<Brusselator, 2, 2>,
};

const DEFAULTS: &str = r#"
size = [128, 128]
boundary = "periodic"
clamp = true
diffusion = { u = 2.0, v = 16.0 }
ink = { species = "u", level = "mean", below = false }
curve = { speed = "off" }
perturbation = [{ target = "u", kind = "noise", amplitude = 0.05, region = "all" }]
"#;

pub(crate) const PRESETS: &[Preset] = &[
    Preset {
        name: "brusselator-stripes",
        about: "Stripes of a labyrinth, near the threshold",
        config: "kinetics = 'brusselator'\n\
                 iterations = 10000\n\
                 dt = 0.02\n\
                 parameters = { a = 3.0, b = 4.6 }\n\
                 initial = { u = 3.0, v = 1.533333 }",
    },
    Preset {
        name: "brusselator-spots",
        about: "Spots, far above the threshold",
        config: "kinetics = 'brusselator'\n\
                 iterations = 8000\n\
                 dt = 0.004\n\
                 parameters = { a = 3.0, b = 6.0 }\n\
                 initial = { u = 3.0, v = 2.0 }",
    },
];
