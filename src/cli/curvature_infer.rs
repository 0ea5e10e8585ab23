//! `patterns curvature infer`: the parameters of a given texture.

use super::{run_args::RunArgs, values};
use crate::request::Request;
use anyhow::{Result, bail};
use std::process::ExitCode;

/// Find the polynomial and the mass that grow textures like a given one.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    patterns curvature infer bone.nii.gz --label 2 --atlas out/curvature-atlas-1\n  \
    patterns curvature infer shape.stl --spacing 0.01\n  \
    patterns curvature infer phase.npy --size 48 --count 32 --generations 10\n\
Curvatures are compared in 1/length: give --spacing so that the texture's finest radius of\n\
curvature is 2 to 10 hundredths, as in the atlas, or scale the results yourself.")]
pub(super) struct Args {
    /// A volume (NPY, VTI, NRRD, NIfTI, MRC, TIFF stack) or a closed mesh (PLY, STL, OBJ, GLB).
    #[arg(value_name = "FILE", required_unless_present = "resume")]
    shape: Option<String>,
    /// Output folder of `patterns curvature atlas` [default: a small atlas is drawn first].
    #[arg(long, value_name = "DIR")]
    atlas: Option<String>,
    /// Shapes of the atlas that is drawn where none is given [default: 64].
    #[arg(long, value_name = "N", conflicts_with = "atlas")]
    count: Option<u64>,
    /// Width of a voxel of the given shape; a mesh is read with such voxels [default: 0.01].
    #[arg(long, value_name = "LENGTH")]
    spacing: Option<f64>,
    /// Level of the volume's surface [default: 0 if the values have both signs, else half way
    /// between least and greatest].
    #[arg(long, value_name = "LEVEL", allow_hyphen_values = true)]
    level: Option<f64>,
    /// Voxels of this value are inside, all others outside.
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true, conflicts_with = "level")]
    label: Option<f64>,
    /// On which side of the level the shape is [default: above].
    #[arg(long, value_parser = ["above", "below"])]
    inside: Option<String>,
    /// Standard deviation of the blur of a volume of two values, voxels [default: 1.5].
    #[arg(long, value_name = "VOXELS")]
    smooth: Option<f64>,
    /// Nearest shapes of the atlas that the search begins at [default: 3].
    #[arg(long, value_name = "N")]
    starts: Option<u64>,
    /// Generations of the search, 8 shapes each: half of them the starts' by turns, a quarter the
    /// best one's, a quarter around all that are near [default: 32].
    #[arg(long, value_name = "N")]
    generations: Option<u64>,
    /// Voxels of the shapes that are grown: N or NZxNYxNX [default: 48].
    #[arg(long, value_name = "N")]
    size: Option<String>,
    /// Evaluations of the energy for each shape [default: 200].
    #[arg(long, value_name = "N")]
    evaluations: Option<u64>,
    #[command(flatten)]
    run: RunArgs,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    let mut request = Request::new("curvature-infer", 0);
    if let Some(size) = &args.size {
        request.set("growth.size", values::size(size, 3)?, "--size")?;
    }
    if let Some(folder) = &args.atlas
        && !std::path::Path::new(folder).join("diagrams.npy").is_file()
    {
        bail!("--atlas {folder}: no output folder of a finished `patterns curvature atlas`");
    }
    request.set_at("shape", args.shape.as_deref(), "FILE")?;
    request.set_flag("atlas", args.atlas.as_deref())?;
    request.set_flag("count", values::integer(args.count))?;
    request.set_flag("spacing", args.spacing)?;
    request.set_flag("level", args.level)?;
    request.set_flag("label", args.label)?;
    request.set_flag("inside", args.inside.as_deref())?;
    request.set_flag("smooth", args.smooth)?;
    request.set_flag("starts", values::integer(args.starts))?;
    request.set_flag("generations", values::integer(args.generations))?;
    let evaluations = values::integer(args.evaluations);
    request.set_at("growth.evaluations", evaluations, "--evaluations")?;
    args.run.execute(request)
}
