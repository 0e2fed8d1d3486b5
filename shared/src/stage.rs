//! The two halves of a recording.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Whether the object stands in the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// The scene before the object is put in.
    Background,
    /// The scene with the object.
    Object,
}

impl Stage {
    /// Both, in recording order.
    pub const BOTH: [Self; 2] = [Self::Background, Self::Object];

    /// The name in files and folders.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Background => "background",
            Self::Object => "object",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
