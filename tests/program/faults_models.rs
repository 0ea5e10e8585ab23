//! What single models refuse, as `faults` says it for all.

use crate::faults::{Lab, npy};
use std::fs;

#[test]
fn bad_structures() {
    let lab = Lab::new();
    lab.refuses(&["topopt"], &["--table", "--problem"]);
    lab.refuses(&["topopt", "--table", "row-z"], &["row-z", "row-a"]);
    lab.refuses(&["topopt", "--mbb", "60by20"], &["--mbb 60by20", "NXxNY"]);
    lab.refuses(&["topopt", "--mbb", "0x20"], &["--mbb 0x20"]);
    lab.refuses(&["topopt", "--mbb", "60x20", "--volume", "1.5"], &["--volume", "1.5", "(0, 1)"]);
    lab.refuses(
        &["topopt", "--mbb", "60x20", "--filter-radius", "0.2"],
        &["--filter-radius", "0.2"],
    );
    lab.refuses(&["topopt", "--mbb", "60x20", "--projection", "8"], &["--projection", "density"]);
    lab.refuses(&["topopt", "--table", "row-o"], &["problem.load.0", "holds along y"]);
    // Ten million elements in space need more than any small machine has.
    lab.refuses(
        &["topopt", "--table", "cantilever-3d", "--set", "problem.elements=[2000, 2000, 2000]"],
        &["GiB"],
    );
    lab.write("bad.toml", b"volume = 0.5\n[problem]\nelements = [8, 4]\npoisson_ratio = 0.7\n");
    lab.refuses(&["topopt", "--problem", "bad.toml"], &["bad.toml:4", "0.7"]);
    lab.write("typo.toml", b"[problem]\nelement = [8, 4]\n");
    lab.refuses(&["topopt", "--problem", "typo.toml"], &["typo.toml:2", "element"]);
    lab.refuses(&["topopt", "--problem", "missing.toml"], &["missing.toml"]);
    lab.write("nan.toml", b"[problem]\nelements = [8, 4]\nload = [{ node = [9, 5], force = [0.0, nan] }]\nsupport = [{ edge = 'left' }]\n");
    lab.refuses(&["topopt", "--problem", "nan.toml"], &["nan.toml:3", "NaN"]);
}

#[test]
fn bad_textures() {
    let lab = Lab::new();
    lab.refuses(&["curvature", "--preset", "tubs"], &["tubs", "trabecular-bone"]);
    lab.refuses(&["curvature", "--mass", "1.5"], &["--mass", "1.5", "(-1, 1)"]);
    lab.refuses(&["curvature", "--size", "4"], &["--size", "4", "[8, inf)"]);
    lab.refuses(&["curvature", "--size", "100000"], &["--size", "GiB"]);
    lab.refuses(&["curvature", "--coefficients", "1,2"], &["--coefficients", "6"]);
    lab.refuses(&["curvature", "--squares", "h2=x"], &["--squares", "h2=x"]);
    lab.refuses(&["curvature", "--squares", "h3=1"], &["h3"]);
    lab.refuses(&["curvature", "--boundary", "free"], &["--boundary", "l2"]);
    lab.refuses(&["curvature", "--start", "missing.npy"], &["--start", "missing.npy"]);
    lab.refuses(
        &["curvature", "--size", "16", "--include", "solid.npy"],
        &["--include", "[2, 2, 2]"],
    );
    lab.refuses(&["curvature", "--size", "16", "--start", "cut.npy"], &["--start", "cut.npy"]);
    lab.refuses(&["curvature", "atlas", "--count", "2"], &["--count", "[3, 20000]"]);
    lab.refuses(&["curvature", "atlas", "--size", "6"], &["--size", "[8, inf)"]);
    lab.refuses(&["curvature", "atlas", "--set", "ranges.mass=[-2, 0]"], &["ranges.mass"]);
    lab.refuses(&["curvature", "atlas", "--pictures", "31"], &["--pictures", "[0, 30]"]);
    let atlas = |set: &'static str| ["curvature", "atlas", "--evaluations", "50", "--set", set];
    lab.refuses(&atlas("growth.opening=50"), &["growth.opening", "[0, 50)"]);
    lab.refuses(&atlas("growth.rate=0.0"), &["growth.rate"]);
    lab.refuses(&atlas("growth.blur=0.0"), &["growth.blur", "(0, 20]"]);
    lab.refuses(&["curvature", "--blur", "0"], &["--blur", "(0, 20]"]);
    lab.refuses(&["curvature", "infer"], &["FILE"]);
    lab.refuses(&["curvature", "infer", "missing.npy"], &["missing.npy"]);
    lab.refuses(&["curvature", "infer", "good.png"], &["good.png", "three axes"]);
    lab.refuses(&["curvature", "infer", "solid.npy", "--atlas", "here"], &["--atlas", "here"]);
    lab.refuses(&["curvature", "infer", "solid.npy"], &["solid.npy", "[2, 2, 2]"]);
    let cube = |value: fn(usize) -> f64| {
        let values: Vec<u8> = (0..512).flat_map(|n| value(n).to_le_bytes()).collect();
        npy("<f8", "(8, 8, 8)", &values)
    };
    lab.write("two.npy", &cube(|n| if n < 100 { 1.0 } else { 0.0 }));
    lab.refuses(&["curvature", "infer", "two.npy", "--label", "7"], &["--label", "no voxel", "7"]);
    lab.refuses(&["curvature", "infer", "two.npy", "--level", "2"], &["--level", "(0, 1)"]);
    lab.write("one.npy", &cube(|_| 4.0));
    lab.refuses(&["curvature", "infer", "one.npy"], &["one.npy", "every voxel", "4"]);
    lab.refuses(&["render", "good.png"], &["good.png"]);
    lab.refuses(&["render", "cut.npy", "--out", "cut-shape.png"], &["cut.npy"]);
}

#[test]
fn bad_classes() {
    let lab = Lab::new();
    let good = "name = \"mine\"\nabout = \"spots\"\nmodel = \"rd\"\nseeds = \"free\"\n\
                [config]\npreset = \"spots\"\nsize = [32, 32]\n\
                [range]\n\"parameters.xi\" = { low = 11.8, high = 12.2 }\n";
    lab.write("good.toml", good.as_bytes());
    let checked = lab.patterns(&["database", "check", "good.toml"]);
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    for (from, to, words) in [
        ("12.2", "17.0", ["range.\"parameters.xi\"", "17", "[0, 16]"]),
        ("12.2", "11.0", ["range.\"parameters.xi\".high", "11", "(low = 11.8, inf)"]),
        ("preset", "presets", ["config.presets", "known", "preset"]),
        ("\"rd\"", "\"dr\"", ["model", "dr", "topopt"]),
        ("parameters.xi", "parameters.zeta", ["range.\"parameters.zeta\"", "zeta", "xi"]),
    ] {
        lab.write("bad.toml", good.replace(from, to).as_bytes());
        for action in ["check", "add"] {
            lab.refuses(&["database", action, "bad.toml"], &words);
            lab.refuses(&["database", action, "bad.toml"], &["bad.toml"]);
        }
    }
    lab.write("taken.toml", good.replace("mine", "turing-spots").as_bytes());
    lab.refuses(&["database", "add", "taken.toml"], &["taken.toml", "turing-spots", "already"]);
    lab.refuses(&["database", "show", "spots"], &["spots", "turing-spots"]);
    lab.refuses(&["database", "list", "--database", "nowhere"], &["--database nowhere"]);
    // A class whose seed is free is of no use without its calibration.
    fs::create_dir(lab.path("classes")).unwrap();
    lab.write("classes/good.toml", good.as_bytes());
    lab.refuses(&["database", "list", "--database", "classes"], &["classes/good.bin"]);
    lab.write("classes/good.bin", b"nonsense");
    lab.refuses(&["database", "list", "--database", "classes"], &["good.bin", "calibration"]);
}

#[test]
fn pictures_that_cannot_be_reconstructed() {
    let lab = Lab::new();
    let dots = |side: u32| {
        image::GrayImage::from_fn(side, side, |x, y| {
            image::Luma([if (x % 12).abs_diff(6) + (y % 12).abs_diff(6) < 5 { 0 } else { 255 }])
        })
    };
    dots(64).save(lab.path("dots.png")).unwrap();
    image::GrayImage::from_pixel(64, 64, image::Luma([255])).save(lab.path("all.png")).unwrap();
    image::GrayImage::from_pixel(64, 64, image::Luma([0])).save(lab.path("none.png")).unwrap();
    image::GrayImage::from_pixel(1, 1, image::Luma([9])).save(lab.path("one.png")).unwrap();
    image::GrayImage::from_pixel(64, 64, image::Luma([90])).save(lab.path("flat.png")).unwrap();
    let with = |args: &[&'static str]| [&["reconstruct"], args].concat();
    lab.refuses(&with(&["dots.png", "--mask", "good.png"]), &["--mask", "16 x 16", "64 x 64"]);
    lab.refuses(&with(&["dots.png", "--mask", "all.png"]), &["--mask", "hides the whole picture"]);
    lab.refuses(&with(&["dots.png", "--mask", "none.png"]), &["--mask", "hides nothing"]);
    lab.refuses(&with(&["dots.png", "--mask", "missing.png"]), &["--mask", "missing.png"]);
    lab.refuses(&with(&["dots.png", "--mask-box", "60,0,9,9"]), &["--mask-box", "64 x 64"]);
    lab.refuses(&with(&["dots.png", "--mask-box", "1,2,3"]), &["--mask-box 1,2,3"]);
    lab.refuses(&with(&["dots.png", "--mask-circle", "9,9,0"]), &["--mask-circle", "(0, inf)"]);
    lab.refuses(&with(&["dots.png"]), &["nothing hidden was found", "--mask-box"]);
    lab.refuses(&with(&["dots.png", "--truth", "good.png"]), &["--truth", "16 x 16", "64 x 64"]);
    lab.refuses(&with(&["one.png", "--mask", "one.png"]), &["one.png", "1 x 1", "16 x 16"]);
    lab.refuses(&with(&["flat.png"]), &["flat.png", "one value only"]);
    lab.refuses(&with(&["solid.npy"]), &["solid.npy", "3 axes"]);
    lab.refuses(&with(&["nan.npy"]), &["nan.npy", "NaN"]);
    lab.refuses(&with(&["cut.png"]), &["cut.png"]);
    lab.refuses(&with(&["noise.png"]), &["noise.png"]);
    lab.refuses(&with(&["dots.png", "--samples", "0"]), &["--samples", "0", "[1,"]);
    lab.refuses(&with(&["dots.png", "--budget", "0"]), &["--budget 0", "(0,"]);
    lab.refuses(&with(&["--example", "spots"]), &["spots", "database list"]);
    lab.refuses(&with(&["--evaluate", "nowhere"]), &["--evaluate nowhere", "labels.csv"]);
    // A folder that is not empty is refused before the work, and left as it is.
    let occupied = ["--example", "topology-row-l", "--out", "full"];
    lab.write(
        "magnified.toml",
        b"command = 'reconstruct'\n[config.example]\n\
        class = 'topology-row-l'\nseed = 1\nharm = 'box'\nshare = 0.25\nmagnify = 65\n",
    );
    lab.refuses(&["run", "magnified.toml"], &["magnified.toml", "example.magnify", "[1, 64]"]);
    fs::create_dir(lab.path("full")).unwrap();
    lab.write("full/own.txt", b"mine");
    lab.refuses(&with(&occupied), &["--out full", "not empty", "--force"]);
    // A picture of 20000 x 20000 pixels in a file of a few bytes, which claims them.
    let mut huge = b"P5 20000 20000 255\n".to_vec();
    huge.extend([0; 64]);
    lab.write("huge.pgm", &huge);
    lab.refuses(&with(&["huge.pgm"]), &["huge.pgm", "20000 x 20000", "limit"]);
}

/// A mechanism is named and drawn; no output folder is made.
#[test]
fn a_mechanism_is_drawn() {
    let lab = Lab::new();
    let output = lab.patterns(&["topopt", "--table", "row-f", "--as-printed", "--out", "x"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("rotate about node (61, 21)"), "{said}");
    assert!(said.contains("x-mechanism.png") && !lab.path("x").exists(), "{said}");
    assert!(image::open(lab.path("x-mechanism.png")).unwrap().width() > 200);
}
