//! The shape textures of the paper, by its names.

use crate::{Error, Preset, Result};
use toml::Table;

macro_rules! preset {
    ($name:literal, $about:literal, $coefficients:literal, $mass:literal) => {
        Preset {
            name: $name,
            about: $about,
            config: concat!("coefficients = ", $coefficients, "\nmass = ", $mass),
        }
    };
}

/// Figures 11 and 12 (a to j), Table 1, and figures 2 and 4 of Song 2022.
///
/// Vesicles: the constant is 468.75, as the squares printed beside it give; vessels: the mass is
/// -0.6, of which the published volume and its discrepancy are, not the printed -0.7.
pub(super) fn presets() -> Vec<Preset> {
    vec![
        preset!("tubes", "(H - 20)^2 + 5 k2^2: vessels (e)", "[1, 2, 6, -40, -40, 400]", "-0.6"),
        preset!(
            "bilayers",
            "half of H^2 + k1^2 + k2^2: membranes (a)",
            "[1, 1, 1, 0, 0, 0]",
            "-0.4"
        ),
        preset!(
            "fenestrations",
            "layers with holes, sieve plates (b)",
            "[1, 4.18, 2.05, 19.34, 29.60, 120.30]",
            "-0.534"
        ),
        preset!(
            "pearls",
            "(H - 28)^2 + 1.55 K: beads on a string (c)",
            "[1, 3.55, 1, -56, -56, 784]",
            "-0.77"
        ),
        preset!(
            "vesicles",
            "half of (H - 25)^2 + (k1 - 12.5)^2 + (k2 - 12.5)^2: spheres (d)",
            "[1, 1, 1, -37.5, -37.5, 468.75]",
            "-0.6"
        ),
        preset!("vessels", "(H - 20)^2 + 5 k2^2 (e)", "[1, 2, 6, -40, -40, 400]", "-0.6"),
        preset!(
            "3d-vessels",
            "vessels arranged in sheets (f)",
            "[1, 1.46, 3.17, 8.97, 66.09, 322.2]",
            "-0.53"
        ),
        preset!(
            "sponges",
            "(H - 5)^2 + 0.8 K + k2^2: bone marrow capillaries (g)",
            "[1, 2.8, 2, -10, -10, 25]",
            "-0.25"
        ),
        preset!(
            "trabecular-bone",
            "rods and plates (h)",
            "[1, 0.90, 5.68, -78.35, -7.18, 1653.85]",
            "-0.45"
        ),
        preset!(
            "porous",
            "porous structure (i)",
            "[1, 0.396, 1.095, -28.64, 190.906, 2062.082]",
            "-0.598"
        ),
        preset!(
            "tortuous",
            "tortuous vessels (j)",
            "[1, 2.221, 2.667, -103.61, 154.632, -1633.36]",
            "-0.745"
        ),
        preset!("layers", "H^2 + k1^2 + k2^2 (Table 1)", "[2, 2, 2, 0, 0, 0]", "-0.3"),
        preset!(
            "spheres",
            "(H - 2/R)^2 + (k1 - 1/R)^2 + (k2 - 1/R)^2, R = 0.08 (Table 1)",
            "[2, 2, 2, -75, -75, 937.5]",
            "-0.6"
        ),
        preset!(
            "thin-tubes",
            "(H - 1/r)^2 + (k1 - 1/r)^2 + 10 k2^2, r = 0.04 (Table 1)",
            "[2, 2, 11, -100, -50, 1250]",
            "-0.7"
        ),
        preset!("branching", "the flow of figure 2", "[1, 2.4, 9, 30, 170, -195]", "-0.66"),
        preset!("seeds", "the shape of figure 4", "[1, -0.35, 1.02, -40, 100, 1600]", "-0.69"),
    ]
}

/// The configuration itself or, where it has `preset = NAME`, that preset with the other keys
/// written over it.
pub(super) fn expand(config: &Table) -> Result<Table> {
    let mut config = config.clone();
    let Some(name) = config.remove("preset") else { return Ok(config) };
    let presets = presets();
    let found = name.as_str().and_then(|name| presets.iter().find(|preset| preset.name == name));
    let Some(preset) = found else {
        let known: Vec<&str> = presets.iter().map(|preset| preset.name).collect();
        let reason = format!("no preset {name}; known presets: {}", known.join(", "));
        return Err(Error::config("preset", reason));
    };
    // A test sees to it that every preset parses.
    let mut base: Table = preset.config.parse().unwrap_or_default();
    base.extend(config);
    Ok(base)
}
