//! The acquirer: looks at the projected grid through a camera and gives the object's shape.

pub mod camera;
pub mod clock;
