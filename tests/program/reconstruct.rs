//! `patterns reconstruct`: the model is named, the hole filled, the files written.

use serde_json::Value;
use std::{fs, path::Path, process::Command};

fn patterns(folder: &Path, args: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_patterns"));
    let output = command.current_dir(folder).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn manifest(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("run.json")).unwrap()).unwrap()
}

#[test]
fn a_structure_behind_a_box_is_completed_and_the_run_repeats_itself() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a");
    let args = ["reconstruct", "--example", "topology-row-l", "--find", "--generations", "2"];
    let said = patterns(folder.path(), &[&args[..], &["--out", "a", "--threads", "1"]].concat());
    assert!(said.contains("flat regions") && said.contains("model: topology-row-l"), "{said}");
    let run = manifest(&out);
    assert_eq!(run["answer"]["class"], "topology-row-l");
    assert!(run["metrics"]["ink_iou"].as_f64().unwrap() >= 0.95, "{run}");
    for parameter in run["answer"]["parameters"].as_array().unwrap() {
        assert!(parameter["deviation"].as_f64().unwrap() > 0.0, "{parameter}");
    }
    let size = image::open(out.join("mask.png")).unwrap().width();
    for name in ["occluded", "reconstructed", "truth"] {
        assert_eq!(image::open(out.join(format!("{name}.png"))).unwrap().width(), size);
    }
    for name in [
        "confidence.png",
        "overlay.png",
        "sheet.png",
        "scores.png",
        "scores.svg",
        "contour.svg",
        "candidates.csv",
    ] {
        assert!(out.join(name).metadata().unwrap().len() > 100, "{name}");
    }
    // From its own manifest, with other threads: the same bytes.
    patterns(folder.path(), &["run", "a/run.json", "--out", "b", "--threads", "2"]);
    for name in run["files"].as_array().unwrap().iter().filter_map(Value::as_str) {
        let [a, b] = ["a", "b"].map(|f| fs::read(folder.path().join(f).join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
    assert_eq!(run, manifest(&folder.path().join("b")));
}

#[test]
fn a_fine_drawing_of_a_coarse_pattern_is_of_its_class() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["rd", "--spots", "--size", "128", "--frames", "0", "--out", "spots"];
    patterns(folder.path(), &run);
    // Four pixels to a cell, borders drawn smoothly.
    let picture = image::open(folder.path().join("spots/ink.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (512, 512));
    let args = ["reconstruct", "spots/ink.png", "--mask-box", "160,160,192,192", "--out", "r"];
    let said = patterns(folder.path(), &[&args[..], &["--generations", "0"]].concat());
    assert!(said.contains("model: turing-spots"), "{said}");
    let found = image::open(folder.path().join("r/reconstructed.png")).unwrap();
    assert_eq!((found.width(), found.height()), (512, 512));
}

#[test]
fn a_foreign_picture_is_of_no_class() {
    let folder = tempfile::tempdir().unwrap();
    let board = image::GrayImage::from_fn(96, 96, |x, y| {
        image::Luma([if (x / 8 + y / 8) % 2 == 0 { 20 } else { 230 }])
    });
    board.save(folder.path().join("board.png")).unwrap();
    let args = ["reconstruct", "board.png", "--mask-box", "30,30,24,24", "--out", "c"];
    let said = patterns(folder.path(), &[&args[..], &["--truth", "board.png"]].concat());
    assert!(said.contains("none of these"), "{said}");
    let run = manifest(&folder.path().join("c"));
    assert_eq!((&run["answer"]["none"], &run["answer"]["class"]), (&true.into(), &Value::Null));
    assert!(run["metrics"]["accuracy"].as_f64().is_some());
}

#[test]
fn a_labelled_folder_is_made_and_evaluated() {
    let folder = tempfile::tempdir().unwrap();
    let make = ["database", "evaluate", "--classes", "topology-row-l", "--patterns", "1"];
    patterns(folder.path(), &[&make[..], &["--out", "cases"]].concat());
    let labels = fs::read_to_string(folder.path().join("cases/labels.csv")).unwrap();
    assert_eq!(labels.lines().count(), 1 + 14 + 20);
    let table = patterns(folder.path(), &["reconstruct", "--evaluate", "cases", "--out", "table"]);
    let all = table.lines().find(|l| l.starts_with("all ")).unwrap();
    let columns: Vec<&str> = all.split_whitespace().collect();
    assert_eq!(columns[1], "14");
    assert!(columns[2].parse::<f64>().unwrap() > 0.9, "{table}");
    assert_eq!(fs::read_to_string(folder.path().join("table/evaluation.txt")).unwrap(), table);
}
