//! The steppers for any reaction, behind [`Stepper`]: diffusion explicit by bonds, implicit or exact.

use super::config::Method;
use super::stepper::{Setup, Stepper, Stretch};
use crate::{Error, Result, State};
use solvers::Field;
use solvers::diffusion::explicit::Stencil;
use solvers::diffusion::{
    Diffusivity, Etdrk4, Etdrk4Config, Euler, ImexScheme, Reaction, SemiImplicit,
    SemiImplicitConfig,
};
use solvers::spectral::{LaplacianSymbol, LinearPart};

/// A stepper over any reaction; the concentrations are its whole state.
pub(super) struct General {
    engine: Engine,
    reaction: Box<dyn Reaction + Send>,
    clamp: bool,
    /// Factor of all concentrations before and after each step.
    dilution: f64,
    u: Vec<Vec<f64>>,
}

enum Engine {
    Euler(Euler),
    SemiImplicit(SemiImplicit),
    Etdrk4(Etdrk4),
}

/// What is linear in each species besides the reaction.
pub(super) enum Linear {
    /// Diffusion of any kind.
    Diffusion(Vec<Diffusivity>),
    /// Functions of the Laplacian, which explicit steps by bonds cannot do.
    Parts(Vec<LinearPart>),
}

impl Linear {
    /// As functions of the Laplacian's symbol; `None` for diffusion that is not constant.
    pub(super) fn parts(&self) -> Option<Vec<LinearPart>> {
        let part = |d: &Diffusivity| match d {
            Diffusivity::Constant(d) => Some(LinearPart::diffusion(*d)),
            _ => None,
        };
        match self {
            Self::Diffusion(diffusivity) => diffusivity.iter().map(part).collect(),
            Self::Parts(parts) => Some(parts.clone()),
        }
    }

    fn species(&self) -> usize {
        match self {
            Self::Diffusion(diffusivity) => diffusivity.len(),
            Self::Parts(parts) => parts.len(),
        }
    }
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
        linear: &Linear,
        reaction: Box<dyn Reaction + Send>,
    ) -> Result<Self> {
        let Setup { grid, clamp, .. } = *setup;
        let engine = match method {
            Method::Explicit => euler(setup, linear)?,
            Method::SemiImplicit => semi_implicit(setup, linear)?,
            Method::Etdrk4 => etdrk4(setup, linear)?,
        };
        let u = vec![vec![0.0; grid.len()]; linear.species()];
        Ok(Self { engine, reaction, clamp, dilution: 1.0, u })
    }

    /// How the linear part is solved.
    pub(super) fn describe(&self) -> String {
        match &self.engine {
            Engine::Euler(_) => "diffusion explicit, by bonds between cells".into(),
            Engine::SemiImplicit(engine) => engine.describe(),
            Engine::Etdrk4(_) => "linear part exact in the Fourier or cosine series".into(),
        }
    }

    fn dilute(&mut self) {
        let factor = self.dilution;
        if factor != 1.0 {
            self.u.iter_mut().flatten().for_each(|u| *u *= factor);
        }
    }
}

fn euler(setup: &Setup, linear: &Linear) -> Result<Engine> {
    let Linear::Diffusion(diffusivity) = linear else {
        let reason = "this kinetics has no explicit step by bonds; use semi-implicit or etdrk4";
        return Err(Error::config("stepper", reason));
    };
    let engine = Euler::new(setup.grid, setup.boundary, diffusivity, setup.dt)?;
    setup.check_rate(engine.max_rate())?;
    Ok(Engine::Euler(engine))
}

fn semi_implicit(setup: &Setup, linear: &Linear) -> Result<Engine> {
    let Setup { grid, boundary, dt, .. } = *setup;
    let laplacian = symbol(setup.stencil);
    let config = SemiImplicitConfig { dt, scheme: ImexScheme::Ars222, laplacian };
    Ok(Engine::SemiImplicit(match linear {
        Linear::Diffusion(d) => SemiImplicit::new(grid, boundary, d, config)?,
        Linear::Parts(parts) => SemiImplicit::with_linear_parts(grid, boundary, parts, config)?,
    }))
}

fn etdrk4(setup: &Setup, linear: &Linear) -> Result<Engine> {
    let parts = linear.parts().ok_or_else(|| {
        let reason = "etdrk4 needs a constant diffusion; use semi-implicit for maps";
        Error::config("stepper", reason)
    })?;
    let config = Etdrk4Config { dt: setup.dt, laplacian: symbol(setup.stencil), dealias: false };
    Ok(Engine::Etdrk4(Etdrk4::new(setup.grid, setup.boundary, &parts, config)?))
}

impl Stepper for General {
    fn advance(&mut self, steps: u64) -> Result<()> {
        for _ in 0..steps {
            self.dilute();
            let reaction = self.reaction.as_ref();
            match &mut self.engine {
                Engine::Euler(engine) => engine.step(reaction, &mut self.u)?,
                Engine::SemiImplicit(engine) => engine.step(reaction, &mut self.u)?,
                Engine::Etdrk4(engine) => engine.step(reaction, &mut self.u)?,
            }
            self.dilute();
            if self.clamp {
                self.u.iter_mut().flatten().for_each(|u| *u = u.max(0.0));
            }
        }
        Ok(())
    }

    /// Half of the dilution before and half after a step keep the second order of the implicit one.
    fn stretch(&mut self, stretch: Stretch) -> Result<()> {
        self.dilution = stretch.dilution.sqrt();
        match &mut self.engine {
            Engine::Euler(engine) => engine.scale_laplacian(stretch.laplacian),
            Engine::SemiImplicit(engine) => engine
                .scale_laplacian(stretch.laplacian)
                .map_err(|error| Error::config("growth", error.to_string()))?,
            Engine::Etdrk4(engine) => engine.scale_laplacian(stretch.laplacian)?,
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
