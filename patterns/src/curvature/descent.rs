//! A flow as a run sees it: steps, measures, checkpoints, whatever its method and precision.

use super::Diagram;
use super::energy::Scalar;
use super::flow::{self, Fast, Guard, Opened, Paper, Stage, StepInfo};
use crate::{Error, Result, State};
use solvers::spectral::Transforms;
use solvers::{Float, mesh::TriangleMesh};

/// A flow of any method and precision.
pub(super) trait Descent {
    /// One step: what it saw before it moved, and whether there is no lower point.
    fn step(&mut self) -> Result<(StepInfo, bool)>;
    /// Evaluations of the energy so far.
    fn evaluations(&self) -> u64;
    /// The phase, shape `[nz, ny, nx]`.
    fn phase(&self) -> Vec<f64>;
    /// Normalized discrepancy of the phase.
    fn discrepancy(&self) -> f64;
    /// The curvatures on a mesh of one of the phase's levels.
    fn diagram(&self, mesh: &TriangleMesh) -> Result<Diagram>;
    /// Times that its rate was halved.
    fn halvings(&self) -> u64 {
        0
    }
    /// Adds all that is needed to go on.
    fn save(&self, state: &mut State);
    /// Goes on from what was saved.
    fn restore(&mut self, state: &State) -> Result<()>;
}

/// Floats that checkpoints hold.
pub(super) trait Stored: Scalar + Transforms {
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

/// What the flows with a step for each evaluation have in common.
macro_rules! steps {
    () => {
        fn step(&mut self) -> Result<(StepInfo, bool)> {
            Ok((self.step()?, false))
        }

        fn evaluations(&self) -> u64 {
            self.steps()
        }
    };
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

/// Fields of a checkpoint of the published flow.
const PUBLISHED: [&str; 5] = ["divergence", "mean", "square_z", "square_y", "square_x"];

impl<T: Stored> Descent for Paper<T> {
    measures!();
    steps!();

    fn save(&self, state: &mut State) {
        state.put_u64("steps", &[self.steps()]);
        for (name, field) in PUBLISHED.iter().zip(self.state()) {
            T::put(state, name, field);
        }
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        let length = self.energy().voxels();
        let [d, m, z, y, x] = PUBLISHED.map(|name| T::get(state, name, length));
        self.restore([d?, m?, z?, y?, x?], state.one_u64("steps")?);
        Ok(())
    }
}

impl<T: Stored> Descent for Fast<T> {
    measures!();
    steps!();

    fn halvings(&self) -> u64 {
        self.guard().halvings
    }

    fn save(&self, state: &mut State) {
        state.put_u64("steps", &[self.steps()]);
        let Guard { ceiling, halvings, begun } = self.guard();
        state.put_f64("ceiling", ceiling.as_slice());
        state.put_u64("halvings", &[halvings]);
        state.put_u64("begun", &[begun]);
        for (name, field) in ["y", "mean", "square"].iter().zip(self.state()) {
            T::put(state, name, field);
        }
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        let length = self.energy().voxels();
        let field = |name: &str| T::get(state, name, length);
        let fields = [field("y")?, field("mean")?, field("square")?];
        let guard = Guard {
            ceiling: state.all_f64("ceiling")?.first().copied(),
            halvings: state.one_u64("halvings")?,
            begun: state.one_u64("begun")?,
        };
        self.restore(fields, state.one_u64("steps")?, guard);
        Ok(())
    }
}

impl<T: Stored> Descent for Opened<T> {
    measures!();
    steps!();

    fn halvings(&self) -> u64 {
        match self.stage() {
            Stage::Opening(_) => 0,
            Stage::Fast(fast) => fast.guard().halvings,
        }
    }

    fn save(&self, state: &mut State) {
        let opened = match self.stage() {
            Stage::Opening(paper) => {
                Descent::save(&**paper, state);
                0
            }
            Stage::Fast(fast) => {
                T::put(state, "start", fast.start());
                Descent::save(&**fast, state);
                1
            }
        };
        state.put_u64("opened", &[opened]);
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        if state.one_u64("opened")? > 0 {
            self.begin(T::get(state, "start", self.energy().voxels())?)?;
        }
        match self.stage_mut() {
            Stage::Opening(paper) => Descent::restore(&mut **paper, state),
            Stage::Fast(fast) => Descent::restore(&mut **fast, state),
        }
    }
}

impl<T: Stored> Descent for flow::Descent<T> {
    measures!();

    fn step(&mut self) -> Result<(StepInfo, bool)> {
        let (info, length) = self.step()?;
        Ok((info, length == 0.0))
    }

    fn evaluations(&self) -> u64 {
        self.counts()[1]
    }

    fn save(&self, state: &mut State) {
        state.put_u64("counts", &self.counts());
        T::put(state, "v", self.solver().x());
        let mut pairs = 0;
        for (n, (step, change)) in self.solver().pairs().enumerate() {
            T::put(state, &format!("step_{n}"), step);
            T::put(state, &format!("change_{n}"), change);
            pairs = n as u64 + 1;
        }
        state.put_u64("pairs", &[pairs]);
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        let length = self.energy().voxels();
        let pair = |n: u64| -> Result<(Vec<T>, Vec<T>)> {
            let step = T::get(state, &format!("step_{n}"), length)?;
            Ok((step, T::get(state, &format!("change_{n}"), length)?))
        };
        let pairs: Result<Vec<_>> = (0..state.one_u64("pairs")?).map(pair).collect();
        let &[steps, evaluations] = state.all_u64("counts")? else {
            return Err(Error::Checkpoint("`counts` should hold 2 counters".into()));
        };
        self.restore(T::get(state, "v", length)?, pairs?, [steps, evaluations]);
        Ok(())
    }
}
