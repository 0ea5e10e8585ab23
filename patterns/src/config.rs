//! What the configurations of all models share.

use crate::{Context, Error, Result};
use serde::{Serialize, de::DeserializeOwned};
use solvers::Grid;
use toml::{Table, Value};

/// Reads a configuration; what is absent takes its default.
///
/// # Errors
/// [`Error::Config`] with the dotted key of an unknown key or a wrong type.
pub(crate) fn from_table<T: DeserializeOwned>(table: &Table) -> Result<T> {
    let value = Value::Table(table.clone());
    serde_path_to_error::deserialize(value).map_err(|error| {
        let reason = error.inner().to_string().trim().replace('\n', " ");
        // `speed[0].kind` as the dotted key `speed.0.kind`.
        let path = error.path().to_string().replace(']', "").replace('[', ".");
        // serde knows only the table of an unknown key; its message has the key.
        let unknown =
            reason.strip_prefix("unknown field `").and_then(|rest| rest.split('`').next());
        let key = match (path.as_str(), unknown) {
            (".", Some(field)) => field.to_owned(),
            (path, Some(field)) if !path.ends_with(field) => format!("{path}.{field}"),
            (path, _) => path.to_owned(),
        };
        Error::Config { key, reason }
    })
}

/// Lays a table over another, table by table: what is not in it stays.
pub(crate) fn overlay(base: &mut Table, over: Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(old)), Value::Table(new)) => overlay(old, new),
            (_, value) => drop(base.insert(key, value)),
        }
    }
}

/// The complete configuration as a table.
pub(crate) fn to_table<T: Serialize>(config: &T) -> Table {
    // Configurations are structs of numbers, texts and lists, which always serialize.
    Table::try_from(config).unwrap_or_default()
}

/// Refuses a grid whose run would not fit in memory, with the size that it needs.
///
/// # Errors
/// [`Error::Config`] for `key` with what is needed and what there is.
pub(crate) fn check_memory(
    key: &str,
    grid: Grid,
    bytes_per_node: usize,
    context: &Context<'_>,
) -> Result<()> {
    let needed = grid.len() as f64 * bytes_per_node as f64;
    if needed <= context.memory as f64 {
        return Ok(());
    }
    let gib = |bytes: f64| format!("{:.1} GiB", bytes / 1024.0_f64.powi(3));
    let nodes = grid.axes().iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
    let (needed, available) = (gib(needed), gib(context.memory as f64));
    let reason = format!("{nodes} cells need {needed} of memory, {available} is available");
    Err(Error::config(key, reason))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoInputs;
    use serde::Deserialize;

    #[derive(Debug, Default, Deserialize, Serialize)]
    #[serde(default, deny_unknown_fields)]
    struct Config {
        size: u32,
        inner: Inner,
    }

    #[derive(Debug, Default, Deserialize, Serialize)]
    #[serde(default, deny_unknown_fields)]
    struct Inner {
        feed: f64,
    }

    fn key(text: &str) -> String {
        match from_table::<Config>(&text.parse().unwrap()) {
            Err(Error::Config { key, .. }) => key,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn errors_carry_the_dotted_key() {
        assert_eq!(key("radios = 1"), "radios");
        assert_eq!(key("inner.fead = 1.0"), "inner.fead");
        assert_eq!(key("inner.feed = 'x'"), "inner.feed");
        assert_eq!(key("size = -1"), "size");
    }

    #[test]
    fn what_does_not_fit_is_refused_with_its_size() {
        let grid = Grid::new(&[1024, 1024, 1024], 1.0).unwrap();
        let context = Context { seed: 0, inputs: &NoInputs, memory: 1 << 30 };
        let message = check_memory("size", grid, 16, &context).unwrap_err().to_string();
        assert!(message.contains("16.0 GiB") && message.contains("1.0 GiB"), "{message}");
    }
}
