//! SHA-256 of files, as 64 hexadecimal digits: tells whether a file is still what was written.

use std::{fmt, fs::File, io, path::Path, str::FromStr};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

/// Bytes of a file read at a time.
const CHUNK: usize = 64 * 1024;

/// The SHA-256 of some bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Checksum([u8; 32]);

/// A text that is no checksum.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0:?} is no SHA-256: it has 64 hexadecimal digits")]
pub struct ChecksumError(String);

impl Checksum {
    /// Stands where a file holds its own checksum while that is made.
    pub(super) const ZERO: Self = Self([0; 32]);

    /// Of these bytes.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// Of a file's content, read piece by piece.
    ///
    /// # Errors
    /// What the system says.
    pub fn of_file(path: &Path) -> io::Result<Self> {
        let (mut file, mut hash) = (File::open(path)?, Sha256::new());
        let mut chunk = vec![0; CHUNK];
        loop {
            match io::Read::read(&mut file, &mut chunk)? {
                0 => return Ok(Self::finished(hash)),
                count => hash.update(&chunk[..count]),
            }
        }
    }

    pub(super) fn finished(hash: Sha256) -> Self {
        Self(hash.finalize().into())
    }
}

impl fmt::Display for Checksum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl From<Checksum> for String {
    fn from(checksum: Checksum) -> Self {
        checksum.to_string()
    }
}

impl TryFrom<String> for Checksum {
    type Error = ChecksumError;

    fn try_from(text: String) -> Result<Self, ChecksumError> {
        text.parse()
    }
}

impl FromStr for Checksum {
    type Err = ChecksumError;

    fn from_str(text: &str) -> Result<Self, ChecksumError> {
        let digits = text.as_bytes();
        let mut bytes = [0; 32];
        let value = |digit: u8| char::from(digit).to_digit(16).map(|value| value as u8);
        if digits.len() != 64 {
            return Err(ChecksumError(text.chars().take(80).collect()));
        }
        for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
            let (Some(high), Some(low)) = (value(pair[0]), value(pair[1])) else {
                return Err(ChecksumError(text.chars().take(80).collect()));
            };
            *byte = 16 * high + low;
        }
        Ok(Self(bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::Checksum;

    #[test]
    fn the_checksum_of_abc_is_that_of_the_standard() {
        let digits = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(Checksum::of(b"abc").to_string(), digits);
        assert_eq!(digits.parse(), Ok(Checksum::of(b"abc")));
    }

    #[test]
    fn a_text_that_is_no_checksum_is_refused() {
        for text in ["", "ba78", &"g".repeat(64), &"\u{e9}".repeat(32)] {
            assert!(text.parse::<Checksum>().is_err(), "{text}");
        }
    }
}
