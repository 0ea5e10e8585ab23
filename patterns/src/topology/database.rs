//! The problems that the program carries: `database/topology/*.toml`.

use crate::{Error, Preset, Result};
use toml::Table;

macro_rules! entry {
    ($name:literal, $about:literal) => {
        Preset {
            name: $name,
            about: $about,
            config: include_str!(concat!("../../database/topology/", $name, ".toml")),
        }
    };
}

/// Table 1.1 first, then the classics.
pub(super) fn presets() -> Vec<Preset> {
    vec![
        entry!("row-a", "half MBB beam, 60x20"),
        entry!("row-b", "half beam held along its whole right side, 60x20"),
        entry!("row-c", "cantilever loaded at its lower corner, 32x20"),
        entry!("row-d", "bridge loaded at its middle, 32x20"),
        entry!("row-e", "cantilever held at rows 1 to 21 of 32, 61x31"),
        entry!("row-f", "bridge loaded from below, 60x20"),
        entry!("row-g", "bridge loaded at its centre, 60x20"),
        entry!("row-h", "clamped beam pulled apart at its middle, 60x20"),
        entry!("row-i", "half beam pulled apart, 60x20"),
        entry!("row-j", "propped cantilever pulled apart, 60x20"),
        entry!("row-k", "square on two feet pulled apart, 45x45"),
        entry!("row-l", "cantilever with two loads (99 lines, section 5.2), 30x30"),
        entry!("row-m", "beam on two feet with loads near its middle, 60x20"),
        entry!("row-n", "propped cantilever pulled apart near its wall, 60x20"),
        entry!("row-o", "plate with a hole; refused: its load acts on a support, 45x30"),
        entry!("row-p", "plate with a hole pulled sideways, 45x30"),
        entry!("row-q", "plate with a hole and two loads, 45x30"),
        entry!("mbb", "half of the MBB beam, 60x20 (top99, top88)"),
        entry!(
            "cantilever",
            "cantilever loaded at its lower corner, 32x20 (99 lines, section 5.1)"
        ),
        entry!("bridge", "deck under a uniform load between two pins, 80x40"),
        entry!("l-bracket", "L-shaped bracket, 60x60 without its upper right part"),
        entry!("michell", "arch over a span loaded at the middle of its base, 80x40"),
        entry!("force-inverter", "mechanism that turns a push into a pull, upper half, 40x20"),
        entry!("gripper", "mechanism whose jaw closes when it is pushed, upper half, 60x30"),
        entry!("heat-sink", "plate heated everywhere and cooled at the middle of one side, 60x60"),
        entry!("cantilever-3d", "cantilever loaded along its lower edge, 24x12x8"),
        entry!("bridge-3d", "deck under a uniform load on four feet, 32x12x12"),
        entry!("wheel-3d", "disk on four corners loaded at the middle of its base, 20x10x20"),
    ]
}

/// The configuration itself or, where it has `table = NAME`, the problem of that name with
/// the other keys written over it.
pub(super) fn expand(config: &Table) -> Result<Table> {
    let mut config = config.clone();
    let Some(name) = config.remove("table") else { return Ok(config) };
    let presets = presets();
    let found = name.as_str().and_then(|name| presets.iter().find(|preset| preset.name == name));
    let Some(preset) = found else {
        let known: Vec<&str> = presets.iter().map(|preset| preset.name).collect();
        let reason = format!("no problem {name}; known problems: {}", known.join(", "));
        return Err(Error::config("table", reason));
    };
    // A test sees to it that every entry parses.
    let mut base: Table = preset.config.parse().unwrap_or_default();
    crate::overlay(&mut base, config);
    Ok(base)
}
