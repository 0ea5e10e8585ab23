//! VTK ImageData (`.vti`), as ParaView reads and writes it.
//!
//! Source: "VTK File Formats", XML formats. Arrays are stored with x fastest, which is the
//! row-major order of `[nz, ny, nx]`.

use super::volume::Volume;
use anyhow::{Context as _, Result, bail, ensure};
use ndarray::ArrayD;
use solvers::Field;
use std::io::Write;

/// Writes point data: `arrays` of one grid, `f64`, appended raw, origin 0.
///
/// # Errors
/// If there is no array, the grids differ, or `out` fails.
pub fn write(arrays: &[(&str, &Field)], out: &mut impl Write) -> Result<()> {
    let h = arrays.first().context("no array to write")?.1.grid().spacing();
    write_placed(arrays, [h; 3], [0.0; 3], out)
}

/// Writes a volume as point data called `values`.
///
/// # Errors
/// If it is too large for a field or `out` fails.
pub fn write_volume(volume: &Volume, out: &mut impl Write) -> Result<()> {
    let field = Field::from_array(volume.values.clone(), 1.0)?;
    write_placed(&[("values", &field)], volume.spacing, volume.origin, out)
}

fn write_placed(
    arrays: &[(&str, &Field)],
    spacing: [f64; 3],
    origin: [f64; 3],
    out: &mut impl Write,
) -> Result<()> {
    let grid = arrays.first().context("no array to write")?.1.grid();
    let [nz, ny, nx] = grid.shape();
    let [spacing, origin] = [spacing, origin].map(|[x, y, z]| format!("{x} {y} {z}"));
    let extent = format!("0 {} 0 {} 0 {}", nx - 1, ny - 1, nz - 1);
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(
        out,
        "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">"
    )?;
    writeln!(
        out,
        "<ImageData WholeExtent=\"{extent}\" Origin=\"{origin}\" Spacing=\"{spacing}\">"
    )?;
    writeln!(out, "<Piece Extent=\"{extent}\">\n<PointData Scalars=\"{}\">", escape(arrays[0].0))?;
    let bytes = 8 * grid.len();
    for (n, (name, field)) in arrays.iter().enumerate() {
        ensure!(field.grid() == grid, "`{name}` lives on another grid than `{}`", arrays[0].0);
        let (name, offset) = (escape(name), n * (8 + bytes));
        writeln!(
            out,
            "<DataArray type=\"Float64\" Name=\"{name}\" format=\"appended\" offset=\"{offset}\"/>"
        )?;
    }
    write!(out, "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_")?;
    for (_, field) in arrays {
        out.write_all(&(bytes as u64).to_le_bytes())?;
        for row in field.as_slice().chunks(4096) {
            let row: Vec<u8> = row.iter().flat_map(|v| v.to_le_bytes()).collect();
            out.write_all(&row)?;
        }
    }
    Ok(write!(out, "\n</AppendedData>\n</VTKFile>\n")?)
}

fn escape(text: &str) -> String {
    ENTITIES.iter().fold(text.to_string(), |text, (plain, entity)| text.replace(plain, entity))
}

fn unescape(text: &str) -> String {
    ENTITIES
        .iter()
        .rev()
        .fold(text.to_string(), |text, (plain, entity)| text.replace(entity, plain))
}

/// The ampersand first: the others bring it in.
const ENTITIES: [(&str, &str); 4] =
    [("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("\"", "&quot;")];

/// An array of an ImageData file.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Its name.
    pub name: String,
    /// Its values: `[nz, ny, nx]`, leading axes of size 1 dropped.
    pub values: ArrayD<f64>,
    /// Distances of nodes along x, y, z.
    pub spacing: [f64; 3],
    /// Position x, y, z of the first node.
    pub origin: [f64; 3],
}

/// Reads all arrays of one component, point or cell data: ascii, base64 (`binary`), and
/// appended raw or base64, uncompressed. At most `limit` bytes of f64 each.
///
/// # Errors
/// If it is no ImageData of one piece, compressed, truncated, or an array does not fill
/// the extent.
pub fn read(bytes: &[u8], limit: u64) -> Result<Vec<Array>> {
    let end = find(bytes, b"<AppendedData").unwrap_or(bytes.len());
    let text = std::str::from_utf8(&bytes[..end]).context("the XML part is no UTF-8")?;
    let file = tag(text, "VTKFile").context("no `<VTKFile>`")?;
    ensure!(
        file.attribute("type") == Some("ImageData"),
        "a VTK file of type {:?}; wanted is ImageData",
        file.attribute("type").unwrap_or("?")
    );
    ensure!(file.attribute("compressor").is_none(), "compressed; save it without compression");
    let layout = Layout {
        little: file.attribute("byte_order") != Some("BigEndian"),
        header: if file.attribute("header_type") == Some("UInt64") { 8 } else { 4 },
    };
    let image = tag(text, "ImageData").context("no `<ImageData>`")?;
    let extent: Vec<i64> = numbers(image.attribute("WholeExtent").unwrap_or(""))?;
    let spacing: Vec<f64> = numbers(image.attribute("Spacing").unwrap_or("1 1 1"))?;
    let (&[x0, x1, y0, y1, z0, z1], &[hx, hy, hz]) = (extent.as_slice(), spacing.as_slice()) else {
        bail!(
            "the extent needs 6 numbers and the spacing 3, found {} and {}",
            extent.len(),
            spacing.len()
        );
    };
    let origin: Vec<f64> = numbers(image.attribute("Origin").unwrap_or("0 0 0"))?;
    let &[ox, oy, oz] = origin.as_slice() else {
        bail!("the origin needs 3 numbers, found {}", origin.len());
    };
    // The extent may begin anywhere.
    let origin = [ox + x0 as f64 * hx, oy + y0 as f64 * hy, oz + z0 as f64 * hz];
    let nodes = [(x0, x1), (y0, y1), (z0, z1)]
        .map(|(a, b)| b.checked_sub(a).and_then(|n| n.checked_add(1)).filter(|n| *n > 0));
    let [Some(nx), Some(ny), Some(nz)] = nodes else {
        bail!("the extent {extent:?} is empty");
    };
    let mut arrays = Vec::new();
    for (section, less) in [("PointData", 0), ("CellData", 1)] {
        let Some(from) = text.find(&format!("<{section}")) else { continue };
        let to = text[from..].find(&format!("</{section}>")).map_or(text.len(), |n| from + n);
        let shape = [nz, ny, nx].map(|n| (n - less).max(1) as u64);
        let mut rest = &text[from..to];
        while let Some(found) = tag(rest, "DataArray") {
            rest = found.after;
            if found.attribute("NumberOfComponents").unwrap_or("1") != "1" {
                continue;
            }
            let name = found.attribute("Name").unwrap_or("unnamed");
            let name = unescape(name);
            let values = layout
                .values(&found, bytes, shape, limit)
                .with_context(|| format!("array `{name}`"))?;
            arrays.push(Array { name, values, spacing: [hx, hy, hz], origin });
        }
    }
    ensure!(!arrays.is_empty(), "no array of one component");
    Ok(arrays)
}

/// Byte order and size of the length before each block.
#[derive(Clone, Copy)]
struct Layout {
    little: bool,
    header: usize,
}

impl Layout {
    fn values(
        self,
        array: &Tag<'_>,
        file: &[u8],
        shape: [u64; 3],
        limit: u64,
    ) -> Result<ArrayD<f64>> {
        let count = shape.iter().try_fold(1_u64, |n, &m| n.checked_mul(m));
        let needed = count.and_then(|n| n.checked_mul(8)).unwrap_or(u64::MAX);
        ensure!(
            needed <= limit,
            "shape {shape:?} needs {needed} bytes, more than the limit of {limit}"
        );
        let count = (needed / 8) as usize;
        let kind = array.attribute("type").unwrap_or("");
        let values = match array.attribute("format").unwrap_or("ascii") {
            "ascii" => numbers(array.text())?,
            "binary" => {
                self.decode(self.block(&base64(array.text().as_bytes(), usize::MAX)?)?, kind)?
            }
            "appended" => self.appended(array, file, count, kind)?,
            other => bail!("format `{other}`; wanted is ascii, binary or appended"),
        };
        ensure!(
            values.len() == count,
            "shape {shape:?} needs {count} values, found {}",
            values.len()
        );
        let axes = shape.iter().map(|&n| n as usize);
        let shape: Vec<usize> = axes.skip_while(|&n| n == 1).collect();
        Ok(ArrayD::from_shape_vec(if shape.is_empty() { vec![1] } else { shape }, values)?)
    }

    fn appended(self, array: &Tag<'_>, file: &[u8], count: usize, kind: &str) -> Result<Vec<f64>> {
        let start = find(file, b"<AppendedData").context("no `<AppendedData>`")?;
        let head = &file[start..];
        let close = find(head, b">").context("truncated before the data")?;
        let raw = find(&head[..close], b"\"raw\"").is_some();
        let mark = find(&head[close..], b"_").context("truncated before the data")? + close + 1;
        let offset: usize = array.attribute("offset").unwrap_or("").parse().context("no offset")?;
        let data = head
            .get(mark..)
            .and_then(|d| d.get(offset..))
            .with_context(|| format!("truncated: the data at offset {offset} are missing"))?;
        if raw {
            return self.decode(self.block(data)?, kind);
        }
        // The longest element has 8 bytes; 4 characters hold 3 bytes.
        let longest = (self.header + 8 * count).div_ceil(3) * 4;
        self.decode(self.block(&base64(data, longest)?)?, kind)
    }

    /// The bytes after a length.
    fn block(self, data: &[u8]) -> Result<&[u8]> {
        let head = data.get(..self.header).context("truncated before the data")?;
        let byte = |n: usize| u64::from(head[if self.little { self.header - 1 - n } else { n }]);
        let length = (0..self.header).fold(0, |sum, n| sum << 8 | byte(n));
        let data = &data[self.header..];
        usize::try_from(length).ok().and_then(|n| data.get(..n)).with_context(|| {
            format!("{length} bytes of data are announced, {} are there (truncated?)", data.len())
        })
    }

    fn decode(self, data: &[u8], kind: &str) -> Result<Vec<f64>> {
        /// Reads elements of one type.
        macro_rules! all {
            ($kind:ty) => {{
                let read = |b: &[u8]| {
                    let b = b.try_into().unwrap_or_default();
                    (if self.little {
                        <$kind>::from_le_bytes(b)
                    } else {
                        <$kind>::from_be_bytes(b)
                    }) as f64
                };
                data.chunks_exact(size_of::<$kind>()).map(read).collect()
            }};
        }
        Ok(match kind {
            "Float64" => all!(f64),
            "Float32" => all!(f32),
            "UInt8" => all!(u8),
            "Int8" => all!(i8),
            "UInt16" => all!(u16),
            "Int16" => all!(i16),
            "UInt32" => all!(u32),
            "Int32" => all!(i32),
            "UInt64" => all!(u64),
            "Int64" => all!(i64),
            _ => bail!("elements of type `{kind}`; wanted is Float64, Float32 or an integer type"),
        })
    }
}

/// A start tag and what follows it.
struct Tag<'a> {
    attributes: &'a str,
    after: &'a str,
}

impl<'a> Tag<'a> {
    fn attribute(&self, name: &str) -> Option<&'a str> {
        let mut rest = self.attributes;
        while let Some((key, value)) = rest.split_once('=') {
            let value = value.trim_start();
            let quote = value.chars().next().filter(|c| matches!(c, '"' | '\''))?;
            let (value, after) = value[1..].split_once(quote)?;
            if key.trim() == name {
                return Some(value);
            }
            rest = after;
        }
        None
    }

    /// Text up to the next tag.
    fn text(&self) -> &'a str {
        self.after.split('<').next().unwrap_or("")
    }
}

/// The first tag of this name.
fn tag<'a>(text: &'a str, name: &str) -> Option<Tag<'a>> {
    let mut rest = text;
    loop {
        let at = rest.find(&format!("<{name}"))?;
        rest = &rest[at + 1 + name.len()..];
        if rest.starts_with(|c: char| c.is_whitespace() || c == '>' || c == '/') {
            let mut quote = None;
            let end = rest.find(|c: char| {
                match quote {
                    Some(q) if c == q => quote = None,
                    None if matches!(c, '"' | '\'') => quote = Some(c),
                    _ => {}
                }
                c == '>' && quote.is_none()
            })?;
            return Some(Tag { attributes: &rest[..end], after: &rest[end + 1..] });
        }
    }
}

fn numbers<T: std::str::FromStr>(text: &str) -> Result<Vec<T>> {
    let parse = |word: &str| word.parse().ok().with_context(|| format!("`{word}` is no number"));
    text.split_whitespace().map(parse).collect()
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|w| w == wanted)
}

/// Decodes base64 up to its first `=`, foreign character or `longest` characters; VTK
/// pads the length and the data separately or together, so padding is skipped over.
fn base64(text: &[u8], longest: usize) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut group = [0_u8; 4];
    let (mut filled, mut padding) = (0, 0);
    for &c in text.iter().filter(|c| !c.is_ascii_whitespace()).take(longest.saturating_add(8)) {
        group[filled] = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' => {
                padding += 1;
                0
            }
            // The next tag.
            b'<' => break,
            other => bail!("byte {other} is not base64"),
        };
        filled += 1;
        if filled == 4 {
            let [a, b, c, d] = group;
            let three = [a << 2 | b >> 4, b << 4 | c >> 2, c << 6 | d];
            bytes.extend(&three[..3_usize.saturating_sub(padding)]);
            (filled, padding) = (0, 0);
        }
    }
    Ok(bytes)
}
