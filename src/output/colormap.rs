//! Colormaps that are uniform to the eye.

use patterns::Colors;
use std::sync::OnceLock;

/// An sRGB colour, 8 bits a channel.
pub type Rgb = [u8; 3];

/// Colour of values that are not numbers.
pub const NOT_A_NUMBER: Rgb = [200, 200, 200];

/// A colormap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colormap {
    /// Dark blue to yellow (matplotlib, CC0).
    Viridis,
    /// Black to cream (matplotlib, CC0).
    Magma,
    /// Blue to yellow, the same to colour-blind eyes (Nunez et al. 2018; matplotlib, CC0).
    Cividis,
    /// Blue over light grey to red (Moreland 2009, "Diverging color maps for
    /// scientific visualization", interpolated in his Msh space).
    CoolWarm,
    /// The circle of hues at CIE L* = 70, chroma 38, for angles: both ends are equal.
    Phase,
    /// Black to white, with L* linear.
    Grey,
}

/// All colormaps with their names on the command line.
pub const COLORMAPS: [(&str, Colormap); 6] = [
    ("viridis", Colormap::Viridis),
    ("magma", Colormap::Magma),
    ("cividis", Colormap::Cividis),
    ("coolwarm", Colormap::CoolWarm),
    ("phase", Colormap::Phase),
    ("grey", Colormap::Grey),
];

impl Colormap {
    /// The colormap for a family.
    pub fn of(colors: Colors) -> Self {
        match colors {
            Colors::Diverging => Self::CoolWarm,
            Colors::Ink => Self::Grey,
            _ => Self::Viridis,
        }
    }

    /// 256 colours from the low end to the high end.
    pub fn table(self) -> &'static [Rgb; 256] {
        static TABLES: [OnceLock<[Rgb; 256]>; 6] = [const { OnceLock::new() }; 6];
        TABLES[self as usize].get_or_init(|| {
            std::array::from_fn(|n| {
                let t = n as f64 / 255.0;
                match self {
                    Self::Viridis => knots(VIRIDIS, t),
                    Self::Magma => knots(MAGMA, t),
                    Self::Cividis => knots(CIVIDIS, t),
                    Self::CoolWarm => cool_warm(t),
                    Self::Phase => {
                        let (sin, cos) = (std::f64::consts::TAU * t).sin_cos();
                        srgb([70.0, 38.0 * cos, 38.0 * sin])
                    }
                    Self::Grey => srgb([100.0 * t, 0.0, 0.0]),
                }
            })
        })
    }

    /// Colour at `t` in [0, 1]; beyond the ends the ends' colours, NaN [`NOT_A_NUMBER`].
    pub fn color(self, t: f64) -> Rgb {
        if t.is_nan() {
            return NOT_A_NUMBER;
        }
        self.table()[(t * 255.0).round().clamp(0.0, 255.0) as usize]
    }
}

/// Every fifth of matplotlib's 256 colours, RRGGBB each; between them a Catmull-Rom
/// spline is within one step of 255 (cividis: three, at its dark end).
/// Source: matplotlib 3, `_cm_listed.py`, dedicated to the public domain (CC0).
const VIRIDIS: &str = "\
    44015446085c471063481769481d6f482475472a7a46307e453781433d844142873f48893d4e8a\
    3a538b38598c355e8d33638d31688e2e6d8e2c718e2a768e297b8e27808e25848e23898e218e8d\
    20928c1f978b1e9c891fa18821a58524aa8328ae802eb37c35b7793dbc7446c06f50c46a5ac864\
    65cb5e70cf577cd25089d54895d840a2da37b0dd2fbddf26cae11fd8e219e5e419f1e51dfde725";
const MAGMA: &str = "\
    00000402020b0504160907200e0b2b140e361a104221114e29115a311165390f6e420f754a1079\
    52137c5a167e6219806a1c81721f81792282812581892881912b81992d80a1307eaa337db2357b\
    ba3878c23b75ca3e72d2426fd9466be04c67e75263ec5860f1605df4695cf7725cf97b5dfb8560\
    fc8e64fd9869fea16efeaa74feb47bfebd82fec68afecf92fed89afde2a3fdebacfcf4b6fcfdbf";
const CIVIDIS: &str = "\
    00224e002656002a5f002d68003070083370163770203a6f273e6e2e416d34456c3a486c3f4c6c\
    444f6c49536c4e566c535a6d575d6d5c616e60646f656870696b716d6f727272747676767a7a78\
    7e7d788381798885788d8878928c789690779b9476a09875a59c74aaa073afa471b5a86fbaac6d\
    bfb06bc4b468c9b965cfbd62d4c15fdac65bdfca57e5cf52ead34cf0d846f6dd3ffce236fee838";

/// Catmull-Rom spline through the colours of a table, `t` in [0, 1].
fn knots(table: &str, t: f64) -> Rgb {
    let count = table.len() / 6;
    let knot = |n: i64, channel: usize| {
        let at = 6 * n.clamp(0, count as i64 - 1) as usize + 2 * channel;
        table
            .get(at..at + 2)
            .and_then(|hex| u8::from_str_radix(hex, 16).ok())
            .map_or(0.0, f64::from)
    };
    let x = t * (count - 1) as f64;
    let n = (x as i64).min(count as i64 - 2);
    let f = x - n as f64;
    std::array::from_fn(|c| {
        let p = [knot(n - 1, c), knot(n, c), knot(n + 1, c), knot(n + 2, c)];
        catmull_rom(p, f).round().clamp(0.0, 255.0) as u8
    })
}

/// Cubic through `p[1]` at 0 and `p[2]` at 1 with slopes by central differences.
pub(crate) fn catmull_rom(p: [f64; 4], f: f64) -> f64 {
    let [a, b, c, d] = p;
    b + 0.5 * f * (c - a + f * (2.0 * a - 5.0 * b + 4.0 * c - d + f * (3.0 * (b - c) + d - a)))
}

/// Moreland's cool-warm map: both ends have M = 80, s = 1.08; the middle is M = 88
/// without saturation; the hue turns a little on its way to grey (his section 5.2).
fn cool_warm(t: f64) -> Rgb {
    const END: f64 = 80.0;
    const MIDDLE: f64 = 88.0;
    const SATURATION: f64 = 1.08;
    let w = (2.0 * t - 1.0).abs();
    let m = MIDDLE + w * (END - MIDDLE);
    let s = SATURATION * w;
    // s sqrt(M_mid^2 - M^2) / (M sin s): how far the hue may turn.
    let turn = SATURATION * (MIDDLE * MIDDLE - END * END).sqrt() / (END * SATURATION.sin());
    let (hue, sign) = if t < 0.5 { (-1.1, -1.0) } else { (0.5, 1.0) };
    let h: f64 = hue + sign * turn * (1.0 - w);
    srgb([m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin()])
}

/// D65 white point of XYZ.
const WHITE: [f64; 3] = [0.950_47, 1.0, 1.088_83];

/// sRGB of CIE L*a*b* (D65), clamped to the gamut.
fn srgb([l, a, b]: [f64; 3]) -> Rgb {
    let fy = (l + 16.0) / 116.0;
    let f = [fy + a / 500.0, fy, fy - b / 200.0];
    let inverse =
        |f: f64| if f > 6.0 / 29.0 { f * f * f } else { (f - 16.0 / 116.0) * 108.0 / 841.0 };
    let [x, y, z] = std::array::from_fn(|c| WHITE[c] * inverse(f[c]));
    let linear = [
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266_0 * x + 1.876_010_8 * y + 0.041_556_0 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ];
    linear.map(|v| {
        let v = v.clamp(0.0, 1.0);
        let v = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (255.0 * v).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE L* (D65) of an sRGB colour.
    fn lightness(color: Rgb) -> f64 {
        let linear = color.map(|v| {
            let v = f64::from(v) / 255.0;
            if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        });
        let y = 0.212_672_9 * linear[0] + 0.715_152_2 * linear[1] + 0.072_175_0 * linear[2];
        if y > 216.0 / 24_389.0 { 116.0 * y.cbrt() - 16.0 } else { y * 24_389.0 / 27.0 }
    }

    #[test]
    fn sequential_maps_grow_lighter_evenly() {
        for map in [Colormap::Viridis, Colormap::Magma, Colormap::Cividis, Colormap::Grey] {
            let l: Vec<f64> = map.table().iter().map(|&c| lightness(c)).collect();
            let mean = (l[255] - l[0]) / 255.0;
            for n in 0..255 {
                // One step of a channel of 255 moves L* by at most 0.5 in the dark.
                assert!(l[n + 1] - l[n] > -0.5, "{map:?} {n}: {} {}", l[n], l[n + 1]);
            }
            for n in 0..240 {
                // Over 16 colours the rounding averages out: monotone, and nowhere twice as steep.
                let slope = (l[n + 15] - l[n]) / 15.0;
                assert!(slope > 0.3 * mean && slope < 2.0 * mean, "{map:?} {n}: {slope} of {mean}");
            }
        }
    }

    #[test]
    fn the_diverging_map_is_as_light_on_both_sides() {
        let table = Colormap::CoolWarm.table();
        for n in 0..128 {
            let (low, high) = (lightness(table[n]), lightness(table[255 - n]));
            // Rounding to 8 bits: 0.4; the reds at the end leave the gamut a little.
            assert!((low - high).abs() < 1.5, "{n}: {low} {high}");
        }
        // Ends as Moreland publishes them, within the rounding of his Msh values to 3 digits.
        for (color, published) in [(table[0], [59, 76, 192]), (table[255], [180, 4, 38])] {
            for c in 0..3 {
                assert!((i32::from(color[c]) - published[c]).abs() <= 4, "{color:?} {published:?}");
            }
        }
        assert!((lightness(table[128]) - 88.0).abs() < 1.0);
    }

    #[test]
    fn the_cyclic_map_is_isoluminant_and_closed() {
        let table = Colormap::Phase.table();
        assert_eq!(table[0], table[255]);
        for &color in table {
            assert!((lightness(color) - 70.0).abs() < 0.5, "{color:?}: {}", lightness(color));
        }
    }

    #[test]
    fn published_colours_are_met() {
        // matplotlib.colormaps["viridis"](127), magma(200), viridis(63), as 8-bit values.
        assert_eq!(Colormap::Viridis.table()[0], [0x44, 0x01, 0x54]);
        assert_eq!(Colormap::Viridis.table()[255], [0xfd, 0xe7, 0x25]);
        let middle = Colormap::Viridis.table()[128];
        for (c, want) in [33, 145, 140].into_iter().enumerate() {
            assert!((i32::from(middle[c]) - want).abs() <= 1, "{middle:?}");
        }
        assert_eq!(Colormap::Magma.color(f64::NAN), NOT_A_NUMBER);
        assert_eq!(Colormap::Magma.color(7.0), Colormap::Magma.table()[255]);
    }
}
