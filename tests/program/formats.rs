//! File formats: what is written reads back, what is broken is refused with a reason.

use lab::{
    input,
    output::{self, convert, csv, mesh, npy, vti},
};
use ndarray::{Array2, ArrayD, IxDyn};
use proptest::prelude::*;
use solvers::{Field, Grid, mesh::TriangleMesh};
use std::{
    fs,
    io::Cursor,
    path::{Path, PathBuf},
};
use tempfile::TempDir;

const LIMIT: u64 = 1 << 20;

fn array(shape: &[usize]) -> ArrayD<f64> {
    let n = shape.iter().product::<usize>();
    let values = (0..n).map(|n| (n as f64 * 0.7).sin() * 1e3).collect();
    ArrayD::from_shape_vec(IxDyn(shape), values).unwrap()
}

fn npy_bytes(values: &ArrayD<f64>) -> Vec<u8> {
    let mut bytes = Vec::new();
    npy::write(&values.view(), &mut bytes).unwrap();
    bytes
}

fn npz_bytes(values: &ArrayD<f64>) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    npy::write_npz(&[("values", values.view())], &mut bytes).unwrap();
    bytes.into_inner()
}

fn vti_bytes(values: &ArrayD<f64>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let field = Field::from_array(values.clone(), 0.5).unwrap();
    vti::write(&[("b <1>", &field)], &mut bytes).unwrap();
    bytes
}

/// An NPY made by hand, of any header.
fn npy_with(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    [bytes, header.as_bytes().to_vec(), data.to_vec()].concat()
}

/// The message of reading `bytes` as a file called `name`, with all its causes.
fn refusal(name: &str, bytes: &[u8]) -> String {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    let error = input::load_within(&path, LIMIT).expect_err(name);
    let message = format!("{error:#}");
    assert!(message.contains(name), "{message}");
    message
}

fn read_back(name: &str, bytes: &[u8]) -> ArrayD<f64> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    input::load_within(&path, LIMIT).unwrap()
}

#[test]
fn arrays_read_back_to_the_last_bit() {
    for shape in [&[5][..], &[4, 6], &[3, 4, 5]] {
        let values = array(shape);
        assert_eq!(read_back("a.npy", &npy_bytes(&values)), values);
        assert_eq!(read_back("a.npz", &npz_bytes(&values)), values);
        assert_eq!(read_back("a.vti", &vti_bytes(&values)), values);
    }
    let mut text = Vec::new();
    csv::write_grid(&array(&[4, 6]).view(), &mut text).unwrap();
    assert_eq!(read_back("a.csv", &text), array(&[4, 6]));
    // The name does not decide where the content tells.
    assert_eq!(read_back("a.dat", &npy_bytes(&array(&[4]))), array(&[4]));
    assert_eq!(npy_bytes(&array(&[4, 6])).len() % 64, 4 * 6 * 8 % 64);
}

#[test]
fn every_numpy_type_and_order_is_read() {
    let header = |descr: &str, fortran: &str| {
        format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': (2, 3), }}\n")
    };
    let rows = ArrayD::from_shape_vec(IxDyn(&[2, 3]), vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
    macro_rules! check {
        ($($kind:ty, $name:literal;)*) => {$(
            let values = [0, 1, 2, 3, 4, 5].map(|v| v as $kind);
            let little: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            let big: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
            let little = npy_with(&header(concat!("<", $name), "False"), &little);
            assert_eq!(npy::read(&little, LIMIT).unwrap(), rows);
            let big = npy_with(&header(concat!(">", $name), "False"), &big);
            assert_eq!(npy::read(&big, LIMIT).unwrap(), rows);
        )*};
    }
    check! { f64, "f8"; f32, "f4"; u8, "u1"; i8, "i1"; u16, "u2"; i16, "i2"; u32, "u4"; i32, "i4"; u64, "u8"; i64, "i8"; }
    let columns = npy_with(&header("|u1", "True"), &[0, 3, 1, 4, 2, 5]);
    let read = npy::read(&columns, LIMIT).unwrap();
    assert_eq!(read, rows);
    assert!(read.is_standard_layout());
    let truth = npy_with(&header("|b1", "False"), &[0, 1, 1, 0, 0, 1]);
    assert_eq!(npy::read(&truth, LIMIT).unwrap().sum(), 3.0);
}

#[test]
fn files_of_numpy_itself_are_read() {
    // numpy.save of numpy.arange(3, dtype='<i4'), version 1.0.
    let header = format!("{{'descr': '<i4', 'fortran_order': False, 'shape': (3,), }}{:60}\n", "");
    let bytes = npy_with(&header, &[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    assert_eq!(bytes.len(), 128 + 12);
    assert_eq!(npy::read(&bytes, LIMIT).unwrap().as_slice().unwrap(), [0.0, 1.0, 2.0]);
}

#[test]
fn vti_of_paraview_is_read() {
    let file = |body: &str, tail: &[u8]| {
        let head = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
             <ImageData WholeExtent=\"0 2 0 1 0 0\" Origin=\"0 0 0\" Spacing=\"1 1 1\">\n\
             <Piece Extent=\"0 2 0 1 0 0\"><PointData Scalars=\"u\">\n{body}\n\
             </PointData></Piece></ImageData>"
        );
        [head.as_bytes(), tail, b"</VTKFile>"].concat()
    };
    let want =
        Array2::from_shape_vec((2, 3), vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap().into_dyn();
    let ascii = file(
        "<DataArray type=\"Float32\" Name=\"u\" format=\"ascii\">0 1 2\n3 4 5</DataArray>",
        b"",
    );
    assert_eq!(read_back("a.vti", &ascii), want);
    // A 32-bit length of 6 and six bytes, together: 06 00 00 00 00 01 02 03 04 05.
    let inline =
        "<DataArray type=\"UInt8\" Name=\"u\" format=\"binary\">BgAAAAABAgMEBQ==</DataArray>";
    assert_eq!(read_back("a.vti", &file(inline, b"")), want);
    let appended = "<DataArray type=\"UInt8\" Name=\"u\" format=\"appended\" offset=\"0\"/>";
    let tail = b"<AppendedData encoding=\"base64\">\n_BgAAAAABAgMEBQ==</AppendedData>";
    assert_eq!(read_back("a.vti", &file(appended, tail)), want);
    let tail = b"<AppendedData encoding=\"raw\">\n_\x06\0\0\0\0\x01\x02\x03\x04\x05</AppendedData>";
    assert_eq!(read_back("a.vti", &file(appended, tail)), want);
    let two = "<DataArray type=\"UInt8\" Name=\"u\" format=\"appended\" offset=\"0\"/>\
               <DataArray type=\"UInt8\" Name=\"v\" format=\"appended\" offset=\"0\"/>";
    assert!(refusal("a.vti", &file(two, tail)).contains("2 arrays (u, v), one is wanted"));
}

#[test]
fn vti_keeps_spacing_and_names() {
    let grid = Grid::new(&[2, 3, 4], 0.25).unwrap();
    let [a, b] =
        [1.0, 2.0].map(|v| Field::from_fn(grid, |[x, y, z]| v * (x + 10.0 * y + 100.0 * z)));
    let mut bytes = Vec::new();
    vti::write(&[("a & b", &a), ("phi", &b)], &mut bytes).unwrap();
    let arrays = vti::read(&bytes, LIMIT).unwrap();
    assert_eq!(arrays.len(), 2);
    assert_eq!(arrays[1].name, "phi");
    assert_eq!(arrays[1].spacing, [0.25; 3]);
    assert_eq!(arrays[1].values.as_slice().unwrap(), b.as_slice());
    assert!(String::from_utf8_lossy(&bytes).contains("Name=\"a &amp; b\""));
}

#[test]
fn meshes_read_back() {
    let tetrahedron = TriangleMesh {
        vertices: vec![[0.0; 3], [1.5, 0.0, 0.0], [0.0, 1.25, 0.0], [0.0, 0.0, 2.0]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    };
    let mut ply = Vec::new();
    mesh::write_ply(&tetrahedron, &mut ply).unwrap();
    assert_eq!(mesh::read_ply(&ply).unwrap(), tetrahedron);
    let mut obj = Vec::new();
    mesh::write_obj(&tetrahedron, &mut obj).unwrap();
    assert_eq!(mesh::read_obj(std::str::from_utf8(&obj).unwrap()).unwrap(), tetrahedron);
    let mut stl = Vec::new();
    mesh::write_stl(&tetrahedron, &mut stl).unwrap();
    assert_eq!(stl.len(), 84 + 4 * 50);
    let soup = mesh::read_stl(&stl).unwrap();
    for (n, triangle) in tetrahedron.triangles.iter().enumerate() {
        for (m, &corner) in triangle.iter().enumerate() {
            assert_eq!(soup.vertices[3 * n + m], tetrahedron.vertices[corner as usize]);
        }
    }
    // The first face lies in z = 0 and looks down.
    let normal: Vec<f32> =
        stl[84..96].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(normal, [0.0, 0.0, -1.0]);
    for cut in 0..ply.len() {
        assert!(mesh::read_ply(&ply[..cut]).is_err());
    }
    for cut in 0..stl.len() {
        assert!(mesh::read_stl(&stl[..cut]).is_err());
    }
}

#[test]
fn bad_arrays_say_what_is_wrong() {
    let shape = |shape: &str| {
        npy_with(
            &format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n"),
            &[0; 16],
        )
    };
    let cases: [(&str, Vec<u8>, &str); 14] = [
        (
            "a.npy",
            npy_bytes(&array(&[4, 6]))[..200].to_vec(),
            "needs 192 bytes of data, the file holds 72 (truncated?)",
        ),
        (
            "a.npy",
            npy_bytes(&array(&[4, 6]))[..30].to_vec(),
            "truncated in the header, after 30 bytes",
        ),
        (
            "a.npy",
            [npy_bytes(&array(&[2])), vec![0]].concat(),
            "needs 16 bytes of data, the file holds 17",
        ),
        ("a.npy", shape("(1000000, 1000000)"), "needs 8000000000000 bytes, more than the limit"),
        ("a.npy", shape("(4294967296, 4294967296, 4294967296)"), "overflows"),
        ("a.npy", shape("(0, 5)"), "needs 0 bytes of data, the file holds 16"),
        ("a.npy", shape("(2, x)"), "axis that is no number"),
        (
            "a.npy",
            npy_with("{'descr': '<c16', 'fortran_order': False, 'shape': (1,), }", &[0; 16]),
            "elements of type `<c16`; wanted are f8",
        ),
        (
            "a.npy",
            npy_with("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (1,), }", &[0; 8]),
            "several fields",
        ),
        (
            "a.npy",
            npy_bytes(
                &ArrayD::from_shape_vec(IxDyn(&[2, 2]), vec![0.0, 1.0, f64::NAN, 2.0]).unwrap(),
            ),
            "NaN at index [1, 0]",
        ),
        ("a.npz", npz_bytes(&array(&[4, 6]))[..100].to_vec(), "no complete zip archive"),
        ("a.csv", b"1,2,3\n4,5\n".to_vec(), "line 2 has 2 numbers, the lines before have 3"),
        ("a.csv", b"1,2\n3,four\n".to_vec(), "line 2, cell 2: `four` is no number"),
        ("a.csv", b"# nothing\n".to_vec(), "no numbers"),
    ];
    for (name, bytes, want) in cases {
        let message = refusal(name, &bytes);
        assert!(message.contains(want), "{message}\nlacks: {want}");
    }
}

#[test]
fn bad_files_say_what_is_wrong() {
    let folder = TempDir::new().unwrap();
    let message = |path: &Path| format!("{:#}", input::load_field(path).unwrap_err());
    let missing = message(&folder.path().join("missing.png"));
    assert!(missing.contains("missing.png") && missing.contains("No such file"), "{missing}");
    let own = message(folder.path());
    assert!(own.contains("a folder; wanted is an image or an array"), "{own}");
    assert!(refusal("a.npy", b"").contains("the file is empty"));
    assert!(refusal("a.png", b"1,2\n3,4\n").contains("no PNG file: it begins with"));
    assert!(
        refusal("a.bin", b"\x01\x02\x00\xff")
            .contains("unknown content: it begins with `\\x01\\x02\\x00\\xff`")
    );
    let wrong = input::check_shape(&array(&[4, 6]), &[6, 4]).unwrap_err().to_string();
    assert_eq!(wrong, "shape [4, 6]; wanted is [6, 4] (rows first)");
}

/// Files of every format that is read, small.
fn valid_files() -> Vec<(&'static str, Vec<u8>)> {
    let mut text = Vec::new();
    csv::write_grid(&array(&[3, 3]).view(), &mut text).unwrap();
    let mut files = vec![
        ("a.npy", npy_bytes(&array(&[3, 3]))),
        ("a.npz", npz_bytes(&array(&[3, 3]))),
        ("a.vti", vti_bytes(&array(&[3, 3]))),
        ("a.csv", text),
    ];
    let picture = image::DynamicImage::ImageRgb8(image::RgbImage::from_fn(9, 7, |x, y| {
        image::Rgb([x as u8 * 20, y as u8 * 30, (x * y) as u8])
    }));
    for (name, format) in [
        ("a.png", image::ImageFormat::Png),
        ("a.jpg", image::ImageFormat::Jpeg),
        ("a.bmp", image::ImageFormat::Bmp),
        ("a.ppm", image::ImageFormat::Pnm),
        ("a.tiff", image::ImageFormat::Tiff),
    ] {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        files.push((name, bytes.into_inner()));
    }
    files
}

/// Reads without a panic: a value or a message.
fn survive(folder: &Path, name: &str, bytes: &[u8]) -> bool {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    input::load_within(&path, LIMIT).is_ok()
}

#[test]
fn truncation_at_any_length_is_an_error() {
    let folder = TempDir::new().unwrap();
    for (name, bytes) in valid_files() {
        assert!(survive(folder.path(), name, &bytes), "{name}");
        let passed =
            (0..bytes.len()).filter(|&n| survive(folder.path(), name, &bytes[..n])).count();
        match name {
            // A text may end at any number; the closing tags of a VTI, the end marks and the
            // trailing bytes of images carry no values.
            "a.csv" => {}
            "a.vti" => {
                assert!(passed <= "\n</AppendedData>\n</VTKFile>\n".len(), "{name}: {passed}")
            }
            "a.png" => assert!(passed <= 16, "{name}: {passed}"),
            "a.jpg" => assert!(passed < bytes.len() / 2, "{name}: {passed}"),
            "a.tiff" => assert!(passed <= 8, "{name}: {passed}"),
            _ => assert_eq!(passed, 0, "{name}"),
        }
    }
}

#[test]
fn damage_at_any_byte_is_survived() {
    let folder = TempDir::new().unwrap();
    for (name, bytes) in valid_files() {
        for n in 0..bytes.len().min(400) {
            for flip in [0x01, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[n] ^= flip;
                survive(folder.path(), name, &damaged);
            }
        }
    }
}

proptest! {
    // Without a file of past failures: there is no library beside this test.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..300), kind in 0_usize..10) {
        let magics: [&[u8]; 10] = [
            b"", b"\x93NUMPY\x01\0\x40\0", b"PK\x03\x04", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"BM",
            b"II*\0", b"P5\n", b"<?xml", b"P6 ",
        ];
        let folder = TempDir::new().unwrap();
        survive(folder.path(), "a", &[magics[kind], &bytes].concat());
        let _ = lab::output::Animation::from_bytes(&[b"PATTERNS-FILM-1\n", bytes.as_slice()].concat());
        let _ = mesh::read_stl(&bytes);
    }

    #[test]
    fn any_array_survives_npy_and_csv(values in prop::collection::vec(prop::num::f64::NORMAL, 1..60)) {
        let values = ArrayD::from_shape_vec(IxDyn(&[1, values.len()]), values).unwrap();
        prop_assert_eq!(&npy::read(&npy_bytes(&values), LIMIT).unwrap(), &values);
        let mut text = Vec::new();
        csv::write_grid(&values.view(), &mut text).unwrap();
        prop_assert_eq!(&csv::read_grid(std::str::from_utf8(&text).unwrap()).unwrap().into_dyn(), &values);
    }
}

#[test]
fn conversion_keeps_values_where_the_format_can() {
    let folder = TempDir::new().unwrap();
    let file = |name: &str| -> PathBuf { folder.path().join(name) };
    let values = array(&[5, 4]);
    fs::write(file("a.npy"), npy_bytes(&values)).unwrap();
    let names = ["a.npy", "b.npz", "c.csv", "d.vti", "e.npy"];
    for pair in names.windows(2) {
        convert(&file(pair[0]), &file(pair[1])).unwrap();
    }
    assert_eq!(fs::read(file("a.npy")).unwrap(), fs::read(file("e.npy")).unwrap());
    // Out of [0, 1]: scaled to the 16 bits of a PNG, and says so.
    let note = convert(&file("a.npy"), &file("f.png")).unwrap();
    assert!(
        note.contains("5 x 4 values") && note.contains("(black) to") && note.contains("16-bit"),
        "{note}"
    );
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
    for (grey, v) in input::load_field(&file("f.png")).unwrap().iter().zip(&values) {
        // Half a step of 65535.
        assert!((grey - (v - low) / (high - low)).abs() <= 0.5001 / 65535.0);
    }
    // Grey of 8 bits there and back.
    let grey = values.mapv(|v| ((v - low) / (high - low) * 255.0).round() / 255.0);
    fs::write(file("g.npy"), npy_bytes(&grey)).unwrap();
    assert!(convert(&file("g.npy"), &file("h.png")).unwrap().contains("[0, 1] as 8-bit grey"));
    assert_eq!(input::load_field(&file("h.png")).unwrap(), grey);
}

#[test]
fn impossible_conversions_leave_nothing() {
    let folder = TempDir::new().unwrap();
    let file = |name: &str| -> PathBuf { folder.path().join(name) };
    fs::write(file("solid.npy"), npy_bytes(&array(&[2, 3, 4]))).unwrap();
    fs::write(file("nan.npy"), npy_bytes(&ArrayD::from_elem(IxDyn(&[2, 2]), f64::NAN))).unwrap();
    for (from, to, want) in [
        ("solid.npy", "a.png", "shape [2, 3, 4] is no picture"),
        ("solid.npy", "a.csv", "an array of 3 axes cannot be a CSV"),
        ("solid.npy", "a.xyz", "unknown extension; wanted is .npy, .npz, .csv, .vti, .nrrd,"),
        ("nan.npy", "a.png", "NaN at index [0, 0]"),
        ("none.npy", "a.npz", "none.npy"),
        ("solid.npy", "no/such/folder.npz", "folder.npz"),
    ] {
        let message = format!("{:#}", convert(&file(from), &file(to)).unwrap_err());
        assert!(message.contains(want), "{message}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    // NaN passes between formats that have it.
    convert(&file("nan.npy"), &file("nan.vti")).unwrap();
}

#[test]
fn a_failed_save_keeps_the_old_file() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.txt");
    output::save_bytes(&path, b"old").unwrap();
    let error = output::save(&path, |_| anyhow::bail!("the writer failed")).unwrap_err();
    let message = format!("{error:#}");
    assert!(message.contains("a.txt") && message.contains("the writer failed"), "{message}");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    // A device without room reports it when the buffer is written out.
    #[cfg(target_os = "linux")]
    {
        use std::io::Write as _;
        let mut full = std::io::BufWriter::new(fs::File::create("/dev/full").unwrap());
        let written =
            npy::write(&array(&[3000]).view(), &mut full).and_then(|()| Ok(full.flush()?));
        assert!(format!("{:#}", written.unwrap_err()).contains("No space left"));
    }
}
