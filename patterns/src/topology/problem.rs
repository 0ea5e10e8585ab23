//! A problem as it is written: domain, material, loads, supports, regions of fixed material.

use super::region::Side;
use serde::{Deserialize, Serialize};
use solvers::fem::PlaneState;

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
