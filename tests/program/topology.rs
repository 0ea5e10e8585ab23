//! Topology optimization as it is called: masks, flags, pictures.

use image::{GrayImage, Luma};
use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

fn topopt(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_patterns"));
    command.current_dir(folder).arg("topopt").args(args).output().unwrap()
}

/// Densities of a run of one iteration, row by row.
fn densities(folder: &Path, args: &[&str]) -> Vec<f64> {
    let args = [args, &["--iterations", "1", "--force", "--out", "out"]].concat();
    let output = topopt(folder, &args);
    // One iteration does not converge: 1, but no error.
    assert!(output.status.code().is_some_and(|code| code < 2), "{output:?}");
    let bytes = fs::read(folder.join("out/density.npy")).unwrap();
    let values = bytes[bytes.len() - 32 * 20 * 8..].chunks_exact(8);
    values.map(|v| f64::from_le_bytes(v.try_into().unwrap())).collect()
}

/// A mask of 32 x 20 with an L in its upper left part, the same under no mirror or turn.
fn mask(folder: &Path, width: u32) -> Vec<bool> {
    let dark =
        |x: u32, y: u32| (2..5).contains(&x) && (1..9).contains(&y) || y == 8 && x < 11 && x > 4;
    let image = GrayImage::from_fn(width, 20, |x, y| Luma([if dark(x, y) { 40 } else { 200 }]));
    image.save(folder.join("mask.png")).unwrap();
    (0..20).flat_map(|y| (0..width).map(move |x| dark(x, y))).collect()
}

#[test]
fn dark_pixels_of_a_mask_are_fixed_where_they_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    let dark = mask(folder.path(), 32);
    for (material, fixed) in [("solid", 1.0), ("void", 0.0)] {
        let region = format!("problem.passive=[{{ image = 'mask.png', material = '{material}' }}]");
        let found = densities(
            folder.path(),
            &["--cantilever", "32x20", "--rules", "88", "--filter", "density", "--set", &region],
        );
        for (e, (rho, dark)) in found.iter().zip(&dark).enumerate() {
            let (x, y) = (e % 32, e / 32);
            assert_eq!(*rho == fixed, *dark, "column {x}, row {y} of {material}: {rho}");
        }
    }
}

#[test]
fn a_mask_of_another_size_is_refused_with_its_file_and_key() {
    let folder = tempfile::tempdir().unwrap();
    mask(folder.path(), 30);
    let region = "problem.passive=[{ image = 'mask.png' }]";
    let output = topopt(folder.path(), &["--cantilever", "32x20", "--set", region]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    for part in ["mask.png", "problem.passive.0.image", "[20, 30]", "[20, 32]"] {
        assert!(message.contains(part), "`{part}` is missing: {message}");
    }
}

/// Every flag reaches its key.
#[test]
fn flags_are_keys() {
    let folder = tempfile::tempdir().unwrap();
    let flags = [
        ("penalization", "2.5", "penalization"),
        ("penalization-start", "1.5", "penalization_start"),
        ("penalization-step", "0.25", "penalization_step"),
        ("penalization-every", "9", "penalization_every"),
        ("void-stiffness", "0.001", "void_stiffness"),
        ("move-limit", "0.15", "move_limit"),
        ("damping", "0.4", "damping"),
        ("stress-exponent", "6.0", "stress_exponent"),
        ("solver-tolerance", "1e-6", "solver_tolerance"),
        ("projection", "8.0", "projection.beta_max"),
        ("projection-start", "2.0", "projection.beta"),
        ("projection-every", "12", "projection.every"),
        ("projection-eta", "0.45", "projection.eta"),
        ("robust", "0.0", "projection.delta"),
        ("nucleate-every", "7", "level_set.nucleate_every"),
        ("nucleate-fraction", "0.02", "level_set.nucleate_fraction"),
        ("redistance-every", "4", "level_set.redistance_every"),
        ("smoothing", "0.8", "level_set.smoothing"),
        ("ersatz", "0.002", "level_set.ersatz"),
        ("front-step", "0.5", "level_set.step"),
        ("volume-step", "0.02", "level_set.volume_step"),
        ("youngs-modulus", "2.0", "problem.youngs_modulus"),
        ("poisson-ratio", "-0.2", "problem.poisson_ratio"),
        ("unit", "0.5", "problem.unit"),
    ];
    let mut args = vec!["--cantilever".to_owned(), "32x20".into(), "--filter".into()];
    args.extend(
        ["density", "--rules", "88", "--preserve-volume", "--holes", "3,2"].map(String::from),
    );
    args.extend(["--plane", "plane-strain", "--body-force", "0,-0.01"].map(String::from));
    for (flag, value, _) in flags {
        args.extend([format!("--{flag}"), value.to_owned()]);
    }
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    densities(folder.path(), &args);
    let text = fs::read_to_string(folder.path().join("out/run.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&text).unwrap();
    let found =
        |key: &str| key.split('.').fold(&manifest["config"], |value, part| &value[part]).clone();
    for (flag, value, key) in flags {
        let wanted: f64 = value.parse().unwrap();
        assert_eq!(found(key).as_f64(), Some(wanted), "--{flag}");
    }
    assert_eq!(found("projection.preserve_volume"), true);
    assert_eq!(found("level_set.holes"), serde_json::json!([3, 2]));
    assert_eq!(found("problem.plane"), "plane-strain");
    assert_eq!(found("problem.body_force"), serde_json::json!([0.0, -0.01]));
}
