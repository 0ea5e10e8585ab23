//! `patterns render`: pictures of surfaces.

use crate::{
    input,
    output::{save, surface},
    render::{Projection, Up, View},
};
use anyhow::{Result, bail, ensure};
use patterns::Surface;
use solvers::isosurface::Caps;
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Draw a surface mesh, or the level surface of a volume, as a picture or a film around it.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: patterns render out/topopt-1/part.ply --view 40,30 --out part.png"
)]
pub(super) struct Args {
    /// Mesh (PLY, STL, OBJ, GLB) or volume (NPY, NPZ, VTI, NRRD, NIfTI, MRC, TIFF stack).
    input: PathBuf,
    /// File to write [default: the input's name with .png, or .gif for a film].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Overwrite the output.
    #[arg(long)]
    force: bool,
    /// Level of a volume's surface; the inside lies below it [default: 0 if the values have
    /// both signs, else half way between least and greatest].
    #[arg(long)]
    level: Option<f64>,
    /// The inside of a volume lies above the level, as in densities and images.
    #[arg(long)]
    above: bool,
    /// How a volume's surface ends at the box: closed by dark cuts, open, or with the first
    /// nodes after the last: periodic-closed, periodic.
    #[arg(long, default_value = "closed", value_parser = caps)]
    caps: Caps,
    /// Degrees right of the front and above the horizon.
    #[arg(long, value_name = "AZ,EL", default_value = "30,25", value_parser = view, allow_hyphen_values = true)]
    view: [f64; 2],
    /// Which way is up: -y (as in the pictures of fields), y or z.
    #[arg(long, default_value = "-y", value_parser = up, allow_hyphen_values = true)]
    up: Up,
    /// Parallel lines stay parallel.
    #[arg(long)]
    orthographic: bool,
    /// Draw the edges of the box around the shape.
    #[arg(long)]
    frame: bool,
    /// Side of the picture in pixels, 16 to 8192; films are half as large.
    #[arg(long, default_value_t = 900, value_parser = clap::value_parser!(u16).range(16..=8192))]
    size: u16,
    /// A film of so many pictures around the shape, as .gif or .apng.
    #[arg(long, value_name = "FRAMES", num_args = 0..=1, default_missing_value = "60",
          value_parser = clap::value_parser!(u16).range(2..=720))]
    turntable: Option<u16>,
}

fn caps(name: &str) -> Result<Caps> {
    Ok(match name {
        "closed" => Caps::Closed,
        "open" => Caps::Open,
        "periodic" => Caps::Periodic,
        "periodic-closed" => Caps::PeriodicClosed,
        _ => bail!("known are closed, open, periodic and periodic-closed"),
    })
}

fn up(name: &str) -> Result<Up> {
    Ok(match name {
        "-y" => Up::MinusY,
        "y" => Up::Y,
        "z" => Up::Z,
        _ => bail!("known are -y, y and z"),
    })
}

fn view(text: &str) -> Result<[f64; 2]> {
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [azimuth, elevation] if text.matches(',').count() == 1 => {
            ensure!(azimuth.is_finite(), "azimuth = {azimuth} is not finite");
            ensure!(
                elevation.abs() <= 90.0,
                "elevation = {elevation} is outside its range [-90, 90]"
            );
            Ok([azimuth, elevation])
        }
        _ => bail!("two numbers are wanted, such as 30,25"),
    }
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    let film = args.turntable.is_some();
    let out = args.out.clone();
    let out = out.unwrap_or_else(|| args.input.with_extension(if film { "gif" } else { "png" }));
    let extension = out.extension().and_then(|e| e.to_str()).unwrap_or("");
    let known = if film { &["gif", "apng", "png"][..] } else { &["png"][..] };
    ensure!(
        known.contains(&extension),
        "cannot write `{}`; wanted is .{}",
        out.display(),
        known.join(" or .")
    );
    ensure!(args.force || !out.exists(), "`{}` exists; --force overwrites it", out.display());
    let surface = load(args)?;
    ensure!(!surface.mesh.triangles.is_empty(), "`{}` has no surface there", args.input.display());
    let [azimuth, elevation] = args.view;
    let mut look = surface::Look { size: args.size.into(), ..surface::Look::default() };
    look.view = View { azimuth, elevation, up: args.up, ..look.view };
    if args.orthographic {
        look.view.projection = Projection::Orthographic;
    }
    save(&out, |sink| match film {
        true => surface::write_film(&surface, &look, Path::new(&out), sink),
        false => surface::draw(&surface, &look)?.write_png(sink),
    })?;
    Ok(ExitCode::SUCCESS)
}

/// The surface of a mesh or volume.
fn load(args: &Args) -> Result<Surface> {
    let turntable = args.turntable.unwrap_or(0).into();
    let mut surface = Surface { turntable, ..Surface::default() };
    if let Some(mesh) = input::load_mesh(&args.input)? {
        surface.mesh = mesh;
        // Some programs turn all triangles over.
        let welded = surface.mesh.weld();
        if welded.is_closed() && welded.volume() < 0.0 {
            surface.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    } else {
        let found = input::load_surface(&args.input, args.level, args.above, args.caps)?;
        (surface.mesh, surface.caps) = (found.mesh, found.caps);
    }
    if args.frame {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for v in &surface.mesh.vertices {
            low = [0, 1, 2].map(|m| low[m].min(v[m]));
            high = [0, 1, 2].map(|m| high[m].max(v[m]));
        }
        surface.frame = Some([low, high]);
    }
    Ok(surface)
}
