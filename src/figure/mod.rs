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
    ("curvature-10", include_str!("../../examples/curvature-10.toml")),
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
    ("willmore", include_str!("../../examples/willmore.toml")),
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
    /// Further files of each run, in rows below the first.
    #[serde(default)]
    pub also: Vec<String>,
    /// Width of each panel in a figure of several (pixels); absent: as it was drawn.
    pub width: Option<u32>,
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
    let mut rows: Vec<Vec<(String, Vec<u8>)>> = vec![Vec::new(); 1 + figure.caption.also.len()];
    for (n, panel) in figure.panels.iter().enumerate() {
        let mut request = Request::new(&panel.command, panel.seed);
        request.config = panel.config.clone();
        if quick {
            request.config.extend(figure.caption.quick.clone());
        }
        let out = folder.join("runs").join(format!("{id}-{}", n + 1));
        start(&request, &out).with_context(|| format!("figure {id}"))?;
        let read = |name: &String| {
            std::fs::read(out.join(name))
                .with_context(|| format!("figure {id}: the run made no `{name}`"))
        };
        let first = panel.picture.as_ref().unwrap_or(&figure.caption.picture);
        let names = std::iter::once(first).chain(&figure.caption.also);
        for (row, name) in rows.iter_mut().zip(names) {
            row.push((panel.title.clone(), read(name)?));
        }
        for more in &panel.more {
            rows[0].push((more.title.clone(), read(&more.picture)?));
        }
    }
    let bytes = match rows.as_slice() {
        [row] if row.len() == 1 && row[0].0.is_empty() => row[0].1.clone(),
        _ => sheet::encode(&interleave(&rows, figure.caption.columns), figure.caption.width)?,
    };
    let path = folder.join(format!("{id}.png"));
    output::save_bytes(&path, &bytes)?;
    Ok(path)
}

/// Rows of at most `columns` panels: of each stretch of runs the first pictures, then the others.
fn interleave(rows: &[Vec<(String, Vec<u8>)>], columns: usize) -> Vec<Vec<(String, Vec<u8>)>> {
    let runs = rows.first().map_or(0, Vec::len);
    let columns = columns.clamp(1, runs.max(1));
    let stretch = |first: usize| {
        rows.iter().map(move |row| {
            let end = row.len();
            row[first.min(end)..(first + columns).min(end)].to_vec()
        })
    };
    (0..runs).step_by(columns).flat_map(stretch).collect()
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
