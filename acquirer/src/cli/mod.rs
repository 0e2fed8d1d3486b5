//! The commands of the acquirer, one file each.

pub mod cameras;
