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
    ensure!(mesh.vertices.iter().flatten().all(|c| c.is_finite()), "a vertex is not finite");
    let beyond = mesh.triangles.iter().flatten().find(|&&v| v as usize >= count);
    ensure!(beyond.is_none(), "a triangle names a vertex beyond {count}");
    let mut data = Data::default();
    let positions: Vec<[f32; 3]> = mesh.vertices.iter().map(|v| v.map(|c| c as f32)).collect();
    let mut nodes = Vec::new();
    if count > 0 && !mesh.triangles.is_empty() {
        // glTF wants normals of length 1 everywhere.
        let normals = mesh.vertex_normals().into_iter();
        let normals = normals.map(|n| if n == [0.0; 3] { [0.0, 0.0, 1.0] } else { n });
        let mut attributes = json!({
            "POSITION": data.floats(&positions, true),
            "NORMAL": data.floats(&normals.map(|n| n.map(|c| c as f32)).collect::<Vec<_>>(), false),
        });
        if colors.len() == count {
            attributes["COLOR_0"] = data.colors(colors).into();
        }
        let indices = data.indices(&mesh.triangles);
        nodes.push(json!({ "attributes": attributes, "indices": indices, "material": 0 }));
    }
    let base = if colors.len() == count { [1.0, 1.0, 1.0, 1.0] } else { [0.81, 0.67, 0.47, 1.0] };
    let mut root = json!({
        "asset": { "version": "2.0", "generator": concat!("patterns ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{}],
    });
    if !nodes.is_empty() {
        root["scenes"] = json!([{ "nodes": [0] }]);
        root["nodes"] = json!([{ "mesh": 0 }]);
        root["meshes"] = json!([{ "primitives": nodes }]);
        root["materials"] = json!([{
            "pbrMetallicRoughness": { "baseColorFactor": base, "metallicFactor": 0.0, "roughnessFactor": 0.8 },
            "doubleSided": true,
        }]);
        root["buffers"] = json!([{ "byteLength": data.bytes.len() }]);
        root["bufferViews"] = Value::Array(data.views);
        root["accessors"] = Value::Array(data.accessors);
    }
    let mut text = serde_json::to_vec(&root)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + if data.bytes.is_empty() { 0 } else { 8 + data.bytes.len() };
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&u32::try_from(total).context("more than 4 GiB for a GLB")?.to_le_bytes())?;
    out.write_all(&(text.len() as u32).to_le_bytes())?;
    out.write_all(&JSON.to_le_bytes())?;
    out.write_all(&text)?;
    if !data.bytes.is_empty() {
        out.write_all(&(data.bytes.len() as u32).to_le_bytes())?;
        out.write_all(&BIN.to_le_bytes())?;
        out.write_all(&data.bytes)?;
    }
    Ok(())
}

/// The buffer and what describes it; each part begins at a multiple of 4 bytes.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    /// A view of what was added from `start` on; returns the number of its accessor.
    fn finish(&mut self, start: usize, target: u64, accessor: Value) -> usize {
        let length = self.bytes.len() - start;
        self.views.push(
            json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": target }),
        );
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn floats(&mut self, points: &[[f32; 3]], ends: bool) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(points.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
        let mut accessor = json!({
            "bufferView": self.views.len(), "componentType": FLOAT, "count": points.len(), "type": "VEC3",
        });
        if ends {
            let end = |pick: fn(f32, f32) -> f32| {
                [0, 1, 2].map(|m| points.iter().map(|p| p[m]).reduce(pick).unwrap_or(0.0))
            };
            accessor["min"] = json!(end(f32::min));
            accessor["max"] = json!(end(f32::max));
        }
        self.finish(start, 34962, accessor)
    }

    /// sRGB becomes linear, with alpha, as glTF wants.
    fn colors(&mut self, colors: &[Rgb]) -> usize {
        let start = self.bytes.len();
        for &color in colors {
            let linear = crate::render::linear(color).map(|c| (255.0 * c).round() as u8);
            self.bytes.extend(linear);
            self.bytes.push(255);
        }
        let accessor = json!({
            "bufferView": self.views.len(), "componentType": BYTE, "normalized": true,
            "count": colors.len(), "type": "VEC4",
        });
        self.finish(start, 34962, accessor)
    }

    fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        let accessor = json!({
            "bufferView": self.views.len(), "componentType": UINT,
            "count": 3 * triangles.len(), "type": "SCALAR",
        });
        self.finish(start, 34963, accessor)
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
