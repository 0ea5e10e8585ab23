//! Gierer and Meinhardt's activator and inhibitor, with saturation.

use super::{Kinetics, explicit_double, range, reaction};
use crate::Preset;
use solvers::diffusion::explicit::{Cell, Real};

/// The reaction of one cell.
pub struct GiererMeinhardt;

impl Cell<2, 4> for GiererMeinhardt {
    #[inline(always)]
    fn rates<T: Real>([a, h]: [T; 2], [rho, mu, nu, kappa]: [T; 4]) -> [T; 2] {
        let square = a * a;
        let made = square / (h * (T::from_f64(1.0) + kappa * square));
        [made - mu * a + rho, nu * (square - h)]
    }
}

/// Registry entry.
pub static KINETICS: Kinetics = Kinetics {
    name: "gierer-meinhardt",
    equations: "a: a^2 / (h (1 + kappa a^2)) - mu a + rho; h: nu (a^2 - h)",
    source: "Gierer and Meinhardt 1972",
    species: &["a", "h"],
    parameters: &[
        range("rho", 0.0, 10.0),
        range("mu", 0.0, 10.0),
        range("nu", 0.0, 100.0),
        range("kappa", 0.0, 100.0),
    ],
    defaults: DEFAULTS,
    presets: PRESETS,
    explicit: explicit_double::<GiererMeinhardt, 2, 4>,
    linear: None,
    reaction: reaction::<GiererMeinhardt, 2, 4>,
};

const DEFAULTS: &str = r#"
size = [128, 128]
dt = 0.03
boundary = "periodic"
clamp = true
diffusion = { a = 0.5, h = 10.0 }
initial = { a = 1.0, h = 1.0 }
ink = { species = "a", level = "mean", below = false }
curve = { speed = "off" }
perturbation = [{ target = "a", kind = "noise", amplitude = 0.05, region = "all" }]
"#;

pub(crate) const PRESETS: &[Preset] = &[
    Preset {
        name: "gierer-meinhardt-spots",
        about: "Peaks of activator, without saturation",
        config: "kinetics = 'gierer-meinhardt'\n\
                 iterations = 8000\n\
                 parameters = { rho = 0.02, mu = 1.0, nu = 2.0, kappa = 0.0 }",
    },
    Preset {
        name: "gierer-meinhardt-stripes",
        about: "Stripes, by saturation of the activator",
        config: "kinetics = 'gierer-meinhardt'\n\
                 iterations = 12000\n\
                 parameters = { rho = 0.02, mu = 1.0, nu = 2.0, kappa = 0.05 }",
    },
    Preset {
        name: "gierer-meinhardt-holes",
        about: "Holes, by strong saturation of the activator",
        config: "kinetics = 'gierer-meinhardt'\n\
                 iterations = 12000\n\
                 parameters = { rho = 0.02, mu = 1.0, nu = 2.0, kappa = 0.1 }",
    },
];
