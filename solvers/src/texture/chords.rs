//! The lineal path function.

use super::Masked;

/// Share of the visible segments of each length (pixels, interpolated between whole ones)
/// that lie in ink entirely, over rows and columns. 0 for lengths of which no segment is visible.
/// Lu & Torquato 1992. `paper` asks for paper instead.
pub fn lineal_path(picture: &Masked<'_>, lengths: &[f64], paper: bool) -> Vec<f64> {
    let longest = lengths.iter().fold(0.0_f64, |a, &b| a.max(b)).ceil() as usize + 1;
    // Number of runs of each length, in ink and visible, then of segments.
    let mut inside = vec![0.0; longest + 1];
    let mut seen = vec![0.0; longest + 1];
    let [ny, nx] = picture.shape;
    let mut line = |start: usize, step: usize, count: usize| {
        let (mut run, mut visible) = (0_usize, 0_usize);
        for n in 0..=count {
            let at = start + n * step;
            let is_seen = n < count && picture.visible[at];
            let is_in = is_seen && picture.ink[at] != paper;
            if !is_in {
                add(&mut inside, run);
            }
            if !is_seen {
                add(&mut seen, visible);
            }
            run = if is_in { run + 1 } else { 0 };
            visible = if is_seen { visible + 1 } else { 0 };
        }
    };
    (0..ny).for_each(|j| line(j * nx, 1, nx));
    (0..nx).for_each(|i| line(i, nx, ny));
    let share = |n: usize| if seen[n] > 0.0 { inside[n] / seen[n] } else { 0.0 };
    let at = |&length: &f64| {
        let n = (length as usize).max(1);
        let t = (length - n as f64).clamp(0.0, 1.0);
        (1.0 - t) * share(n) + t * share(n + 1)
    };
    lengths.iter().map(at).collect()
}

/// Adds the segments of each length that a run of `run` pixels holds.
fn add(segments: &mut [f64], run: usize) {
    for (length, count) in segments.iter_mut().enumerate().skip(1) {
        *count += (run + 1).saturating_sub(length) as f64;
    }
}
