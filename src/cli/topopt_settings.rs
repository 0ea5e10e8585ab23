//! The settings of `patterns topopt` that are keys of its configuration.

use super::values;
use crate::request::Request;
use anyhow::Result;
use toml::Value;

/// One flag for every number and choice of the configuration; lengths in elements.
#[derive(Debug, clap::Args)]
pub(super) struct Settings {
    /// The problem as its source prints it, without interpretations.
    #[arg(long)]
    as_printed: bool,
    /// All loads at once, as one load case.
    #[arg(long)]
    one_case: bool,
    /// simp: a density per element; level-set: a front that moves [default: simp].
    #[arg(long, value_parser = ["simp", "level-set"])]
    method: Option<String>,
    /// Material as a fraction of the box, in (0, 1) [default: the problem's, 0.5].
    #[arg(long, value_name = "FRACTION")]
    volume: Option<f64>,
    /// What is made small [default: the problem's, compliance].
    #[arg(long, value_parser = ["compliance", "displacement", "stress"])]
    objective: Option<String>,
    /// Load cases: their weighted sum, or the worst (mma, gcmma) [default: sum].
    #[arg(long, value_parser = ["sum", "worst"])]
    cases: Option<String>,
    /// Density limits and bisection as in the 99 or the 88 lines [default: the problem's, 88].
    #[arg(long, value_parser = ["99", "88"])]
    rules: Option<String>,
    /// Stiffness by density [default: modified; simp by the 99 rules].
    #[arg(long, value_parser = ["simp", "modified", "ramp"])]
    interpolation: Option<String>,
    /// Exponent p (q of ramp), in [0, 20] [default: 3].
    #[arg(long, value_name = "P")]
    penalization: Option<f64>,
    /// Exponent at the start, in [0, penalization]; it rises in steps, and the run ends only
    /// at the whole one [default: none, the exponent is constant].
    #[arg(long, value_name = "P")]
    penalization_start: Option<f64>,
    /// Rise of the exponent, in (0, 20] [default: 0.5].
    #[arg(long, value_name = "P")]
    penalization_step: Option<f64>,
    /// Iterations until the exponent rises, at least 1; it rises earlier when the design rests
    /// [default: 20].
    #[arg(long, value_name = "N")]
    penalization_every: Option<u64>,
    /// Stiffness of void relative to solid (modified, ramp), in (0, 0.1]
    /// [default: the problem's, 1e-9].
    #[arg(long, value_name = "FRACTION")]
    void_stiffness: Option<f64>,
    /// Filter [default: the problem's, sensitivity].
    #[arg(long, value_parser = ["none", "sensitivity", "density", "helmholtz"])]
    filter: Option<String>,
    /// Radius of the filter, elements, in [1, 1000] [default: the problem's, 1.5].
    #[arg(long, value_name = "ELEMENTS")]
    filter_radius: Option<f64>,
    /// Sharpest step of the filtered densities (beta), in (0, 1024] [default: no step; 32 where
    /// another --projection-*, --preserve-volume or --robust is given].
    #[arg(long, value_name = "BETA")]
    projection: Option<f64>,
    /// Sharpness of the step at the start, in (0, sharpest]; it doubles [default: 1].
    #[arg(long, value_name = "BETA")]
    projection_start: Option<f64>,
    /// Iterations until the step's sharpness doubles, at least 1; earlier when the design rests
    /// [default: 50].
    #[arg(long, value_name = "N")]
    projection_every: Option<u64>,
    /// Density of the step, in (0, 1) [default: 0.5].
    #[arg(long, value_name = "DENSITY")]
    projection_eta: Option<f64>,
    /// Choose the step's density in each iteration so that the step keeps the volume.
    #[arg(long)]
    preserve_volume: bool,
    /// Robust design: steps at eta - DELTA, eta, eta + DELTA, the worst counts (mma, gcmma);
    /// in [0, min(eta, 1 - eta)) [default: 0].
    #[arg(long, value_name = "DELTA")]
    robust: Option<f64>,
    /// Update of the design [default: the problem's, oc].
    #[arg(long, value_parser = ["oc", "mma", "gcmma"])]
    optimizer: Option<String>,
    /// Largest change of a density in an iteration, in (0, 1] [default: 0.2].
    #[arg(long, value_name = "CHANGE")]
    move_limit: Option<f64>,
    /// Exponent of the optimality criteria, in (0, 1] [default: 0.5; the problem's].
    #[arg(long, value_name = "ETA")]
    damping: Option<f64>,
    /// The run ends when no density changes more than this (level-set: the compliance, as a
    /// fraction), in (0, 1] [default: 0.01].
    #[arg(long, value_name = "CHANGE")]
    tolerance: Option<f64>,
    /// Most iterations, in [1, 10000000] [default: 1000].
    #[arg(long, value_name = "N")]
    iterations: Option<u64>,
    /// Exponent of the p-norm of the stresses, in [2, 64] [default: the problem's, 8].
    #[arg(long, value_name = "P")]
    stress_exponent: Option<f64>,
    /// Linear solver [default: auto, by size].
    #[arg(long, value_parser = ["auto", "direct", "multigrid"])]
    solver: Option<String>,
    /// Relative residual asked of an iterative solver, in [1e-12, 0.01] [default: follows the
    /// change of the design, 5e-4 to 1e-8; 1e-8 for level-set].
    #[arg(long, value_name = "RESIDUAL")]
    solver_tolerance: Option<f64>,
    /// level-set: round holes across and down at the start, e.g. 6,3 [default: 0,0, a full box].
    #[arg(long, value_name = "NX,NY")]
    holes: Option<String>,
    /// level-set: iterations between two nucleations of holes, 0 for none [default: 5].
    #[arg(long, value_name = "N")]
    nucleate_every: Option<u64>,
    /// level-set: part of the solid that a nucleation turns to void, in [0, 0.2]
    /// [default: 0.03].
    #[arg(long, value_name = "FRACTION")]
    nucleate_fraction: Option<f64>,
    /// level-set: iterations between two redistancings, 0 for none [default: 5].
    #[arg(long, value_name = "N")]
    redistance_every: Option<u64>,
    /// level-set: length over which the speed is smoothed, elements, in [0, 20] [default: 1].
    #[arg(long, value_name = "ELEMENTS")]
    smoothing: Option<f64>,
    /// level-set: stiffness of void relative to solid while the front moves, in (0, 0.1]
    /// [default: 1e-3].
    #[arg(long, value_name = "FRACTION")]
    ersatz: Option<f64>,
    /// level-set: largest way of the front in an iteration, elements, in (0, 2] [default: 1].
    #[arg(long, value_name = "ELEMENTS")]
    front_step: Option<f64>,
    /// level-set: most volume that an iteration takes away, as a fraction of the box, in (0, 1]
    /// [default: 0.01].
    #[arg(long, value_name = "FRACTION")]
    volume_step: Option<f64>,
    /// Young's modulus of solid (force/length^2) or its conductivity, above 0
    /// [default: the problem's, 1].
    #[arg(long, value_name = "E")]
    youngs_modulus: Option<f64>,
    /// Poisson's ratio, in (-1, 0.5) [default: the problem's, 0.3].
    #[arg(long, value_name = "NU")]
    poisson_ratio: Option<f64>,
    /// What is assumed across a plane problem [default: plane-stress].
    #[arg(long, value_parser = ["plane-stress", "plane-strain"])]
    plane: Option<String>,
    /// Edge of an element (length), above 0 [default: 1].
    #[arg(long, value_name = "LENGTH")]
    unit: Option<f64>,
    /// Force per volume of solid along x, y (and z), e.g. its weight 0,0.01 (force/length^3)
    /// [default: the problem's, none].
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    body_force: Option<String>,
}

impl Settings {
    /// Writes what was given over the configuration.
    pub(super) fn apply(&self, request: &mut Request) -> Result<()> {
        request.set_flag("as_printed", self.as_printed.then_some(true))?;
        request.set_flag("one_case", self.one_case.then_some(true))?;
        let choices = [
            ("method", &self.method),
            ("objective", &self.objective),
            ("cases", &self.cases),
            ("rules", &self.rules),
            ("interpolation", &self.interpolation),
            ("filter", &self.filter),
            ("optimizer", &self.optimizer),
            ("solver", &self.solver),
        ];
        for (key, value) in choices {
            request.set_flag(key, value.as_deref())?;
        }
        let numbers = [
            ("volume", self.volume),
            ("penalization", self.penalization),
            ("penalization_start", self.penalization_start),
            ("penalization_step", self.penalization_step),
            ("void_stiffness", self.void_stiffness),
            ("filter_radius", self.filter_radius),
            ("move_limit", self.move_limit),
            ("damping", self.damping),
            ("tolerance", self.tolerance),
            ("stress_exponent", self.stress_exponent),
            ("solver_tolerance", self.solver_tolerance),
        ];
        for (key, value) in numbers {
            request.set_flag(key, value)?;
        }
        request.set_flag("penalization_every", values::integer(self.penalization_every))?;
        request.set_flag("iterations", values::integer(self.iterations))?;
        if self.rules.is_some() && self.interpolation.is_none() {
            let kind = if self.rules.as_deref() == Some("99") { "simp" } else { "modified" };
            request.set("interpolation", Value::String(kind.into()), "--rules")?;
        }
        self.apply_projection(request)?;
        self.apply_level_set(request)?;
        self.apply_problem(request)
    }

    fn apply_projection(&self, request: &mut Request) -> Result<()> {
        let every = values::integer(self.projection_every).map(Value::Integer);
        let entries = [
            ("beta_max", "--projection", self.projection.map(Value::Float)),
            ("beta", "--projection-start", self.projection_start.map(Value::Float)),
            ("every", "--projection-every", every),
            ("eta", "--projection-eta", self.projection_eta.map(Value::Float)),
            ("preserve_volume", "--preserve-volume", on(self.preserve_volume)),
            ("delta", "--robust", self.robust.map(Value::Float)),
        ];
        set_all(request, "projection", entries)
    }

    fn apply_level_set(&self, request: &mut Request) -> Result<()> {
        let holes =
            self.holes.as_deref().map(|text| values::integers(text, "--holes")).transpose()?;
        let integer = |value: Option<u64>| values::integer(value).map(Value::Integer);
        let entries = [
            ("holes", "--holes", holes),
            ("nucleate_every", "--nucleate-every", integer(self.nucleate_every)),
            ("nucleate_fraction", "--nucleate-fraction", self.nucleate_fraction.map(Value::Float)),
            ("redistance_every", "--redistance-every", integer(self.redistance_every)),
            ("smoothing", "--smoothing", self.smoothing.map(Value::Float)),
            ("ersatz", "--ersatz", self.ersatz.map(Value::Float)),
            ("step", "--front-step", self.front_step.map(Value::Float)),
            ("volume_step", "--volume-step", self.volume_step.map(Value::Float)),
        ];
        set_all(request, "level_set", entries)
    }

    fn apply_problem(&self, request: &mut Request) -> Result<()> {
        let text = self.body_force.as_deref();
        let force = text.map(|text| values::list(text, "--body-force")).transpose()?;
        let entries = [
            ("youngs_modulus", "--youngs-modulus", self.youngs_modulus.map(Value::Float)),
            ("poisson_ratio", "--poisson-ratio", self.poisson_ratio.map(Value::Float)),
            ("plane", "--plane", self.plane.clone().map(Value::String)),
            ("unit", "--unit", self.unit.map(Value::Float)),
            ("body_force", "--body-force", force),
        ];
        set_all(request, "problem", entries)
    }
}

fn on(flag: bool) -> Option<Value> {
    flag.then_some(Value::Boolean(true))
}

/// Sets the keys of `table` whose flags were given.
fn set_all<const N: usize>(
    request: &mut Request,
    table: &str,
    entries: [(&str, &str, Option<Value>); N],
) -> Result<()> {
    for (key, flag, value) in entries {
        if let Some(value) = value {
            request.set(&format!("{table}.{key}"), value, flag)?;
        }
    }
    Ok(())
}
