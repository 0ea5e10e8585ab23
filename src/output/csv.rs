//! Comma-separated values: tables with headings, plane arrays as bare rows of numbers, and lines.

use anyhow::{Context as _, Result, bail, ensure};
use ndarray::{Array2, ArrayView2, ArrayViewD};
use solvers::isosurface::Polyline;
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

/// Writes lines in the plane under the heading `loop,x,y`, a point a row.
///
/// # Errors
/// If `out` fails.
pub fn write_lines(lines: &[Polyline], out: &mut impl Write) -> Result<()> {
    writeln!(out, "loop,x,y")?;
    for (n, line) in lines.iter().enumerate() {
        for [x, y] in &line.points {
            writeln!(out, "{n},{x},{y}")?;
        }
    }
    Ok(())
}

/// Reads closed lines in the plane: rows `x,y` with blank lines between the loops, or rows
/// `loop,x,y` whose first number tells the loops apart. A heading and `#` comments are
/// passed over; a last point that repeats the first is dropped.
///
/// # Errors
/// If a cell is no finite number, a row has neither 2 nor 3 numbers or another count than the
/// rows before, or a loop has fewer than 3 points, with the line's number; for no loop.
pub fn read_lines(text: &str) -> Result<Vec<Polyline>> {
    let mut loops = Loops::default();
    for (n, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let comment = line.trim_start().starts_with('#');
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() && !comment {
            loops.end()?;
        }
        if line.is_empty() || (loops.columns == 0 && line.starts_with(|c: char| c.is_alphabetic()))
        {
            continue;
        }
        loops.add(n + 1, line)?;
    }
    loops.end()?;
    ensure!(!loops.done.is_empty(), "no points");
    Ok(loops.done)
}

/// The loops of a file, as far as it is read.
#[derive(Default)]
struct Loops {
    done: Vec<Polyline>,
    points: Vec<[f64; 2]>,
    /// Line and number of the loop that is being read.
    first: usize,
    number: f64,
    /// Numbers in a row, 0 before the first.
    columns: usize,
}

impl Loops {
    fn add(&mut self, n: usize, line: &str) -> Result<()> {
        let numbers = cells(line).enumerate().map(|(m, cell)| number(n, m, cell));
        let row = numbers.collect::<Result<Vec<f64>>>()?;
        let bad = row.iter().find(|v| !v.is_finite());
        ensure!(bad.is_none(), "line {n}: {} is not finite", bad.copied().unwrap_or_default());
        let (index, point) = match row[..] {
            [x, y] => (0.0, [x, y]),
            [index, x, y] => (index, [x, y]),
            _ => bail!("line {n} has {} numbers; wanted is x,y or loop,x,y", row.len()),
        };
        let before = self.columns;
        ensure!(
            before == 0 || row.len() == before,
            "line {n} has {} numbers, the lines before have {before}",
            row.len()
        );
        self.columns = row.len();
        if index != self.number {
            self.end()?;
        }
        if self.points.is_empty() {
            (self.first, self.number) = (n, index);
        }
        self.points.push(point);
        Ok(())
    }

    fn end(&mut self) -> Result<()> {
        let mut points = std::mem::take(&mut self.points);
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        let (count, first) = (points.len(), self.first);
        ensure!(
            count == 0 || count >= 3,
            "line {first}: the loop that begins here has {count} points, at least 3 are wanted"
        );
        if count > 0 {
            self.done.push(Polyline { points, closed: true });
        }
        Ok(())
    }
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
            values.push(number(n + 1, m, cell)?);
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

/// The number in cell `m` of line `n`.
fn number(n: usize, m: usize, cell: &str) -> Result<f64> {
    cell.parse::<f64>().ok().with_context(|| {
        let shown: String = cell.chars().take(40).collect();
        format!("line {n}, cell {}: `{shown}` is no number", m + 1)
    })
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
