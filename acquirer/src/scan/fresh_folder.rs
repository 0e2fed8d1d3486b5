//! A name for the next scan.

use std::path::{Path, PathBuf};

/// The first of `name`, `name-2`, `name-3`, ... that is not there yet.
#[must_use]
pub fn fresh_folder(name: &Path) -> PathBuf {
    let numbered = |n: u32| {
        let mut numbered = name.as_os_str().to_owned();
        numbered.push(format!("-{n}"));
        PathBuf::from(numbered)
    };
    let names = std::iter::once(name.to_owned()).chain((2..).map(numbered));
    let mut free = names.filter(|name| !name.exists());
    free.next().unwrap_or_else(|| name.to_owned())
}
