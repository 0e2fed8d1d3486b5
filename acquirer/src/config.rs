//! The acquirer's configuration file: one table per part of the program.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    camera::CameraSettings,
    pipeline::{Method, PipelineSettings, shift::ShiftSettings},
    session::{DoctorSettings, ExposureSettings, LatencySettings, RecordSettings},
};

/// Every setting of the acquirer; `config/acquirer.toml` explains each key and holds the built-in values.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// What is asked of the camera.
    pub camera: CameraSettings,
    /// How the camera's exposure is set.
    pub exposure: ExposureSettings,
    /// How the latency is measured.
    pub latency: LatencySettings,
    /// Up to where `acquirer doctor` calls things good.
    pub doctor: DoctorSettings,
    /// How often each picture of a recording is taken.
    pub record: RecordSettings,
    /// How captures are read.
    pub pipeline: PipelineSettings,
    /// How shifts become relative depth.
    pub shift: ShiftSettings,
}

/// Why a configuration file is not accepted.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file can't be read.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Not TOML, an unknown key, or a value of the wrong kind; the message names the line.
    #[error("{path}: {source}")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the line.
        source: Box<toml::de::Error>,
    },
}

impl Config {
    /// Reads a configuration file; without a path the built-in values hold.
    ///
    /// # Errors
    /// A file that can't be read, is not TOML, or has an unknown key or a value of the wrong kind.
    pub fn load(path: Option<&Path>) -> Result<Self, ConfigError> {
        let Some(path) = path else {
            return Ok(Self::default());
        };
        let text = fs::read_to_string(path).map_err(|source| ConfigError::File {
            path: path.to_owned(),
            source,
        })?;
        toml::from_str(&text).map_err(|source| ConfigError::Syntax {
            path: path.to_owned(),
            source: Box::new(source),
        })
    }

    /// Takes the method that the command line asks for, if it does.
    pub fn set_method(&mut self, method: Option<Method>) {
        self.pipeline.method = method.unwrap_or(self.pipeline.method);
    }
}
