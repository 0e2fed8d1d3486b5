//! The bytes between the programs: as they are, or through TLS with a projector whose certificate is known.
//!
//! One thread receives while others send; a receiver that waits keeps nobody from sending.

use std::{
    io::{self, Read, Write},
    net::{Shutdown, TcpStream},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use rustls::{
    CertificateError, ClientConfig, ClientConnection, DigitallySignedStruct, Error as TlsError,
    SignatureScheme,
    client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier},
    crypto::{CryptoProvider, ring, verify_tls13_signature},
    pki_types::{CertificateDer, ServerName, UnixTime},
    version::TLS13,
};
use sha2::{Digest, Sha256};
use shared::protocol::Fingerprint;

/// Bytes read at a time.
const CHUNK: usize = 16 * 1024;

/// A connection, open for both directions.
#[derive(Debug)]
pub(super) struct Wire {
    tcp: TcpStream,
    tls: Option<Mutex<Box<ClientConnection>>>,
    /// Held while something is sent without TLS.
    sending: Mutex<()>,
}

impl Wire {
    /// Bytes as they are.
    pub(super) fn plain(tcp: TcpStream) -> Self {
        Self {
            tcp,
            tls: None,
            sending: Mutex::new(()),
        }
    }

    /// Through TLS 1.3; whoever has another certificate than the one of this fingerprint is refused.
    pub(super) fn protected(tcp: TcpStream, fingerprint: Fingerprint) -> io::Result<Self> {
        let provider = Arc::new(ring::default_provider());
        let pinned = Arc::new(Pinned {
            fingerprint,
            provider: provider.clone(),
        });
        let config = ClientConfig::builder_with_provider(provider)
            .with_protocol_versions(&[&TLS13])
            .map_err(io::Error::other)?
            .dangerous()
            .with_custom_certificate_verifier(pinned)
            .with_no_client_auth();
        let name = ServerName::try_from("projector").map_err(io::Error::other)?;
        let mut tls = ClientConnection::new(Arc::new(config), name).map_err(io::Error::other)?;
        while tls.is_handshaking() {
            tls.complete_io(&mut &tcp)?;
        }
        Ok(Self {
            tcp,
            tls: Some(Mutex::new(Box::new(tls))),
            sending: Mutex::new(()),
        })
    }

    /// Sends bytes, all of them.
    pub(super) fn send(&self, bytes: &[u8]) -> io::Result<()> {
        let Some(tls) = &self.tls else {
            let _sending = lock(&self.sending);
            return (&self.tcp).write_all(bytes);
        };
        let mut tls = lock(tls);
        tls.writer().write_all(bytes)?;
        self.flush(&mut tls)
    }

    /// Waits for bytes and appends them; gives how many came, 0 at the end.
    pub(super) fn receive(&self, bytes: &mut Vec<u8>) -> io::Result<usize> {
        let mut chunk = [0; CHUNK];
        let Some(tls) = &self.tls else {
            let count = (&self.tcp).read(&mut chunk)?;
            bytes.extend_from_slice(&chunk[..count]);
            return Ok(count);
        };
        let before = bytes.len();
        take_plain(&mut lock(tls), bytes)?;
        while bytes.len() == before {
            let count = (&self.tcp).read(&mut chunk)?;
            if count == 0 {
                return Ok(0);
            }
            let mut tls = lock(tls);
            let mut rest = &chunk[..count];
            while !rest.is_empty() {
                tls.read_tls(&mut rest)?;
                let state = tls.process_new_packets().map_err(io::Error::other)?;
                take_plain(&mut tls, bytes)?;
                if state.peer_has_closed() && bytes.len() == before {
                    return Ok(0);
                }
            }
            self.flush(&mut tls)?;
        }
        Ok(bytes.len() - before)
    }

    fn flush(&self, tls: &mut ClientConnection) -> io::Result<()> {
        while tls.wants_write() {
            tls.write_tls(&mut &self.tcp)?;
        }
        Ok(())
    }

    /// Longest wait of [`Self::receive`]; for ever without one.
    pub(super) fn set_receive_timeout(&self, timeout: Option<Duration>) -> io::Result<()> {
        self.tcp.set_read_timeout(timeout)
    }

    /// Ends both directions, which wakes the receiver.
    pub(super) fn shutdown(&self) -> io::Result<()> {
        self.tcp.shutdown(Shutdown::Both)
    }
}

/// Takes what has been decrypted.
fn take_plain(tls: &mut ClientConnection, bytes: &mut Vec<u8>) -> io::Result<()> {
    match tls.reader().read_to_end(bytes) {
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(()),
        other => other.map(|_| ()),
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Accepts the one certificate that was paired. Names and dates do not matter: the fingerprint says it all.
#[derive(Debug)]
struct Pinned {
    fingerprint: Fingerprint,
    provider: Arc<CryptoProvider>,
}

impl ServerCertVerifier for Pinned {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        _intermediates: &[CertificateDer<'_>],
        _server_name: &ServerName<'_>,
        _ocsp_response: &[u8],
        _now: UnixTime,
    ) -> Result<ServerCertVerified, TlsError> {
        let found: [u8; 32] = Sha256::digest(end_entity.as_ref()).into();
        if found == self.fingerprint.0 {
            Ok(ServerCertVerified::assertion())
        } else {
            Err(CertificateError::ApplicationVerificationFailure.into())
        }
    }

    fn verify_tls12_signature(
        &self,
        _message: &[u8],
        _cert: &CertificateDer<'_>,
        _dss: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, TlsError> {
        Err(TlsError::General("only TLS 1.3 is spoken".into()))
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        cert: &CertificateDer<'_>,
        dss: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, TlsError> {
        let algorithms = &self.provider.signature_verification_algorithms;
        verify_tls13_signature(message, cert, dss, algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        let algorithms = &self.provider.signature_verification_algorithms;
        algorithms.supported_schemes()
    }
}

/// Whether an error is that of another certificate than the paired one.
pub(super) fn is_other_certificate(error: &io::Error) -> bool {
    let inner = error.get_ref().and_then(|inner| inner.downcast_ref());
    matches!(
        inner,
        Some(TlsError::InvalidCertificate(
            CertificateError::ApplicationVerificationFailure
        ))
    )
}
