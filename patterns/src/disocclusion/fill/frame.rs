//! Part of a picture at the scale of a class, and the way back.

use super::super::normalize::Normal;
use solvers::Field;

/// Points along each axis at which a pixel of the new scale looks at the old one.
const POINTS: usize = 3;

/// Relative difference of wavelengths that is left alone: the estimate's own error.
const SAME: f64 = 0.1;

/// Fewest cells along an axis.
const LEAST: usize = 8;

/// The box around the holes, scaled.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Upper left corner and size of the box in the picture (pixels).
    corner: [usize; 2],
    size: [usize; 2],
    /// Rows and columns at the new scale.
    pub(super) shape: [usize; 2],
    picture: [usize; 2],
}

impl Frame {
    /// All that is hidden and a rim of `rim` pixels, with `scale` cells per pixel.
    pub(super) fn new(normal: &Normal, rim: f64, scale: f64) -> Self {
        let [ny, nx] = normal.shape;
        let (mut low, mut high) = ([ny, nx], [0, 0]);
        for n in (0..ny * nx).filter(|&n| !normal.visible[n]) {
            for (axis, at) in [n / nx, n % nx].into_iter().enumerate() {
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at + 1);
            }
        }
        let rim = rim.ceil() as usize;
        let corner = [0, 1].map(|a| low[a].saturating_sub(rim));
        let size = [0, 1].map(|a| (high[a] + rim).min(normal.shape[a]) - corner[a]);
        let scale = if (scale - 1.0).abs() < SAME { 1.0 } else { scale };
        let shape = size.map(|n| {
            if scale == 1.0 { n } else { ((n as f64 * scale).round() as usize).max(LEAST) }
        });
        Self { corner, size, shape, picture: normal.shape }
    }

    /// The visible ink, as the share of it in each cell.
    pub(super) fn normal(&self, normal: &Normal) -> Normal {
        let number = |flags: &[bool]| -> Vec<f64> {
            flags.iter().map(|&flag| f64::from(u8::from(flag))).collect()
        };
        let seen = self.inward(&number(&normal.visible));
        let ink = self.inward(&number(&normal.ink));
        Normal {
            shape: self.shape,
            // A cell of which a part is hidden is hidden.
            visible: seen.iter().map(|&v| v > 0.999).collect(),
            ink: ink.iter().zip(&seen).map(|(&i, &v)| v > 0.999 && i > 0.5).collect(),
            ..*normal
        }
    }

    /// Grey levels of the picture in each cell.
    pub(super) fn grey(&self, grey: &Field) -> Vec<f64> {
        self.inward(grey.as_slice())
    }

    /// Means over each cell of the frame.
    fn inward(&self, values: &[f64]) -> Vec<f64> {
        let [ny, nx] = self.shape;
        let points = if self.shape == self.size { 1 } else { POINTS };
        let place = |axis: usize, at: usize, p: usize| {
            let share = (at as f64 + (p as f64 + 0.5) / points as f64) / self.shape[axis] as f64;
            self.corner[axis] + (share * self.size[axis] as f64) as usize
        };
        let mean = |n: usize| {
            let mut sum = 0.0;
            for p in 0..points * points {
                let j = place(0, n / nx, p / points);
                let i = place(1, n % nx, p % points);
                sum += values[j * self.picture[1] + i];
            }
            sum / (points * points) as f64
        };
        (0..ny * nx).map(mean).collect()
    }

    /// Values of cells at each pixel of the picture, linear between cells; 0 off the frame.
    pub(super) fn outward(&self, cells: &[f64]) -> Vec<f64> {
        let [ny, nx] = self.picture;
        let mut out = vec![0.0; ny * nx];
        let place = |axis: usize, at: usize| {
            let share = (at as f64 + 0.5) / self.size[axis] as f64;
            let last = self.shape[axis] - 1;
            let x = (share * self.shape[axis] as f64 - 0.5).clamp(0.0, last as f64);
            let n = (x as usize).min(last.saturating_sub(1));
            (n, (n + 1).min(last), x - n as f64)
        };
        for j in 0..self.size[0] {
            let (j0, j1, t) = place(0, j);
            for i in 0..self.size[1] {
                let (i0, i1, s) = place(1, i);
                let at = |j: usize, i: usize| cells[j * self.shape[1] + i];
                let row = |j: usize| (1.0 - s) * at(j, i0) + s * at(j, i1);
                out[(self.corner[0] + j) * nx + self.corner[1] + i] =
                    (1.0 - t) * row(j0) + t * row(j1);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disk(shape: [usize; 2], radius: f64) -> Normal {
        let [ny, nx] = shape;
        let ink = (0..ny * nx)
            .map(|n| ((n / nx) as f64 - 30.0).hypot((n % nx) as f64 - 34.0) < radius)
            .collect();
        let visible = (0..ny * nx)
            .map(|n| !((24..32).contains(&(n / nx)) && (30..40).contains(&(n % nx))))
            .collect();
        Normal { shape, ink, visible, threshold: 0.5, despeckled: false }
    }

    #[test]
    fn what_goes_in_comes_out() {
        let normal = disk([60, 70], 13.0);
        let frame = Frame::new(&normal, 12.0, 1.02);
        assert_eq!(frame.shape, [32, 34]);
        let numbers: Vec<f64> = (0..60 * 70).map(f64::from).collect();
        let field = Field::from_vec(solvers::Grid::new(&[60, 70], 1.0).unwrap(), numbers).unwrap();
        let back = frame.outward(&frame.grey(&field));
        for (n, back) in back.iter().enumerate() {
            let inside = (12..44).contains(&(n / 70)) && (18..52).contains(&(n % 70));
            assert_eq!(*back, if inside { n as f64 } else { 0.0 });
        }
    }

    #[test]
    fn scaled_ink_has_the_area_of_the_scale_and_half_hidden_cells_are_hidden() {
        let mut normal = disk([60, 70], 13.0);
        let area = normal.ink.iter().filter(|&&ink| ink).count() as f64;
        let hidden = normal.visible.iter().filter(|&&seen| !seen).count() as f64;
        let frame = Frame::new(&normal, 60.0, 0.5);
        assert_eq!(frame.shape, [30, 35]);
        let small = frame.normal(&normal);
        let covered = small.visible.iter().filter(|&&seen| !seen).count() as f64;
        assert!(4.0 * covered >= hidden, "{covered} {hidden}");
        normal.visible.fill(true);
        let ink = frame.normal(&normal).ink.iter().filter(|&&ink| ink).count() as f64;
        assert!((4.0 * ink / area - 1.0).abs() < 0.05, "{ink} {area}");
    }
}
