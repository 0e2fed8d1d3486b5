//! What a projector and its clients know each other by: the fingerprint of the projector's certificate, tokens, and
//! the pairing code that carries both.

use std::{fmt, str::FromStr};

use thiserror::Error;

/// First word of every pairing code.
const WORD: &str = "SLP1";

/// A text that is no pairing code, token or fingerprint.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PairingError {
    /// Not the parts of a code.
    #[error(
        "this is no pairing code: it begins with {WORD}/ and has an address, a fingerprint and a token; copy all of it"
    )]
    Code,
    /// Not as many hexadecimal digits as there must be.
    #[error("{what} has {digits} hexadecimal digits: copy all of it")]
    Digits {
        /// Which part.
        what: &'static str,
        /// How many there must be.
        digits: usize,
    },
}

/// SHA-256 of a projector's certificate in DER form.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Fingerprint(pub [u8; 32]);

/// What lets a client in: 128 random bits. It is not shown by `Debug`, so that no log tells it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Token(pub [u8; 16]);

/// What a client must know to pair with a projector.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PairingCode {
    /// Where the projector listens, HOST:PORT.
    pub address: String,
    /// What its certificate must be.
    pub fingerprint: Fingerprint,
    /// Good for pairing once.
    pub token: Token,
}

impl fmt::Display for PairingCode {
    /// In capital letters, which make the smaller QR code.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let address = self.address.to_uppercase();
        let text = format!("{WORD}/{address}/{}/{}", self.fingerprint, self.token);
        f.write_str(&text.to_uppercase())
    }
}

impl FromStr for PairingCode {
    type Err = PairingError;

    fn from_str(text: &str) -> Result<Self, PairingError> {
        let parts: Vec<&str> = text.trim().split('/').collect();
        match parts[..] {
            [word, address, fingerprint, token] if word == WORD && !address.is_empty() => {
                Ok(Self {
                    address: address.to_lowercase(),
                    fingerprint: fingerprint.parse()?,
                    token: token.parse()?,
                })
            }
            _ => Err(PairingError::Code),
        }
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hex(&self.0, f)
    }
}

impl fmt::Debug for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hex(&self.0, f)
    }
}

impl FromStr for Fingerprint {
    type Err = PairingError;

    fn from_str(text: &str) -> Result<Self, PairingError> {
        read_hex("a fingerprint", text).map(Self)
    }
}

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hex(&self.0, f)
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(..)")
    }
}

impl FromStr for Token {
    type Err = PairingError;

    fn from_str(text: &str) -> Result<Self, PairingError> {
        read_hex("a token", text).map(Self)
    }
}

fn write_hex(bytes: &[u8], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    bytes.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
}

fn read_hex<const N: usize>(what: &'static str, text: &str) -> Result<[u8; N], PairingError> {
    let wrong = || PairingError::Digits {
        what,
        digits: 2 * N,
    };
    let digits: Option<Vec<u32>> = text.chars().map(|digit| digit.to_digit(16)).collect();
    let digits = digits.filter(|d| d.len() == 2 * N).ok_or_else(wrong)?;
    let mut bytes = [0; N];
    for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = (16 * pair[0] + pair[1]) as u8;
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::{Fingerprint, PairingCode, Token};

    #[test]
    fn a_code_is_read_back_as_it_was_written() {
        let code = PairingCode {
            address: "bench-2.lab:4460".into(),
            fingerprint: Fingerprint(std::array::from_fn(|k| k as u8 * 7)),
            token: Token([0xab; 16]),
        };
        assert_eq!(code.to_string().parse(), Ok(code.clone()));
        assert_eq!(format!(" {code}\n").parse(), Ok(code.clone()));
        assert!(
            !format!("{code:?}").contains("abab"),
            "a log tells no token"
        );
    }

    #[test]
    fn a_text_that_is_no_code_is_refused() {
        let zeros = "0".repeat(64);
        for text in [
            "",
            "SLP1",
            "SLP1/a:1/00/11",
            "HTTP/a/b/c",
            &format!("SLP1/a:1/{zeros}/{}", "\u{e9}".repeat(32)),
            &format!("SLP1//{zeros}/{}", "0".repeat(32)),
        ] {
            assert!(text.parse::<PairingCode>().is_err(), "{text}");
        }
    }
}
