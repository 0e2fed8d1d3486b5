//! What the projector shows during a capture, and the word for it in files.

use serde::{Deserialize, Serialize};
use shared::pattern::{PatternError, Rgb};

/// What the projector showed during a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Shows {
    /// Black.
    Black,
    /// White.
    White,
    /// The coded grid.
    Prmvs,
    /// The single-colour grid.
    Unary,
    /// A solid colour.
    Solid(Rgb),
}

impl Shows {
    /// The four kinds of a full recording, in recording order.
    pub const RECORDING: [Self; 4] = [Self::Black, Self::White, Self::Prmvs, Self::Unary];

    /// The word in file names: the kind, or the colour's six digits.
    #[must_use]
    pub fn stem(self) -> String {
        String::from(self).trim_start_matches('#').to_owned()
    }
}

impl From<Shows> for String {
    fn from(shows: Shows) -> Self {
        match shows {
            Shows::Black => "black".into(),
            Shows::White => "white".into(),
            Shows::Prmvs => "prmvs".into(),
            Shows::Unary => "unary".into(),
            Shows::Solid(colour) => colour.to_string(),
        }
    }
}

impl TryFrom<String> for Shows {
    type Error = PatternError;

    fn try_from(text: String) -> Result<Self, PatternError> {
        Ok(match text.as_str() {
            "black" => Self::Black,
            "white" => Self::White,
            "prmvs" => Self::Prmvs,
            "unary" => Self::Unary,
            colour => Self::Solid(colour.parse()?),
        })
    }
}
