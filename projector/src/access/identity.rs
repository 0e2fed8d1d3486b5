//! The projector's own certificate: made at the first start, the same from then on.

use std::{path::Path, sync::Arc};

use rustls::{
    ServerConfig,
    crypto::{CryptoProvider, ring},
    pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer},
    version::TLS13,
};
use sha2::{Digest, Sha256};
use shared::{private_file, protocol::Fingerprint};

use super::AccessError;

const CERTIFICATE: &str = "certificate.der";
const KEY: &str = "key.der";

/// Reads the certificate and its key, or makes them where one is missing.
pub(super) fn load_or_make(dir: &Path) -> Result<(Arc<ServerConfig>, Fingerprint), AccessError> {
    let (certificate, key) = (dir.join(CERTIFICATE), dir.join(KEY));
    let (certificate, key) = match (private_file::read(&certificate)?, private_file::read(&key)?) {
        (Some(certificate), Some(key)) => (certificate, key),
        _ => make(dir)?,
    };
    let fingerprint = Fingerprint(Sha256::digest(&certificate).into());
    let config = ServerConfig::builder_with_provider(provider())
        .with_protocol_versions(&[&TLS13])
        .and_then(|builder| {
            builder.with_no_client_auth().with_single_cert(
                vec![CertificateDer::from(certificate)],
                PrivateKeyDer::from(PrivatePkcs8KeyDer::from(key)),
            )
        })
        .map_err(|source| AccessError::Certificate {
            dir: dir.to_owned(),
            source,
        })?;
    Ok((Arc::new(config), fingerprint))
}

/// Makes a certificate. The key is written first: a certificate is never there without its key.
fn make(dir: &Path) -> Result<(Vec<u8>, Vec<u8>), AccessError> {
    let made = rcgen::generate_simple_self_signed(vec!["projector".to_owned()])?;
    let (certificate, key) = (made.cert.der().to_vec(), made.signing_key.serialize_der());
    let path = dir.join(CERTIFICATE);
    if path.exists() {
        std::fs::remove_file(&path)?;
    }
    private_file::write(&dir.join(KEY), &key)?;
    private_file::write(&path, &certificate)?;
    tracing::info!("made a certificate of our own in {}", dir.display());
    Ok((certificate, key))
}

/// The cryptography in use.
pub(super) fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}
