//! The camera's response in the summary: which curve was used, and how well it was measured.

use serde::Serialize;

use super::summary::rounded;
use crate::pipeline::{
    Method,
    response::{KNOTS, ResponseCurve, ResponseSettings},
    result::ScanResult,
};

/// Where the curve from bytes to light comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CurveSource {
    /// The sRGB curve, for want of a measurement, or because it is as good as what was measured.
    Srgb,
    /// A power law of the settings.
    Power,
    /// A curve of the settings.
    Given,
    /// Measured with this scan's solid colours.
    Measured,
}

impl CurveSource {
    /// What it is, in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Srgb => "the sRGB curve",
            Self::Power => "a power law, from the settings",
            Self::Given => "a given curve, from the settings",
            Self::Measured => "measured with solid colours",
        }
    }
}

/// The curve from bytes to light that a scan was read with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResponseFigures {
    /// Where it comes from.
    pub curve: CurveSource,
    /// Linear light of the bytes 255 k / 16, 0 to 1.
    pub light: [f64; KNOTS],
    /// By how much the solid colours miss adding up, root mean square, byte values; when it was measured.
    pub residual_levels: Option<f64>,
    /// The same with the sRGB curve.
    pub srgb_residual_levels: Option<f64>,
    /// Light of white over that of the three primaries together; above 1 the projector brightens white.
    pub white_over_primaries: Option<f64>,
    /// Why the solid colours gave no curve, if they did not.
    pub not_measured: Option<String>,
}

impl ResponseFigures {
    /// The response of a result; `None` when its method or its settings know none.
    #[must_use]
    pub fn of(result: &ScanResult) -> Option<Self> {
        if result.method != Method::Likelihood {
            return None;
        }
        let settings = result.settings.get("response")?.clone();
        let settings: ResponseSettings = serde_json::from_value(settings).ok()?;
        let measured = result.response.as_ref().and_then(|r| r.as_ref().ok());
        let (curve, light) = match (settings.power(), settings.curve) {
            (Some(gamma), _) => {
                let power = |k: usize| (k as f64 / (KNOTS - 1) as f64).powf(gamma);
                (CurveSource::Power, std::array::from_fn(power))
            }
            (None, None) => (CurveSource::Srgb, ResponseCurve::srgb().knots()),
            (None, Some(curve)) if measured.is_some() => (CurveSource::Measured, curve.knots()),
            (None, Some(curve)) => (CurveSource::Given, curve.knots()),
        };
        let refused = result.response.as_ref().and_then(|r| r.as_ref().err());
        Some(Self {
            curve,
            light: light.map(rounded),
            residual_levels: measured.map(|m| rounded(m.residual_levels)),
            srgb_residual_levels: measured.map(|m| rounded(m.srgb_residual_levels)),
            white_over_primaries: measured.map(|m| rounded(m.white_over_primaries)),
            not_measured: refused.map(ToString::to_string),
        })
    }
}
