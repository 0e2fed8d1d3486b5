//! The panels of the window, one file each.

pub(super) mod colours;
mod controls;
mod crossing;
mod histogram;
pub(super) mod live;
mod overlay;
pub(super) mod result;
pub(super) mod scan;
mod shape;
pub(super) mod source;
pub(super) mod status;
pub(super) mod steps;
pub(super) mod toolbar;

pub(super) mod compare;
pub(super) mod help;
pub(super) mod messages;
mod table;
