//! Triangle meshes as binary glTF 2.0 (`.glb`), for browsers, Blender and slide programs.
//!
//! Source: Khronos Group, "glTF 2.0 Specification" (2021), chapter 4.4 (GLB). One buffer holds
//! positions, normals, colours and indices; glTF's axes (y up, right-handed) take the mesh's
//! as they are.

use super::colormap::Rgb;
use anyhow::{Context as _, Result, bail, ensure};
use serde_json::{Value, json};
use solvers::mesh::TriangleMesh;
use std::io::Write;

/// Component types: `unsigned byte`, `unsigned int`, `float`.
const BYTE: u64 = 5121;
const UINT: u64 = 5125;
const FLOAT: u64 = 5126;
/// Targets of views: `ARRAY_BUFFER`, `ELEMENT_ARRAY_BUFFER`.
const CORNERS: u64 = 34962;
const INDICES: u64 = 34963;
/// Kinds of chunks.
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// Writes a mesh with vertex normals, and with one colour a vertex if `colors` has as many.
///
/// # Errors
/// If a coordinate is not finite, a triangle names a vertex that is not there, the file would
/// have 4 GiB or more, or `out` fails.
pub fn write(mesh: &TriangleMesh, colors: &[Rgb], out: &mut impl Write) -> Result<()> {
    let count = mesh.vertices.len();
    let fits = |c: &f64| (*c as f32).is_finite();
    ensure!(mesh.vertices.iter().flatten().all(fits), "a vertex is not finite in 32 bits");
    let beyond = mesh.triangles.iter().flatten().find(|&&v| v as usize >= count);
    ensure!(beyond.is_none(), "a triangle names a vertex beyond {count}");
    let some = count > 0 && !mesh.triangles.is_empty();
    let colors = if colors.len() == count { colors } else { &[] };
    let layout = if some { Layout::of(mesh, !colors.is_empty()) } else { Layout::default() };
    let bytes = layout.bytes;
    let mut text = serde_json::to_vec(&layout.document(!colors.is_empty()))?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + if some { 8 + bytes } else { 0 };
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&u32::try_from(total).context("more than 4 GiB for a GLB")?.to_le_bytes())?;
    out.write_all(&(text.len() as u32).to_le_bytes())?;
    out.write_all(&JSON.to_le_bytes())?;
    out.write_all(&text)?;
    if some {
        out.write_all(&(bytes as u32).to_le_bytes())?;
        out.write_all(&BIN.to_le_bytes())?;
        write_data(mesh, colors, out)?;
    }
    Ok(())
}

/// The buffer, straight to `out`: large meshes are not held twice. In the order of
/// [`Layout::of`].
fn write_data(mesh: &TriangleMesh, colors: &[Rgb], out: &mut impl Write) -> Result<()> {
    let mut point = |p: [f64; 3]| out.write_all(p.map(|c| (c as f32).to_le_bytes()).as_flattened());
    mesh.vertices.iter().try_for_each(|&p| point(p))?;
    // glTF wants normals of length 1 everywhere.
    let normals = mesh.vertex_normals().into_iter();
    let mut normals = normals.map(|n| if n == [0.0; 3] { [0.0, 0.0, 1.0] } else { n });
    normals.try_for_each(point)?;
    for &color in colors {
        // sRGB becomes linear, with alpha, as glTF wants.
        let [r, g, b] = crate::render::linear(color).map(|c| (255.0 * c).round() as u8);
        out.write_all(&[r, g, b, 255])?;
    }
    for triangle in &mesh.triangles {
        out.write_all(triangle.map(u32::to_le_bytes).as_flattened())?;
    }
    Ok(())
}

/// Where the parts of the buffer are; each begins at a multiple of 4 bytes.
#[derive(Default)]
struct Layout {
    bytes: usize,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Layout {
    /// Positions, normals, perhaps colours, indices.
    fn of(mesh: &TriangleMesh, colors: bool) -> Self {
        let count = mesh.vertices.len();
        let mut layout = Self::default();
        // Of the numbers as they are written, as glTF wants.
        let end = |pick: fn(f32, f32) -> f32| {
            let of = |m: usize| mesh.vertices.iter().map(move |p| p[m] as f32).reduce(pick);
            [0, 1, 2].map(|m| of(m).unwrap_or(0.0))
        };
        let [min, max] = [end(f32::min), end(f32::max)];
        let vectors = json!({ "componentType": FLOAT, "count": count, "type": "VEC3" });
        layout.add(12 * count, CORNERS, vectors.clone(), json!({ "min": min, "max": max }));
        layout.add(12 * count, CORNERS, vectors, json!({}));
        if colors {
            let bytes = json!({ "componentType": BYTE, "count": count, "type": "VEC4" });
            layout.add(4 * count, CORNERS, bytes, json!({ "normalized": true }));
        }
        let count = 3 * mesh.triangles.len();
        let numbers = json!({ "componentType": UINT, "count": count, "type": "SCALAR" });
        layout.add(4 * count, INDICES, numbers, json!({}));
        layout
    }

    /// A part of `length` bytes, and the accessor of its elements, with `more` about it.
    fn add(&mut self, length: usize, target: u64, mut accessor: Value, more: Value) {
        accessor["bufferView"] = self.views.len().into();
        if let (Some(all), Value::Object(more)) = (accessor.as_object_mut(), more) {
            all.extend(more);
        }
        self.accessors.push(accessor);
        self.views.push(
            json!({ "buffer": 0, "byteOffset": self.bytes, "byteLength": length, "target": target }),
        );
        self.bytes += length;
    }

    /// The whole description.
    fn document(self, colors: bool) -> Value {
        let mut root = json!({
            "asset": { "version": "2.0", "generator": concat!("patterns ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{}],
        });
        if self.accessors.is_empty() {
            return root;
        }
        let mut attributes = json!({ "POSITION": 0, "NORMAL": 1 });
        if colors {
            attributes["COLOR_0"] = 2.into();
        }
        let indices = self.accessors.len() - 1;
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": 0 });
        let base = if colors { [1.0, 1.0, 1.0, 1.0] } else { [0.81, 0.67, 0.47, 1.0] };
        root["scenes"] = json!([{ "nodes": [0] }]);
        root["nodes"] = json!([{ "mesh": 0 }]);
        root["meshes"] = json!([{ "primitives": [primitive] }]);
        root["materials"] = json!([{
            "pbrMetallicRoughness": { "baseColorFactor": base, "metallicFactor": 0.0, "roughnessFactor": 0.8 },
            "doubleSided": true,
        }]);
        root["buffers"] = json!([{ "byteLength": self.bytes }]);
        root["bufferViews"] = Value::Array(self.views);
        root["accessors"] = Value::Array(self.accessors);
        root
    }
}

/// Reads the first primitive of the first mesh of a GLB whose one buffer is in the file:
/// positions as `float`, indices of any size; without placing nodes.
///
/// # Errors
/// If it is no GLB 2, truncated, compressed, not made of indexed triangles, or names bytes or
/// vertices that are not there.
pub fn read(bytes: &[u8]) -> Result<TriangleMesh> {
    ensure!(bytes.starts_with(b"glTF"), "no GLB");
    let word = |at: usize| -> Result<u32> {
        let four = bytes.get(at..at + 4).context("the GLB is truncated")?;
        Ok(u32::from_le_bytes(four.try_into()?))
    };
    ensure!(word(4)? == 2, "GLB of version {}; wanted is 2", word(4)?);
    ensure!(
        word(8)? as usize == bytes.len(),
        "{} bytes are announced, {} are there (truncated?)",
        word(8)?,
        bytes.len()
    );
    let (length, kind) = (word(12)? as usize, word(16)?);
    ensure!(kind == JSON, "the GLB does not begin with JSON");
    let text = bytes.get(20..).and_then(|b| b.get(..length)).context("the GLB is truncated")?;
    let root: Value = serde_json::from_slice(text).context("the GLB's JSON")?;
    let primitive = &root["meshes"][0]["primitives"][0];
    if primitive.is_null() {
        return Ok(TriangleMesh::default());
    }
    let mode = primitive["mode"].as_u64().unwrap_or(4);
    ensure!(mode == 4, "a primitive of mode {mode}; wanted is 4, triangles");
    let at = 20 + length;
    ensure!(word(at + 4)? == BIN, "the GLB has no data of its own");
    let data = bytes[at + 8..].get(..word(at)? as usize).context("the GLB is truncated")?;
    let (floats, kind, size) = elements(&root, &primitive["attributes"]["POSITION"], data)?;
    ensure!(kind == FLOAT && size == 3, "positions are no triples of floats");
    let value = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let vertices: Vec<[f64; 3]> =
        floats.iter().map(|b| [0, 4, 8].map(|n| value(&b[n..]))).collect();
    let (numbers, _, size) = elements(&root, &primitive["indices"], data)?;
    ensure!(size == 1 && numbers.len() % 3 == 0, "{} indices are no triangles", numbers.len());
    let number = |b: &&[u8]| b.iter().rev().fold(0_u32, |n, &byte| n << 8 | u32::from(byte));
    let numbers: Vec<u32> = numbers.iter().map(number).collect();
    let triangles = numbers.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let mesh = TriangleMesh { vertices, triangles };
    super::mesh::check(&mesh)?;
    Ok(mesh)
}

/// The elements of an accessor as bytes, their component type, and components of each.
fn elements<'a>(
    root: &Value,
    accessor: &Value,
    data: &'a [u8],
) -> Result<(Vec<&'a [u8]>, u64, usize)> {
    let number = accessor.as_u64().context("a primitive without positions or indices")?;
    let accessor = &root["accessors"][number as usize];
    let kind = accessor["componentType"].as_u64().unwrap_or(0);
    let size = match accessor["type"].as_str() {
        Some("SCALAR") => 1,
        Some("VEC3") => 3,
        other => bail!("elements of type {other:?}"),
    };
    let bytes = size
        * match kind {
            BYTE => 1,
            5123 => 2,
            UINT | FLOAT => 4,
            other => bail!("components of type {other}"),
        };
    let view = accessor["bufferView"].as_u64().context("an accessor without data")?;
    let view = &root["bufferViews"][view as usize];
    let offset = |v: &Value| v["byteOffset"].as_u64().unwrap_or(0) as usize;
    let stride = view["byteStride"].as_u64().map_or(bytes, |s| s as usize);
    let count = accessor["count"].as_u64().unwrap_or(0) as usize;
    let start = offset(view).checked_add(offset(accessor)).context("offsets overflow")?;
    let rest = data.get(start..).context("the GLB names data that are not there")?;
    let end = stride.checked_mul(count.max(1) - 1).and_then(|n| n.checked_add(bytes));
    ensure!(
        stride >= bytes && end.is_some_and(|end| count == 0 || end <= rest.len()),
        "{count} elements do not fit in {} bytes",
        rest.len()
    );
    Ok(((0..count).map(|n| &rest[n * stride..][..bytes]).collect(), kind, size))
}
