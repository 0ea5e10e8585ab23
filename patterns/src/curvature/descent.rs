//! A flow as a run sees it: steps, measures, checkpoints, whatever its method and precision.

use super::Diagram;
use super::flow::{Paper, StepInfo};
use crate::{Result, State};
use solvers::{Float, mesh::TriangleMesh};

/// A flow of any method and precision.
pub(super) trait Descent {
    /// One evaluation.
    fn step(&mut self) -> Result<StepInfo>;
    /// The phase, shape `[nz, ny, nx]`.
    fn phase(&self) -> Vec<f64>;
    /// Normalized discrepancy of the phase.
    fn discrepancy(&self) -> f64;
    /// The curvatures on a mesh of one of the phase's levels.
    fn diagram(&self, mesh: &TriangleMesh) -> Result<Diagram>;
    /// Adds all that is needed to go on.
    fn save(&self, state: &mut State);
    /// Goes on from what was saved.
    fn restore(&mut self, state: &State) -> Result<()>;
}

/// Floats that checkpoints hold.
pub(super) trait Stored: Float {
    fn put(state: &mut State, name: &str, values: &[Self]);
    fn get(state: &State, name: &str, length: usize) -> Result<Vec<Self>>;
}

impl Stored for f32 {
    fn put(state: &mut State, name: &str, values: &[Self]) {
        state.put_f32(name, values);
    }

    fn get(state: &State, name: &str, length: usize) -> Result<Vec<Self>> {
        let mut values = vec![0.0; length];
        state.get_f32(name, &mut values)?;
        Ok(values)
    }
}

impl Stored for f64 {
    fn put(state: &mut State, name: &str, values: &[Self]) {
        state.put_f64(name, values);
    }

    fn get(state: &State, name: &str, length: usize) -> Result<Vec<Self>> {
        let mut values = vec![0.0; length];
        state.get_f64(name, &mut values)?;
        Ok(values)
    }
}

fn wide<T: Float>(values: &[T]) -> Vec<f64> {
    values.iter().map(|v| v.to_f64()).collect()
}

/// What the methods have in common.
macro_rules! measures {
    () => {
        fn phase(&self) -> Vec<f64> {
            wide(self.phase())
        }

        fn discrepancy(&self) -> f64 {
            self.energy().discrepancy(self.phase())
        }

        fn diagram(&self, mesh: &TriangleMesh) -> Result<Diagram> {
            Diagram::of(self.energy(), self.phase(), mesh)
        }
    };
}

impl<T: Stored> Descent for Paper<T> {
    measures!();

    fn step(&mut self) -> Result<StepInfo> {
        Ok(self.step()?)
    }

    fn save(&self, state: &mut State) {
        state.put_u64("steps", &[self.steps()]);
        for (name, fields) in ["a", "mean", "square"].iter().zip(self.state()) {
            for (axis, field) in ["z", "y", "x"].iter().zip(fields) {
                T::put(state, &format!("{name}_{axis}"), field);
            }
        }
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        let length = self.energy().voxels();
        let fields = |name: &str| -> Result<[Vec<T>; 3]> {
            let field = |axis: &str| T::get(state, &format!("{name}_{axis}"), length);
            Ok([field("z")?, field("y")?, field("x")?])
        };
        let fields = [fields("a")?, fields("mean")?, fields("square")?];
        self.restore(fields, state.one_u64("steps")?);
        Ok(())
    }
}
