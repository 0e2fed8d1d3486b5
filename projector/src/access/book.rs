//! `pairings.json`: who is paired, and the code that is open for pairing. Tokens of paired clients are kept as their
//! SHA-256 only.

use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use shared::{
    private_file,
    protocol::{Fingerprint, Token},
};

use super::{AccessError, CODE_LASTS_S};

const BOOK: &str = "pairings.json";

/// A client that is let in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pairing {
    /// What the client called itself when it was paired.
    pub name: String,
    /// Seconds since 1970.
    pub paired_at_s: u64,
    /// SHA-256 of its token, hexadecimal.
    pub token_sha256: String,
}

/// A pairing code that is good once.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Invitation {
    /// The token in the code, hexadecimal.
    pub(super) token: String,
    /// Seconds since 1970.
    pub(super) expires_at_s: u64,
}

/// The file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Book {
    /// Where the projector listened last, HOST:PORT, for codes made by another process.
    pub(super) address: String,
    pub(super) pairings: Vec<Pairing>,
    pub(super) invitation: Option<Invitation>,
}

impl Book {
    pub(super) fn read(dir: &Path) -> Result<Self, AccessError> {
        let path = dir.join(BOOK);
        match private_file::read(&path)? {
            None => Ok(Self::default()),
            Some(bytes) => {
                serde_json::from_slice(&bytes).map_err(|source| AccessError::Book { path, source })
            }
        }
    }

    /// Changes the file while no other process does.
    pub(super) fn change<T>(
        dir: &Path,
        change: impl FnOnce(&mut Self) -> T,
    ) -> Result<T, AccessError> {
        let path = dir.join(BOOK);
        let lock = private_file::lock(dir)?;
        let mut book = Self::read(dir)?;
        let given = change(&mut book);
        let json = serde_json::to_vec_pretty(&book);
        let json = json.map_err(|source| AccessError::Book {
            path: path.clone(),
            source,
        })?;
        private_file::write(&path, &json)?;
        drop(lock);
        Ok(given)
    }

    /// Whether a client with a token of this sum is let in.
    pub(super) fn is_paired(&self, token_sha256: &str) -> bool {
        let mut pairings = self.pairings.iter();
        pairings.any(|pairing| pairing.token_sha256 == token_sha256)
    }

    /// The token of the code that is open at this time. A code that would last longer than any is not: the clock was set
    /// back since it was made.
    pub(super) fn open_token(&self, now_s: u64) -> Option<Token> {
        let open = self.invitation.as_ref();
        let open = open.filter(|invitation| {
            let left_s = invitation.expires_at_s.saturating_sub(now_s);
            (1..=CODE_LASTS_S).contains(&left_s)
        })?;
        open.token.parse().ok()
    }
}

/// What is kept of a token. A sum of 128 random bits can't be turned back, and comparing sums tells nothing by its time.
pub(super) fn sum_of(token: Token) -> String {
    Fingerprint(Sha256::digest(token.0).into()).to_string()
}

#[cfg(test)]
mod tests {
    use super::{Book, Invitation};
    use crate::access::CODE_LASTS_S;

    #[test]
    fn a_code_is_open_for_its_minutes_and_not_for_longer_when_the_clock_is_set_back() {
        let made_at_s = 1_000_000;
        let book = Book {
            invitation: Some(Invitation {
                token: "0123456789abcdef0123456789abcdef".to_owned(),
                expires_at_s: made_at_s + CODE_LASTS_S,
            }),
            ..Book::default()
        };
        let is_open = |now_s| book.open_token(now_s).is_some();
        assert!(is_open(made_at_s) && is_open(made_at_s + CODE_LASTS_S - 1));
        assert!(!is_open(made_at_s + CODE_LASTS_S));
        assert!(!is_open(made_at_s - 1) && !is_open(made_at_s - 3600));
    }
}
