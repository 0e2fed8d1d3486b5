//! The configuration files: `config/projector.toml` and `config/pattern.toml`.
//!
//! Takes a file's text, gives checked settings. A key that is left out has the value of the shipped file; an
//! unknown key is an error with its line, because a misspelt key would otherwise change nothing quietly.

use std::{
    fs,
    num::NonZero,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize, de::DeserializeOwned};
use shared::{
    pattern::{Grid, GridSettings, PatternError, Rgb},
    protocol::{DEFAULT_PORT, View},
};
use thiserror::Error;

use crate::{control::OnControllerLost, screen::WhenOperator};

/// Why a configuration file is not accepted.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// It cannot be read.
    #[error("cannot read {path}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// It is not TOML, or a key or value is wrong; the source tells the line.
    #[error("error in {path}")]
    Parse {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        source: Box<toml::de::Error>,
    },
    /// The values do not make a grid.
    #[error("error in {path}")]
    Grid {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: PatternError,
    },
}

/// The contents of `projector.toml`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// How commands are taken.
    pub control: ControlTable,
    /// Where and how pictures are shown.
    pub screen: ScreenTable,
    /// The operator's window.
    pub operator: OperatorTable,
}

/// The table `[control]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ControlTable {
    /// Address and port to listen on.
    pub listen: String,
    /// Most connections at a time.
    pub max_connections: NonZero<u16>,
    /// Messages that may wait for one client.
    pub queue_messages: NonZero<u16>,
    /// What happens when the controller's connection ends.
    pub on_controller_lost: OnControllerLost,
}

impl Default for ControlTable {
    fn default() -> Self {
        Self {
            listen: format!("127.0.0.1:{DEFAULT_PORT}"),
            max_connections: NonZero::<u16>::MIN.saturating_add(7),
            queue_messages: NonZero::<u16>::MIN.saturating_add(63),
            on_controller_lost: OnControllerLost::default(),
        }
    }
}

/// The table `[screen]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ScreenTable {
    /// Name of the monitor; empty for the one that is not primary.
    pub name: String,
    /// After how many refreshes a picture is taken as certainly shown.
    pub hold_refreshes: NonZero<u8>,
    /// What is shown at the start.
    pub start: StartView,
}

impl Default for ScreenTable {
    fn default() -> Self {
        let hold_refreshes = NonZero::<u8>::MIN.saturating_add(3);
        Self {
            name: String::new(),
            hold_refreshes,
            start: StartView::default(),
        }
    }
}

/// The table `[operator]`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OperatorTable {
    /// Whether the window opens by itself.
    pub window: WhenOperator,
}

/// What is shown before anybody asks for something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartView {
    /// The card with the screen's name.
    #[default]
    Identify,
    /// Nothing.
    Black,
    /// The coded grid.
    Coded,
}

impl From<StartView> for View {
    fn from(start: StartView) -> Self {
        match start {
            StartView::Identify => Self::Identify,
            StartView::Black => Self::Black,
            StartView::Coded => Self::Coded,
        }
    }
}

/// The contents of `pattern.toml`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
struct PatternTable {
    rows: usize,
    columns: usize,
    row_width_px: u32,
    column_width_px: u32,
    colours: Vec<Rgb>,
    unary: Rgb,
}

impl Config {
    /// Reads a file in the form of `config/projector.toml`.
    ///
    /// # Errors
    /// The file cannot be read, or a key or value in it is wrong.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        parse(&read(path)?, path)
    }
}

/// Reads a file in the form of `config/pattern.toml`.
///
/// # Errors
/// The file cannot be read, a key or value in it is wrong, or no grid has these values.
pub fn read_grid(path: &Path) -> Result<GridSettings, ConfigError> {
    grid(&read(path)?, path)
}

fn read(path: &Path) -> Result<String, ConfigError> {
    fs::read_to_string(path).map_err(|source| ConfigError::Read {
        path: path.to_owned(),
        source,
    })
}

fn parse<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, ConfigError> {
    toml::from_str(text).map_err(|error| ConfigError::Parse {
        path: path.to_owned(),
        source: Box::new(error),
    })
}

fn grid(text: &str, path: &Path) -> Result<GridSettings, ConfigError> {
    let PatternTable {
        rows,
        columns,
        row_width_px,
        column_width_px,
        colours,
        unary,
    } = parse(text, path)?;
    Grid::coded(rows, columns, row_width_px, column_width_px, &colours)
        .map(|coded| GridSettings { coded, unary })
        .map_err(|source| ConfigError::Grid {
            path: path.to_owned(),
            source,
        })
}

/// The grid of the shipped `config/pattern.toml`, which is compiled in.
///
/// # Errors
/// Never, as a test reads the shipped file.
pub fn shipped_grid() -> Result<GridSettings, ConfigError> {
    grid(
        include_str!("../../config/pattern.toml"),
        Path::new("config/pattern.toml"),
    )
}

/// The shipped `config/projector.toml`, which is compiled in.
///
/// # Errors
/// Never, as a test reads the shipped file.
pub fn shipped_config() -> Result<Config, ConfigError> {
    parse(
        include_str!("../../config/projector.toml"),
        Path::new("config/projector.toml"),
    )
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{Config, grid, parse, shipped_config, shipped_grid};

    #[test]
    fn the_shipped_file_holds_every_key_with_its_default() {
        let shipped = shipped_config().unwrap();
        assert_eq!(shipped, Config::default());
        let written: toml::Table =
            toml::from_str(include_str!("../../config/projector.toml")).unwrap();
        assert_eq!(written, toml::Table::try_from(&shipped).unwrap());
    }

    #[test]
    fn the_shipped_grid_is_the_default_grid() {
        assert_eq!(
            shipped_grid().unwrap(),
            shared::pattern::GridSettings::default()
        );
    }

    #[test]
    fn an_unknown_key_is_refused_with_file_and_line() {
        let text = "[control]\nlisten = \"0.0.0.0:1\"\nmax_conections = 3\n";
        let error = parse::<Config>(text, Path::new("my.toml")).unwrap_err();
        let error = format!("{:#}", anyhow::Error::from(error));
        assert!(
            error.contains("my.toml") && error.contains("line 3"),
            "{error}"
        );
        assert!(error.contains("max_conections"), "{error}");
    }

    #[test]
    fn values_out_of_range_are_refused() {
        for text in [
            "[control]\nmax_connections = 0",
            "[screen]\nhold_refreshes = 0",
            "[screen]\nstart = 3",
        ] {
            assert!(
                parse::<Config>(text, Path::new("my.toml")).is_err(),
                "{text}"
            );
        }
        let lines = "rows = 16\ncolumns = 15\nrow_width_px = 6\ncolumn_width_px = 6\n\
                     colours = [\"#ff0000\"]\nunary = \"#ffffff\"";
        let error = grid(lines, Path::new("my.toml")).unwrap_err();
        let error = format!("{:#}", anyhow::Error::from(error));
        assert!(
            error.contains("my.toml") && error.contains("16 lines"),
            "{error}"
        );
    }
}
