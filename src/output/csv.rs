//! Comma-separated values: tables with headings, and plane arrays as bare rows of numbers.

use anyhow::{Context as _, Result, bail, ensure};
use ndarray::{Array2, ArrayView2, ArrayViewD};
use std::io::Write;

/// Writes columns under their headings. Numbers are the shortest that read back exactly;
/// columns that are shorter than the longest end in empty cells.
///
/// # Errors
/// If `out` fails.
pub fn write_table(columns: &[(String, Vec<f64>)], out: &mut impl Write) -> Result<()> {
    let heads: Vec<String> = columns.iter().map(|(name, _)| quote(name)).collect();
    writeln!(out, "{}", heads.join(","))?;
    let rows = columns.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    for row in 0..rows {
        let cell = |(_, v): &(String, Vec<f64>)| v.get(row).map_or(String::new(), f64::to_string);
        let cells: Vec<String> = columns.iter().map(cell).collect();
        writeln!(out, "{}", cells.join(","))?;
    }
    Ok(())
}

/// Writes an array of one axis (a row) or two (`ny` lines of `nx` numbers), no headings.
///
/// # Errors
/// If there are more axes or `out` fails.
pub fn write_grid(values: &ArrayViewD<'_, f64>, out: &mut impl Write) -> Result<()> {
    let rows: ArrayView2<'_, f64> = match values.ndim() {
        1 => values.view().insert_axis(ndarray::Axis(0)).into_dimensionality()?,
        2 => values.view().into_dimensionality()?,
        n => bail!("an array of {n} axes cannot be a CSV; wanted are 1 or 2"),
    };
    for row in rows.rows() {
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(out, "{}", cells.join(","))?;
    }
    Ok(())
}

/// Reads lines of numbers, separated by commas, semicolons, tabs or blanks; `#` begins a comment.
///
/// # Errors
/// If a cell is no number or the lines differ in length, with the line's number.
pub fn read_grid(text: &str) -> Result<Array2<f64>> {
    let mut values = Vec::new();
    let (mut rows, mut columns) = (0, 0);
    for (n, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() {
            continue;
        }
        let before = values.len();
        for (m, cell) in cells(line).enumerate() {
            let number = cell.parse::<f64>().ok().with_context(|| {
                let shown: String = cell.chars().take(40).collect();
                format!("line {}, cell {}: `{shown}` is no number", n + 1, m + 1)
            })?;
            values.push(number);
        }
        let count = values.len() - before;
        ensure!(
            rows == 0 || count == columns,
            "line {} has {count} numbers, the lines before have {columns}",
            n + 1
        );
        (rows, columns) = (rows + 1, count);
    }
    ensure!(rows > 0, "no numbers");
    Ok(Array2::from_shape_vec((rows, columns), values)?)
}

/// Cells of a line.
fn cells(line: &str) -> Box<dyn Iterator<Item = &str> + '_> {
    match [',', ';', '\t'].into_iter().find(|&c| line.contains(c)) {
        Some(separator) => Box::new(line.split(separator).map(str::trim)),
        None => Box::new(line.split_whitespace()),
    }
}

/// A heading, quoted where it has to be (RFC 4180).
fn quote(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}
