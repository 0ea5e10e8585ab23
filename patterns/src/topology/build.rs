//! From a problem as it is written to vectors over the unknowns; every bad entry is found here.

use super::{
    Config,
    problem::{Load, Material, Physics, ProblemConfig},
    region::{NodeBox, Place},
};
use crate::{Context, Error, Result};
use solvers::{
    Grid,
    fem::{Elastic, Element, Lattice, PlaneState, System},
};

/// Densities, gradients, filter, optimizer and pictures of an element, displacements and
/// forces of its node; the linear solver tells its own needs, and has the rest.
const BYTES_PER_ELEMENT: usize = 400;

/// A problem ready to be solved.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    /// Elements as the nodes of a grid.
    pub(super) grid: Grid,
    pub(super) system: System,
    /// Weight and nodal loads of each case.
    pub(super) cases: Vec<(f64, Vec<f64>)>,
    /// Displacements of the fixed unknowns, if any is not 0.
    pub(super) prescribed: Option<Vec<f64>>,
    /// `l` of the output `l . u`, if there is one.
    pub(super) output: Option<Vec<f64>>,
    /// Force of a solid element on each of its nodes, per axis.
    pub(super) body_force: Option<[f64; 3]>,
    pub(super) passive: Vec<Option<Material>>,
    /// Axes x, y, z across which the design is mirrored.
    pub(super) mirror: [bool; 3],
    /// Bytes that a linear solver may take.
    pub(super) memory: u64,
    /// Edge of an element (length).
    pub(super) unit: f64,
    pub(super) hole: Hole,
}

/// What a small hole costs per its volume, from energy density and stresses: the topological
/// derivative of the compliance.
#[derive(Clone, Copy, Debug)]
pub(super) enum Hole {
    /// For heat; a round hole costs twice its energy, a ball 3/2.
    Heat(f64),
    /// In the plane `((s1 + s2)^2 + 2 (s1 - s2)^2) / E`, Kirsch's hole: Garreau, Guillaume &
    /// Masmoudi 2001. E of plane strain is `E / (1 - nu^2)`.
    Plane {
        /// 1/E.
        compliance: f64,
    },
    /// A ball in space: `a (10 w - b (tr s)^2)` with `a = 3 (1 - nu) / (2 (7 - 5 nu))` and
    /// `b = (1 - 5 nu) / E`; Garreau, Guillaume & Masmoudi 2001, section 5.
    Space {
        /// a.
        factor: f64,
        /// b.
        trace: f64,
    },
}

impl Hole {
    fn new(problem: &ProblemConfig, dim: usize) -> Self {
        let (e, nu) = (problem.youngs_modulus, problem.poisson_ratio);
        match (problem.physics, dim) {
            (Physics::Heat, 2) => Self::Heat(2.0),
            (Physics::Heat, _) => Self::Heat(1.5),
            (Physics::Elasticity, 2) => {
                let strain = problem.plane == PlaneState::PlaneStrain;
                let stiffer = if strain { 1.0 - nu * nu } else { 1.0 };
                Self::Plane { compliance: stiffer / e }
            }
            (Physics::Elasticity, _) => {
                let factor = 1.5 * (1.0 - nu) / (7.0 - 5.0 * nu);
                // The element's matrix and stresses have the edge in them once.
                Self::Space { factor, trace: (1.0 - 5.0 * nu) / (e * problem.unit) }
            }
        }
    }

    /// The cost, from the energy density and the stresses `xx, yy, ...`.
    pub(super) fn cost(self, energy: f64, stress: &[f64; 6]) -> f64 {
        let [xx, yy, third, ..] = *stress;
        match self {
            Self::Heat(factor) => factor * energy,
            Self::Plane { compliance } => {
                let (sum, difference) = (xx + yy, xx - yy);
                let shear = 2.0 * third;
                compliance * (sum * sum + 2.0 * (difference * difference + shear * shear))
            }
            Self::Space { factor, trace } => {
                let sum = xx + yy + third;
                factor * (10.0 * energy - trace * sum * sum)
            }
        }
    }
}

macro_rules! place {
    ($item:expr, $key:expr) => {
        Place {
            key: $key,
            node: $item.node.as_ref(),
            nodes: $item.nodes.as_ref(),
            edge: $item.edge,
            area: $item.area.as_ref(),
        }
    };
}

impl Problem {
    /// Checks `config.problem` and builds it.
    pub(super) fn new(config: &Config, context: &Context<'_>) -> Result<Self> {
        let problem = &config.problem;
        let grid = grid(problem)?;
        crate::check_memory("problem.elements", grid, BYTES_PER_ELEMENT, context)?;
        let lattice = Lattice::new(grid.axes())?;
        let element = element(problem, grid.dim())?;
        let components = element.components();
        let builder = Builder { config, lattice, components };
        let (fixed, prescribed) = builder.supports()?;
        let springs = builder.springs()?;
        let cases = builder.loads(&fixed, prescribed.is_some())?;
        let output = builder.output()?;
        let body_force = builder.body_force(grid.dim())?;
        let mut passive = super::passive::find(&problem.passive, grid, context)?;
        let mirror = builder.mirror(grid.dim())?;
        super::passive::mirror(&mut passive, grid, mirror)?;
        let system = System::new(lattice, element, fixed, springs)?;
        // What the design itself takes is no longer there for the solver.
        let memory = context.memory.saturating_sub((BYTES_PER_ELEMENT * grid.len()) as u64);
        let unit = problem.unit;
        let hole = Hole::new(problem, grid.dim());
        Ok(Self {
            grid,
            system,
            cases,
            prescribed,
            output,
            body_force,
            passive,
            mirror,
            memory,
            unit,
            hole,
        })
    }

    /// Makes a field over the elements symmetric across the mirrored axes.
    pub(super) fn symmetrize(&self, values: &mut [f64]) {
        let [nz, ny, nx] = self.grid.shape();
        for axis in (0..3).filter(|&axis| self.mirror[axis]) {
            for e in 0..values.len() {
                let mut at = [e % nx, e / nx % ny, e / (nx * ny)];
                at[axis] = [nx, ny, nz][axis] - 1 - at[axis];
                let other = self.grid.index(at[2], at[1], at[0]);
                if other > e {
                    let mean = 0.5 * (values[e] + values[other]);
                    (values[e], values[other]) = (mean, mean);
                }
            }
        }
    }
}

fn grid(problem: &ProblemConfig) -> Result<Grid> {
    let elements = &problem.elements;
    if elements.is_empty() {
        let reason = "there is none; give --table, --problem or --mbb, or `problem.elements`";
        return Err(Error::config("problem", reason));
    }
    if !(2..=3).contains(&elements.len()) {
        return Err(Error::range("problem.elements", elements.len() as f64, "2 or 3 numbers"));
    }
    let shape: Vec<usize> = elements.iter().rev().copied().collect();
    Grid::new(&shape, 1.0).map_err(|error| Error::config("problem.elements", error.to_string()))
}

fn element(problem: &ProblemConfig, dim: usize) -> Result<Element> {
    if !(problem.unit > 0.0 && problem.unit.is_finite()) {
        return Err(Error::range("problem.unit", problem.unit, "(0, inf)"));
    }
    // A cube's stiffness is proportional to its edge, a square's is not.
    let scale = if dim == 3 { problem.unit } else { 1.0 };
    let element = match problem.physics {
        Physics::Heat => Element::conducting(dim, problem.youngs_modulus * scale),
        Physics::Elasticity => {
            let material = Elastic {
                youngs_modulus: problem.youngs_modulus * scale,
                poisson_ratio: problem.poisson_ratio,
                plane: problem.plane,
            };
            Element::elastic(dim, material)
        }
    };
    element.map_err(|error| match error {
        solvers::Error::OutOfRange { name, value, range } => {
            let name = if name == "conductivity" { "youngs_modulus".into() } else { name };
            Error::range(&format!("problem.{name}"), value, &range)
        }
        other => other.into(),
    })
}

/// Turns written entries into vectors over the unknowns.
struct Builder<'a> {
    config: &'a Config,
    lattice: Lattice,
    components: usize,
}

impl Builder<'_> {
    fn unknowns(&self) -> usize {
        self.lattice.node_count() * self.components
    }

    fn vector(&self, key: &str, values: &[f64]) -> Result<()> {
        if values.len() != self.components || values.iter().any(|v| !v.is_finite()) {
            let reason = format!("{values:?} should be {} finite numbers", self.components);
            return Err(Error::config(key, reason));
        }
        Ok(())
    }

    fn supports(&self) -> Result<(Vec<bool>, Option<Vec<f64>>)> {
        let mut fixed = vec![false; self.unknowns()];
        let mut values = vec![0.0; self.unknowns()];
        for (n, support) in self.config.problem.support.iter().enumerate() {
            if self.config.as_printed && support.interpreted.is_some() {
                continue;
            }
            let key = format!("problem.support.{n}");
            let axes = self.axes(support.fix.as_deref(), &format!("{key}.fix"))?;
            if let Some(value) = &support.value {
                self.vector(&format!("{key}.value"), value)?;
            }
            let place: NodeBox = place!(support, key).find(self.lattice)?;
            for node in place.nodes(self.lattice) {
                for &axis in &axes {
                    fixed[node * self.components + axis] = true;
                    values[node * self.components + axis] =
                        support.value.as_ref().map_or(0.0, |v| v[axis]);
                }
            }
        }
        if !fixed.contains(&true) && self.config.problem.spring.is_empty() {
            return Err(Error::config("problem.support", "there is none; give at least one"));
        }
        let prescribed = values.iter().any(|&v| v != 0.0).then_some(values);
        Ok((fixed, prescribed))
    }

    /// Axes named by `fix`.
    fn axes(&self, fix: Option<&str>, key: &str) -> Result<Vec<usize>> {
        let Some(text) = fix.filter(|_| self.components > 1) else {
            return Ok((0..self.components).collect());
        };
        let axis = |letter: char| "xyz".find(letter).filter(|&axis| axis < self.components);
        let axes: Option<Vec<usize>> = text.chars().map(axis).collect();
        axes.filter(|axes| !axes.is_empty()).ok_or_else(|| {
            let all: String = "xyz".chars().take(self.components).collect();
            Error::config(key, format!("`{text}` should name axes, as in `{all}`"))
        })
    }

    fn springs(&self) -> Result<Vec<f64>> {
        let list = &self.config.problem.spring;
        if list.is_empty() {
            return Ok(Vec::new());
        }
        let mut springs = vec![0.0; self.unknowns()];
        for (n, spring) in list.iter().enumerate() {
            let key = format!("problem.spring.{n}");
            self.vector(&format!("{key}.stiffness"), &spring.stiffness)?;
            if let Some(&bad) = spring.stiffness.iter().find(|&&k| k < 0.0) {
                return Err(Error::range(&format!("{key}.stiffness"), bad, "[0, inf)"));
            }
            for (node, share) in place!(spring, key).find(self.lattice)?.shares(self.lattice) {
                for (axis, k) in spring.stiffness.iter().enumerate() {
                    springs[node * self.components + axis] += share * k;
                }
            }
        }
        Ok(springs)
    }

    /// Weight and forces of each case.
    fn loads(&self, fixed: &[bool], prescribed: bool) -> Result<Vec<(f64, Vec<f64>)>> {
        let problem = &self.config.problem;
        let together = self.config.one_case || self.config.as_printed;
        let case_of = |load: &Load| if together { 1 } else { load.case.unwrap_or(1) };
        let count = problem.load.iter().map(case_of).max().unwrap_or(1);
        if count > 100 || problem.load.iter().any(|load| load.case == Some(0)) {
            return Err(Error::range("problem.load.case", count as f64, "[1, 100]"));
        }
        if problem.case_weights.len() > count && !together {
            let reason = format!("{} weights for {count} load cases", problem.case_weights.len());
            return Err(Error::config("problem.case_weights", reason));
        }
        let weight = |n: usize| {
            let weight = problem.case_weights.get(n).copied().unwrap_or(1.0);
            if weight > 0.0 && weight.is_finite() {
                Ok(weight)
            } else {
                Err(Error::range("problem.case_weights", weight, "(0, inf)"))
            }
        };
        let weights: Result<Vec<f64>> = (0..count).map(weight).collect();
        let mut cases: Vec<(f64, Vec<f64>)> =
            weights?.into_iter().map(|w| (w, vec![0.0; self.unknowns()])).collect();
        for (n, load) in problem.load.iter().enumerate() {
            let key = format!("problem.load.{n}");
            self.vector(&format!("{key}.force"), &load.force)?;
            let force = &mut cases[case_of(load) - 1].1;
            for (node, share) in place!(load, key.clone()).find(self.lattice)?.shares(self.lattice)
            {
                for (axis, f) in load.force.iter().enumerate().filter(|(_, f)| **f != 0.0) {
                    let unknown = node * self.components + axis;
                    if fixed[unknown] {
                        return Err(self.load_on_support(&key, unknown));
                    }
                    force[unknown] += share * f;
                }
            }
        }
        let weight = problem.body_force.iter().any(|&f| f != 0.0);
        let empty = cases.iter().position(|(_, force)| force.iter().all(|&f| f == 0.0));
        match empty.filter(|_| !weight && !prescribed) {
            Some(_) if problem.load.is_empty() => {
                Err(Error::config("problem.load", "there is none; give at least one"))
            }
            Some(case) => {
                let reason = format!("case {} has no load that is not 0", case + 1);
                Err(Error::config("problem.load", reason))
            }
            None => Ok(cases),
        }
    }

    fn load_on_support(&self, key: &str, unknown: usize) -> Error {
        let node = self.lattice.position(unknown / self.components).map(|n| n + 1);
        let axis = ["x", "y", "z"][unknown % self.components];
        let printed = &node[..self.lattice.dim()];
        let reason = format!(
            "its part along {axis} acts on node {printed:?}, which a support holds along {axis}: \
             it would do no work"
        );
        Error::config(key, reason)
    }

    fn output(&self) -> Result<Option<Vec<f64>>> {
        let list = &self.config.problem.output;
        let wanted = self.config.objective == super::config::Objective::Displacement;
        if list.is_empty() {
            if wanted {
                let reason = "the objective `displacement` needs at least one";
                return Err(Error::config("problem.output", reason));
            }
            return Ok(None);
        }
        let mut output = vec![0.0; self.unknowns()];
        for (n, entry) in list.iter().enumerate() {
            let key = format!("problem.output.{n}");
            self.vector(&format!("{key}.direction"), &entry.direction)?;
            for (node, share) in place!(entry, key).find(self.lattice)?.shares(self.lattice) {
                for (axis, d) in entry.direction.iter().enumerate() {
                    output[node * self.components + axis] -= share * d;
                }
            }
        }
        Ok(Some(output))
    }

    fn body_force(&self, dim: usize) -> Result<Option<[f64; 3]>> {
        let force = &self.config.problem.body_force;
        if force.is_empty() {
            return Ok(None);
        }
        self.vector("problem.body_force", force)?;
        let volume = self.config.problem.unit.powi(dim as i32);
        let per_node = volume / self.lattice.corners() as f64;
        Ok(Some(std::array::from_fn(|axis| force.get(axis).map_or(0.0, |f| f * per_node))))
    }

    fn mirror(&self, dim: usize) -> Result<[bool; 3]> {
        let mut mirror = [false; 3];
        for name in &self.config.problem.symmetry {
            match ["x", "y", "z"].iter().position(|axis| axis == name).filter(|&axis| axis < dim) {
                Some(axis) => mirror[axis] = true,
                None => {
                    let reason = format!("`{name}` is no axis of a problem with {dim} axes");
                    return Err(Error::config("problem.symmetry", reason));
                }
            }
        }
        Ok(mirror)
    }
}
