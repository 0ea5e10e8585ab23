//! What a run shows.

use super::{Rd, measure};
use crate::{Artifact, Axis, Colors, Image, Mark, Plot, Series};
use solvers::{Field, Grid, isosurface};

impl Rd {
    /// All that can be drawn or saved in the current state.
    pub(super) fn pictures(&self) -> Vec<Artifact> {
        let phi = self.phi();
        let grid = phi.grid();
        let mut artifacts = vec![Artifact::Image(self.ink_image(phi.clone()))];
        for (species, name) in self.names.iter().enumerate() {
            let mut field = Field::constant(grid, 0.0);
            self.stepper.copy_into(species, &mut field);
            artifacts.push(Artifact::Image(self.image(name, field, &phi)));
        }
        match grid.dim() {
            2 => artifacts.push(Artifact::contour("contour", &phi)),
            3 => {
                if let Ok(mesh) = isosurface::triangulate(&phi, 0.0, isosurface::Caps::Closed) {
                    artifacts.push(Artifact::Mesh { name: "surface".into(), mesh });
                }
            }
            _ => {}
        }
        let predicted = self.prediction.as_ref().and_then(|p| p.wavelength);
        if let Some(spectrum) = self.spectrum() {
            artifacts.push(Artifact::Plot(measure::spectrum_plot(&spectrum, predicted)));
            if let Some(prediction) = &self.prediction {
                let plot = measure::dispersion_plot(prediction, spectrum.peak_wavelength());
                artifacts.push(Artifact::Plot(plot));
            }
        }
        artifacts.extend(self.snapshot_artifacts(&phi));
        if grid.dim() == 1 {
            artifacts.extend(self.history_artifact());
        }
        artifacts
    }

    pub(super) fn image(&self, name: &str, field: Field, phi: &Field) -> Image {
        Image {
            name: name.into(),
            field,
            label: format!("{name} (concentration)"),
            colors: Colors::Sequential,
            range: None,
            contour: Some(phi.clone()),
            rows: None,
        }
    }

    pub(super) fn ink_image(&self, phi: Field) -> Image {
        Image {
            name: "ink".into(),
            field: phi.clone(),
            label: "ink".into(),
            colors: Colors::Ink,
            range: None,
            contour: Some(phi),
            rows: None,
        }
    }

    /// Snapshots as panels of a plot (1D) or as pictures.
    fn snapshot_artifacts(&self, phi: &Field) -> Vec<Artifact> {
        let name = &self.names[self.ink];
        if self.c.grid().dim() > 1 {
            let image = |(n, field): &(u64, Field)| {
                let mut image = self.image(&format!("{name}-{n}"), field.clone(), phi);
                image.contour = None;
                Artifact::Image(image)
            };
            return self.snapshots.iter().map(image).collect();
        }
        if self.snapshots.is_empty() {
            return Vec::new();
        }
        let series = |(n, field): &(u64, Field)| Series {
            label: format!("iteration {n}"),
            points: field.as_slice().iter().enumerate().map(|(i, &v)| [i as f64, v]).collect(),
            mark: if *n == 0 { Mark::Dashed } else { Mark::Line },
        };
        vec![Artifact::Plot(Plot {
            name: "snapshots".into(),
            title: format!("Concentration of {name} across the row"),
            x: Axis::linear("x (cells)"),
            y: Axis::linear(&format!("{name} (concentration)")),
            series: self.snapshots.iter().map(series).collect(),
        })]
    }

    /// The history of a row as a picture: x to the right, time downwards.
    fn history_artifact(&self) -> Option<Artifact> {
        let nx = self.c.as_slice().len();
        let grid = Grid::new(&[self.history.len() / nx, nx], 1.0).ok()?;
        let field = Field::from_vec(grid, self.history.clone()).ok()?;
        let name = &self.names[self.ink];
        Some(Artifact::Image(Image {
            name: "history".into(),
            field,
            label: format!("{name} (concentration)"),
            colors: Colors::Sequential,
            range: None,
            contour: None,
            rows: Some(("iteration", self.history_every() as f64)),
        }))
    }
}
