//! The conditions of the simulation sweep, from `tests/measured/sweep.toml`: a shipped scene with some keys changed,
//! a grid, and how often each picture is taken.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, bail};
use serde::Deserialize;
use shared::{
    pattern::{Grid, GridSettings, Rgb},
    simulation::Scene,
};
use toml::{Table, Value};

use super::simulated::Repeats;

/// The sweep's file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Groups of conditions that vary one thing.
    pub groups: Vec<Group>,
}

/// Conditions that vary one thing.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// What is varied.
    pub name: String,
    /// The shipped scenes that it is varied in.
    pub scenes: Vec<String>,
    /// Keys of the scene that all of its conditions change.
    #[serde(default)]
    pub set: Table,
    /// The values.
    pub conditions: Vec<Condition>,
}

/// One value of what is varied.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// The value, for people.
    pub name: String,
    /// Keys of the scene and their values: `camera.blur_px`, or `solids.NAME.key`.
    #[serde(default)]
    pub set: Table,
    /// Keys of the pattern and their values, as in `config/pattern.toml`.
    #[serde(default)]
    pub pattern: Table,
    /// How often the references are taken, if not as usual.
    pub references: Option<usize>,
    /// How often the coded grid is taken, if not as usual.
    pub coded: Option<usize>,
    /// How often the single-colour grid is taken, if not as usual.
    pub unary: Option<usize>,
    /// Whether the short sweep has it too.
    #[serde(default)]
    pub quick: bool,
}

impl Sweep {
    /// Reads the sweep that the repository holds.
    ///
    /// # Errors
    /// A file that can't be read or has an unknown key.
    pub fn shipped() -> anyhow::Result<Self> {
        let path = in_repository("tests/measured/sweep.toml");
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        toml::from_str(&text).with_context(|| path.display().to_string())
    }
}

impl Condition {
    /// The shipped scene `name` with the changed keys.
    ///
    /// # Errors
    /// A scene that can't be read, or a change that it can't take.
    pub fn scene(&self, name: &str, common: &Table) -> anyhow::Result<Scene> {
        let folder = in_repository("config/scenes");
        let text = fs::read_to_string(folder.join(name).with_extension("toml"))?;
        let mut scene: Table = toml::from_str(&text)?;
        for (key, value) in common.iter().chain(&self.set) {
            change(&mut scene, key, value).with_context(|| format!("{name}: {key}"))?;
        }
        Ok(Scene::parse(&toml::to_string(&scene)?, &folder)?)
    }

    /// The grid: that of `config/pattern.toml` with the changed keys.
    ///
    /// # Errors
    /// A pattern that there is none of.
    pub fn grid(&self) -> anyhow::Result<GridSettings> {
        let mut pattern = Table::try_from(GridSettings::default())?;
        let explicit = |key: &str| self.pattern.contains_key(key);
        if explicit("row_symbols") || explicit("column_symbols") {
            pattern.remove("rows");
            pattern.remove("columns");
        }
        pattern.extend(self.pattern.clone());
        let unary: Rgb = pattern
            .remove("unary")
            .context("no unary colour")?
            .try_into()?;
        let coded: Grid = pattern.try_into()?;
        Ok(GridSettings { coded, unary })
    }

    /// How often each picture is taken.
    #[must_use]
    pub fn repeats(&self) -> Repeats {
        let usual = Repeats::default();
        Repeats {
            references: self.references.unwrap_or(usual.references),
            coded: self.coded.unwrap_or(usual.coded),
            unary: self.unary.unwrap_or(usual.unary),
        }
    }
}

/// The files of the shipped scenes, sorted by name.
///
/// # Errors
/// A folder that can't be read.
pub fn shipped_scenes() -> anyhow::Result<Vec<PathBuf>> {
    let mut scenes = Vec::new();
    for entry in fs::read_dir(in_repository("config/scenes"))? {
        let path = entry?.path();
        if path.extension().is_some_and(|end| end == "toml") {
            scenes.push(path);
        }
    }
    scenes.sort();
    Ok(scenes)
}

/// A path from the repository's root.
#[must_use]
pub fn in_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// Sets the key at a dotted path; a part that meets a list picks the entry of that name.
fn change(at: &mut Table, path: &str, value: &Value) -> anyhow::Result<()> {
    let Some((first, rest)) = path.split_once('.') else {
        at.insert(path.to_owned(), value.clone());
        return Ok(());
    };
    match at.get_mut(first) {
        Some(Value::Table(table)) => change(table, rest, value),
        Some(Value::Array(entries)) => {
            let (name, rest) = rest.split_once('.').context("an entry, then a key")?;
            let is_it =
                |entry: &&mut Value| entry.get("name").and_then(Value::as_str) == Some(name);
            let entry = entries.iter_mut().find(is_it);
            let entry = entry.and_then(Value::as_table_mut);
            change(entry.context("no entry of this name")?, rest, value)
        }
        _ => bail!("no table {first:?}"),
    }
}
