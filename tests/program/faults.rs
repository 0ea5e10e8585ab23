//! Bad input: a clear message that names it, exit code 2, no panic, nothing left behind.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};
use tempfile::TempDir;

/// A folder with good and broken files in it; the program runs inside.
pub(crate) struct Lab(TempDir);

impl Lab {
    pub(crate) fn new() -> Self {
        let lab = Self(tempfile::tempdir().unwrap());
        let png = lab.grey_png(16, 16);
        lab.write("good.png", &png);
        lab.write("cut.png", &png[..png.len() / 2]);
        lab.write("noise.png", b"\x89PNG\r\n\x1a\nnot a picture at all");
        lab.write("text.png", b"hello");
        lab.write("empty.npy", b"");
        let array = npy("<f8", "(4, 4)", &[0.5_f64; 16].map(f64::to_le_bytes).concat());
        lab.write("small.npy", &array);
        lab.write("cut.npy", &array[..array.len() - 9]);
        let mut holes = [0.5_f64; 6400];
        holes[81] = f64::NAN;
        lab.write("nan.npy", &npy("<f8", "(80, 80)", &holes.map(f64::to_le_bytes).concat()));
        lab.write("complex.npy", &npy("<c16", "(1, 1)", &[0; 16]));
        lab.write("solid.npy", &npy("<f8", "(2, 2, 2)", &[0; 64]));
        lab.write("huge.npy", &npy("<f8", "(1000000, 1000000)", &[0; 64]));
        lab
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
    }

    fn grey_png(&self, width: u32, height: u32) -> Vec<u8> {
        let picture = image::GrayImage::from_fn(width, height, |x, y| image::Luma([(x * y) as u8]));
        let path = self.path("drawn.png");
        picture.save(&path).unwrap();
        fs::read(path).unwrap()
    }

    pub(crate) fn patterns(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_patterns"));
        command.current_dir(self.0.path()).args(args).output().unwrap()
    }

    /// The command fails as it should, and says all of `words`.
    pub(crate) fn refuses(&self, args: &[&str], words: &[&str]) {
        let before = listing(self.0.path());
        let output = self.patterns(args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {said}");
        assert!(!said.contains("panicked"), "{args:?}: {said}");
        for word in words {
            assert!(said.contains(word), "{args:?}: `{word}` is not in: {said}");
        }
        assert_eq!(listing(self.0.path()), before, "{args:?} left files behind");
    }

    fn refuses_toml(&self, text: &str, words: &[&str]) {
        self.write("run.toml", text.as_bytes());
        self.refuses(&["run", "run.toml"], words);
    }
}

pub(crate) fn npy(dtype: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}");
    header += &" ".repeat(63 - (10 + header.len()) % 64);
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths
}

#[test]
fn flags_out_of_range() {
    let lab = Lab::new();
    lab.refuses(&["rd", "--size", "0"], &["--size", "0"]);
    lab.refuses(&["rd", "--size", "axb"], &["--size axb", "NYxNX"]);
    lab.refuses(&["rd", "--size", "1000000x1000000"], &["--size", "GiB", "available"]);
    lab.refuses(&["rd", "--size", "100000x100000x100000"], &["--size"]);
    lab.refuses(&["rd", "--iterations", "0"], &["--iterations", "0", "[1,"]);
    lab.refuses(&["rd", "--iterations", "-5"], &["-5"]);
    lab.refuses(&["rd", "--dt", "5"], &["--dt", "5", "unstable"]);
    lab.refuses(&["rd", "--dt", "nan"], &["--dt", "NaN"]);
    lab.refuses(&["rd", "--seed", "abc"], &["--seed", "abc"]);
    lab.refuses(&["rd", "--threads", "5000"], &["--threads 5000", "[0, 1024]"]);
    lab.refuses(&["rd", "--frames", "99999999"], &["--frames", "99999999"]);
    lab.refuses(&["rd", "--spots", "--stripes"], &["--spots", "--stripes"]);
    lab.refuses(&["rd", "--preset", "dots"], &["--preset", "dots", "spots"]);
    lab.refuses(&["rd", "--kinetics", "touring"], &["--kinetics", "touring", "turing"]);
    lab.refuses(&["rd", "--param", "xi"], &["--param xi", "NAME=VALUE"]);
    lab.refuses(&["rd", "--param", "zeta=3"], &["--param zeta=3", "zeta"]);
    lab.refuses(&["rd", "--param", "xi=99"], &["--param xi=99", "99", "[0, 16]"]);
    lab.refuses(&["rd", "--diffusion", "a=-1"], &["--diffusion a=-1", "-1"]);
    lab.refuses(&["rd", "--set", "radius=3"], &["radius"]);
    lab.refuses(&["rd", "--set", "radius"], &["--set radius", "key=value"]);
    lab.refuses(&["rd", "--snapshots", "1,99999"], &["--snapshots", "99999"]);
    lab.refuses(&["level-set", "--size", "2"], &["--size", "2", "[4, inf)"]);
    lab.refuses(&["level-set", "--cfl", "1.5"], &["--cfl", "1.5", "(0, 1]"]);
    lab.refuses(&["level-set", "--shape", "blob"], &["--shape", "blob", "star"]);
    lab.refuses(&["level-set", "--speed", "warp=9"], &["--speed warp=9", "curvature"]);
    lab.refuses(&["level-set", "--speed", "curvature=-1"], &["--speed", "-1", "(0, inf)"]);
    lab.refuses(&["rd", "--growth", "-1"], &["--growth", "-1", "[0, inf)"]);
    lab.refuses(&["rd", "--growth", "nan"], &["--growth", "NaN", "[0, inf)"]);
    lab.refuses(&["rd", "--growth", "1"], &["--growth", "times as long", "1000"]);
    lab.refuses(&["rd", "--growth-law", "linear"], &["--growth-law", "rate"]);
    lab.refuses(&["rd", "--growth", "0", "--growth-law", "cubic"], &["--growth-law", "cubic"]);
    lab.refuses(&["rd", "--growth", "0", "--growth-law", "logistic"], &["growth.limit"]);
    lab.refuses(&["rd", "--growth", "0", "--growth-limit", "2"], &["--growth-limit", "logistic"]);
    lab.refuses(
        &["rd", "--growth", "0", "--growth-law", "logistic", "--growth-limit", "1"],
        &["--growth-limit", "1", "(1, inf)"],
    );
    lab.refuses(&["rd", "--growth", "0", "--dispersion"], &["--dispersion", "growth"]);
    lab.refuses(
        &["rd", "--kinetics", "swift-hohenberg", "--diffusion", "u=1"],
        &["--diffusion u=1", "no diffusion"],
    );
    lab.refuses(&["rd", "--animation", "mp4"], &["--animation", "mp4", "apng"]);
    lab.refuses(&["level-set", "--union", "blob"], &["--union", "blob", "star"]);
    lab.refuses(&["level-set", "--union", "circle,r=3"], &["--union circle,r=3", "size"]);
    lab.refuses(&["level-set", "--subtract", "star,x=a"], &["--subtract star,x=a", "x=NUMBER"]);
    lab.refuses(&["level-set", "--intersect", "star,size=-3"], &["--intersect", "-3", "(0, inf)"]);
    lab.refuses(&["level-set", "--union", "star,x=inf"], &["--union", "inf"]);
    lab.refuses(&["figure", "9.9"], &["9.9", "1.5"]);
    lab.refuses(&["list", "nope"], &["nope", "level-set"]);
    lab.refuses(&["paint"], &["paint"]);
}

#[test]
fn files_that_cannot_be_used() {
    let lab = Lab::new();
    let start = |file: &'static str| ["level-set", "--image", file];
    lab.refuses(&start("missing.png"), &["--image", "missing.png"]);
    lab.refuses(&start("."), &["--image", "folder"]);
    lab.refuses(&start("cut.png"), &["--image", "cut.png"]);
    lab.refuses(&start("noise.png"), &["--image", "noise.png"]);
    lab.refuses(&start("text.png"), &["--image", "text.png"]);
    lab.refuses(&start("empty.npy"), &["--image", "empty.npy"]);
    lab.refuses(&start("cut.npy"), &["--image", "cut.npy"]);
    lab.refuses(&start("nan.npy"), &["--image", "nan.npy", "NaN", "[1, 1]"]);
    lab.refuses(&start("complex.npy"), &["--image", "complex.npy", "c16"]);
    lab.refuses(&start("huge.npy"), &["--image", "huge.npy"]);
    lab.refuses(
        &["rd", "--param", "xi=small.npy"],
        &["--param", "small.npy", "[4, 4]", "[80, 80]"],
    );
    lab.refuses(&["rd", "--param", "xi=nan.npy"], &["--param", "nan.npy", "NaN"]);
    lab.refuses(&["convert", "solid.npy", "solid.png"], &["solid"]);
    lab.refuses(&["convert", "good.png", "good.xyz"], &["xyz"]);
    lab.refuses(&["convert", "cut.png", "x.npy"], &["cut.png"]);
    lab.refuses(&["convert", "good.png", "small.npy"], &["small.npy", "--force"]);
}

#[test]
fn lines_that_cannot_be_used() {
    let lab = Lab::new();
    lab.write("word.csv", b"x,y\n1,2\n3,four\n");
    lab.write("short.csv", b"1,1\n2,2\n\n5,5\n6,6\n7,5\n");
    lab.write("mixed.csv", b"1,1\n2,2\n0,5,5\n");
    lab.write("wide.csv", b"1,1,1,1\n");
    lab.write("nan.csv", b"1,1\n2,nan\n3,3\n");
    lab.write("far.csv", b"1,1\n900,1\n1,9\n");
    lab.write("none.csv", b"# nothing\n");
    for command in ["level-set", "rd"] {
        let with = |file: &'static str| [command, "--contour", file];
        lab.refuses(&with("missing.csv"), &["--contour", "missing.csv"]);
        lab.refuses(&with("."), &["--contour", "folder"]);
        lab.refuses(&with("good.png"), &["--contour", "good.png", "no text"]);
        lab.refuses(&with("word.csv"), &["--contour", "word.csv", "line 3", "four"]);
        lab.refuses(&with("short.csv"), &["--contour", "short.csv", "line 1", "2 points"]);
        lab.refuses(&with("mixed.csv"), &["--contour", "mixed.csv", "line 3"]);
        lab.refuses(&with("wide.csv"), &["--contour", "wide.csv", "line 1", "4 numbers"]);
        lab.refuses(&with("nan.csv"), &["--contour", "nan.csv", "line 2", "NaN"]);
        lab.refuses(&with("far.csv"), &["--contour", "far.csv", "(900, 1)"]);
        lab.refuses(&with("none.csv"), &["--contour", "none.csv", "no points"]);
    }
    lab.refuses(&["level-set", "--contour", "far.csv", "--shape", "star"], &["--shape"]);
    lab.refuses(&["level-set", "--contour", "far.csv", "--size", "20x20x20"], &["2 axes"]);
    lab.refuses(&["rd", "--contour", "far.csv", "--start", "border"], &["--start"]);
}

#[test]
fn run_files_with_mistakes_are_quoted_by_line() {
    let lab = Lab::new();
    lab.refuses(&["run", "missing.toml"], &["missing.toml"]);
    lab.refuses_toml("command = \"rd\"\n[config\n", &["run.toml", "line 2"]);
    lab.refuses_toml("command = \"rd\"\nsede = 3\n", &["run.toml", "sede", "line 2"]);
    lab.refuses_toml("command = \"painting\"\n", &["painting", "level-set"]);
    lab.refuses_toml("command = \"rd\"\n[config]\nsizes = 3\n", &["run.toml:3", "sizes"]);
    lab.refuses_toml("command = \"rd\"\n[config]\ndt = -1.0\n", &["run.toml:3", "-1"]);
    lab.refuses_toml("command = \"rd\"\n[config]\ndt = \"fast\"\n", &["run.toml:3", "fast"]);
    lab.refuses_toml(
        "command = \"level-set\"\n[config]\n\n[[config.speed]]\nkind = \"warp\"\n",
        &["run.toml:", "warp"],
    );
    let many: String = (0..33).map(|n| format!("s{n} = \"0\"\n")).collect();
    lab.refuses_toml(
        &format!(
            "command = \"rd\"\n[config]\nkinetics = \"formulas\"\ncurve.speed = \"off\"\n\
             ink = {{ species = \"s0\", level = \"mean\", below = false }}\n[config.formulas]\n{many}"
        ),
        &["formulas", "33 species, at most 32"],
    );
    lab.write("run.json", b"{\"command\": \"rd\"}");
    lab.refuses(&["run", "run.json"], &["run.json", "version"]);
}

#[test]
fn output_folders_that_cannot_be_used() {
    let lab = Lab::new();
    let short = ["rd", "--size", "16", "--iterations", "50", "--out"];
    let with = |out: &'static str| [&short[..], &[out]].concat();
    lab.refuses(&with("good.png"), &["--out good.png", "file"]);
    lab.refuses(&with("good.png/inside"), &["good.png/inside"]);
    fs::create_dir(lab.path("full")).unwrap();
    lab.write("full/mine.txt", b"precious");
    lab.refuses(&with("full"), &["--out full", "--force"]);
    assert_eq!(fs::read(lab.path("full/mine.txt")).unwrap(), b"precious");
    // A system folder in which nobody, not even root, can make folders.
    #[cfg(target_os = "linux")]
    lab.refuses(&with("/proc/patterns"), &["/proc/patterns"]);
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_refused() {
    use std::os::unix::fs::PermissionsExt as _;
    let lab = Lab::new();
    fs::create_dir(lab.path("locked")).unwrap();
    fs::set_permissions(lab.path("locked"), fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(lab.path("locked/probe"), b"").is_ok() {
        return; // root may write everywhere; `/proc` above stands for this case then
    }
    lab.refuses(&["rd", "--size", "16", "--iterations", "50", "--out", "locked/x"], &["locked/x"]);
}

/// A disk that is full after 40 kB, simulated by the shell's limit on file sizes.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing_behind() {
    let lab = Lab::new();
    let before = listing(lab.0.path());
    let script = format!(
        "trap '' XFSZ; ulimit -f 40; exec {} level-set --size 128 --iterations 4 --time 4 --out o",
        env!("CARGO_BIN_EXE_patterns")
    );
    let output =
        Command::new("bash").args(["-c", &script]).current_dir(lab.0.path()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("cannot write `o/") && !said.contains("panicked"), "{said}");
    assert_eq!(listing(lab.0.path()), before);
}

#[test]
fn resuming_what_cannot_be_resumed() {
    let lab = Lab::new();
    lab.refuses(&["rd", "--resume", "nowhere"], &["nowhere", "run.json"]);
    let done = ["level-set", "--size", "32", "--iterations", "3", "--time", "1", "--out", "done"];
    assert!(lab.patterns(&done).status.success());
    lab.refuses(&["run", "--resume", "done"], &["done", "finished"]);
    lab.refuses(&["rd", "--resume", "done"], &["done", "level-set"]);
    let manifest = fs::read_to_string(lab.path("done/run.json")).unwrap();
    lab.write("done/run.json", manifest.replace("\"done\"", "\"running\"").as_bytes());
    lab.refuses(&["run", "--resume", "done"], &["checkpoint.npz"]);
    lab.write("done/checkpoint.npz", b"not an archive");
    lab.refuses(&["run", "--resume", "done"], &["checkpoint.npz"]);
}
