//! Published figures and the README's pictures: `examples/*.toml` to one PNG each.

pub(crate) mod sheet;

use crate::{
    output, reconstruct,
    request::{Request, parse_toml},
    runner::{self, Options},
};
use anyhow::{Context as _, Result};
use serde::Deserialize;
use std::{
    path::{Path, PathBuf},
    time::Duration,
};
use toml::Table;

/// The files of `examples/`, carried by the program; a test sees to it that none is missing.
const EXAMPLES: &[(&str, &str)] = &[
    ("anisotropic", include_str!("../../examples/anisotropic.toml")),
    ("curvature", include_str!("../../examples/curvature.toml")),
    ("curvature-1", include_str!("../../examples/curvature-1.toml")),
    ("curvature-11", include_str!("../../examples/curvature-11.toml")),
    ("curvature-13", include_str!("../../examples/curvature-13.toml")),
    ("curvature-2", include_str!("../../examples/curvature-2.toml")),
    ("curvature-4", include_str!("../../examples/curvature-4.toml")),
    ("curvature-8", include_str!("../../examples/curvature-8.toml")),
    ("figure-1-1", include_str!("../../examples/figure-1-1.toml")),
    ("figure-1-5", include_str!("../../examples/figure-1-5.toml")),
    ("figure-1-6", include_str!("../../examples/figure-1-6.toml")),
    ("figure-1-7", include_str!("../../examples/figure-1-7.toml")),
    ("figure-1-8", include_str!("../../examples/figure-1-8.toml")),
    ("formulas", include_str!("../../examples/formulas.toml")),
    ("gray-scott", include_str!("../../examples/gray-scott.toml")),
    ("growth", include_str!("../../examples/growth.toml")),
    ("kinetics", include_str!("../../examples/kinetics.toml")),
    ("spots", include_str!("../../examples/spots.toml")),
    ("strip", include_str!("../../examples/strip.toml")),
    ("topopt", include_str!("../../examples/topopt.toml")),
];

/// What a figure shows.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Caption {
    /// Name on the command line and of the picture.
    pub id: String,
    /// One sentence.
    pub title: String,
    /// The file of the run's output that is the picture.
    #[serde(default = "ink")]
    pub picture: String,
    /// Panels in a row.
    #[serde(default = "two")]
    pub columns: usize,
    /// Settings that make a quick version of the same figure.
    #[serde(default)]
    pub quick: Table,
}

fn ink() -> String {
    "ink.png".into()
}

fn two() -> usize {
    2
}

/// A run of a figure with several panels.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// Text under the panel.
    pub title: String,
    /// Name of the model.
    pub command: String,
    /// Seed of all random streams.
    #[serde(default)]
    pub seed: u64,
    /// The file of the run's output that is the picture; absent: that of the figure.
    pub picture: Option<String>,
    /// Further panels that show other pictures of the same run.
    #[serde(default)]
    pub more: Vec<More>,
    /// Configuration of the model.
    #[serde(default)]
    pub config: Table,
}

/// Another picture of a [`Panel`]'s run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct More {
    /// Text under the panel.
    pub title: String,
    /// The file of the run's output that is the picture.
    pub picture: String,
}

/// A figure, ready to be made.
#[derive(Clone, Debug)]
pub struct Figure {
    /// What it shows.
    pub caption: Caption,
    /// Its runs; one for a figure without panels.
    pub panels: Vec<Panel>,
}

/// All figures, in order of the files' names.
///
/// # Errors
/// If an example is broken; a test sees to it that none is.
pub fn all() -> Result<Vec<Figure>> {
    let mut figures = Vec::new();
    for (name, text) in EXAMPLES {
        let file = parse_toml(text, Path::new(name))?;
        let Some(caption) = file.figure else { continue };
        let mut panels = file.panel;
        if panels.is_empty() {
            panels.push(Panel {
                title: String::new(),
                command: file.command,
                seed: file.seed,
                picture: None,
                more: Vec::new(),
                config: file.config,
            });
        }
        figures.push(Figure { caption, panels });
    }
    Ok(figures)
}

/// Runs a figure's panels in `folder/runs/` and writes `folder/<id>.png`.
///
/// # Errors
/// If a run fails, or the folder cannot be written to.
pub fn make(figure: &Figure, folder: &Path, quick: bool) -> Result<PathBuf> {
    let id = &figure.caption.id;
    let mut pictures = Vec::new();
    for (n, panel) in figure.panels.iter().enumerate() {
        let mut request = Request::new(&panel.command, panel.seed);
        request.config = panel.config.clone();
        if quick {
            request.config.extend(figure.caption.quick.clone());
        }
        let out = folder.join("runs").join(format!("{id}-{}", n + 1));
        let name = panel.picture.as_ref().unwrap_or(&figure.caption.picture);
        start(&request, &out).with_context(|| format!("figure {id}"))?;
        let first = std::iter::once((&panel.title, name));
        for (title, name) in first.chain(panel.more.iter().map(|m| (&m.title, &m.picture))) {
            let picture = std::fs::read(out.join(name))
                .with_context(|| format!("figure {id}: the run made no `{name}`"))?;
            pictures.push((title.clone(), picture));
        }
    }
    let bytes = match pictures.as_slice() {
        [(title, picture)] if title.is_empty() => picture.clone(),
        _ => sheet::encode(&pictures, figure.caption.columns)?,
    };
    let path = folder.join(format!("{id}.png"));
    output::save_bytes(&path, &bytes)?;
    Ok(path)
}

/// Runs a panel in its own folder.
fn start(request: &Request, out: &Path) -> Result<()> {
    let out = Some(out.to_path_buf());
    if request.command == "reconstruct" {
        // As many generations as the file tells, however long they take.
        let budget = Duration::MAX;
        let options = reconstruct::Options { out, force: true, quiet: true, budget };
        reconstruct::run(request, &options)?;
    } else {
        let options = Options { out, force: true, frames: 0, ..Options::default() };
        runner::run(request, &options)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_example_is_registered_and_parses() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|e| e == "toml"))
            .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        files.sort();
        let registered: Vec<&str> = EXAMPLES.iter().map(|(name, _)| *name).collect();
        assert_eq!(files, registered);
        assert!(all().unwrap().len() >= 4);
    }
}
