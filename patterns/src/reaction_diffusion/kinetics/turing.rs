//! Turing's two morphogens as the paper writes them, equations 1.6 and 1.7.

use super::{Kinetics, explicit, range, reaction};
use crate::Preset;
use solvers::diffusion::explicit::{Cell, Real};

/// The reaction of one cell.
pub struct Turing;

impl Cell<2, 2> for Turing {
    #[inline(always)]
    fn rates<T: Real>([a, b]: [T; 2], [s, xi]: [T; 2]) -> [T; 2] {
        let reaction = a * b;
        [s * (T::from_f64(16.0) - reaction), s * (reaction - b - xi)]
    }
}

/// Registry entry.
pub static KINETICS: Kinetics = Kinetics {
    name: "turing",
    equations: "a: s (16 - a b); b: s (a b - b - xi)",
    source: "Turing 1952; equations 1.6 and 1.7",
    species: &["a", "b"],
    parameters: &[range("s", 0.0, 10.0), range("xi", 0.0, 16.0)],
    defaults: DEFAULTS,
    presets: PRESETS,
    explicit: explicit::<Turing, 2, 2>,
    linear: None,
    reaction: reaction::<Turing, 2, 2>,
};

const DEFAULTS: &str = r#"
diffusion = { a = 0.25, b = 0.0625 }
initial = { a = 4.0, b = 4.0 }
parameters = { s = 0.03125, xi = 12.0 }
ink = { species = "b", level = "mean", below = true }
"#;

pub(crate) const PRESETS: &[Preset] = &[
    Preset {
        name: "spots",
        about: "Spots from a random substrate: figure 1.5, 80x80, 8000 iterations",
        config: "kinetics = 'turing'\n\
                 perturbation = [{ target = 'xi', kind = 'noise', amplitude = 0.5, region = 'even' }]",
    },
    Preset {
        name: "stripes",
        about: "Straight stripes that spread from a line of the substrate",
        config: "kinetics = 'turing'\n\
                 perturbation = [{ target = 'xi', kind = 'add', amplitude = 0.5, region = 'center-line' }]",
    },
    Preset {
        name: "rings",
        about: "Rings around a 4x4 block of the substrate, 1000 iterations",
        config: "kinetics = 'turing'\n\
                 iterations = 1000\n\
                 perturbation = [{ target = 'xi', kind = 'add', amplitude = 0.5, region = 'block', width = 4 }]",
    },
    Preset {
        name: "labyrinth",
        about: "A labyrinth: a higher substrate and slower diffusion of b",
        config: "kinetics = 'turing'\n\
                 parameters = { s = 0.03125, xi = 13.0 }\n\
                 diffusion = { a = 0.25, b = 0.05 }\n\
                 initial = { a = 5.333333333333333, b = 3.0 }\n\
                 perturbation = [{ target = 'xi', kind = 'noise', amplitude = 0.5, region = 'even' }]",
    },
    Preset {
        name: "literal",
        about: "The spots with the speed that the paper writes, the Laplacian of b: tracks inflection contours",
        config: "kinetics = 'turing'\n\
                 perturbation = [{ target = 'xi', kind = 'noise', amplitude = 0.5, region = 'even' }]\n\
                 curve = { speed = 'literal' }",
    },
    Preset {
        name: "figure-1-1",
        about: "One row of 60 cells at iterations 0, 4000, 8000 and 12000: figure 1.1",
        config: "kinetics = 'turing'\n\
                 size = [60]\n\
                 iterations = 12000\n\
                 snapshots = [0, 4000, 8000, 12000]\n\
                 perturbation = [{ target = 'xi', kind = 'noise', amplitude = 0.05, region = 'all' }]\n\
                 curve = { speed = 'off' }",
    },
];
