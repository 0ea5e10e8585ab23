//! The level-set engine by itself: a shape or a picture moves at a chosen speed.
//!
//! `dphi/dt = -beta |grad phi|` (1.3) of Chattopadhyay & Mukherjee, with `phi < 0` inside.
//! Metrics: `area` (2D) or `volume` (3D), `perimeter` (the surface's area in 3D),
//! `components`, `euler_number`, `time`; lengths in cells.

mod config;
mod shape;

pub use config::{Config, SpeedConfig};
pub use shape::{Placed, ShapeConfig};

use shape::{Combination, combine};

use crate::{
    Artifact, Colors, Context, Error, Image, Metric, Model, Preset, Result, Run, State, Status,
    contour,
};
use solvers::{
    Field, Grid, isosurface,
    level_set::{LevelSet, Measures, Redistance, RedistanceOptions, Speed},
};

/// Registry entry.
pub static MODEL: Model = Model {
    name: "level-set",
    about: "A shape or a picture whose contour moves at a chosen speed",
    paper: "Osher & Sethian 1988, doi:10.1016/0021-9991(88)90002-2; Chattopadhyay & Mukherjee, eq. (1.3)",
    presets: || PRESETS.to_vec(),
    start,
};

const PRESETS: &[Preset] = &[
    Preset {
        name: "shrinking-star",
        about: "motion by curvature: a star becomes round and vanishes",
        config: "shape = 'star'\nspeed = [{ kind = 'curvature', coefficient = 1.0 }]",
    },
    Preset {
        name: "growing-square",
        about: "constant speed: the corners of a square become round",
        config: "shape = 'square'\ntime = 30.0\nspeed = [{ kind = 'constant', value = 1.0 }]",
    },
    Preset {
        name: "zalesak",
        about: "a notched disk carried once around",
        config: "size = [100, 100]\nshape = 'zalesak'\ntime = 628.3185307179587\nredistance_every = 0\n\
                 speed = [{ kind = 'rotation', rate = 0.01 }]",
    },
    Preset {
        name: "vortex",
        about: "a disk drawn out by a vortex, then back",
        config: "size = [128, 128]\ntime = 8.0\nredistance_every = 0\n\
                 shape = { kind = 'circle', center = [63.5, 95.5], radius = 19.2 }\n\
                 speed = [{ kind = 'vortex', period = 8.0 }]",
    },
];

/// phi, three Runge-Kutta buffers, six parts of the speed, distances and pictures.
const BYTES_PER_NODE: usize = 160;

struct Front {
    config: Config,
    front: LevelSet,
    speeds: Vec<Box<dyn Speed>>,
    redistance: Redistance,
    done: u64,
}

fn start(table: &toml::Table, context: &Context<'_>) -> Result<Box<dyn Run>> {
    let mut config: Config = crate::from_table(table)?;
    let mut phi = first_front(&mut config, context)?;
    let grid = phi.grid();
    let speeds = config.speeds(grid, context)?;
    let mut redistance =
        Redistance::new(grid, RedistanceOptions { boundary: config.boundary, band: None })?;
    if config.image.is_some() && config.combines() {
        // Grey levels become cells, so that shapes are combined with like.
        redistance.apply(&mut phi)?;
    }
    combine(&mut phi, &config.union, Combination::Union)?;
    combine(&mut phi, &config.intersect, Combination::Intersect)?;
    combine(&mut phi, &config.subtract, Combination::Subtract)?;
    redistance.apply(&mut phi)?;
    let front = LevelSet::new(phi, config.scheme())?;
    Ok(Box::new(Front { config, front, speeds, redistance, done: 0 }))
}

/// phi of the picture, the lines or the shape that the front starts from.
fn first_front(config: &mut Config, context: &Context<'_>) -> Result<Field> {
    if let Some(path) = &config.image {
        let image = context.inputs.field("image", path)?;
        config.size = image.grid().axes().to_vec();
        config.check()?;
        return Ok(config::below(image, config.level));
    }
    config.check()?;
    let grid =
        Grid::new(&config.size, 1.0).map_err(|error| Error::config("size", error.to_string()))?;
    crate::check_memory("size", grid, BYTES_PER_NODE, context)?;
    if let Some(path) = &config.contour {
        return contour::phi("contour", path, grid, context);
    }
    let shape = config.shape.shape("shape", grid)?;
    shape.field(grid).map_err(|error| Error::config("shape", error.to_string()))
}

impl Front {
    fn measures(&self) -> Measures {
        Measures::of(self.front.phi(), self.config.boundary)
    }
}

impl Run for Front {
    fn step(&mut self) -> Result<Status> {
        let end = self.config.time * (self.done + 1) as f64 / self.config.iterations as f64;
        while self.front.time() < end {
            self.front.advance(&mut self.speeds, end - self.front.time())?;
        }
        self.done += 1;
        let every = self.config.redistance_every;
        if every > 0 && self.done.is_multiple_of(every) {
            self.redistance.apply(self.front.phi_mut())?;
        }
        Ok(if self.done < self.config.iterations { Status::Running } else { Status::Done })
    }

    fn iterations(&self) -> u64 {
        self.done
    }

    fn max_iterations(&self) -> u64 {
        self.config.iterations
    }

    fn config(&self) -> toml::Table {
        crate::to_table(&self.config)
    }

    fn observe(&self) -> Vec<Metric> {
        let measures = self.measures();
        let (inside, border) = names(self.front.phi().grid().dim());
        vec![
            Metric::new(inside.0, measures.area, inside.1),
            Metric::new(border.0, measures.perimeter, border.1),
        ]
    }

    fn metrics(&self) -> Vec<Metric> {
        let measures = self.measures();
        let mut metrics = self.observe();
        metrics.push(Metric::new("components", measures.components as f64, "1"));
        metrics.push(Metric::new("euler_number", measures.euler_number as f64, "1"));
        metrics.push(Metric::new("time", self.front.time(), "time"));
        metrics
    }

    fn artifacts(&self) -> Vec<Artifact> {
        let phi = self.front.phi();
        let mut artifacts: Vec<Artifact> = self.frame().map(Artifact::Image).into_iter().collect();
        artifacts.push(Artifact::Image(Image {
            name: "phi".into(),
            field: phi.clone(),
            label: "signed distance phi (cells)".into(),
            colors: Colors::Diverging,
            range: None,
            contour: Some(phi.clone()),
            rows: None,
        }));
        if phi.grid().dim() == 3 {
            let mesh = isosurface::triangulate(phi, 0.0, isosurface::Caps::Closed);
            let mesh = mesh.unwrap_or_default();
            artifacts.push(Artifact::Mesh { name: "surface".into(), mesh });
        } else {
            artifacts.push(Artifact::contour("contour", phi));
        }
        artifacts
    }

    fn frame(&self) -> Option<Image> {
        let phi = self.front.phi();
        Some(Image {
            name: "ink".into(),
            field: phi.clone(),
            label: "inside".into(),
            colors: Colors::Ink,
            range: None,
            contour: Some(phi.clone()),
            rows: None,
        })
    }

    fn save(&self) -> State {
        let mut state = State::default();
        state.put_u64("done", &[self.done]);
        state.put_f64("time", &[self.front.time()]);
        state.put_f64("phi", self.front.phi().as_slice());
        state
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        let mut time = [0.0];
        state.get_f64("time", &mut time)?;
        state.get_f64("phi", self.front.phi_mut().as_mut_slice())?;
        self.front.set_time(time[0]);
        self.done = state.one_u64("done")?;
        Ok(())
    }
}

/// Names and units of the two measures.
fn names(dim: usize) -> ((&'static str, &'static str), (&'static str, &'static str)) {
    if dim == 3 {
        (("volume", "cells^3"), ("perimeter", "cells^2"))
    } else {
        (("area", "cells^2"), ("perimeter", "cells"))
    }
}
