//! `projector.toml` and `pattern.toml`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rig_tests::fuzz::{Target, feed_here};

fuzz_target!(|input: &[u8]| feed_here(Target::Projector, input));
