//! The sixteen colours an operator can choose from.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::Rgb;

/// Number of colours in a palette, as in the thesis's projector window.
pub const PALETTE_SIZE: usize = 16;

/// Why a palette file is not accepted.
#[derive(Debug, Error)]
pub enum PaletteError {
    /// Not TOML, an unknown key, or a value of the wrong kind; the message names line and column.
    #[error("palette: {0}")]
    Syntax(#[from] toml::de::Error),
    /// Too few or too many colours.
    #[error("palette: {0} colours, but it must have exactly {PALETTE_SIZE}")]
    Count(usize),
    /// Two entries with one name or one colour.
    #[error("palette: {0:?} stands twice")]
    Twice(String),
}

/// A colour with the name the operator sees.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedColour {
    /// Name in the menus and in the report.
    pub name: String,
    /// Projector drive values.
    pub colour: Rgb,
}

/// Exactly sixteen different, named colours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Palette(Vec<NamedColour>);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PaletteFile {
    colours: Vec<NamedColour>,
}

impl Palette {
    /// Reads a palette in the form of `config/palettes/sixteen.toml`.
    ///
    /// # Errors
    /// [`PaletteError`], with the line where the text is at fault.
    pub fn from_toml(text: &str) -> Result<Self, PaletteError> {
        let PaletteFile { colours } = toml::from_str(text)?;
        if colours.len() != PALETTE_SIZE {
            return Err(PaletteError::Count(colours.len()));
        }
        for (k, a) in colours.iter().enumerate() {
            for b in &colours[..k] {
                if a.name == b.name || a.colour == b.colour {
                    return Err(PaletteError::Twice(a.name.clone()));
                }
            }
        }
        Ok(Self(colours))
    }

    /// The sixteen colours in menu order.
    #[must_use]
    pub fn colours(&self) -> &[NamedColour] {
        &self.0
    }

    /// The name of a colour, or its `#rrggbb` when the palette does not have it.
    #[must_use]
    pub fn name_of(&self, colour: Rgb) -> String {
        let entry = self.0.iter().find(|entry| entry.colour == colour);
        entry.map_or_else(|| colour.to_string(), |entry| entry.name.clone())
    }
}

impl Default for Palette {
    /// The palette that the product ships: `config/palettes/sixteen.toml`.
    fn default() -> Self {
        match Self::from_toml(include_str!("../../../config/palettes/sixteen.toml")) {
            Ok(palette) => palette,
            Err(error) => unreachable!("the shipped palette is valid: {error}"),
        }
    }
}
