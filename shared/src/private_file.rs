//! Files with secrets in them: in the user's own configuration folder, readable by that user alone, whole or absent
//! after a crash.

use std::{
    env,
    fs::{self, File, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
};

/// The folder of a program's secrets: `colour-grid/PROGRAM` in `$XDG_CONFIG_HOME`, `$HOME/.config` or `%APPDATA%`.
///
/// # Errors
/// None of the variables is set.
pub fn folder(program: &str) -> io::Result<PathBuf> {
    let set = |name| env::var_os(name).filter(|value| !value.is_empty());
    let base = set("XDG_CONFIG_HOME")
        .map(PathBuf::from)
        .or_else(|| set("HOME").map(|home| Path::new(&home).join(".config")))
        .or_else(|| set("APPDATA").map(PathBuf::from));
    let base = base.ok_or_else(|| {
        io::Error::other("there is no place for secrets: set HOME or XDG_CONFIG_HOME")
    })?;
    Ok(base.join("colour-grid").join(program))
}

/// Reads a file; nothing where there is none.
///
/// # Errors
/// What the system says, with the path.
pub fn read(path: &Path) -> io::Result<Option<Vec<u8>>> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(named(path, &error)),
    }
}

/// Writes a file that only its owner can read, and its folder if need be.
///
/// # Errors
/// What the system says, with the path.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let put = || {
        let dir = path.parent().unwrap_or(Path::new("."));
        make_private_folder(dir)?;
        let mut beside = path.as_os_str().to_owned();
        beside.push(".part");
        let beside = PathBuf::from(beside);
        // an older one may have other permissions
        match fs::remove_file(&beside) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let mut file = private(OpenOptions::new().write(true).create_new(true)).open(&beside)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&beside, path)?;
        File::open(dir)?.sync_all()
    };
    put().map_err(|error| named(path, &error))
}

/// Keeps other programs from changing the files of a folder until the value is dropped.
///
/// # Errors
/// What the system says, with the path.
pub fn lock(dir: &Path) -> io::Result<File> {
    let path = dir.join("lock");
    let take = || {
        make_private_folder(dir)?;
        let file = private(OpenOptions::new().create(true).append(true)).open(&path)?;
        file.lock()?;
        Ok(file)
    };
    take().map_err(|error: io::Error| named(&path, &error))
}

#[cfg(unix)]
fn private(options: &mut OpenOptions) -> &mut OpenOptions {
    std::os::unix::fs::OpenOptionsExt::mode(options, 0o600)
}

#[cfg(not(unix))]
fn private(options: &mut OpenOptions) -> &mut OpenOptions {
    options
}

fn make_private_folder(dir: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(dir)
}

fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}
