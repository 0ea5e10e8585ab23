//! NumPy arrays: NPY (format 1.0 to 3.0) and NPZ.
//!
//! Source: NumPy Enhancement Proposal 1, "A simple file format for NumPy arrays".

use anyhow::{Context as _, Result, bail, ensure};
use ndarray::{ArrayD, ArrayViewD, IxDyn, ShapeBuilder as _};
use std::io::{Cursor, Read as _, Seek, Write};

/// First bytes of an NPY file.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// Writes an array as NPY: `<f8`, C order.
///
/// # Errors
/// If `out` fails.
pub fn write(values: &ArrayViewD<'_, f64>, out: &mut impl Write) -> Result<()> {
    write_header("<f8", values.shape(), out)?;
    write_values(values, out)
}

/// Writes a one-dimensional array of elements of type `descr` (`<f8`) from its bytes.
///
/// # Errors
/// If `out` fails.
pub fn write_raw(descr: &str, count: usize, data: &[u8], out: &mut impl Write) -> Result<()> {
    write_header(descr, &[count], out)?;
    Ok(out.write_all(data)?)
}

/// The elements' type and the bytes of a one-dimensional NPY, as they are.
///
/// # Errors
/// If the header is not that of an NPY of one axis, or the data do not fill it.
pub fn read_raw(bytes: &[u8]) -> Result<(String, &[u8])> {
    let header = Header::parse(bytes)?;
    let (name, data) = (header.element.name, &bytes[header.data..]);
    let wanted = match header.shape[..] {
        [count] => count.checked_mul(header.element.size),
        _ => bail!("shape {:?}; wanted is one axis", header.shape),
    };
    ensure!(wanted == Some(data.len()), "the data of `{name}` are truncated or too long");
    Ok((name, data))
}

fn write_header(descr: &str, shape: &[usize], out: &mut impl Write) -> Result<()> {
    let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    let shape = format!("({}{comma})", shape.join(", "));
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    // Magic, version and length take 10 bytes; the data begin at a multiple of 64.
    let padded = (header.len() + 11).next_multiple_of(64) - 10;
    header += &" ".repeat(padded - header.len() - 1);
    header.push('\n');
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&u16::try_from(header.len())?.to_le_bytes())?;
    Ok(out.write_all(header.as_bytes())?)
}

/// The values, little endian, row-major, through a buffer of a few rows.
fn write_values(values: &ArrayViewD<'_, f64>, out: &mut impl Write) -> Result<()> {
    let mut buffer = Vec::with_capacity(8 * 4096);
    for v in values {
        buffer.extend(v.to_le_bytes());
        if buffer.len() >= 8 * 4096 {
            out.write_all(&buffer)?;
            buffer.clear();
        }
    }
    Ok(out.write_all(&buffer)?)
}

/// Writes named arrays as a compressed NPZ; the same bytes each time.
///
/// # Errors
/// If `out` fails.
pub fn write_npz(
    arrays: &[(&str, ArrayViewD<'_, f64>)],
    out: &mut (impl Write + Seek),
) -> Result<()> {
    let mut zip = zip::ZipWriter::new(out);
    // Without a time of its own the archive says 1980.
    let options = zip::write::SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated)
        .compression_level(Some(1));
    for (name, values) in arrays {
        zip.start_file(format!("{name}.npy"), options)?;
        write(values, &mut zip)?;
    }
    zip.finish()?;
    Ok(())
}

/// Reads an NPY: floating point, integer and boolean elements of either byte order, C or
/// Fortran order, as f64. At most `limit` bytes of f64.
///
/// # Errors
/// If the header is not that of an NPY, the elements are of another type, the data do not
/// fill the shape (a truncated file) or more than fill it.
pub fn read(bytes: &[u8], limit: u64) -> Result<ArrayD<f64>> {
    let header = Header::parse(bytes)?;
    let count = header.shape.iter().try_fold(1_u64, |n, &m| n.checked_mul(m as u64));
    let count = count.with_context(|| format!("the shape {:?} overflows", header.shape))?;
    let needed = count.saturating_mul(8);
    ensure!(
        needed <= limit,
        "an array of shape {:?} needs {needed} bytes, more than the limit of {limit}",
        header.shape
    );
    let wanted = count * header.element.size as u64;
    let data = &bytes[header.data..];
    ensure!(
        data.len() as u64 == wanted,
        "shape {:?} of `{}` needs {wanted} bytes of data, the file holds {}{}",
        header.shape,
        header.element.name,
        data.len(),
        if (data.len() as u64) < wanted { " (truncated?)" } else { "" }
    );
    let values: Vec<f64> =
        data.chunks_exact(header.element.size).map(header.element.read).collect();
    let shape = IxDyn(&header.shape).set_f(header.fortran);
    let array = ArrayD::from_shape_vec(shape, values)?;
    Ok(if header.fortran { array.as_standard_layout().into_owned() } else { array })
}

/// Reads the only array of an NPZ, or the one called `name`. At most `limit` bytes of f64.
///
/// # Errors
/// If it is no archive of NPY files, has several arrays and no `name` is given, or as [`read`].
pub fn read_npz(bytes: &[u8], name: Option<&str>, limit: u64) -> Result<ArrayD<f64>> {
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).context("no complete zip archive")?;
    let names: Vec<String> = zip.file_names().map(str::to_string).collect();
    let wanted = match (name, names.as_slice()) {
        (Some(name), _) => format!("{name}.npy"),
        (None, [only]) => only.clone(),
        (None, []) => bail!("the archive is empty"),
        (None, several) => {
            bail!("{} arrays ({}), one is wanted", several.len(), several.join(", "))
        }
    };
    let mut file = zip
        .by_name(&wanted)
        .with_context(|| format!("no `{wanted}` in the archive; it has {}", names.join(", ")))?;
    let mut data = Vec::new();
    // Elements of one byte become eight; the header is small.
    file.by_ref().take(limit.saturating_add(1 << 16)).read_to_end(&mut data)?;
    read(&data, limit).with_context(|| format!("in `{wanted}`"))
}

/// How an element is stored.
struct Element {
    name: String,
    size: usize,
    read: fn(&[u8]) -> f64,
}

/// A reader of one type for both byte orders.
macro_rules! element {
    ($name:expr, $little:expr, $kind:ty) => {
        Element {
            name: $name.into(),
            size: size_of::<$kind>(),
            read: if $little {
                |b| <$kind>::from_le_bytes(b.try_into().unwrap_or_default()) as f64
            } else {
                |b| <$kind>::from_be_bytes(b.try_into().unwrap_or_default()) as f64
            },
        }
    };
}

impl Element {
    /// The element that NumPy calls `descr`, for example `<f4`.
    fn parse(descr: &str) -> Result<Self> {
        let little = !descr.starts_with('>');
        Ok(match descr.trim_start_matches(['<', '>', '|', '=']) {
            "f8" => element!(descr, little, f64),
            "f4" => element!(descr, little, f32),
            "b1" | "u1" => element!(descr, little, u8),
            "i1" => element!(descr, little, i8),
            "u2" => element!(descr, little, u16),
            "i2" => element!(descr, little, i16),
            "u4" => element!(descr, little, u32),
            "i4" => element!(descr, little, i32),
            "u8" => element!(descr, little, u64),
            "i8" => element!(descr, little, i64),
            _ => bail!(
                "elements of type `{descr}`; wanted are f8, f4, bool, or integers of 1 to 8 bytes"
            ),
        })
    }
}

struct Header {
    element: Element,
    fortran: bool,
    shape: Vec<usize>,
    /// Where the data begin.
    data: usize,
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Self> {
        ensure!(bytes.starts_with(MAGIC), "no NPY file: it does not begin with \\x93NUMPY");
        let truncated = || format!("truncated in the header, after {} bytes", bytes.len());
        let version = *bytes.get(6).with_context(truncated)?;
        let (length, start) = match version {
            1 => {
                let b = bytes.get(8..10).with_context(truncated)?;
                (usize::from(u16::from_le_bytes([b[0], b[1]])), 10)
            }
            2 | 3 => {
                let b = bytes.get(8..12).with_context(truncated)?;
                (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize, 12)
            }
            other => bail!("NPY format {other}; wanted is 1, 2 or 3"),
        };
        let text = bytes.get(start..start + length).with_context(truncated)?;
        let text = std::str::from_utf8(text).context("the header is no text")?;
        let value = |key: &str| -> Result<&str> {
            let at = text
                .find(&format!("'{key}'"))
                .with_context(|| format!("the header has no `{key}`"))?;
            let rest = text[at + key.len() + 2..].trim_start();
            Ok(rest.strip_prefix(':').context("the header lacks a colon")?.trim_start())
        };
        let descr = value("descr")?;
        let descr = descr.strip_prefix('\'').and_then(|d| d.split('\'').next());
        let descr = descr.context("elements of several fields; wanted is one number each")?;
        let shape = value("shape")?.strip_prefix('(').and_then(|s| s.split(')').next());
        let shape = shape.context("the header's shape is no tuple")?;
        let axes = shape.split(',').map(str::trim).filter(|s| !s.is_empty());
        let shape = axes.map(str::parse).collect::<Result<Vec<usize>, _>>();
        Ok(Self {
            element: Element::parse(descr)?,
            fortran: value("fortran_order")?.starts_with("True"),
            shape: shape.context("the header's shape has an axis that is no number")?,
            data: start + length,
        })
    }
}
