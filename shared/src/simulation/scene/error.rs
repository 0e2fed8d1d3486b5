//! What can be wrong with a scene.

use std::path::PathBuf;

use thiserror::Error;

/// Why a scene can't be used: which file, where in it, what to do.
#[derive(Debug, Error)]
pub enum SceneError {
    /// A file can't be read.
    #[error("the file {path} of a simulated scene can't be read: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// It is not TOML, or has an unknown key or a value out of range.
    #[error("{scene}: {source}")]
    Toml {
        /// The scene file.
        scene: String,
        /// The reason, with line and column.
        source: Box<toml::de::Error>,
    },
    /// The scene file is well formed and makes no sense.
    #[error("{scene}, line {line}: {fault}")]
    Sense {
        /// The scene file.
        scene: String,
        /// The line where the part begins, from 1.
        line: usize,
        /// What is wrong and what to do.
        fault: String,
    },
    /// A mesh file, or a mesh in the scene file, can't be used.
    #[error("mesh {mesh}: {fault}")]
    Mesh {
        /// The file, or the solid's name.
        mesh: String,
        /// What is wrong, with the line where there is one.
        fault: String,
    },
    /// A picture of a surface can't be read.
    #[error("the picture {path} of a surface can't be read: {source}")]
    Picture {
        /// The file.
        path: PathBuf,
        /// The decoder's reason.
        source: image::ImageError,
    },
}
