//! Gray and Scott's autocatalysis, with the classes of Pearson and Munafo by name.
//!
//! Munafo's grid (256 nodes over a length of 2.5, D_u = 2e-5, D_v = 1e-5, dt = 1) in cell
//! units: D h^-2 = .2097152 and .1048576.

use super::{Kinetics, explicit, range, reaction};
use crate::Preset;
use solvers::diffusion::explicit::{Cell, Real};

/// The reaction of one cell.
pub struct GrayScott;

impl Cell<2, 2> for GrayScott {
    #[inline(always)]
    fn rates<T: Real>([u, v]: [T; 2], [feed, kill]: [T; 2]) -> [T; 2] {
        let reaction = u * v * v;
        [feed * (T::from_f64(1.0) - u) - reaction, reaction - (feed + kill) * v]
    }
}

/// Registry entry.
pub static KINETICS: Kinetics = Kinetics {
    name: "gray-scott",
    equations: "u: -u v^2 + feed (1 - u); v: u v^2 - (feed + kill) v",
    source: "Gray and Scott 1984; Pearson 1993; Munafo 2014",
    species: &["u", "v"],
    parameters: &[range("feed", 0.0, 1.0), range("kill", 0.0, 1.0)],
    presets: PRESETS,
    explicit: explicit::<GrayScott, 2, 2>,
    reaction: Some(reaction::<GrayScott, 2, 2>),
};

pub(crate) const PRESETS: &[Preset] = &[
    Preset {
        name: "gray-scott-kappa",
        about: "Pearson kappa: a labyrinth of stripes",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 20000
boundary = "periodic"
parameters = { feed = 0.058, kill = 0.063 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-alpha",
        about: "Pearson alpha: spiral wavelets, never settling",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 12000
boundary = "periodic"
parameters = { feed = 0.01, kill = 0.047 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-beta",
        about: "Pearson beta: chaotic blue and red patches",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 12000
boundary = "periodic"
parameters = { feed = 0.026, kill = 0.051 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-gamma",
        about: "Pearson gamma: worms that keep moving",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 12000
boundary = "periodic"
parameters = { feed = 0.022, kill = 0.051 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-delta",
        about: "Pearson delta: negative spots in hexagonal order, with oscillation",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 15000
boundary = "periodic"
parameters = { feed = 0.03, kill = 0.055 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-epsilon",
        about: "Pearson epsilon: dividing and dying spots, chaotic",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 12000
boundary = "periodic"
parameters = { feed = 0.018, kill = 0.055 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-zeta",
        about: "Pearson zeta: spots and short worms, chaotic",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 12000
boundary = "periodic"
parameters = { feed = 0.026, kill = 0.059 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-eta",
        about: "Pearson eta: spots and worms that slowly move",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 15000
boundary = "periodic"
parameters = { feed = 0.034, kill = 0.063 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-theta",
        about: "Pearson theta: stripes and negative spots (fingerprint with gaps)",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 15000
boundary = "periodic"
parameters = { feed = 0.03, kill = 0.057 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-iota",
        about: "Pearson iota: negative spots",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 15000
boundary = "periodic"
parameters = { feed = 0.046, kill = 0.0594 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-lambda",
        about: "Pearson lambda: dividing spots that fill the plane (mitosis)",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 20000
boundary = "periodic"
parameters = { feed = 0.034, kill = 0.065 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-mu",
        about: "Pearson mu: worms that grow and branch",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 20000
boundary = "periodic"
parameters = { feed = 0.046, kill = 0.065 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-nu",
        about: "Munafo nu: solitons that drift apart",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 20000
boundary = "periodic"
parameters = { feed = 0.054, kill = 0.067 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 40 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 40 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-xi",
        about: "Munafo xi: large spirals and target waves",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 12000
boundary = "periodic"
parameters = { feed = 0.014, kill = 0.047 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-pi",
        about: "Munafo pi: u-skate world, negative solitons and stripes",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 20000
boundary = "periodic"
parameters = { feed = 0.062, kill = 0.061 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-rho",
        about: "Munafo rho: coarsening of the two states",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 20000
boundary = "periodic"
parameters = { feed = 0.09, kill = 0.059 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-sigma",
        about: "Munafo sigma: growing negative bubbles",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 20000
boundary = "periodic"
parameters = { feed = 0.09, kill = 0.057 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-r",
        about: "Pearson R: everything dies, the red state",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 2000
boundary = "periodic"
parameters = { feed = .050, kill = .070 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
    Preset {
        name: "gray-scott-b",
        about: "Pearson B: the blue state fills the plane",
        config: r#"
kinetics = "gray-scott"
size = [256, 256]
iterations = 6000
boundary = "periodic"
parameters = { feed = .030, kill = .050 }
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
perturbation = [
    { target = "u", kind = "set", amplitude = 0.5, region = "squares", width = 10, count = 20 },
    { target = "v", kind = "set", amplitude = 0.25, region = "squares", width = 10, count = 20 },
    { target = "u", kind = "noise", amplitude = 0.01, region = "all" },
    { target = "v", kind = "noise", amplitude = 0.01, region = "all" },
]
"#,
    },
];
