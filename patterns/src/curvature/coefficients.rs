//! The polynomial of the principal curvatures.

use serde::{Deserialize, Serialize};

/// Surface energy density `p(kappa1, kappa2) = a20 kappa1^2 + a11 kappa1 kappa2 + a02 kappa2^2
/// + b10 kappa1 + b01 kappa2 + c`, with `kappa1 >= kappa2`.
///
/// Curvatures in 1/length, positive where `{u > 0}` is convex. Song 2021, eq. (6).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coefficients {
    /// Of `kappa1^2`.
    pub a20: f64,
    /// Of `kappa1 kappa2`.
    pub a11: f64,
    /// Of `kappa2^2`.
    pub a02: f64,
    /// Of `kappa1`.
    pub b10: f64,
    /// Of `kappa2`.
    pub b01: f64,
    /// The constant.
    pub c: f64,
}

/// The same density as `h2 (H - h0)^2 + k1 K + s (kappa1 - kappa1_0)^2 + t (kappa2 - kappa2_0)^2`
/// with `H = kappa1 + kappa2`, `K = kappa1 kappa2`. Song 2021, eq. (26).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Interpretable {
    /// Bending rigidity.
    pub h2: f64,
    /// Spontaneous total curvature `kappa1 + kappa2`.
    pub h0: f64,
    /// Gaussian rigidity.
    pub k1: f64,
    /// Rigidity of the greater curvature.
    pub s: f64,
    /// Its preferred value.
    pub kappa1_0: f64,
    /// Rigidity of the lesser curvature.
    pub t: f64,
    /// Its preferred value.
    pub kappa2_0: f64,
}

impl From<Interpretable> for Coefficients {
    fn from(b: Interpretable) -> Self {
        Self {
            a20: b.h2 + b.s,
            a11: 2.0 * b.h2 + b.k1,
            a02: b.h2 + b.t,
            b10: -2.0 * (b.h2 * b.h0 + b.s * b.kappa1_0),
            b01: -2.0 * (b.h2 * b.h0 + b.t * b.kappa2_0),
            c: b.h2 * b.h0 * b.h0 + b.s * b.kappa1_0 * b.kappa1_0 + b.t * b.kappa2_0 * b.kappa2_0,
        }
    }
}

impl From<[f64; 6]> for Coefficients {
    /// In the order `a20, a11, a02, b10, b01, c`.
    fn from([a20, a11, a02, b10, b01, c]: [f64; 6]) -> Self {
        Self { a20, a11, a02, b10, b01, c }
    }
}

impl Coefficients {
    /// `a20, a11, a02, b10, b01, c`.
    pub fn to_array(self) -> [f64; 6] {
        [self.a20, self.a11, self.a02, self.b10, self.b01, self.c]
    }

    /// The density at a pair of curvatures.
    pub fn density(self, kappa1: f64, kappa2: f64) -> f64 {
        (self.a20 * kappa1 + self.a11 * kappa2 + self.b10) * kappa1
            + (self.a02 * kappa2 + self.b01) * kappa2
            + self.c
    }

    /// Why the density has no lower bound, if it has none; the flow then ends where the grid
    /// and the phase field's width stop it, not at a minimum of the surface energy.
    pub fn unbounded(self) -> Option<String> {
        let Self { a20, a11, a02, b10, b01, .. } = self;
        let least = 0.5 * (a20 + a02) - 0.5 * (a20 - a02).hypot(a11);
        let scale = a20.abs().max(a02.abs()).max(a11.abs());
        let zero = 1e-12 * scale;
        if least < -zero {
            return Some(format!(
                "the quadratic part has the eigenvalue {least:.4}: 4 a20 a02 = {:.4} must be at \
                 least a11^2 = {:.4}, and a20, a02 >= 0, for an energy that is bounded below",
                4.0 * a20 * a02,
                a11 * a11
            ));
        }
        if least > zero {
            return None;
        }
        // Along the null direction only the linear part acts. Of d and -d the one with
        // kappa1 >= kappa2 is admissible, both if they are equal.
        let flat = if a20 >= a02 { [-0.5 * a11, a20] } else { [a02, -0.5 * a11] };
        let flat = if scale == 0.0 {
            // No quadratic part: the admissible directions span (1, 1), (-1, -1), (1, -1).
            let worst = -(b10 + b01).abs().max(b01 - b10);
            return (worst < 0.0).then(|| linear(worst));
        } else if flat[0] >= flat[1] {
            flat
        } else {
            flat.map(|d| -d)
        };
        let both = (flat[0] - flat[1]).abs() <= 1e-12 * (flat[0].abs() + flat[1].abs());
        let slope = b10 * flat[0] + b01 * flat[1];
        let slope = if both { -slope.abs() } else { slope };
        (slope < -1e-12 * (b10.abs() + b01.abs()) * scale).then(|| linear(slope))
    }
}

fn linear(slope: f64) -> String {
    format!(
        "the quadratic part vanishes in a direction in which b10 kappa1 + b01 kappa2 falls (by \
         {:.4}), so the energy has no lower bound",
        -slope
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_are_the_same_polynomial() {
        let b = Interpretable {
            h2: 2.0,
            h0: 45.0,
            k1: -0.3,
            s: 1.5,
            kappa1_0: 20.0,
            t: 10.0,
            kappa2_0: -3.0,
        };
        let a = Coefficients::from(b);
        for (x, y) in [(0.0, 0.0), (30.0, -7.0), (12.0, 11.5), (-2.0, -40.0)] {
            let expected = b.h2 * (x + y - b.h0).powi(2)
                + b.k1 * x * y
                + b.s * (x - b.kappa1_0).powi(2)
                + b.t * (y - b.kappa2_0).powi(2);
            assert!((a.density(x, y) - expected).abs() < 1e-9 * expected.abs());
        }
    }

    /// Table 2 of the paper, second row: (H - 25)^2 + (k1 - 12.5)^2 + (k2 - 12.5)^2.
    #[test]
    fn published_conversions() {
        let b = Interpretable {
            h2: 1.0,
            h0: 25.0,
            k1: 0.0,
            s: 1.0,
            kappa1_0: 12.5,
            t: 1.0,
            kappa2_0: 12.5,
        };
        let a = Coefficients::from(b).to_array();
        assert_eq!(a, [2.0, 2.0, 2.0, -75.0, -75.0, 937.5]);
    }

    #[test]
    fn unbounded_energies_are_told() {
        let told = |a: [f64; 6]| Coefficients::from(a).unbounded();
        for bounded in [
            [1.0, 2.0, 6.0, -40.0, -40.0, 400.0],
            [1.0, 2.4, 9.0, 30.0, 170.0, -195.0],
            [1.0, 2.0, 1.0, 0.0, 0.0, 0.0],
            [1.0, 2.0, 1.0, -3.0, -3.0, 0.0],
            // Flat along (1, -1), where the linear part rises.
            [1.0, 2.0, 1.0, 1.0, 0.0, 0.0],
        ] {
            assert_eq!(told(bounded), None, "{bounded:?}");
        }
        assert!(told([1.0, 3.0, 1.0, 0.0, 0.0, 0.0]).unwrap().contains("eigenvalue -0.5"));
        assert!(told([1.0, 0.0, -0.1, 0.0, 0.0, 0.0]).unwrap().contains("eigenvalue -0.1"));
        assert!(told([1.0, 2.0, 1.0, -1.0, 0.0, 0.0]).unwrap().contains("b10"));
        // Flat along (1, 1) in both senses.
        assert!(told([1.0, -2.0, 1.0, 1.0, 0.0, 0.0]).unwrap().contains("b10"));
        assert!(told([0.0, 0.0, 0.0, 0.0, 1.0, 0.0]).unwrap().contains("b10"));
    }
}
