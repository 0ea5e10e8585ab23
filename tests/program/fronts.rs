//! What a front may start from: shapes combined, and the lines that another run wrote.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

fn patterns(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_patterns"));
    let output = command.current_dir(folder).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Metrics of a run that moves the front by a millionth of a cell.
fn start(folder: &Path, args: &[&str]) -> serde_json::Value {
    let still =
        ["--size", "100", "--iterations", "1", "--time", "1e-6", "--json", "--force", "--out"];
    let args = [&["level-set"][..], args, &still, &["still"]].concat();
    let manifest: serde_json::Value =
        serde_json::from_slice(&patterns(folder, &args).stdout).unwrap();
    manifest["metrics"].clone()
}

fn close(metrics: &serde_json::Value, name: &str, wanted: f64, tolerance: f64) {
    let found = metrics[name].as_f64().unwrap();
    assert!((found - wanted).abs() <= tolerance, "{name}: {found}, wanted {wanted}");
}

/// Areas of disks and squares that are known; the marching squares err by 0.1 % of them.
#[test]
fn shapes_are_combined_by_flags() {
    let folder = tempfile::tempdir().unwrap();
    let disk = std::f64::consts::PI * 100.0;
    let two = start(
        folder.path(),
        &[
            "--shape",
            "circle",
            "--intersect",
            "circle,x=30,size=10",
            "--union",
            "circle,x=30,size=10",
        ],
    );
    // The order is fixed: the union adds what the intersection then keeps.
    close(&two, "area", disk, 1.0);
    let apart = start(
        folder.path(),
        &[
            "--shape",
            "circle",
            "--subtract",
            "square,size=25",
            "--union",
            "circle,x=10,y=10,size=8",
        ],
    );
    let corners = std::f64::consts::PI * 900.0
        - 4.0 * (30.0 * 30.0 * (25.0_f64 / 30.0).acos() - 25.0 * (900.0_f64 - 625.0).sqrt());
    // The square takes all of the disk of radius 30 but four segments.
    let segments = std::f64::consts::PI * 900.0 - corners;
    // Redistancing rounds the eight sharp tips by less than a cell each.
    close(&apart, "area", segments + std::f64::consts::PI * 64.0, 8.0);
    close(&apart, "components", 5.0, 0.0);
    let turned =
        start(folder.path(), &["--shape", "square", "--subtract", "square,turn=45,size=10"]);
    close(&turned, "area", 3600.0 - 400.0, 2.0);
    close(&turned, "euler_number", 0.0, 0.0);
}

/// The contour that a run writes is where the next one starts, by either format.
#[test]
fn a_written_contour_is_a_start() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let first = start(folder.path(), &["--shape", "star", "--subtract", "circle,size=8"]);
    let written = fs::read_to_string(at("still/contour.csv")).unwrap();
    fs::write(at("rows.csv"), &written).unwrap();
    // The same as blocks of x,y.
    let (mut blocks, mut last) = (String::new(), "0");
    for row in written.lines().skip(1) {
        let (number, point) = row.split_once(',').unwrap();
        if number != last {
            blocks += "\n";
        }
        last = number;
        blocks += &format!("{point}\n");
    }
    fs::write(at("blocks.csv"), &blocks).unwrap();
    for file in ["rows.csv", "blocks.csv"] {
        let again = start(folder.path(), &["--contour", file]);
        // The star's ten corners are cut once more, by a fraction of a cell each.
        for (name, tolerance) in [("area", 1.0), ("perimeter", 2.0), ("euler_number", 0.0)] {
            close(&again, name, first[name].as_f64().unwrap(), tolerance);
        }
    }
    let rd = ["rd", "--contour", "rows.csv", "--size", "100", "--iterations", "20", "--out", "rd"];
    patterns(folder.path(), &rd);
    assert!(at("rd/inputs/rows.csv").exists());
}
