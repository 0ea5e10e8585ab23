//! NRRD volumes, as 3D Slicer, ITK and teem read and write them.
//!
//! Source: teem, "Definition of NRRD File Format". The first axis is the fastest: x.

use super::volume::{self, Element, Volume};
use anyhow::{Context as _, Result, bail, ensure};
use flate2::{Compression, write::GzEncoder};
use std::io::Write;

/// First bytes of a file.
pub const MAGIC: &[u8] = b"NRRD000";

/// Writes a volume as `double`, little endian, compressed with gzip.
///
/// # Errors
/// If it has more than three axes or `out` fails.
pub fn write(volume: &Volume, out: &mut impl Write) -> Result<()> {
    let [nx, ny, nz] = volume.sizes()?;
    let ([dx, dy, dz], [x, y, z]) = (volume.spacing, volume.origin);
    write!(
        out,
        "NRRD0004\ntype: double\ndimension: 3\nspace dimension: 3\nsizes: {nx} {ny} {nz}\n\
         space directions: ({dx:?},0,0) (0,{dy:?},0) (0,0,{dz:?})\nspace origin: ({x:?},{y:?},{z:?})\n\
         kinds: domain domain domain\nendian: little\nencoding: gzip\n\n"
    )?;
    let mut encoder = GzEncoder::new(out, Compression::fast());
    for v in &volume.values {
        encoder.write_all(&v.to_le_bytes())?;
    }
    encoder.finish()?;
    Ok(())
}

/// Reads one to three axes of numbers in the file itself: raw, gzip or text; at most `limit`
/// bytes of f64. Directions that are not those of the axes become their lengths.
///
/// # Errors
/// If it is another file, has more axes or detached data, is too large or truncated.
pub fn read(bytes: &[u8], limit: u64) -> Result<Volume> {
    ensure!(bytes.starts_with(MAGIC), "no NRRD");
    let end = |pattern: &[u8]| bytes.windows(pattern.len()).position(|w| w == pattern);
    let (at, skip) = match (end(b"\n\n"), end(b"\r\n\r\n")) {
        (Some(a), Some(b)) if b < a => (b, 4),
        (Some(a), _) => (a, 2),
        (None, Some(b)) => (b, 4),
        _ => bail!("the NRRD header has no end (truncated, or its data are in another file)"),
    };
    let header = std::str::from_utf8(&bytes[..at]).context("the NRRD header is no text")?;
    let data = &bytes[at + skip..];
    let field = |name: &str| {
        let value = |line: &'_ str| {
            let (key, value) = line.split_once(':')?;
            // `:=` are free remarks.
            let same = key.trim().eq_ignore_ascii_case(name) && !value.starts_with('=');
            same.then(|| value.trim().to_owned())
        };
        header.lines().find_map(value)
    };
    let wanted =
        |name: &str| field(name).with_context(|| format!("no `{name}` in the NRRD header"));
    for other in ["data file", "datafile"] {
        ensure!(field(other).is_none(), "the data are in another file; wanted is one file");
    }
    let sizes = wanted("sizes")?;
    let sizes: Option<Vec<usize>> = sizes.split_whitespace().map(|n| n.parse().ok()).collect();
    let sizes = sizes.context("`sizes` are no whole numbers")?;
    let dimension: usize = wanted("dimension")?.parse().context("`dimension` is no number")?;
    ensure!(dimension == sizes.len(), "dimension {dimension} with sizes {sizes:?}");
    let extra = sizes.iter().skip(3).any(|&n| n != 1);
    ensure!(!sizes.is_empty() && !extra, "sizes {sizes:?}; wanted are 1 to 3 axes");
    let count = volume::count(&sizes, limit)?;
    let (spacing, origin) = place(field)?;
    let encoding = wanted("encoding")?.to_lowercase();
    let values = if ["ascii", "text", "txt"].contains(&encoding.as_str()) {
        let text = std::str::from_utf8(data).context("the data are no text")?;
        let numbers: Option<Vec<f64>> =
            text.split_whitespace().take(count + 1).map(|v| v.parse().ok()).collect();
        let numbers = numbers.context("the data are no numbers")?;
        ensure!(numbers.len() == count, "sizes {sizes:?} need {count} numbers");
        numbers
    } else {
        let kind = element(&wanted("type")?)?;
        let little = match field("endian").as_deref() {
            Some("little") => true,
            Some("big") => false,
            None if kind.bytes() == 1 => true,
            other => bail!("endian `{}`; wanted is little or big", other.unwrap_or("")),
        };
        let needed = count * kind.bytes();
        let unpacked = match encoding.as_str() {
            "raw" => data.to_vec(),
            "gzip" | "gz" => volume::gunzip(data, needed as u64)?,
            other => bail!("encoding `{other}`; wanted is raw, gzip or ascii"),
        };
        kind.decode(volume::head(&unpacked, needed)?, little)
    };
    Volume::from_values(&sizes, values, spacing, origin)
}

/// Spacing and origin, 1 and 0 where the header does not tell.
fn place(field: impl Fn(&str) -> Option<String>) -> Result<([f64; 3], [f64; 3])> {
    let (mut spacing, mut origin) = ([1.0; 3], [0.0; 3]);
    if let Some(text) = field("spacings") {
        for (v, word) in spacing.iter_mut().zip(text.split_whitespace()) {
            let given: f64 = word.parse().with_context(|| format!("spacing `{word}`"))?;
            *v = if given.is_nan() { 1.0 } else { given.abs() };
        }
    }
    if let Some(text) = field("space directions") {
        // `none` for axes that are not of space.
        let axes = text.split(['(', ')']).filter(|part| part.contains(','));
        for (v, axis) in spacing.iter_mut().zip(axes) {
            *v = vector(axis)?.iter().map(|c| c * c).sum::<f64>().sqrt();
        }
    }
    if let Some(text) = field("space origin") {
        let place = vector(text.trim_matches(['(', ')']))?;
        origin.iter_mut().zip(place).for_each(|(v, c)| *v = c);
    }
    Ok((spacing, origin))
}

fn vector(text: &str) -> Result<Vec<f64>> {
    let number = |c: &str| c.trim().parse().ok().with_context(|| format!("`{c}` is no number"));
    text.split(',').map(number).collect()
}

fn element(name: &str) -> Result<Element> {
    Ok(match name.to_lowercase().as_str() {
        "signed char" | "int8" | "int8_t" => Element::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Element::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Element::I16
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Element::U16,
        "int" | "signed int" | "int32" | "int32_t" => Element::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Element::U32,
        "longlong" | "long long" | "long long int" | "signed long long" | "int64" | "int64_t" => {
            Element::I64
        }
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            Element::U64
        }
        "float" => Element::F32,
        "double" => Element::F64,
        other => bail!("elements of type `{other}`; wanted is float, double or an integer type"),
    })
}
