//! Histograms.

use crate::{Error, Field, Grid, Result};

/// Density of weighted points of the plane (parts of the whole weight per unit of area) on
/// `bins` by `bins` squares that fill `range` along both axes.
///
/// Node `(j, i)` of the field is the square whose middle is at
/// `[low + (i + 1/2) h, low + (j + 1/2) h]`, with `h` the field's spacing. Points outside
/// the range are left out: the density sums to the part of the weight that lies inside. A
/// square has its lower and left sides, the last ones all four.
///
/// # Errors
/// If the numbers of points and weights differ, the range is empty or not finite, there
/// are no bins, or the weights are negative, not finite or all zero.
pub fn histogram2(
    points: &[[f64; 2]],
    weights: &[f64],
    range: [f64; 2],
    bins: usize,
) -> Result<Field> {
    if points.len() != weights.len() {
        return Err(Error::Shape {
            name: "weights".into(),
            actual: vec![weights.len()],
            expected: vec![points.len()],
        });
    }
    let [low, high] = range;
    let grid = Grid::new(&[bins, bins], (high - low) / bins as f64)?;
    if let Some(&bad) = weights.iter().find(|w| !(**w >= 0.0 && w.is_finite())) {
        return Err(Error::out_of_range("weight of a point", bad, "[0, inf)"));
    }
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Err(Error::out_of_range("sum of the weights", total, "(0, inf)"));
    }
    let bin = |x: f64| {
        let inside = (low..=high).contains(&x);
        inside.then(|| (((x - low) / grid.spacing()) as usize).min(bins - 1))
    };
    let mut field = Field::constant(grid, 0.0);
    let unit = 1.0 / (total * grid.cell_volume());
    for (&[x, y], weight) in points.iter().zip(weights) {
        if let (Some(i), Some(j)) = (bin(x), bin(y)) {
            field.as_mut_slice()[grid.index(0, j, i)] += weight * unit;
        }
    }
    Ok(field)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fall_into_their_squares() {
        let points =
            [[-1.0, -1.0], [0.9, -0.1], [1.0, 1.0], [0.0, 0.0], [1.1, 0.0], [f64::NAN, 0.0]];
        let found = histogram2(&points, &[1.0, 2.0, 3.0, 4.0, 5.0, 1.0], [-1.0, 1.0], 2).unwrap();
        assert_eq!(found.grid().spacing(), 1.0);
        assert_eq!(found.as_slice(), [0.0625, 0.125, 0.0, 0.4375]);
        let finer = histogram2(&points, &[1.0; 6], [-1.0, 1.0], 10).unwrap();
        let inside = finer.as_slice().iter().sum::<f64>() * finer.grid().cell_volume();
        assert!((inside - 4.0 / 6.0).abs() < 1e-12);
    }

    #[test]
    fn refuses_what_is_no_density() {
        let point = [[0.0, 0.0]];
        assert!(histogram2(&point, &[], [-1.0, 1.0], 2).is_err());
        assert!(histogram2(&point, &[0.0], [-1.0, 1.0], 2).is_err());
        assert!(histogram2(&point, &[-1.0], [-1.0, 1.0], 2).is_err());
        assert!(histogram2(&point, &[1.0], [1.0, -1.0], 2).is_err());
        assert!(histogram2(&point, &[1.0], [-1.0, f64::INFINITY], 2).is_err());
        assert!(histogram2(&point, &[1.0], [-1.0, 1.0], 0).is_err());
    }
}
