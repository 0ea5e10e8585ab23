//! Speeds known on a front, carried off it along its normals.

use crate::{Boundary, Error, Field, Grid, Result};

/// Extends `speed` off the front `phi = 0` so that `grad speed . grad phi = 0`: every
/// node gets the value at the nearest point of the front.
///
/// `phi` is a signed distance (length). Only the values of `speed` at nodes with a
/// neighbour of opposite sign are read; all are overwritten, except where no path
/// along falling |phi| leads to the front. Second order, in linear time: nodes are
/// visited in the order of |phi|, each solving the upwind form of the equation, once
/// from the nodes visited before as in Adalsteinsson & Sethian 1999, J. Comput. Phys.
/// 148:2, section 4, and once with one-sided differences of second order.
///
/// # Errors
/// If the shapes differ or phi is not finite.
pub fn extend_speed(phi: &Field, speed: &mut Field, boundary: Boundary) -> Result<()> {
    speed.check_shape("speed", phi.grid())?;
    phi.check_finite("phi", 0.0)?;
    if u32::try_from(phi.grid().len()).is_err() {
        return Err(Error::Invalid("velocity extension handles at most 2^32 nodes".into()));
    }
    let known = speed.as_slice().to_vec();
    let mut sweep = Sweep {
        grid: phi.grid(),
        periodic: boundary == Boundary::Periodic,
        phi: phi.as_slice(),
        known: &known,
        speed: speed.as_mut_slice(),
        done: vec![false; known.len()],
    };
    let order = order_by_distance(phi.as_slice());
    for &n in &order {
        if let Some(value) = sweep.solve(n as usize) {
            sweep.speed[n as usize] = value;
            sweep.done[n as usize] = true;
        }
    }
    for &n in &order {
        if let Some(value) = sweep.refine(n as usize) {
            sweep.speed[n as usize] = value;
        }
    }
    Ok(())
}

struct Sweep<'a> {
    grid: Grid,
    periodic: bool,
    phi: &'a [f64],
    /// The speed as given.
    known: &'a [f64],
    speed: &'a mut [f64],
    /// Whether `speed` is extended there.
    done: Vec<bool>,
}

impl Sweep<'_> {
    /// Solves `sum over axes of (D phi) (D F) = 0` for F at node `n`, where D looks to
    /// the front itself if it crosses the next edge, else to a visited node.
    fn solve(&self, n: usize) -> Option<f64> {
        if self.phi[n] == 0.0 {
            return Some(self.known[n]);
        }
        let (mut weight, mut sum) = (0.0, 0.0);
        for axis in 3 - self.grid.dim()..3 {
            let Some((slope, per_step, value)) = self
                .crossing(n, axis)
                .map(|(m, theta)| {
                    let on_front = self.known[n] + theta * (self.known[m] - self.known[n]);
                    (self.distance(n) / theta, 1.0 / theta, on_front)
                })
                .or_else(|| {
                    let m = self.visited(n, axis)?;
                    Some((self.distance(n) - self.distance(m), 1.0, self.speed[m]))
                })
            else {
                continue;
            };
            weight += slope * per_step;
            sum += slope * per_step * value;
        }
        (weight > 0.0).then(|| sum / weight)
    }

    /// As [`Self::solve`], off the front, with second-order differences that may look
    /// to any node: where the front is nearly normal to an axis, the upwind neighbour
    /// along the other axes is visited later, but has little weight.
    fn refine(&self, n: usize) -> Option<f64> {
        let axes = 3 - self.grid.dim()..3;
        if self.phi[n] == 0.0 || axes.clone().any(|axis| self.crossing(n, axis).is_some()) {
            return None;
        }
        let (mut weight, mut sum) = (0.0, 0.0);
        for axis in axes {
            let [low, high] = [false, true].map(|up| self.neighbour(n, axis, up));
            let slope = 0.5 * (self.distance(high.unwrap_or(n)) - self.distance(low.unwrap_or(n)));
            let up = slope < 0.0;
            let Some(first) = (if up { high } else { low }).filter(|&m| self.done[m]) else {
                continue;
            };
            let second =
                self.neighbour(first, axis, up).filter(|&m| self.done[m] && self.same_side(m, n));
            let (per_step, value) = second.map_or((1.0, self.speed[first]), |second| {
                (1.5, 2.0 * self.speed[first] - 0.5 * self.speed[second])
            });
            weight += slope.abs() * per_step;
            sum += slope.abs() * value;
        }
        (weight > 0.0).then(|| sum / weight)
    }

    fn distance(&self, n: usize) -> f64 {
        self.phi[n].abs()
    }

    fn same_side(&self, m: usize, n: usize) -> bool {
        self.phi[m] != 0.0 && (self.phi[m] < 0.0) == (self.phi[n] < 0.0)
    }

    /// The nearer neighbour along an axis on the other side of the front, and the
    /// fraction of the edge to it at which the front crosses.
    fn crossing(&self, n: usize, axis: usize) -> Option<(usize, f64)> {
        [false, true]
            .into_iter()
            .filter_map(|up| self.neighbour(n, axis, up))
            .filter(|&m| !self.same_side(m, n))
            .map(|m| (m, self.distance(n) / (self.distance(n) + self.distance(m))))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The visited neighbour along an axis that is closest to the front.
    fn visited(&self, n: usize, axis: usize) -> Option<usize> {
        [false, true]
            .into_iter()
            .filter_map(|up| self.neighbour(n, axis, up))
            .filter(|&m| self.done[m] && self.distance(m) < self.distance(n))
            .min_by(|&a, &b| self.distance(a).total_cmp(&self.distance(b)))
    }

    /// The next node along an axis, if the grid has one.
    fn neighbour(&self, n: usize, axis: usize, up: bool) -> Option<usize> {
        let (count, stride) = (self.grid.shape()[axis], self.grid.strides()[axis]);
        let i = n / stride % count;
        match (up, self.periodic) {
            (true, _) if i + 1 < count => Some(n + stride),
            (false, _) if i > 0 => Some(n - stride),
            (true, true) => Some(n - (count - 1) * stride),
            (false, true) => Some(n + (count - 1) * stride),
            _ => None,
        }
    }
}

/// The nodes by increasing |phi|, to one part in 2^22 of the greatest, by a radix sort.
fn order_by_distance(phi: &[f64]) -> Vec<u32> {
    const BITS: u32 = 11;
    let greatest = phi.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    let scale = f64::from((1_u32 << (2 * BITS)) - 1) / greatest;
    let key = |n: u32| (phi[n as usize].abs() * scale) as u32;
    let mut order: Vec<u32> = (0..phi.len() as u32).collect();
    let mut sorted = order.clone();
    for shift in [0, BITS] {
        let digit = |n: u32| (key(n) >> shift & ((1 << BITS) - 1)) as usize;
        let mut starts = vec![0_usize; (1 << BITS) + 1];
        order.iter().for_each(|&n| starts[digit(n) + 1] += 1);
        for d in 0..1 << BITS {
            starts[d + 1] += starts[d];
        }
        for &n in &order {
            let slot = &mut starts[digit(n)];
            sorted[*slot] = n;
            *slot += 1;
        }
        std::mem::swap(&mut order, &mut sorted);
    }
    order
}

#[cfg(test)]
mod tests {
    #[test]
    fn nodes_come_in_the_order_of_distance() {
        let phi: Vec<f64> = (0..2000).map(|n| f64::from(n * 7919 % 2003) - 1000.0).collect();
        let order = super::order_by_distance(&phi);
        assert!(order.windows(2).all(|w| phi[w[0] as usize].abs() <= phi[w[1] as usize].abs()));
        let mut nodes = order.clone();
        nodes.sort_unstable();
        assert!(nodes.into_iter().eq(0..2000));
    }
}
