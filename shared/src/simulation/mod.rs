//! A room in software: a scene and what the projector shows give the frames that a camera takes, with the truth.
//!
//! Everything is a function of its arguments: no clock, no random state; the same scene, picture and frame number
//! give the same bytes.
//!
//! # Conventions
//! - Positions on rasters are edge coordinates, lengths millimetres, y points down; as in [`crate::geometry`].
//! - Light is linear; 1 is the projector's white on a white surface that faces it at the distance of the point it
//!   looks at.
//! - The scene has two states, the stages of a scan: without the object and with it.

mod random;

mod tone;

mod scene;

mod surface;

mod solid;

mod light;

mod flicker;

mod scaler;

mod timeline;

mod space;

mod room;

mod room_camera;

mod sensor;

mod tuning;

mod truth;

mod line_truth;

pub use light::ProjectedLight;
pub use line_truth::LineSample;
pub use room::Room;
pub use room_camera::RoomCamera;
pub use scene::{Scene, SceneError};
pub use space::Space;
pub use timeline::Timeline;
pub use truth::{TruthVertex, write_truth_csv};
pub use tuning::CameraTuning;
