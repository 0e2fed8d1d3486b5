//! The method of the thesis.
pub(crate) mod hsl;

pub(crate) mod background;

pub(crate) mod threshold;

pub(crate) mod settings;

pub use settings::ThesisSettings;
