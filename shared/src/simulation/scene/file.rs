//! The tables of a scene file, one type per table; `config/scenes/cube.toml` explains every key.

use serde::Deserialize;
use toml::Spanned;

use super::checked;
use crate::pattern::Rgb;

/// A whole scene file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    pub(super) title: String,
    #[serde(default)]
    pub(super) seed: u64,
    pub(super) camera: Spanned<CameraTable>,
    pub(super) projector: Spanned<ProjectorTable>,
    #[serde(default)]
    pub(super) ambient: AmbientTable,
    #[serde(default)]
    pub(super) solids: Vec<Spanned<SolidTable>>,
}

/// `[camera]`: where it stands, its lens, its sensor and its clock.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::simulation) struct CameraTable {
    #[serde(deserialize_with = "checked::side")]
    pub(in crate::simulation) width: u32,
    #[serde(deserialize_with = "checked::side")]
    pub(in crate::simulation) height: u32,
    #[serde(deserialize_with = "checked::positive_array")]
    pub(in crate::simulation) focal_px: [f64; 2],
    #[serde(deserialize_with = "checked::finite_array")]
    pub(in crate::simulation) centre_px: [f64; 2],
    #[serde(default, deserialize_with = "checked::finite_array")]
    pub(in crate::simulation) distortion: [f64; 5],
    #[serde(deserialize_with = "checked::finite_array")]
    pub(in crate::simulation) position_mm: [f64; 3],
    #[serde(deserialize_with = "checked::finite_array")]
    pub(in crate::simulation) looks_at_mm: [f64; 3],
    #[serde(default, deserialize_with = "checked::finite")]
    pub(in crate::simulation) roll_deg: f64,
    #[serde(default = "one", deserialize_with = "checked::positive")]
    pub(in crate::simulation) exposure: f64,
    #[serde(default = "ones", deserialize_with = "checked::positive_array")]
    pub(in crate::simulation) white_balance: [f64; 3],
    #[serde(default = "no_mixing", deserialize_with = "checked::mixing")]
    pub(in crate::simulation) crosstalk: [[f64; 3]; 3],
    #[serde(default, deserialize_with = "checked::blur")]
    pub(in crate::simulation) blur_px: f64,
    #[serde(default)]
    pub(in crate::simulation) bayer: bool,
    #[serde(default, deserialize_with = "checked::non_negative")]
    pub(in crate::simulation) full_well_electrons: f64,
    #[serde(default, deserialize_with = "checked::non_negative")]
    pub(in crate::simulation) read_noise_electrons: f64,
    #[serde(default)]
    pub(in crate::simulation) tone_curve: ToneCurve,
    #[serde(default, deserialize_with = "checked::quality")]
    pub(in crate::simulation) jpeg_quality: u8,
    #[serde(default = "thirty", deserialize_with = "checked::positive")]
    pub(in crate::simulation) frame_rate_hz: f64,
    #[serde(default = "ten", deserialize_with = "checked::positive")]
    pub(in crate::simulation) exposure_ms: f64,
    #[serde(default, deserialize_with = "checked::non_negative")]
    pub(in crate::simulation) readout_ms: f64,
}

/// How the camera codes linear light in 8 bits.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(in crate::simulation) enum ToneCurve {
    /// The curve of IEC 61966-2-1, as webcams use it.
    #[default]
    Srgb,
    /// Proportional to light, as laboratory cameras do.
    Linear,
    /// The root of this degree, 0.2 to 5.
    Power(#[serde(deserialize_with = "checked::exponent")] f64),
    /// The sRGB curve made steeper in the middle and flatter at both ends, as the picture modes of webcams do: a byte
    /// b, 0 to 1, becomes b - strength sin(2 pi b) / (2 pi); 0 changes nothing, 0.95 is the most.
    Contrast(#[serde(deserialize_with = "checked::contrast")] f64),
}

/// `[projector]`: where it stands, its lens, its light and its delay.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::simulation) struct ProjectorTable {
    #[serde(deserialize_with = "checked::side")]
    pub(in crate::simulation) width: u32,
    #[serde(deserialize_with = "checked::side")]
    pub(in crate::simulation) height: u32,
    #[serde(deserialize_with = "checked::positive_array")]
    pub(in crate::simulation) focal_px: [f64; 2],
    #[serde(deserialize_with = "checked::finite_array")]
    pub(in crate::simulation) centre_px: [f64; 2],
    #[serde(default, deserialize_with = "checked::finite_array")]
    pub(in crate::simulation) distortion: [f64; 5],
    #[serde(deserialize_with = "checked::finite_array")]
    pub(in crate::simulation) position_mm: [f64; 3],
    #[serde(deserialize_with = "checked::finite_array")]
    pub(in crate::simulation) looks_at_mm: [f64; 3],
    #[serde(default, deserialize_with = "checked::finite")]
    pub(in crate::simulation) roll_deg: f64,
    #[serde(default = "one", deserialize_with = "checked::positive")]
    pub(in crate::simulation) gamma: f64,
    #[serde(default, deserialize_with = "checked::fraction")]
    pub(in crate::simulation) black_level: f64,
    #[serde(default, deserialize_with = "checked::blur")]
    pub(in crate::simulation) blur_px: f64,
    #[serde(default, deserialize_with = "checked::fraction")]
    pub(in crate::simulation) vignetting: f64,
    #[serde(default, deserialize_with = "checked::shifts")]
    pub(in crate::simulation) convergence_px: [[f64; 2]; 3],
    #[serde(default, deserialize_with = "checked::non_negative")]
    pub(in crate::simulation) display_latency_ms: f64,
    #[serde(default, deserialize_with = "checked::non_negative")]
    pub(in crate::simulation) display_jitter_ms: f64,
}

/// `[ambient]`: the light that does not come from the projector.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::simulation) struct AmbientTable {
    #[serde(default, deserialize_with = "checked::non_negative")]
    pub(in crate::simulation) level: f64,
    #[serde(default = "white")]
    pub(in crate::simulation) colour: Rgb,
    #[serde(default, deserialize_with = "checked::fraction")]
    pub(in crate::simulation) from_above: f64,
}

impl Default for AmbientTable {
    fn default() -> Self {
        Self {
            level: 0.0,
            colour: white(),
            from_above: 0.0,
        }
    }
}

/// `[[solids]]`: one thing in the room.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SolidTable {
    pub(super) name: String,
    #[serde(default)]
    pub(super) when: When,
    #[serde(default, deserialize_with = "checked::finite_array")]
    pub(super) position_mm: [f64; 3],
    #[serde(default, deserialize_with = "checked::finite_array")]
    pub(super) rotation_deg: [f64; 3],
    #[serde(default)]
    pub(super) surface: SurfaceTable,
    pub(super) plane: Option<PlaneTable>,
    #[serde(rename = "box")]
    pub(super) cuboid: Option<BoxTable>,
    pub(super) cylinder: Option<CylinderTable>,
    pub(super) sphere: Option<SphereTable>,
    pub(super) ellipsoid: Option<EllipsoidTable>,
    pub(super) mesh: Option<MeshTable>,
}

/// In which of the two states of the scene a solid is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(in crate::simulation) enum When {
    /// Before and after.
    #[default]
    Always,
    /// Only after: it is (part of) the object.
    Object,
}

/// `plane`: a rectangle in its own x and y, its centre at the position.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlaneTable {
    #[serde(deserialize_with = "checked::positive_array")]
    pub(super) size_mm: [f64; 2],
}

/// `box`: a cuboid, its centre at the position.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxTable {
    #[serde(deserialize_with = "checked::positive_array")]
    pub(super) size_mm: [f64; 3],
}

/// `cylinder`: closed, its axis along its own y.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CylinderTable {
    #[serde(deserialize_with = "checked::positive")]
    pub(super) radius_mm: f64,
    #[serde(deserialize_with = "checked::positive")]
    pub(super) height_mm: f64,
}

/// `sphere`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereTable {
    #[serde(deserialize_with = "checked::positive")]
    pub(super) radius_mm: f64,
}

/// `ellipsoid`: half axes along its own x, y and z.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EllipsoidTable {
    #[serde(deserialize_with = "checked::positive_array")]
    pub(super) radii_mm: [f64; 3],
}

/// `mesh`: triangles from a file, or from `vertices_mm` and `faces`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshTable {
    pub(super) file: Option<String>,
    #[serde(default)]
    pub(super) vertices_mm: Vec<[f64; 3]>,
    #[serde(default)]
    pub(super) faces: Vec<[u32; 3]>,
    #[serde(default = "one", deserialize_with = "checked::positive")]
    pub(super) scale: f64,
    #[serde(default)]
    pub(super) smooth: bool,
}

/// `surface`: what a solid looks like.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SurfaceTable {
    #[serde(default = "light_grey")]
    pub(super) colour: Rgb,
    #[serde(default, deserialize_with = "checked::fraction")]
    pub(super) gloss: f64,
    #[serde(default = "thirty", deserialize_with = "checked::positive")]
    pub(super) gloss_exponent: f64,
    pub(super) checker: Option<CheckerTable>,
    pub(super) stripes: Option<StripesTable>,
    pub(super) patches: Option<PatchesTable>,
    pub(super) noise: Option<NoiseTable>,
    pub(super) picture: Option<PictureTable>,
}

impl Default for SurfaceTable {
    fn default() -> Self {
        Self {
            colour: light_grey(),
            gloss: 0.0,
            gloss_exponent: thirty(),
            checker: None,
            stripes: None,
            patches: None,
            noise: None,
            picture: None,
        }
    }
}

/// `checker`: cubes of two colours in turn.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CheckerTable {
    pub(super) colour: Rgb,
    #[serde(deserialize_with = "checked::positive")]
    pub(super) size_mm: f64,
}

/// `stripes`: layers of two colours in turn, across a direction.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StripesTable {
    pub(super) colour: Rgb,
    #[serde(deserialize_with = "checked::positive")]
    pub(super) width_mm: f64,
    #[serde(default = "along_x", deserialize_with = "checked::finite_array")]
    pub(super) across: [f64; 3],
}

/// `patches`: irregular cells of colours drawn from a list, with a seam in the surface's own colour.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PatchesTable {
    pub(super) colours: Vec<Rgb>,
    #[serde(deserialize_with = "checked::positive")]
    pub(super) size_mm: f64,
    #[serde(default, deserialize_with = "checked::non_negative")]
    pub(super) seam_mm: f64,
}

/// `noise`: a cloudy mixture of two colours.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NoiseTable {
    pub(super) colour: Rgb,
    #[serde(deserialize_with = "checked::positive")]
    pub(super) size_mm: f64,
}

/// `picture`: an image laid on the solid's own x and y, its middle at the solid's.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PictureTable {
    pub(super) file: String,
    #[serde(deserialize_with = "checked::positive")]
    pub(super) width_mm: f64,
}

fn one() -> f64 {
    1.0
}

fn ones() -> [f64; 3] {
    [1.0; 3]
}

fn ten() -> f64 {
    10.0
}

fn thirty() -> f64 {
    30.0
}

fn along_x() -> [f64; 3] {
    [1.0, 0.0, 0.0]
}

fn no_mixing() -> [[f64; 3]; 3] {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
}

fn white() -> Rgb {
    Rgb::WHITE
}

fn light_grey() -> Rgb {
    Rgb([0xcc; 3])
}
