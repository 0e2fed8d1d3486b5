//! What can be set of the thesis's method; all have defaults that fit no scene in particular.

use serde::{Deserialize, Serialize};

/// Settings of the thesis's method, the table `[thesis]` of the configuration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ThesisSettings {
    /// A pixel is foreground when its hue or saturation lies this many standard deviations from the
    /// background's; 1 to 20.
    pub background_sigmas: f32,
}

impl Default for ThesisSettings {
    fn default() -> Self {
        Self {
            background_sigmas: 4.0,
        }
    }
}
