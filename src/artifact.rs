//! From what a run shows to the files of its output folder.

use crate::folder::Folder;
use crate::output::{self, colormap::Rgb};
use crate::output::{csv, dxf, glb, map, mesh, npy, picture, plot, surface, svg, vti};
use anyhow::{Context as _, Result};
use patterns::{Artifact, Colors, Image, Plot, Surface};
use rayon::prelude::*;
use solvers::{Field, mesh::TriangleMesh};
use std::io::Write;

/// A file in memory: its name and its bytes.
pub type NamedBytes = (String, Vec<u8>);

/// A file of an artifact that is yet to be written.
struct Job<'a> {
    file: String,
    write: Box<Writer<'a>>,
}

/// Writes a file.
type Writer<'a> = dyn FnOnce(&mut Out<'_>) -> Result<()> + Send + 'a;

/// What jobs write to.
type Out<'a> = &'a mut (dyn Write + Send);

/// The files of all artifacts, in their order; they are encoded in parallel.
///
/// # Errors
/// If an artifact cannot be drawn.
pub fn encode_all(artifacts: &[Artifact]) -> Result<Vec<NamedBytes>> {
    let encode = |job: Job<'_>| {
        let mut bytes = Vec::new();
        (job.write)(&mut (&mut bytes as Out<'_>))
            .with_context(|| format!("cannot draw `{}`", job.file))?;
        Ok((job.file, bytes))
    };
    jobs(artifacts).into_par_iter().map(encode).collect()
}

/// Writes the files of all artifacts into `folder`, in parallel and none of them whole in memory.
///
/// # Errors
/// If an artifact cannot be drawn or written; files that were written by then count as such.
pub fn write_all(artifacts: &[Artifact], folder: &mut Folder) -> Result<()> {
    let path = folder.path().to_path_buf();
    let write = |job: Job<'_>| {
        let result =
            output::save(&path.join(&job.file), |sink| (job.write)(&mut (sink as Out<'_>)));
        (job.file, result)
    };
    let files: Vec<(String, Result<()>)> = jobs(artifacts).into_par_iter().map(write).collect();
    for (file, result) in &files {
        if result.is_ok() {
            folder.adopt(std::slice::from_ref(file));
        }
    }
    files.into_iter().try_for_each(|(_, result)| result)
}

fn jobs(artifacts: &[Artifact]) -> Vec<Job<'_>> {
    artifacts.iter().flat_map(of).collect()
}

fn of(artifact: &Artifact) -> Vec<Job<'_>> {
    match artifact {
        Artifact::Image(image) => of_image(image),
        Artifact::Drawing { image, strokes } => {
            vec![job(&image.name, "png", |out| picture::write_drawing(image, strokes, out))]
        }
        Artifact::Contour { name, lines, size } => {
            let style = svg::Style::default();
            let mut jobs = vec![
                job(name, "svg", move |out| svg::write_svg(lines, *size, style, out)),
                job(name, "csv", |out| csv::write_lines(lines, out)),
            ];
            if name == "outline" {
                let unit = dxf::Unit::default();
                jobs.push(job(name, "dxf", move |out| dxf::write(lines, size[1], unit, out)));
            }
            jobs
        }
        Artifact::Mesh { name, mesh } => {
            let surface = Surface { mesh: mesh.clone(), ..Surface::default() };
            let draw = move |out: &mut Out<'_>| draw(&surface, out);
            let mut jobs = vec![job(name, "png", draw)];
            jobs.extend(of_mesh(name, mesh, Vec::new()));
            jobs
        }
        Artifact::Surface(surface) => of_surface(surface),
        Artifact::Plot(plot) => of_plot(plot),
        Artifact::Table { name, columns } => {
            vec![job(name, "csv", |out| csv::write_table(columns, out))]
        }
        Artifact::Map(map) => vec![
            job(&map.name, "png", |out| map::write_png(map, out)),
            job(&map.name, "svg", |out| map::write_svg(map, out)),
        ],
        Artifact::Array { name, field } => vec![of_array(name, field)],
        _ => Vec::new(),
    }
}

/// A picture; the numbers too, unless it is only ink on paper.
fn of_image(image: &Image) -> Vec<Job<'_>> {
    let (name, field) = (&image.name, &image.field);
    let style = picture::Style::default();
    let mut jobs = vec![job(name, "png", move |out| picture::write_png(image, &style, out))];
    if image.colors != Colors::Ink {
        jobs.push(of_array(name, field));
        jobs.push(job(name, "vti", move |out| vti::write(&[(name, field)], out)));
    }
    jobs
}

fn of_array<'a>(name: &str, field: &'a Field) -> Job<'a> {
    job(name, "npy", |out| {
        let values = field.view().into_dyn();
        npy::write(&values.into_shape_with_order(field.grid().axes().to_vec())?, out)
    })
}

/// A surface as picture, for other programs, and as a film if one is wanted.
fn of_surface(surface: &Surface) -> Vec<Job<'_>> {
    let name = &surface.name;
    let mut jobs = vec![job(name, "png", |out| draw(surface, out))];
    jobs.extend(of_mesh(name, &surface.mesh, surface::colors(surface)));
    if surface.turntable > 0 {
        let look = surface::Look::default();
        let film = move |out: &mut Out<'_>| surface::write_turntable(surface, &look, out);
        jobs.push(job(name, "gif", film));
    }
    jobs
}

fn draw(surface: &Surface, out: &mut Out<'_>) -> Result<()> {
    surface::draw(surface, &surface::Look::default())?.write_png(out)
}

/// A mesh for other programs, `colors` at its vertices or none.
fn of_mesh<'a>(name: &str, mesh: &'a TriangleMesh, colors: Vec<Rgb>) -> [Job<'a>; 4] {
    [
        job(name, "ply", |out| mesh::write_ply(mesh, out)),
        job(name, "stl", |out| mesh::write_stl(mesh, out)),
        job(name, "obj", |out| mesh::write_obj(mesh, out)),
        job(name, "glb", move |out| glb::write(mesh, &colors, out)),
    ]
}

/// A plot as picture and drawing, and its points, one row each.
fn of_plot(plot: &Plot) -> Vec<Job<'_>> {
    let name = &plot.name;
    let table = |out: &mut Out<'_>| {
        let points = plot.series.iter().enumerate();
        let rows: Vec<(f64, [f64; 2])> =
            points.flat_map(|(n, s)| s.points.iter().map(move |&p| (n as f64, p))).collect();
        let columns = vec![
            ("series".to_owned(), rows.iter().map(|r| r.0).collect()),
            (plot.x.label.clone(), rows.iter().map(|r| r.1[0]).collect()),
            (plot.y.label.clone(), rows.iter().map(|r| r.1[1]).collect()),
        ];
        csv::write_table(&columns, out)
    };
    vec![
        job(name, "png", |out| plot::write_png(plot, out)),
        job(name, "svg", |out| plot::write_svg(plot, out)),
        job(name, "csv", table),
    ]
}

fn job<'a>(
    name: &str,
    extension: &str,
    write: impl FnOnce(&mut Out<'_>) -> Result<()> + Send + 'a,
) -> Job<'a> {
    Job { file: format!("{name}.{extension}"), write: Box::new(write) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_before_a_failure_is_known() {
        let place = tempfile::tempdir().unwrap();
        let mut folder = Folder::open(place.path());
        let table = |name: &str| Artifact::Table {
            name: name.into(),
            columns: vec![("x".into(), vec![1.0, 2.0])],
        };
        let error = write_all(&[table("a"), table("missing/b"), table("c")], &mut folder);
        let message = format!("{:#}", error.unwrap_err());
        assert!(message.contains("missing/b.csv"), "{message}");
        assert_eq!(folder.files(), ["a.csv", "c.csv"]);
        let bytes = encode_all(&[table("a")]).unwrap();
        assert_eq!(std::fs::read(place.path().join("a.csv")).unwrap(), bytes[0].1);
    }
}
