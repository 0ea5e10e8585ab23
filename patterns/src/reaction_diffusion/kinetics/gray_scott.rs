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
    defaults: DEFAULTS,
    presets: PRESETS,
    explicit: explicit::<GrayScott, 2, 2>,
    linear: None,
    reaction: reaction::<GrayScott, 2, 2>,
};

const DEFAULTS: &str = r#"
size = [256, 256]
boundary = "periodic"
diffusion = { u = 0.2097152, v = 0.1048576 }
initial = { u = 1.0, v = 0.0 }
ink = { species = "v", level = 0.2, below = false }
curve = { speed = "off" }
"#;

/// A class: squares (u, v, width, number) of the other state on a 256x256 grid, at one feed and kill rate.
macro_rules! class {
    ($name:literal, $about:literal, $feed:literal, $kill:literal, $iterations:literal) => {
        class!($name, $about, $feed, $kill, $iterations, "0.5", "0.25", 10, 40)
    };
    ($name:literal, $about:literal, $feed:literal, $kill:literal, $iterations:literal,
     $u:literal, $v:literal, $width:literal, $count:literal) => {
        Preset {
            name: concat!("gray-scott-", $name),
            about: $about,
            config: concat!(
                "kinetics = 'gray-scott'\niterations = ",
                $iterations,
                "\nparameters = { feed = ",
                $feed,
                ", kill = ",
                $kill,
                " }\nperturbation = [\n",
                "{ target = 'u', kind = 'set', region = 'squares', amplitude = ",
                $u,
                ", width = ",
                $width,
                ", count = ",
                $count,
                " },\n{ target = 'v', kind = 'set', region = 'squares', amplitude = ",
                $v,
                ", width = ",
                $width,
                ", count = ",
                $count,
                " },\n",
                "{ target = 'u', kind = 'noise', amplitude = 0.01, region = 'all' },\n",
                "{ target = 'v', kind = 'noise', amplitude = 0.01, region = 'all' },\n]",
            ),
        }
    };
}

/// Letters of Pearson 1993 (R, B, alpha to mu) and Munafo 2014 (nu to sigma).
pub(crate) const PRESETS: &[Preset] = &[
    class!("kappa", "Pearson kappa: a labyrinth of stripes", "0.058", "0.063", 20000),
    class!("alpha", "Pearson alpha: spiral wavelets, never settling", "0.01", "0.047", 12000),
    class!("beta", "Pearson beta: chaotic blue and red patches", "0.026", "0.051", 12000),
    class!("gamma", "Pearson gamma: worms that keep moving", "0.022", "0.051", 12000),
    class!(
        "delta",
        "Pearson delta: negative spots in hexagonal order, with oscillation",
        "0.03",
        "0.055",
        15000
    ),
    class!(
        "epsilon",
        "Pearson epsilon: dividing and dying spots, chaotic",
        "0.018",
        "0.055",
        12000
    ),
    class!("zeta", "Pearson zeta: spots and short worms, chaotic", "0.026", "0.059", 12000),
    class!("eta", "Pearson eta: spots and worms that slowly move", "0.034", "0.063", 15000),
    class!(
        "theta",
        "Pearson theta: stripes and negative spots (fingerprint with gaps)",
        "0.03",
        "0.057",
        15000
    ),
    class!("iota", "Pearson iota: negative spots", "0.046", "0.0594", 15000),
    class!(
        "lambda",
        "Pearson lambda: dividing spots that fill the plane (mitosis)",
        "0.034",
        "0.065",
        20000
    ),
    class!("mu", "Pearson mu: worms that grow and branch", "0.046", "0.065", 20000),
    class!("nu", "Munafo nu: solitons that drift apart", "0.054", "0.067", 20000),
    class!(
        "xi",
        "Munafo xi: large spirals and target waves",
        "0.014",
        "0.047",
        6000,
        "0.5",
        "0.25",
        40,
        12
    ),
    class!(
        "pi",
        "Munafo pi: u-skate world, negative solitons and stripes",
        "0.062",
        "0.061",
        20000
    ),
    class!(
        "rho",
        "Munafo rho: the two states coarsen, stripes between them",
        "0.09",
        "0.059",
        8000,
        "0.42",
        "0.36",
        70,
        12
    ),
    class!(
        "sigma",
        "Munafo sigma: the state of the squares wins, its borders stay as lines",
        "0.09",
        "0.057",
        5000,
        "0.42",
        "0.36",
        70,
        12
    ),
    class!("r", "Pearson R: everything dies, the red state", "0.050", "0.070", 2000),
    class!("b", "Pearson B: the blue state fills the plane", "0.030", "0.050", 6000),
];
