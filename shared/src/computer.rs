//! What this computer is called.

use std::{env, fs};

/// Most characters of a name: with a word or two before it, it must fit into 63 bytes.
const MAX_CHARS: usize = 40;

/// The computer's name on its network, without what can't be printed, shortened to 40 letters; "a computer" where it
/// has none.
#[must_use]
pub fn name() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let name = name.or_else(|| env::var("COMPUTERNAME").ok());
    let name = name.unwrap_or_default();
    let name: String = name
        .chars()
        .filter(char::is_ascii_graphic)
        .take(MAX_CHARS)
        .collect();
    if name.is_empty() {
        "a computer".to_owned()
    } else {
        name
    }
}
