//! Who may command a projector that is reached over a network: its certificate, pairings, and pairing codes.
//!
//! A pairing code carries the certificate's fingerprint and a token that is good once, for some minutes; the client
//! that says hello with it gets a token of its own, which stays good until it is revoked. Everything is in files of
//! mode 0600, so that `projector pair` and `projector revoke` work beside a running projector, which looks at them at
//! every hello and every second.

mod book;

mod identity;

use std::{
    io,
    net::{IpAddr, SocketAddr, UdpSocket},
    path::{Path, PathBuf},
    sync::Arc,
    time::{SystemTime, UNIX_EPOCH},
};

pub use book::Pairing;
use book::{Book, Invitation, sum_of};
use rustls::ServerConfig;
use shared::{
    private_file,
    protocol::{Fingerprint, PairingCode, Token},
};
use thiserror::Error;

/// How long a pairing code is good, in seconds.
pub const CODE_LASTS_S: u64 = 600;

/// Why the wire can't be protected, or a client is not let in.
#[derive(Debug, Error)]
pub enum AccessError {
    /// A file with secrets.
    #[error("the projector's own files: {0}")]
    File(#[from] io::Error),
    /// The list of pairings.
    #[error("{path}: {source}; remove it to begin anew, all clients must pair again then")]
    Book {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: serde_json::Error,
    },
    /// A certificate can't be made.
    #[error("cannot make a certificate")]
    Make(#[from] rcgen::Error),
    /// The certificate can't be used.
    #[error("the certificate in {dir} can't be used: {source}; remove it to have another one made")]
    Certificate {
        /// The folder.
        dir: PathBuf,
        /// What is wrong with it.
        source: rustls::Error,
    },
    /// No randomness.
    #[error("the system gives no random numbers")]
    Random,
    /// A hello without a token.
    #[error(
        "this projector lets in who is paired: type `acquirer pair CODE` with the code that `projector pair` makes there"
    )]
    NoToken,
    /// A hello with a token that is none, is used up, or was revoked.
    #[error(
        "this token is not known here: it was revoked, or its pairing code was used or is older than {} minutes; pair again",
        CODE_LASTS_S / 60
    )]
    Unknown,
    /// The projector was never started on a network.
    #[error(
        "no projector listened on a network here yet: start it first, for example with --listen 0.0.0.0:4460"
    )]
    NeverListened,
}

/// A client that was let in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Admission {
    /// What its token is known by.
    pub token_sha256: String,
    /// The token it has from now on, when it has just been paired.
    pub new_token: Option<Token>,
}

/// The projector's certificate and pairings.
#[derive(Debug)]
pub struct Access {
    dir: PathBuf,
    tls: Arc<ServerConfig>,
    fingerprint: Fingerprint,
}

impl Access {
    /// Reads the certificate in the user's configuration folder, or makes one at the first start.
    ///
    /// # Errors
    /// Files that can't be read or written, a certificate that can't be used.
    pub fn open() -> Result<Self, AccessError> {
        let dir = private_file::folder("projector")?;
        let (tls, fingerprint) = identity::load_or_make(&dir)?;
        Ok(Self {
            dir,
            tls,
            fingerprint,
        })
    }

    /// What the network side needs to speak TLS.
    #[must_use]
    pub fn tls(&self) -> Arc<ServerConfig> {
        self.tls.clone()
    }

    /// What the projector is known by.
    #[must_use]
    pub fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    /// Notes where clients reach the projector, and opens a pairing code where nobody is paired yet.
    ///
    /// # Errors
    /// The list of pairings can't be read or written.
    pub fn listens_on(&self, address: SocketAddr) -> Result<(), AccessError> {
        let address = seen_from_outside(address).to_string();
        let nobody = Book::change(&self.dir, |book| {
            book.address = address;
            book.pairings.is_empty()
        })?;
        if nobody {
            self.invite()?;
        }
        Ok(())
    }

    /// Opens a pairing code, in place of an earlier one.
    ///
    /// # Errors
    /// The list of pairings can't be read or written.
    pub fn invite(&self) -> Result<PairingCode, AccessError> {
        let token = random_token()?;
        let invitation = Invitation {
            token: token.to_string(),
            expires_at_s: now_s() + CODE_LASTS_S,
        };
        let address = Book::change(&self.dir, |book| {
            book.invitation = Some(invitation);
            book.address.clone()
        })?;
        if address.is_empty() {
            return Err(AccessError::NeverListened);
        }
        Ok(self.code(address, token))
    }

    /// The pairing code that is open now.
    ///
    /// # Errors
    /// The list of pairings can't be read.
    pub fn open_code(&self) -> Result<Option<PairingCode>, AccessError> {
        let book = Book::read(&self.dir)?;
        let token = book.open_token(now_s());
        Ok(token.map(|token| self.code(book.address, token)))
    }

    /// Lets a client in, or tells why not. A token from a pairing code is used up by it.
    ///
    /// # Errors
    /// No token, a token that is not known, files that can't be read or written.
    pub fn admit(&self, token: Option<&str>, name: &str) -> Result<Admission, AccessError> {
        let token: Token = token
            .ok_or(AccessError::NoToken)?
            .parse()
            .map_err(|_| AccessError::Unknown)?;
        let sum = sum_of(token);
        let book = Book::read(&self.dir)?;
        if book.is_paired(&sum) {
            return Ok(Admission {
                token_sha256: sum,
                new_token: None,
            });
        }
        let is_open = |book: &Book| {
            let open = book.open_token(now_s());
            open.is_some_and(|open| sum_of(open) == sum)
        };
        if !is_open(&book) {
            return Err(AccessError::Unknown);
        }
        let new = random_token()?;
        let pairing = Pairing {
            name: name.to_owned(),
            paired_at_s: now_s(),
            token_sha256: sum_of(new),
        };
        let token_sha256 = pairing.token_sha256.clone();
        let paired = Book::change(&self.dir, |book| {
            // somebody else may have used it meanwhile
            let still = is_open(book);
            if still {
                book.invitation = None;
                book.pairings.push(pairing);
            }
            still
        })?;
        if !paired {
            return Err(AccessError::Unknown);
        }
        tracing::info!("{name:?} is paired");
        Ok(Admission {
            token_sha256,
            new_token: Some(new),
        })
    }

    /// Whether a client that was let in has not been revoked since.
    ///
    /// # Errors
    /// The list of pairings can't be read.
    pub fn is_paired(&self, token_sha256: &str) -> Result<bool, AccessError> {
        Ok(Book::read(&self.dir)?.is_paired(token_sha256))
    }

    /// Who is paired, the oldest first.
    ///
    /// # Errors
    /// The list of pairings can't be read.
    pub fn pairings(&self) -> Result<Vec<Pairing>, AccessError> {
        Ok(Book::read(&self.dir)?.pairings)
    }

    /// Takes the pairings of this name back, or all without one; gives how many.
    ///
    /// # Errors
    /// The list of pairings can't be read or written.
    pub fn revoke(&self, name: Option<&str>) -> Result<usize, AccessError> {
        Book::change(&self.dir, |book| {
            let before = book.pairings.len();
            book.pairings
                .retain(|pairing| name.is_some_and(|name| pairing.name != name));
            before - book.pairings.len()
        })
    }

    /// The folder of the projector's secrets.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    fn code(&self, address: String, token: Token) -> PairingCode {
        PairingCode {
            address,
            fingerprint: self.fingerprint,
            token,
        }
    }
}

fn random_token() -> Result<Token, AccessError> {
    let mut bytes = [0; 16];
    let random = identity::provider().secure_random;
    random.fill(&mut bytes).map_err(|_| AccessError::Random)?;
    Ok(Token(bytes))
}

fn now_s() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |since| since.as_secs())
}

/// The address to tell others: for a socket on all networks, the one that packets to the outside would leave by.
fn seen_from_outside(address: SocketAddr) -> SocketAddr {
    if !address.ip().is_unspecified() {
        return address;
    }
    let own = || -> io::Result<IpAddr> {
        let socket = UdpSocket::bind("0.0.0.0:0")?;
        // sends nothing; an address of the range for documentation
        socket.connect("192.0.2.1:9")?;
        Ok(socket.local_addr()?.ip())
    };
    let loopback = IpAddr::from([127, 0, 0, 1]);
    SocketAddr::new(own().unwrap_or(loopback), address.port())
}
