//! The steppers whose diffusion is implicit or exact, behind [`Stepper`].

use super::config::Method;
use super::stepper::{Setup, Stepper};
use crate::{Error, Result, State};
use solvers::Field;
use solvers::diffusion::explicit::Stencil;
use solvers::diffusion::{
    Diffusivity, Etdrk4, Etdrk4Config, ImexScheme, Operator, Reaction, SemiImplicit,
    SemiImplicitConfig,
};
use solvers::spectral::{LaplacianSymbol, LinearPart};

/// A stepper over any reaction; the concentrations are its whole state.
pub(super) struct General {
    engine: Engine,
    reaction: Box<dyn Reaction + Send>,
    clamp: bool,
    u: Vec<Vec<f64>>,
}

enum Engine {
    Euler { dt: f64, operators: Vec<Operator>, rates: Vec<Vec<f64>>, spread: Vec<f64> },
    SemiImplicit(SemiImplicit),
    Etdrk4(Etdrk4),
}

/// The symbol of a stencil, so that all steppers agree on the wavelength.
pub(super) fn symbol(stencil: Stencil) -> LaplacianSymbol {
    match stencil {
        Stencil::NinePoint => LaplacianSymbol::Isotropic,
        Stencil::Axes => LaplacianSymbol::Axes,
    }
}

impl General {
    /// A stepper at concentrations 0.
    ///
    /// # Errors
    /// If a diffusivity is not valid, or ETDRK4 is asked for one that is not constant.
    pub(super) fn new(
        setup: &Setup,
        method: Method,
        diffusivity: &[Diffusivity],
        reaction: Box<dyn Reaction + Send>,
    ) -> Result<Self> {
        let Setup { grid, boundary, dt, clamp, .. } = *setup;
        let laplacian = symbol(setup.stencil);
        let engine = if method == Method::Explicit {
            euler(setup, diffusivity)?
        } else if method == Method::Etdrk4 {
            let linear = linear_parts(diffusivity).ok_or_else(|| {
                let reason = "etdrk4 needs a constant diffusion; use semi-implicit for maps";
                Error::config("stepper", reason)
            })?;
            let config = Etdrk4Config { dt, laplacian, dealias: false };
            Engine::Etdrk4(Etdrk4::new(grid, boundary, &linear, config)?)
        } else {
            let config = SemiImplicitConfig { dt, scheme: ImexScheme::Ars222, laplacian };
            Engine::SemiImplicit(SemiImplicit::new(grid, boundary, diffusivity, config)?)
        };
        Ok(Self { engine, reaction, clamp, u: vec![vec![0.0; grid.len()]; diffusivity.len()] })
    }

    /// How the diffusion is solved.
    pub(super) fn describe(&self) -> String {
        match &self.engine {
            Engine::Euler { .. } => "diffusion explicit, by bonds between cells".into(),
            Engine::SemiImplicit(engine) => engine.describe(),
            Engine::Etdrk4(_) => "diffusion exact in the Fourier or cosine series".into(),
        }
    }
}

/// Forward Euler with the diffusion of any operator.
fn euler(setup: &Setup, diffusivity: &[Diffusivity]) -> Result<Engine> {
    let operator = |d: &Diffusivity| Operator::new(setup.grid, setup.boundary, d);
    let operators = diffusivity.iter().map(operator).collect::<solvers::Result<Vec<_>>>()?;
    let fastest = operators.iter().map(Operator::max_rate).fold(0.0, f64::max);
    setup.check_rate(fastest)?;
    let nodes = setup.grid.len();
    let rates = vec![vec![0.0; nodes]; operators.len()];
    Ok(Engine::Euler { dt: setup.dt, operators, rates, spread: vec![0.0; nodes] })
}

/// Diffusion of each species as a function of the Laplacian's symbol, if all are constant.
pub(super) fn linear_parts(diffusivity: &[Diffusivity]) -> Option<Vec<LinearPart>> {
    let part = |d: &Diffusivity| match d {
        Diffusivity::Constant(d) => Some(LinearPart::diffusion(*d)),
        _ => None,
    };
    diffusivity.iter().map(part).collect()
}

impl Stepper for General {
    fn advance(&mut self, steps: u64) -> Result<()> {
        for _ in 0..steps {
            match &mut self.engine {
                Engine::Euler { dt, operators, rates, spread } => {
                    let dt = *dt;
                    let now: Vec<&[f64]> = self.u.iter().map(Vec::as_slice).collect();
                    let mut next: Vec<&mut [f64]> =
                        rates.iter_mut().map(Vec::as_mut_slice).collect();
                    self.reaction.rates(0, &now, &mut next);
                    for ((u, f), operator) in self.u.iter_mut().zip(rates).zip(operators) {
                        operator.apply(u, spread);
                        for ((u, f), d) in u.iter_mut().zip(f.iter()).zip(spread.iter()) {
                            *u += dt * (f + d);
                        }
                    }
                }
                Engine::SemiImplicit(engine) => engine.step(self.reaction.as_ref(), &mut self.u)?,
                Engine::Etdrk4(engine) => engine.step(self.reaction.as_ref(), &mut self.u)?,
            }
            if self.clamp {
                self.u.iter_mut().flatten().for_each(|u| *u = u.max(0.0));
            }
        }
        Ok(())
    }

    fn set(&mut self, species: usize, field: &Field) {
        self.u[species].copy_from_slice(field.as_slice());
    }

    fn copy_into(&self, species: usize, field: &mut Field) {
        field.as_mut_slice().copy_from_slice(&self.u[species]);
    }

    fn save(&self, names: &[String], state: &mut State) {
        for (name, u) in names.iter().zip(&self.u) {
            state.put_f64(name, u);
        }
    }

    fn restore(&mut self, names: &[String], state: &State) -> Result<()> {
        for (name, u) in names.iter().zip(&mut self.u) {
            state.get_f64(name, u)?;
        }
        Ok(())
    }
}
