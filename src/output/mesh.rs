//! Triangle meshes: PLY and STL (binary, little endian) and OBJ.

use anyhow::{Context as _, Result, bail, ensure};
use solvers::mesh::TriangleMesh;
use std::io::Write;

/// Writes binary PLY: vertices as `float`.
///
/// # Errors
/// If `out` fails.
pub fn write_ply(mesh: &TriangleMesh, out: &mut impl Write) -> Result<()> {
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )?;
    for vertex in &mesh.vertices {
        out.write_all(&floats(*vertex))?;
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        out.write_all(triangle.map(u32::to_le_bytes).as_flattened())?;
    }
    Ok(())
}

/// Writes binary STL, with unit normals (0 for a triangle without area).
///
/// # Errors
/// If a triangle names a vertex that is not there, there are more than 2^32 triangles,
/// or `out` fails.
pub fn write_stl(mesh: &TriangleMesh, out: &mut impl Write) -> Result<()> {
    // Many readers take a file that begins with `solid` for text.
    let mut header = [b' '; 80];
    header[..18].copy_from_slice(b"binary STL, meshes");
    out.write_all(&header)?;
    out.write_all(&u32::try_from(mesh.triangles.len())?.to_le_bytes())?;
    for triangle in &mesh.triangles {
        let corner = |n: u32| mesh.vertices.get(n as usize).copied();
        let [Some(a), Some(b), Some(c)] = triangle.map(corner) else {
            bail!("triangle {triangle:?} names a vertex beyond {}", mesh.vertices.len());
        };
        out.write_all(&floats(normal(a, b, c)))?;
        for vertex in [a, b, c] {
            out.write_all(&floats(vertex))?;
        }
        out.write_all(&[0, 0])?;
    }
    Ok(())
}

/// Writes OBJ text.
///
/// # Errors
/// If `out` fails.
pub fn write_obj(mesh: &TriangleMesh, out: &mut impl Write) -> Result<()> {
    for [x, y, z] in &mesh.vertices {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|n| u64::from(n) + 1);
        writeln!(out, "f {a} {b} {c}")?;
    }
    Ok(())
}

/// Reads the PLY that [`write_ply`] writes.
///
/// # Errors
/// If the header is another or the data are truncated.
pub fn read_ply(bytes: &[u8]) -> Result<TriangleMesh> {
    const END: &[u8] = b"end_header\n";
    let end = bytes.windows(END.len()).position(|w| w == END).context("no PLY header")?;
    let header = std::str::from_utf8(&bytes[..end]).context("the PLY header is no text")?;
    ensure!(
        header.starts_with("ply\nformat binary_little_endian 1.0\n"),
        "no little-endian binary PLY"
    );
    let count = |element: &str| -> Result<usize> {
        let line = header.lines().find_map(|l| l.strip_prefix(element));
        line.and_then(|n| n.trim().parse().ok()).with_context(|| format!("no `{element}`"))
    };
    let (vertices, triangles) = (count("element vertex")?, count("element face")?);
    let data = &bytes[end + END.len()..];
    let sizes = vertices.checked_mul(12).zip(triangles.checked_mul(13));
    let (split, rest) = sizes.context("the PLY header's counts overflow")?;
    ensure!(
        split.checked_add(rest) == Some(data.len()),
        "{vertices} vertices and {triangles} triangles do not fill {} bytes of data",
        data.len()
    );
    let vertices = data[..split].chunks_exact(12).map(vertex).collect();
    let triangles =
        data[split..].chunks_exact(13).map(|b| [1, 5, 9].map(|n| word(&b[n..]))).collect();
    let mesh = TriangleMesh { vertices, triangles };
    check(&mesh)?;
    Ok(mesh)
}

/// Refuses triangles without their vertices.
pub(super) fn check(mesh: &TriangleMesh) -> Result<()> {
    let count = mesh.vertices.len();
    let bad = mesh.triangles.iter().flatten().find(|&&n| n as usize >= count);
    ensure!(
        bad.is_none(),
        "vertex {} is named, there are {count}",
        bad.map_or(0, |&n| u64::from(n) + 1)
    );
    Ok(())
}

/// Reads binary STL; equal corners of neighbours stay separate vertices.
///
/// # Errors
/// If the file's length does not fit its number of triangles.
pub fn read_stl(bytes: &[u8]) -> Result<TriangleMesh> {
    ensure!(bytes.len() >= 84, "{} bytes are too few for a binary STL", bytes.len());
    let count = word(&bytes[80..]) as usize;
    let data = &bytes[84..];
    ensure!(
        count.checked_mul(50) == Some(data.len()),
        "{count} triangles do not fill {} bytes of data",
        data.len()
    );
    let corners = data.chunks_exact(50).flat_map(|b| [12, 24, 36].map(|n| vertex(&b[n..])));
    let triangles = (0..count as u32).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
    Ok(TriangleMesh { vertices: corners.collect(), triangles })
}

/// Reads the `v` and triangular `f` lines of an OBJ.
///
/// # Errors
/// If a line has another number of entries, or names a vertex that is not there.
pub fn read_obj(text: &str) -> Result<TriangleMesh> {
    let mut mesh = TriangleMesh::default();
    for (n, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let v: Vec<f64> = words.filter_map(|w| w.parse().ok()).collect();
                let v = v.get(..3).and_then(|v| v.try_into().ok());
                mesh.vertices
                    .push(v.with_context(|| format!("line {}: three numbers wanted", n + 1))?);
            }
            Some("f") => {
                let index = |w: &str| {
                    w.split('/').next().and_then(|w| w.parse::<u32>().ok()?.checked_sub(1))
                };
                let f: Vec<u32> = words.filter_map(index).collect();
                let f = f.try_into().ok();
                mesh.triangles
                    .push(f.with_context(|| format!("line {}: three corners wanted", n + 1))?);
            }
            _ => {}
        }
    }
    check(&mesh)?;
    Ok(mesh)
}

fn floats(v: [f64; 3]) -> Vec<u8> {
    v.iter().flat_map(|v| (*v as f32).to_le_bytes()).collect()
}

fn word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

fn vertex(bytes: &[u8]) -> [f64; 3] {
    [0, 4, 8].map(|n| f64::from(f32::from_bits(word(&bytes[n..]))))
}

/// Unit normal, counter-clockwise from outside.
fn normal(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [f64; 3] {
    let d = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (u, v) = (d(b), d(c));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length > 0.0 { n.map(|v| v / length) } else { [0.0; 3] }
}
