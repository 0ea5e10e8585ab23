//! Fronts moving at a pluggable normal speed: `dphi/dt = -beta |grad phi|`, `phi < 0` inside.
//!
//! | symbol | code    | meaning                                 | unit        |
//! |--------|---------|-----------------------------------------|-------------|
//! | phi    | `phi`   | signed distance, negative inside        | length      |
//! | beta   | `beta`  | normal speed, positive outwards         | length/time |
//! | v      | `v`     | velocity of a flow                      | length/time |
//! | b      | `b`     | coefficient of motion by curvature      | length^2/time |
//! | kappa  | `kappa` | curvature `div(grad phi / |grad phi|)`  | 1/length    |
//! | h      | `h`     | node distance                           | length      |
//! | dt     | `dt`    | time step                               | time        |
//!
//! [`LevelSet`] advances a front by any [`Speed`] under a [`Scheme`];
//! [`reinitialize`] and [`extend_speed`] serve fronts that deform phi.

mod band;
mod curvature;
pub mod distance;
mod evolve;
mod extension;
mod ghost;
pub mod measure;
mod reinitialize;
mod rows;
mod scheme;
pub mod shapes;
pub mod speed;
mod speed_advection;
mod speed_constant;
mod speed_curvature;
mod speed_field;
mod speed_sum;
mod stage;
mod upwind;
mod weno;

pub use distance::{Redistance, RedistanceOptions, redistance};
pub use evolve::LevelSet;
pub use extension::extend_speed;
pub use measure::{Components, Measures, label_components};
pub use reinitialize::reinitialize;
pub use scheme::{Order, Scheme};
pub use shapes::{Point, Shape};
pub use speed::{Speed, Terms};
pub use speed_advection::{FieldAdvection, FnAdvection};
pub use speed_constant::ConstantSpeed;
pub use speed_curvature::CurvatureSpeed;
pub use speed_field::{FieldSpeed, FnSpeed};
