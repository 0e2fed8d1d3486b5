//! Projectors that this computer is paired with, remembered in `projectors.json`, which only its owner can read.

use std::{collections::BTreeMap, io, path::PathBuf};

use serde::{Deserialize, Serialize};
use shared::{
    private_file,
    protocol::{Fingerprint, PairingCode, Role, Token},
};
use thiserror::Error;

use super::{LinkError, LinkSettings, connection::Connection};

const FILE: &str = "projectors.json";

/// Why pairing failed.
#[derive(Debug, Error)]
pub enum PairError {
    /// The projector.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The projector let us in but gave no token: it is paired already, or no projector of ours.
    #[error("the projector gave no token of our own: open a new code there with `projector pair`")]
    NoToken,
    /// The file of what is remembered.
    #[error(transparent)]
    File(#[from] io::Error),
}

/// What a projector is known by, and we by it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Credentials {
    pub(super) fingerprint: Fingerprint,
    pub(super) token: Token,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Entry {
    fingerprint: String,
    token: String,
}

#[derive(Debug, Default, Serialize, Deserialize)]
struct Remembered {
    projectors: BTreeMap<String, Entry>,
}

/// Pairs with the projector that made a code, and remembers it. `address` goes before the code's own, for a projector
/// that is reached by another one.
///
/// # Errors
/// A projector that can't be reached or does not know the code, a file that can't be written.
pub fn pair(code: &PairingCode, address: Option<&str>, name: &str) -> Result<String, PairError> {
    let address = address.unwrap_or(&code.address).to_owned();
    let settings = LinkSettings::new(&address, name, Role::Watcher);
    let credentials = Credentials {
        fingerprint: code.fingerprint,
        token: code.token,
    };
    let connection = Connection::open(&settings, Some(credentials))?;
    let token = connection.new_token().ok_or(PairError::NoToken)?;
    let mut remembered = read()?;
    let entry = Entry {
        fingerprint: code.fingerprint.to_string(),
        token: token.to_owned(),
    };
    remembered.projectors.insert(address.clone(), entry);
    write(&remembered)?;
    Ok(address)
}

/// What is remembered of the projector at an address.
pub(super) fn remembered(address: &str) -> io::Result<Option<Credentials>> {
    let Some(entry) = read()?.projectors.remove(address) else {
        return Ok(None);
    };
    match (entry.fingerprint.parse(), entry.token.parse()) {
        (Ok(fingerprint), Ok(token)) => Ok(Some(Credentials { fingerprint, token })),
        _ => Err(broken(&path()?, "an entry is no fingerprint and token")),
    }
}

/// Whether this computer is paired with the projector of this certificate, at whatever address.
pub(super) fn is_paired(fingerprint: Fingerprint) -> io::Result<bool> {
    let fingerprint = fingerprint.to_string();
    let remembered = read()?;
    let mut entries = remembered.projectors.values();
    Ok(entries.any(|entry| entry.fingerprint == fingerprint))
}

/// Remembers a paired projector by one more address. The connection checks its certificate all the same.
pub(super) fn remember_at(fingerprint: &str, address: &str) -> io::Result<()> {
    let mut remembered = read()?;
    let known = |entry: &&Entry| entry.fingerprint == fingerprint;
    let at_address = remembered.projectors.get(address);
    if at_address.is_some_and(|entry| known(&entry)) {
        return Ok(());
    }
    if let Some(entry) = remembered.projectors.values().find(known).cloned() {
        remembered.projectors.insert(address.to_owned(), entry);
        write(&remembered)?;
    }
    Ok(())
}

fn read() -> io::Result<Remembered> {
    let Ok(path) = path() else {
        // without a home nothing was remembered
        return Ok(Remembered::default());
    };
    match private_file::read(&path)? {
        None => Ok(Remembered::default()),
        Some(bytes) => {
            serde_json::from_slice(&bytes).map_err(|error| broken(&path, &error.to_string()))
        }
    }
}

fn write(remembered: &Remembered) -> io::Result<()> {
    let json = serde_json::to_vec_pretty(remembered).map_err(io::Error::other)?;
    private_file::write(&path()?, &json)
}

fn broken(path: &std::path::Path, why: &str) -> io::Error {
    io::Error::other(format!(
        "{}: {why}; remove the file and pair again",
        path.display()
    ))
}

fn path() -> io::Result<PathBuf> {
    Ok(private_file::folder("acquirer")?.join(FILE))
}
