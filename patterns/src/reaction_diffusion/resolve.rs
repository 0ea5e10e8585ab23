//! From what the user says to a configuration: defaults, presets and the user's keys, in that order.

use super::config::{Config, FORMULAS};
use super::kinetics;
use crate::{Error, Preset, Result};

/// What every run starts from.
const COMMON: &str = r#"
size = [80, 80]
iterations = 8000
dt = 1.0
boundary = "neumann"
precision = "f64"
stepper = "explicit"
clamp = true
snapshots = []
stop_when_settled = false
dispersion = false
perturbation = []
parameters = {}
diffusion = {}
initial = {}

[curve]
speed = "recipe"
start = "circle"
dt = 0.45
redistance_every = 20
finish = 200
"#;

/// Lays `over` on `base`: tables key by key, anything else as a whole.
fn lay(base: &mut toml::Table, over: &toml::Table) {
    for (key, value) in over {
        match (base.get_mut(key), value) {
            (Some(toml::Value::Table(base)), toml::Value::Table(over)) => lay(base, over),
            _ => {
                base.insert(key.clone(), value.clone());
            }
        }
    }
}

fn parse(text: &str) -> Result<toml::Table> {
    text.parse().map_err(|e: toml::de::Error| Error::config("preset", e.to_string()))
}

/// The configuration that `user` asks for: [`COMMON`], then the defaults of a kinetics,
/// then a preset, then `user`'s own keys. The preset is the one under the key `preset`,
/// else the first of the kinetics, else the first of all.
pub(super) fn resolve(user: &toml::Table) -> Result<Config> {
    let mut user = user.clone();
    let text = |key: &str, value: &toml::Value| {
        value.as_str().map(str::to_owned).ok_or_else(|| {
            Error::config(key, format!("expected a name, found {}", value.type_str()))
        })
    };
    let preset = user.remove("preset").map(|v| text("preset", &v)).transpose()?;
    let named = user.get("kinetics").map(|v| text("kinetics", v)).transpose()?;
    let mut table = parse(COMMON)?;
    if let Some((kinetics, preset)) = beginning(preset.as_deref(), named.as_deref())? {
        lay(&mut table, &parse(kinetics.defaults)?);
        lay(&mut table, &parse(preset.config)?);
    }
    // A table of the preset that the user replaces by something else is replaced whole.
    lay(&mut table, &user);
    let config: Config = crate::from_table(&table)?;
    config.check()?;
    Ok(config)
}

/// The kinetics and the preset that a configuration begins with; none for formulas.
fn beginning(
    preset: Option<&str>,
    named: Option<&str>,
) -> Result<Option<(&'static kinetics::Kinetics, &'static Preset)>> {
    let all = || kinetics::KINETICS.iter().flat_map(|k| k.presets.iter().map(move |p| (*k, p)));
    let Some(name) = preset else {
        return match named {
            Some(FORMULAS) => Ok(None),
            Some(name) => {
                let kinetics = lookup(name)?;
                Ok(kinetics.presets.first().map(|preset| (kinetics, preset)))
            }
            None => Ok(all().next()),
        };
    };
    let Some((kinetics, preset)) = all().find(|(_, preset)| preset.name == name) else {
        let known: Vec<_> = all().map(|(_, preset)| preset.name).collect();
        return Err(Error::config("preset", format!("no `{name}`; known: {}", known.join(", "))));
    };
    if let Some(named) = named.filter(|&named| named != kinetics.name) {
        let reason = format!("`{named}` does not go with preset `{name}` of `{}`", kinetics.name);
        return Err(Error::config("kinetics", reason));
    }
    Ok(Some((kinetics, preset)))
}

/// The kinetics of that name, or an error that lists the known ones.
pub(super) fn lookup(name: &str) -> Result<&'static kinetics::Kinetics> {
    kinetics::find(name).ok_or_else(|| {
        let known: Vec<_> = kinetics::KINETICS.iter().map(|k| k.name).collect();
        let reason = format!("no `{name}`; known: {}, formulas", known.join(", "));
        Error::config("kinetics", reason)
    })
}
