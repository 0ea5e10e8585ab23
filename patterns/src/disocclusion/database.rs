//! The classes that the program carries: `database/classes/*.toml`.

use super::class::Class;
use crate::{Error, Inputs, NoInputs, Result};

macro_rules! entries {
    ($($name:literal),* $(,)?) => {
        &[$((concat!($name, ".toml"),
             include_str!(concat!("../../database/classes/", $name, ".toml")))),*]
    };
}

/// File name and text of every class, those matched by statistics first.
pub const BUILT_IN: &[(&str, &str)] = entries![
    "turing-spots",
    "turing-labyrinth",
    "turing-stripes",
    "gray-scott-kappa",
    "gray-scott-delta",
    "gray-scott-pi",
    "gray-scott-lambda",
    "gray-scott-mu",
    "gray-scott-nu",
    "gray-scott-epsilon",
    "schnakenberg-spots",
    "schnakenberg-worms",
    "fitzhugh-nagumo-labyrinth",
    "gierer-meinhardt-spots",
    "gierer-meinhardt-stripes",
    "gierer-meinhardt-holes",
    "brusselator-spots",
    "swift-hohenberg-rolls",
    "swift-hohenberg-spots",
    "meinhardt-patches",
    "topology-row-a",
    "topology-row-b",
    "topology-row-c",
    "topology-row-d",
    "topology-row-e",
    "topology-row-f",
    "topology-row-g",
    "topology-row-h",
    "topology-row-i",
    "topology-row-j",
    "topology-row-k",
    "topology-row-l",
    "topology-row-m",
    "topology-row-n",
    "topology-row-p",
    "topology-row-q",
];

/// The classes that are compared with a picture.
#[derive(Clone, Default)]
pub struct Database {
    /// In the order in which they were added; names are unique.
    pub classes: Vec<Class>,
}

impl Database {
    /// The classes that the program carries.
    ///
    /// # Errors
    /// [`Error::Config`] with the file's name and the key that is wrong.
    pub fn built_in() -> Result<Self> {
        let mut database = Self::default();
        for (file, text) in BUILT_IN {
            database.add(file, text, &NoInputs)?;
        }
        Ok(database)
    }

    /// Adds the class that `text`, the content of `file`, describes.
    ///
    /// # Errors
    /// [`Error::Config`] with the file's name and the key that is wrong; a name that is
    /// there already.
    pub fn add(&mut self, file: &str, text: &str, inputs: &dyn Inputs) -> Result<&Class> {
        let named = |error| match error {
            Error::Config { key, reason } => {
                Error::Config { key: format!("{file}: {key}"), reason }
            }
            other => other,
        };
        let class = Class::parse(text, inputs).map_err(named)?;
        if self.find(&class.name).is_some() {
            let reason = format!("`{}` is in the database already", class.name);
            return Err(named(Error::config("name", reason)));
        }
        self.classes.push(class);
        Ok(&self.classes[self.classes.len() - 1])
    }

    /// The class of that name.
    pub fn find(&self, name: &str) -> Option<&Class> {
        self.classes.iter().find(|class| class.name == name)
    }
}
