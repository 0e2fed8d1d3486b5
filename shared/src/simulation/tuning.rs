//! What a camera's controls make of its light, against the settings of the scene file.

use std::time::Duration;

use super::scene::Scene;

/// Settings of a simulated camera for one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraTuning {
    /// How long each row gathers light; twice the scene's time is twice the light.
    pub exposure: Duration,
    /// Amplification after the sensor, above 0: of signal and noise alike; 1 is the scene's.
    pub gain: f32,
    /// Gains of red, green and blue besides the scene's own, above 0.
    pub white_balance: [f32; 3],
}

impl CameraTuning {
    /// The settings of the scene file itself.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        Self {
            exposure: scene.exposure(),
            gain: 1.0,
            white_balance: [1.0; 3],
        }
    }

    /// Amplification of each colour after the sensor.
    pub(super) fn gains(&self) -> [f32; 3] {
        self.white_balance.map(|balance| balance * self.gain)
    }
}
