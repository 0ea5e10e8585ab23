//! Inference reads what people have: phases, two-valued volumes and closed meshes of one texture
//! are the same shape.

use lab::output::npy;
use std::{fs, path::Path, process::Command};

fn patterns(folder: &Path, args: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_patterns"));
    let output = command.current_dir(folder).args(args).arg("--quiet").output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn metric(folder: &Path, name: &str) -> f64 {
    let text = fs::read_to_string(folder.join("run.json")).unwrap();
    let run: serde_json::Value = serde_json::from_str(&text).unwrap();
    run["metrics"][name].as_f64().unwrap_or_else(|| panic!("{name} is not in {text}"))
}

#[test]
fn files_of_one_texture_are_one_shape() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let grow = "curvature --preset tubes --size 40 --evaluations 120 --animation none --out grown";
    patterns(at, &grow.split(' ').collect::<Vec<_>>());
    let bytes = fs::read(at.join("grown/phase.npy")).unwrap();
    let phase = npy::read(&bytes, 1 << 24).unwrap();
    let mut labels = Vec::new();
    npy::write(&phase.mapv(|u| if u > 0.0 { 3.0 } else { 1.0 }).view(), &mut labels).unwrap();
    fs::write(at.join("labels.npy"), labels).unwrap();
    let few = "--count 3 --generations 0 --size 24 --evaluations 60 --force";
    for (name, file) in [
        ("phase", "grown/phase.npy"),
        ("labels", "labels.npy --label 3"),
        ("mesh", "grown/shape.stl --spacing 0.01"),
    ] {
        let args = format!("curvature infer {file} {few} --out {name}");
        patterns(at, &args.split(' ').collect::<Vec<_>>());
    }
    let of = |name: &str, what: &str| metric(&at.join(name), what);
    // A phase of thin tubes is not quite the profile of a distance: its mean is .03 greater.
    for name in ["labels", "mesh"] {
        for (what, bound) in [("shape_mass", 0.04), ("shape_area_density", 0.25)] {
            let (read, whole) = (of(name, what), of("phase", what));
            println!("{name} {what}: {read:.4}, of the phase {whole:.4}");
            assert!((read - whole).abs() < bound, "{name} {what}: {read} {whole}");
        }
        let (read, whole) = (of(name, "nearest_distance"), of("phase", "nearest_distance"));
        println!("{name}: nearest shape at {read:.2}, for the phase {whole:.2}");
    }
}
