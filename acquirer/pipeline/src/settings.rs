//! The pipeline's settings: one table per stage, named after the stage.

use serde::{Deserialize, Serialize};

use super::{
    Method, colours::ColourSettings, crossings::CrossingSettings, gain::GainSettings,
    grid::DecodeSettings, lines::LineSettings, reference::ReferenceSettings,
    response::ResponseSettings, thesis::ThesisSettings,
};

/// All settings of the pipeline. In TOML each field that is a struct is a table of its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PipelineSettings {
    /// Which reading method is used: `likelihood` (ours) or `thesis` (2001).
    pub method: Method,
    /// Whether the stages' products are kept as pictures for the report.
    pub pictures: bool,
    /// Light from camera bytes.
    pub response: ResponseSettings,
    /// Black and white references, noise.
    pub reference: ReferenceSettings,
    /// The gain image.
    pub gain: GainSettings,
    /// Line middles.
    pub lines: LineSettings,
    /// Crossings.
    pub crossings: CrossingSettings,
    /// Colour evidence.
    pub colours: ColourSettings,
    /// Linking and decoding.
    pub grid: DecodeSettings,
    /// The thesis's method, which has these settings alone.
    pub thesis: ThesisSettings,
}

impl Default for PipelineSettings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            pictures: true,
            response: ResponseSettings::default(),
            reference: ReferenceSettings::default(),
            gain: GainSettings::default(),
            lines: LineSettings::default(),
            crossings: CrossingSettings::default(),
            colours: ColourSettings::default(),
            grid: DecodeSettings::default(),
            thesis: ThesisSettings::default(),
        }
    }
}

impl PipelineSettings {
    /// For frame after frame as they come: no pictures, every second sample along the lines, half the colour samples.
    #[must_use]
    pub fn live() -> Self {
        let settings = Self::default();
        Self {
            pictures: false,
            lines: LineSettings {
                step_px: 2,
                ..settings.lines
            },
            colours: ColourSettings {
                samples: 4,
                ..settings.colours
            },
            ..settings
        }
    }
}
