//! A problem: domain, material, loads, supports, regions of fixed material.

use super::{
    Config,
    region::{NodeBox, Place, Side},
};
use crate::{Context, Error, Result};
use serde::{Deserialize, Serialize};
use solvers::{
    Grid,
    fem::{Elastic, Element, Lattice, PlaneState, System},
};

/// A problem as it is written; lengths in elements, y down.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ProblemConfig {
    /// Name, for titles and messages.
    pub name: String,
    /// Elements along x and y (and z).
    pub elements: Vec<usize>,
    /// Edge of an element (length); only body forces depend on it.
    pub unit: f64,
    /// What is computed.
    pub physics: Physics,
    /// Young's modulus of solid (force/length^2), or its conductivity.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Plane stress or plane strain.
    pub plane: PlaneState,
    /// Forces, or sources of heat.
    pub load: Vec<Load>,
    /// Supports, or sinks of heat.
    pub support: Vec<Support>,
    /// Springs to the ground.
    pub spring: Vec<Spring>,
    /// Regions of fixed material.
    pub passive: Vec<Passive>,
    /// What a mechanism moves.
    pub output: Vec<Output>,
    /// Force per volume of solid (force/length^3), e.g. its weight.
    pub body_force: Vec<f64>,
    /// Weight of each load case, 1 where absent.
    pub case_weights: Vec<f64>,
    /// Axes across which the design is mirrored: `["x"]`.
    pub symmetry: Vec<String>,
}

impl Default for ProblemConfig {
    fn default() -> Self {
        Self {
            name: String::new(),
            elements: Vec::new(),
            unit: 1.0,
            physics: Physics::Elasticity,
            youngs_modulus: 1.0,
            poisson_ratio: 0.3,
            plane: PlaneState::PlaneStress,
            load: Vec::new(),
            support: Vec::new(),
            spring: Vec::new(),
            passive: Vec::new(),
            output: Vec::new(),
            body_force: Vec::new(),
            case_weights: Vec::new(),
            symmetry: Vec::new(),
        }
    }
}

/// What is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Physics {
    /// Linear elasticity.
    Elasticity,
    /// Stationary heat conduction.
    Heat,
}

/// A load, spread over its nodes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Load {
    /// One node: column, row (and plane), from 1.
    pub node: Option<Vec<usize>>,
    /// A line, rectangle or box of nodes by its first and last.
    pub nodes: Option<[Vec<usize>; 2]>,
    /// A whole side.
    pub edge: Option<Side>,
    /// Nodes in a box of space.
    #[serde(rename = "box")]
    pub area: Option<[Vec<f64>; 2]>,
    /// The whole force (force), one number per axis; one number for heat.
    pub force: Vec<f64>,
    /// Its load case, from 1.
    pub case: Option<usize>,
}

/// A support.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Support {
    /// One node: column, row (and plane), from 1.
    pub node: Option<Vec<usize>>,
    /// A line, rectangle or box of nodes by its first and last.
    pub nodes: Option<[Vec<usize>; 2]>,
    /// A whole side.
    pub edge: Option<Side>,
    /// Nodes in a box of space.
    #[serde(rename = "box")]
    pub area: Option<[Vec<f64>; 2]>,
    /// Directions that are held: `"x"`, `"xy"`, ...; all where absent.
    pub fix: Option<String>,
    /// Prescribed displacement of the held directions (length), or temperature; 0 where absent.
    pub value: Option<Vec<f64>>,
    /// Why it stands here although the source does not print it; `as_printed` drops it.
    pub interpreted: Option<String>,
}

/// Springs to the ground, one at each node.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Spring {
    /// One node: column, row (and plane), from 1.
    pub node: Option<Vec<usize>>,
    /// A line, rectangle or box of nodes by its first and last.
    pub nodes: Option<[Vec<usize>; 2]>,
    /// A whole side.
    pub edge: Option<Side>,
    /// Nodes in a box of space.
    #[serde(rename = "box")]
    pub area: Option<[Vec<f64>; 2]>,
    /// Stiffness of the whole (force/length), one number per axis.
    pub stiffness: Vec<f64>,
}

/// What a mechanism moves: the objective `displacement` is minus the mean of
/// `direction . u` over the nodes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Output {
    /// One node: column, row (and plane), from 1.
    pub node: Option<Vec<usize>>,
    /// A line, rectangle or box of nodes by its first and last.
    pub nodes: Option<[Vec<usize>; 2]>,
    /// A whole side.
    pub edge: Option<Side>,
    /// Nodes in a box of space.
    #[serde(rename = "box")]
    pub area: Option<[Vec<f64>; 2]>,
    /// Where it should go, one number per axis.
    pub direction: Vec<f64>,
}

/// A region whose material is fixed: exactly one shape is given.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Passive {
    /// Solid or void.
    pub material: Material,
    /// `[[x, y], [x, y]]`, elements whose middle lies inside.
    #[serde(rename = "box")]
    pub area: Option<[Vec<f64>; 2]>,
    /// `[x, y, radius]` or `[x, y, z, radius]`, elements whose middle lies nearer than the radius.
    pub circle: Option<Vec<f64>>,
    /// Corners `[x, y]` of a polygon.
    pub polygon: Option<Vec<[f64; 2]>>,
    /// A picture or array of the mesh's size: its dark elements (below 0.5).
    pub image: Option<String>,
}

/// Fixed material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Material {
    /// Density 0.
    #[default]
    Void,
    /// Density 1.
    Solid,
}

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
        let bytes = if grid.dim() == 3 { 2600 } else { 1200 };
        crate::check_memory("problem.elements", grid, bytes, context)?;
        let lattice = Lattice::new(grid.axes())?;
        let element = element(problem, grid.dim())?;
        let components = element.components();
        let builder = Builder { config, lattice, components };
        let (fixed, prescribed) = builder.supports()?;
        let springs = builder.springs()?;
        let cases = builder.loads(&fixed, prescribed.is_some())?;
        let output = builder.output()?;
        let body_force = builder.body_force(grid.dim())?;
        let passive = super::passive::find(&problem.passive, grid, context)?;
        let mirror = builder.mirror(grid.dim())?;
        let system = System::new(lattice, element, fixed, springs)?;
        Ok(Self { grid, system, cases, prescribed, output, body_force, passive, mirror })
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
