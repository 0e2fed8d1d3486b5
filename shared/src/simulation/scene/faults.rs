//! `[faults]`: what goes wrong in a simulated room on purpose; without it nothing does.

use serde::Deserialize;

use super::checked;
use crate::pattern::Rgb;

/// `[faults]`, every key with nothing wrong as its default; `config/scenes/cube.toml` explains them.
#[derive(Debug, Clone, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(in crate::simulation) struct FaultsTable {
    #[serde(deserialize_with = "checked::fraction")]
    pub(in crate::simulation) lamp_flicker: f64,
    #[serde(deserialize_with = "checked::positive")]
    pub(in crate::simulation) lamp_flicker_hz: f64,
    #[serde(deserialize_with = "checked::non_negative")]
    pub(in crate::simulation) colour_wheel_hz: f64,
    #[serde(deserialize_with = "checked::positive_array")]
    pub(in crate::simulation) picture_scale: [f64; 2],
    #[serde(deserialize_with = "checked::fraction")]
    pub(in crate::simulation) keystone: f64,
    pub(in crate::simulation) other_output: Option<Rgb>,
    pub(in crate::simulation) no_controls: bool,
    #[serde(deserialize_with = "checked::non_negative")]
    pub(in crate::simulation) delivered_rate_hz: f64,
    #[serde(deserialize_with = "checked::fraction")]
    pub(in crate::simulation) lost_share: f64,
}

impl Default for FaultsTable {
    fn default() -> Self {
        Self {
            lamp_flicker: 0.0,
            lamp_flicker_hz: 100.0,
            colour_wheel_hz: 0.0,
            picture_scale: [1.0, 1.0],
            keystone: 0.0,
            other_output: None,
            no_controls: false,
            delivered_rate_hz: 0.0,
            lost_share: 0.0,
        }
    }
}
