//! Fronts moving at a pluggable normal speed: `dphi/dt = -beta |grad phi|`, `phi < 0` inside.
//!
//! | symbol | code    | meaning                                 | unit        |
//! |--------|---------|-----------------------------------------|-------------|
//! | phi    | `phi`   | signed distance, negative inside        | length      |
//! | beta   | `speed` | normal speed, positive outwards         | length/time |
//! | kappa  | `kappa` | curvature `div(grad phi / |grad phi|)`  | 1/length    |
//! | h      | `h`     | node distance                           | length      |
//! | dt     | `dt`    | time step                               | time        |

pub mod distance;
pub mod measure;
pub mod shapes;
pub mod speed;

pub use distance::{Redistance, RedistanceOptions, redistance};
pub use measure::{Components, Measures, label_components};
pub use shapes::Shape;
pub use speed::{Speed, Terms};
