//! Volumes, stacks and GLB: what is written reads back, what is broken is refused.

use lab::{
    input,
    output::{convert, glb, mrc, nifti, nrrd, tiff, volume::Volume, vti},
};
use ndarray::{ArrayD, IxDyn};
use proptest::prelude::*;
use solvers::{
    Field, Grid,
    isosurface::{Caps, triangulate},
    mesh::TriangleMesh,
};
use std::{f64::consts::PI, fs, io::Cursor};
use tempfile::TempDir;

const LIMIT: u64 = 1 << 20;

type Write = fn(&Volume) -> Vec<u8>;

const FORMATS: [(&str, Write); 5] = [
    ("v.nrrd", |v| bytes(|out| nrrd::write(v, out))),
    ("v.nii", |v| bytes(|out| nifti::write(v, out))),
    ("v.nii.gz", |v| bytes(|out| nifti::write_gz(v, out))),
    ("v.mrc", |v| bytes(|out| mrc::write(v, out))),
    ("v.vti", |v| bytes(|out| vti::write_volume(v, out))),
];

fn bytes(write: impl FnOnce(&mut Vec<u8>) -> anyhow::Result<()>) -> Vec<u8> {
    let mut out = Vec::new();
    write(&mut out).unwrap();
    out
}

/// Values, spacing and origin that `f32` holds exactly.
fn volume(shape: &[usize]) -> Volume {
    let n = shape.iter().product::<usize>();
    let values = (0..n).map(|n| (n * 37 % 101) as f64 / 64.0 - 0.5).collect();
    let values = ArrayD::from_shape_vec(IxDyn(shape), values).unwrap();
    Volume { values, spacing: [0.5, 0.75, 2.0], origin: [-3.0, 0.25, 7.5] }
}

fn load(name: &str, bytes: &[u8]) -> Result<Volume, String> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    input::load_volume(&path, LIMIT).map_err(|error| format!("{error:#}"))
}

#[test]
fn volumes_read_back_with_their_place() {
    for (name, write) in FORMATS {
        for shape in [&[2, 3, 5][..], &[4, 6], &[7]] {
            let volume = volume(shape);
            assert_eq!(load(name, &write(&volume)).unwrap(), volume, "{name}");
        }
    }
    let stack = volume(&[3, 4, 5]);
    let mut out = Cursor::new(Vec::new());
    tiff::write(&stack, &mut out).unwrap();
    let read = load("v.tif", out.get_ref()).unwrap();
    assert_eq!(read.values, stack.values);
    // One page is a picture.
    let mut out = Cursor::new(Vec::new());
    tiff::write(&volume(&[4, 5]), &mut out).unwrap();
    assert_eq!(tiff::pages(out.get_ref()), 1);
}

#[test]
fn headers_of_other_programs_are_read() {
    // As the format's definition has them: big endian shorts, comments, keys, per-axis spacing.
    let head = "NRRD0005\n# made by hand\ntype: short\ndimension: 3\nsizes: 3 2 1\n\
                spacings: 0.5 nan 2\nkey:=sizes: 9 9 9\nencoding: raw\nendian: big\n\n";
    let data: Vec<u8> = [-1_i16, 2, 300, 4, 5, 6].iter().flat_map(|v| v.to_be_bytes()).collect();
    let read = load("v.nrrd", &[head.as_bytes(), &data].concat()).unwrap();
    assert_eq!(read.values.shape(), [2, 3]);
    assert_eq!(read.values.as_slice().unwrap(), [-1.0, 2.0, 300.0, 4.0, 5.0, 6.0]);
    assert_eq!(read.spacing, [0.5, 1.0, 2.0]);
    let text = "NRRD0004\r\ntype: float\r\ndimension: 2\r\nsizes: 2 2\r\n\
                space directions: (3,4,0) none\r\nencoding: ascii\r\n\r\n1 2\n3 4e1\n";
    let read = load("v.nrrd", text.as_bytes()).unwrap();
    assert_eq!(read.values.as_slice().unwrap(), [1.0, 2.0, 3.0, 40.0]);
    assert_eq!(read.spacing[0], 5.0);
    // Scaled bytes, with the offset of the quaternion form.
    let mut nii = bytes(|out| nifti::write(&volume(&[2, 2]), out));
    nii.truncate(352);
    nii[70..72].copy_from_slice(&2_i16.to_le_bytes());
    nii[112..116].copy_from_slice(&0.5_f32.to_le_bytes());
    nii[116..120].copy_from_slice(&(-1_f32).to_le_bytes());
    nii[254..256].fill(0);
    nii[252] = 1;
    nii.extend([0, 2, 4, 255]);
    let read = load("v.nii", &nii).unwrap();
    assert_eq!(read.values.as_slice().unwrap(), [-1.0, 0.0, 1.0, 126.5]);
    assert_eq!(read.origin, [-3.0, 0.25, 7.5]);
}

#[test]
fn broken_volumes_say_what_is_wrong() {
    let huge = "NRRD0004\ntype: double\ndimension: 3\nsizes: 99999 99999 99999\nencoding: raw\nendian: little\n\n";
    let head = "NRRD0004\ntype: double\ndimension: 2\nsizes: 2 2\nendian: little\n";
    for (text, reason) in [
        (huge.to_owned(), "more than the limit"),
        (format!("{head}encoding: raw\n\n1234567"), "truncated"),
        (format!("{head}encoding: bzip2\n\n"), "encoding `bzip2`"),
        (format!("{head}encoding: raw\ndata file: other.raw\n\n"), "another file"),
        (format!("{head}encoding: ascii\n\n1 2 3"), "need 4 numbers"),
        (format!("{head}encoding: raw"), "has no end"),
        (head.replace("2 2", "2") + "encoding: raw\n\n", "dimension 2 with sizes"),
        (head.replace("double", "block") + "encoding: raw\n\n", "type `block`"),
    ] {
        let error = load("v.nrrd", text.as_bytes()).unwrap_err();
        assert!(error.contains(reason), "{error}");
    }
    let mut nii = bytes(|out| nifti::write(&volume(&[2, 3, 4]), out));
    nii[70] = 32;
    assert!(load("v.nii", &nii).unwrap_err().contains("code 32"));
    nii[40..56].fill(0x7f);
    assert!(load("v.nii", &nii).is_err());
    let mut map = bytes(|out| mrc::write(&volume(&[2, 3, 4]), out));
    map[64] = 3;
    assert!(load("v.mrc", &map).unwrap_err().contains("columns, rows and sections"));
    let mut gz = bytes(|out| nifti::write_gz(&volume(&[9, 9, 9]), out));
    gz.truncate(gz.len() / 2);
    assert!(load("v.nii.gz", &gz).unwrap_err().contains("gzip"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn truncation_is_an_error_and_damage_is_survived(
        which in 0..FORMATS.len(), cut in 0.0..1.0_f64, at in 0.0..1.0_f64, byte: u8,
    ) {
        let (name, write) = FORMATS[which];
        let whole = write(&volume(&[3, 4, 5]));
        let part = &whole[..(cut * whole.len() as f64) as usize];
        // What VTI and gzip have at their end is not needed.
        if part.len() + 64 < whole.len() {
            prop_assert!(load(name, part).is_err());
        }
        let mut damaged = whole.clone();
        // The header matters most.
        let n = (at * at * damaged.len() as f64) as usize;
        damaged[n] = byte;
        if let Ok(volume) = load(name, &damaged) {
            prop_assert!(volume.values.len() as u64 * 8 <= LIMIT);
        }
    }

    #[test]
    fn any_place_survives_the_formats_of_f64(
        spacing in prop::array::uniform3(1e-6..1e6_f64), origin in prop::array::uniform3(-1e6..1e6_f64),
    ) {
        let volume = Volume { spacing, origin, ..volume(&[2, 1, 3]) };
        for (name, write) in [FORMATS[0], FORMATS[4]] {
            let read = load(name, &write(&volume)).unwrap();
            for n in 0..3 {
                prop_assert!((read.spacing[n] / spacing[n] - 1.0).abs() < 1e-15);
                prop_assert!((read.origin[n] - origin[n]).abs() <= 1e-15 * origin[n].abs());
            }
        }
    }
}

/// A ball of radius 0.6 about the middle of the unit cube.
fn ball() -> Field {
    let grid = Grid::new(&[31, 31, 31], 1.0 / 30.0).unwrap();
    Field::from_fn(grid, |p| p.iter().map(|c| (c - 0.5).powi(2)).sum::<f64>().sqrt() - 0.4)
}

#[test]
fn glb_reads_back_and_keeps_the_rules_of_the_format() {
    let mesh = triangulate(&ball(), 0.0, Caps::Open).unwrap();
    let colors = vec![[255, 128, 0]; mesh.vertices.len()];
    let file = bytes(|out| glb::write(&mesh, &colors, out));
    let read = glb::read(&file).unwrap();
    assert_eq!(read.triangles, mesh.triangles);
    assert!(read.is_closed() && read.is_manifold());
    assert!((read.volume() / (4.0 / 3.0 * PI * 0.4_f64.powi(3)) - 1.0).abs() < 0.01);
    // Chunks of a multiple of four bytes, lengths that add up, min and max of the positions.
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    let (json, data) = (word(12), word(20 + word(12)));
    assert_eq!((json % 4, data % 4, word(8)), (0, 0, 28 + json + data));
    assert_eq!(file.len(), word(8));
    let root: serde_json::Value = serde_json::from_slice(&file[20..20 + json]).unwrap();
    for axis in 0..3 {
        let all = || read.vertices.iter().map(|v| v[axis]);
        let accessor = &root["accessors"][0];
        assert_eq!(
            accessor["min"][axis].as_f64().unwrap() as f32,
            all().fold(1.0, f64::min) as f32
        );
        assert_eq!(
            accessor["max"][axis].as_f64().unwrap() as f32,
            all().fold(0.0, f64::max) as f32
        );
    }
    let views = root["bufferViews"].as_array().unwrap();
    assert_eq!(views.len(), 4);
    let total: u64 = views.iter().map(|v| v["byteLength"].as_u64().unwrap()).sum();
    assert_eq!(total as usize, data);
    assert!(views.iter().all(|v| v["byteOffset"].as_u64().unwrap() % 4 == 0));
    // sRGB 128 is 0.2159 of the light.
    let start = views[2]["byteOffset"].as_u64().unwrap() as usize + 28 + json;
    assert_eq!(file[start..start + 4], [255, 55, 0, 255]);
    // Broken files.
    for cut in [0, 3, 11, 30, 20 + json, file.len() - 1] {
        assert!(glb::read(&file[..cut]).is_err());
    }
    let empty = bytes(|out| glb::write(&TriangleMesh::default(), &[], out));
    assert_eq!(glb::read(&empty).unwrap(), TriangleMesh::default());
    let bad = TriangleMesh { vertices: vec![[0.0; 3]; 2], triangles: vec![[0, 1, 2]] };
    assert!(glb::write(&bad, &[], &mut Vec::new()).is_err());
}

proptest! {
    #[test]
    fn a_damaged_glb_is_survived(at in 0..1600_usize, byte: u8) {
        let tetrahedron = TriangleMesh {
            vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        };
        let mut file = bytes(|out| glb::write(&tetrahedron, &[], out));
        let n = at % file.len();
        file[n] = byte;
        if let Ok(mesh) = glb::read(&file) {
            prop_assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.vertices.len()));
        }
    }
}

#[test]
fn volumes_and_meshes_convert_and_surfaces_keep_their_place() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    let phi = Volume {
        values: ball().view().to_owned().into_dyn(),
        spacing: [1.0, 2.0, 4.0],
        origin: [10.0, 0.0, -5.0],
    };
    fs::write(path("a.nrrd"), bytes(|out| nrrd::write(&phi, out))).unwrap();
    let chain = ["a.nrrd", "b.vti", "c.nii.gz", "d.nii", "e.mrc", "f.nrrd"];
    for pair in chain.windows(2) {
        convert(&path(pair[0]), &path(pair[1])).unwrap();
    }
    let last = input::load_volume(&path("f.nrrd"), 1 << 30).unwrap();
    assert_eq!((last.spacing, last.origin), (phi.spacing, phi.origin));
    let off = (&last.values - &phi.values).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(off < 1e-7, "{off}");
    // An ellipsoid of half axes 12, 24, 48 about (25, 30, 55).
    let surface = input::load_surface(&path("f.nrrd"), None, false, Caps::Closed).unwrap().mesh;
    let exact = 4.0 / 3.0 * PI * 12.0 * 24.0 * 48.0;
    assert!(surface.is_closed() && (surface.volume() / exact - 1.0).abs() < 0.01);
    let end = |axis: usize| surface.vertices.iter().map(|v| v[axis]).fold(f64::MIN, f64::max);
    assert!(
        (end(0) - 37.0).abs() < 0.1 && (end(1) - 54.0).abs() < 0.2 && (end(2) - 103.0).abs() < 0.4
    );
    convert(&path("f.nrrd"), &path("g.stl")).unwrap();
    for pair in ["g.stl", "h.ply", "i.glb", "j.obj"].windows(2) {
        convert(&path(pair[0]), &path(pair[1])).unwrap();
    }
    let mesh = input::load_mesh(&path("j.obj")).unwrap().unwrap().weld();
    assert!(mesh.is_closed() && (mesh.volume() / exact - 1.0).abs() < 0.01);
    assert!(convert(&path("h.ply"), &path("k.npy")).unwrap_err().to_string().contains("is a mesh"));
    fs::write(path("l.csv"), "line,x,y\n0,1,2\n0,3,2\n0,3,5\n").unwrap();
    convert(&path("l.csv"), &path("l.dxf")).unwrap();
    assert!(fs::read_to_string(path("l.dxf")).unwrap().contains("POLYLINE"));
}
