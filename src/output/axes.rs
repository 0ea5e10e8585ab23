//! Ranges of axes, ticks and their labels.

/// Least and greatest finite value (only positive ones on a logarithmic axis), widened
/// until they differ; `[0, 1]` or `[1, 10]` when there is none.
pub(crate) fn data_range(values: impl Iterator<Item = f64>, log: bool) -> [f64; 2] {
    // Beyond 1e300 the width of a range overflows.
    let usable = values.filter(|v| v.abs() < 1e300 && (!log || *v > 1e-300));
    let [low, high] =
        usable.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    match (low <= high, log) {
        (false, true) => [1.0, 10.0],
        (false, false) => [0.0, 1.0],
        (true, true) if high / low < 1.0 + 1e-9 => [low / 3.0, high * 3.0],
        (true, false) if high - low <= 1e-12 * high.abs().max(low.abs()) => {
            let margin = if high == 0.0 { 1.0 } else { 0.1 * high.abs() };
            [low - margin, high + margin]
        }
        _ => [low, high],
    }
}

/// Part of a number below which differences are roundings to a reader.
const LEVEL: f64 = 1e-6;

/// A range of numbers with a little more on either side. What is one number to six digits becomes
/// a level line: labels that tell its roundings apart would have no room.
pub(crate) fn with_margin([low, high]: [f64; 2]) -> [f64; 2] {
    let middle = 0.5 * (low + high);
    if high - low < LEVEL * middle.abs() {
        let margin = 10.0 * LEVEL * middle.abs();
        return [middle - margin, middle + margin];
    }
    let margin = 0.04 * (high - low);
    // Quantities that cannot be negative keep their zero at the edge.
    [if low == 0.0 { 0.0 } else { low - margin }, high + margin]
}

/// Whether a range can be an axis.
pub(crate) fn is_range([low, high]: [f64; 2], log: bool) -> bool {
    low < high && low.abs() < 1e300 && high.abs() < 1e300 && (!log || low > 0.0)
}

/// Positions for about `count` ticks in `[low, high]`: multiples of 1, 2 or 5 times a
/// power of ten; with their labels.
pub(crate) fn ticks([low, high]: [f64; 2], count: usize) -> Vec<(f64, String)> {
    let step = nice_step((high - low) / count.max(1) as f64);
    if !(step > 0.0 && step.is_finite()) {
        return Vec::new();
    }
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    let values: Vec<f64> = (0..)
        .map(|n| first + f64::from(n))
        .take_while(|&n| n <= last)
        .take(1000)
        .map(|n| n * step)
        .collect();
    let labels = label_all(&values, step);
    values.into_iter().zip(labels).collect()
}

/// Powers of ten in `[low, high]`, thinned to about `count`; where there are fewer
/// than two, 2 and 5 times a power as well, and linear ticks as the last resort.
pub(crate) fn log_ticks([low, high]: [f64; 2], count: usize) -> Vec<(f64, String)> {
    let (first, last) = ((low.log10() - 1e-9).ceil() as i32, (high.log10() + 1e-9).floor() as i32);
    let plain = low > 0.9e-3 && high < 1.1e4;
    let name = |v: f64| if plain { format!("{}", round_to(v, 2)) } else { scientific(v, 0) };
    if last - first + 1 >= 3 {
        let every = ((last - first) as usize / count.max(1) + 1) as i32;
        let decades = (first..=last).filter(|e| e.rem_euclid(every) == 0);
        return decades.map(|e| 10_f64.powi(e)).map(|v| (v, name(v))).collect();
    }
    let fine: Vec<f64> = (first - 1..=last)
        .flat_map(|e| [1.0, 2.0, 5.0].map(|m| m * 10_f64.powi(e)))
        .filter(|v| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9))
        .collect();
    if fine.len() >= 2 {
        return fine.into_iter().map(|v| (v, name(v))).collect();
    }
    ticks([low, high], count)
}

/// 1, 2 or 5 times a power of ten, at least `step`.
fn nice_step(step: f64) -> f64 {
    let decade = 10_f64.powf(step.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * decade >= step * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * decade
}

/// Labels with as many decimals as `step` needs; very large or small ones as powers of ten.
fn label_all(values: &[f64], step: f64) -> Vec<String> {
    let greatest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let decimals = (-step.log10()).ceil().max(0.0) as usize;
    if greatest >= 1e6 || (greatest > 0.0 && greatest < 1e-3) {
        let digits = (greatest.log10().floor() - step.log10().floor()).max(0.0) as usize;
        return values.iter().map(|&v| scientific(v, digits)).collect();
    }
    // A step of 5e-13 on values near 1 would need more digits than fit. Ten are what `LEVEL`
    // needs of the least numbers that come here.
    values.iter().map(|&v| minus(format!("{:.*}", decimals.min(10), v + 0.0))).collect()
}

/// `1.5e-7`, `0`.
fn scientific(v: f64, digits: usize) -> String {
    if v == 0.0 { "0".into() } else { minus(format!("{v:.*e}", digits.min(7))) }
}

/// -0.0 without its sign, and the hyphen as a minus sign.
fn minus(text: String) -> String {
    let zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if zero { text.replace('-', "") } else { text.replace('-', "\u{2212}") }
}

/// `v` with `digits` significant digits.
fn round_to(v: f64, digits: usize) -> f64 {
    format!("{v:.*e}", digits).parse().unwrap_or(v)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[(f64, String)]) -> Vec<&str> {
        ticks.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(&ticks([0.0, 79.0], 5)), ["0", "20", "40", "60"]);
        assert_eq!(labels(&ticks([0.0, 0.3], 3)), ["0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(
            labels(&ticks([-1.0, 1.0], 4)),
            ["\u{2212}1.0", "\u{2212}0.5", "0.0", "0.5", "1.0"]
        );
        assert_eq!(
            labels(&ticks([0.0, 3e-7], 3)),
            ["0", "1e\u{2212}7", "2e\u{2212}7", "3e\u{2212}7"]
        );
        assert_eq!(labels(&log_ticks([0.5, 2000.0], 6)), ["1", "10", "100", "1000"]);
        assert_eq!(labels(&log_ticks([2.0, 7.0], 6)), ["2", "5"]);
    }

    #[test]
    fn labels_differ_on_ranges_with_margins() {
        for middle in [1.1e-3, 0.01, -0.6, 1.0, 203.3061, 9e5, 1e7] {
            for part in [1e-9, 0.9e-6, 1.1e-6, 1e-4, 0.1] {
                let half = 0.5 * part * f64::abs(middle);
                let range = with_margin([middle - half, middle + half]);
                let ticks = ticks(range, 6);
                let mut names = labels(&ticks);
                names.dedup();
                assert!(
                    names.len() == ticks.len() && names.len() > 2,
                    "{middle} {part}: {names:?}"
                );
            }
        }
        assert_eq!(with_margin([0.0, 1.0]), [0.0, 1.04]);
        // A mass that is kept is a level line.
        let kept = ticks(with_margin([-0.600_000_35, -0.600_000_12]), 4);
        let names = ["\u{2212}0.600005", "\u{2212}0.600000", "\u{2212}0.599995"];
        assert_eq!(labels(&kept), names);
    }

    #[test]
    fn impossible_ranges_have_no_ticks() {
        for range in [[1.0, 1.0], [2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            assert!(ticks(range, 5).is_empty(), "{range:?}");
        }
    }
}
