//! What to run: a model, its configuration, a seed, and where each value came from.

use anyhow::{Context as _, Result, bail};
use patterns::{MODELS, Model};
use serde::Deserialize;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};
use toml::{Table, Value};

/// A request for one run.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Name of the model.
    pub command: String,
    /// Its configuration; what is absent takes the model's default.
    pub config: Table,
    /// Seed of all random streams.
    pub seed: u64,
    /// Folders in which relative input paths are looked up, the first that has the file.
    pub base: Vec<PathBuf>,
    /// Where a key of the configuration was given: `--size`, `spots.toml:7`.
    pub origins: BTreeMap<String, String>,
}

/// A run as a file: `run.json` and the TOML files of `examples/` have this form.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunFile {
    /// Name of the model.
    #[serde(default)]
    pub command: String,
    /// Seed of all random streams.
    #[serde(default)]
    pub seed: u64,
    /// Configuration of the model.
    #[serde(default)]
    pub config: Table,
    /// What makes the file a published figure.
    #[serde(default)]
    pub figure: Option<crate::figure::Caption>,
    /// The runs of a figure with several panels.
    #[serde(default)]
    pub panel: Vec<crate::figure::Panel>,
}

/// The model of that name.
///
/// # Errors
/// If there is none, with the names that there are.
pub fn find_model(name: &str) -> Result<&'static Model> {
    MODELS.iter().copied().find(|model| model.name == name).with_context(|| {
        let known: Vec<_> = MODELS.iter().map(|model| model.name).collect();
        format!("no model `{name}`; known models: {}", known.join(", "))
    })
}

impl Request {
    /// A request by flags; inputs are looked up from the working directory.
    pub fn new(command: &str, seed: u64) -> Self {
        Self { command: command.into(), seed, base: vec![PathBuf::from(".")], ..Self::default() }
    }

    /// Reads a TOML file or a `run.json`.
    ///
    /// # Errors
    /// If the file cannot be read or is not of that form; the message has the line.
    pub fn from_file(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path)
            .with_context(|| format!("cannot read the run file `{}`", path.display()))?;
        let json = path.extension().is_some_and(|extension| extension == "json");
        let file = if json { parse_manifest(&text, path)? } else { parse_toml(&text, path)? };
        if !file.panel.is_empty() {
            let id = file.figure.map_or_else(String::new, |figure| figure.id);
            bail!("`{}` is a figure of several runs; use `patterns figure {id}`", path.display());
        }
        let mut request = Self::new(&file.command, file.seed);
        request.config = file.config;
        if let Some(folder) = path.parent() {
            request.base.insert(0, folder.to_path_buf());
        }
        request.note_lines(&text, path);
        Ok(request)
    }

    /// Takes the configuration from a TOML file that holds nothing else.
    ///
    /// # Errors
    /// If the file cannot be read or is no TOML; the message has the line.
    pub fn read_config(&mut self, path: &Path) -> Result<()> {
        let text = fs::read_to_string(path)
            .with_context(|| format!("cannot read the file `{}`", path.display()))?;
        let parsed = text.parse::<Table>();
        self.config = parsed.with_context(|| format!("`{}` is no TOML", path.display()))?;
        if let Some(folder) = path.parent() {
            self.base.insert(0, folder.to_path_buf());
        }
        self.note_lines(&text, path);
        Ok(())
    }

    /// Sets a dotted key of the configuration and remembers where it came from.
    ///
    /// # Errors
    /// If the key passes through a value that is not a table.
    pub fn set(&mut self, key: &str, value: Value, origin: &str) -> Result<()> {
        let mut table = &mut self.config;
        let mut parts = key.split('.').peekable();
        while let Some(part) = parts.next() {
            if parts.peek().is_none() {
                table.insert(part.into(), value);
                break;
            }
            let entry = table.entry(part).or_insert_with(|| Value::Table(Table::new()));
            match entry {
                Value::Table(inner) => table = inner,
                other => bail!("{origin}: `{part}` in `{key}` is {other}, not a table"),
            }
        }
        self.origins.insert(key.into(), origin.into());
        Ok(())
    }

    /// Sets a key by the flag of its name, if the flag was given.
    ///
    /// # Errors
    /// As [`Request::set`].
    pub fn set_flag(&mut self, key: &str, value: Option<impl Into<Value>>) -> Result<()> {
        self.set_at(key, value, &format!("--{}", key.replace('_', "-")))
    }

    /// Sets a key by a flag of another name, if the flag was given.
    ///
    /// # Errors
    /// As [`Request::set`].
    pub fn set_at(&mut self, key: &str, value: Option<impl Into<Value>>, flag: &str) -> Result<()> {
        value.map_or(Ok(()), |value| self.set(key, value.into(), flag))
    }

    /// Starts from a preset of the model.
    ///
    /// # Errors
    /// If there is no preset of that name, with the names that there are.
    pub fn preset(&mut self, name: &str) -> Result<()> {
        let presets = (find_model(&self.command)?.presets)();
        let preset = presets.iter().find(|preset| preset.name == name).with_context(|| {
            let known: Vec<_> = presets.iter().map(|preset| preset.name).collect();
            format!("no preset `{name}` of `{}`; known presets: {}", self.command, known.join(", "))
        })?;
        self.config = preset.config.parse().with_context(|| format!("preset `{name}`"))?;
        Ok(())
    }

    /// Sets `key=value` as written behind `--set`; the value is TOML, or text if it is not.
    ///
    /// # Errors
    /// If there is no `=`, or as [`Request::set`].
    pub fn set_text(&mut self, assignment: &str) -> Result<()> {
        let Some((key, value)) = assignment.split_once('=') else {
            bail!("--set {assignment}: expected key=value");
        };
        let (key, value) = (key.trim(), value.trim());
        if key.is_empty() || key.split('.').any(str::is_empty) {
            bail!("--set {assignment}: the key is empty");
        }
        let parsed = format!("v = {value}").parse::<Table>().ok().and_then(|mut t| t.remove("v"));
        let value = parsed.unwrap_or_else(|| Value::String(value.into()));
        self.set(key, value, &format!("--set {key}"))
    }

    /// Says where the key of an error was given.
    pub fn locate(&self, error: patterns::Error) -> anyhow::Error {
        let key = match &error {
            patterns::Error::Config { key, .. }
            | patterns::Error::Mechanism { key, .. }
            | patterns::Error::Input { key, .. } => key.clone(),
            _ => return error.into(),
        };
        // The key itself, or the nearest one around or inside it.
        let around = (0..=key.len())
            .rev()
            .filter(|&end| end == key.len() || key[end..].starts_with('.'))
            .find_map(|end| self.origins.get(&key[..end]));
        let inside = || self.origins.iter().find(|(k, _)| k.starts_with(&format!("{key}.")));
        match around.or_else(|| inside().map(|(_, origin)| origin)) {
            Some(origin) => anyhow::Error::from(error).context(origin.clone()),
            None => error.into(),
        }
    }

    /// Remembers the line of each key of `[config]`, found by its spelling at the start of a line.
    fn note_lines(&mut self, text: &str, path: &Path) {
        let mut keys = Vec::new();
        collect_keys(&self.config, "", &mut keys);
        for key in keys {
            let last = key.rsplit('.').next().unwrap_or(&key).to_owned();
            let line = text.lines().position(|line| {
                let bare = line.trim_start().trim_start_matches(['"', '\'', '{', ' ', '[']);
                let bare = bare.strip_prefix("config.").unwrap_or(bare);
                bare.strip_prefix(&last).is_some_and(|rest| {
                    rest.trim_start_matches(['"', '\''])
                        .trim_start()
                        .starts_with(['=', ':', '.', ']'])
                })
            });
            if let Some(line) = line {
                let origin = format!("{}:{}", path.display(), line + 1);
                self.origins.insert(key, origin);
            }
        }
    }
}

fn collect_keys(table: &Table, prefix: &str, keys: &mut Vec<String>) {
    for (name, value) in table {
        let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        if let Value::Table(inner) = value {
            collect_keys(inner, &key, keys);
        }
        keys.push(key);
    }
}

/// Parses a run or figure file.
///
/// # Errors
/// With file, line and column.
pub fn parse_toml(text: &str, path: &Path) -> Result<RunFile> {
    toml::from_str(text).with_context(|| format!("`{}` is not a run file", path.display()))
}

fn parse_manifest(text: &str, path: &Path) -> Result<RunFile> {
    let manifest = crate::manifest::Manifest::parse(text)
        .with_context(|| format!("`{}` is not a run.json", path.display()))?;
    Ok(RunFile {
        command: manifest.command,
        seed: manifest.seed,
        config: manifest.config,
        ..RunFile::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_makes_tables_and_parses_values() {
        let mut request = Request::new("rd", 0);
        request.set_text("kinetics.feed = 0.03").unwrap();
        request.set_text("name=spots").unwrap();
        assert_eq!(request.config["kinetics"]["feed"].as_float(), Some(0.03));
        assert_eq!(request.config["name"].as_str(), Some("spots"));
        assert!(request.set_text("feed").unwrap_err().to_string().contains("key=value"));
        assert!(request.set_text("name.x=1").unwrap_err().to_string().contains("not a table"));
    }

    #[test]
    fn errors_name_the_line_or_the_flag() {
        let mut request = Request::new("rd", 0);
        request.set("size", Value::Integer(0), "--size").unwrap();
        let error = request.locate(patterns::Error::range("size", 0.0, "[1, inf)"));
        assert_eq!(format!("{error:#}"), "--size: `size`: 0 is outside its range [1, inf)");
        request.config = "size = 4\n[kinetics]\nfeed = 2".parse().unwrap();
        request.origins.clear();
        request.note_lines("[config]\nsize = 4\n[config.kinetics]\nfeed = 2", Path::new("a.toml"));
        let error = request.locate(patterns::Error::range("kinetics.feed", 2.0, "[0, 1]"));
        assert!(format!("{error:#}").starts_with("a.toml:4: "), "{error:#}");
    }
}
