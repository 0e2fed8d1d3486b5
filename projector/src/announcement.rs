//! Tells the network where the projector is, by multicast DNS, so that nobody has to type addresses.
//!
//! Told are a name, the address and port, the program's version and the certificate's fingerprint: nothing that lets
//! anybody in.

use std::{net::SocketAddr, time::Duration};

use mdns_sd::{Error, IfKind, ServiceDaemon, ServiceInfo};
use shared::{
    computer,
    protocol::{Fingerprint, SERVICE},
};

/// Longest wait at the end until the network has been told that the projector goes.
const FAREWELL: Duration = Duration::from_millis(500);

/// The projector is announced for as long as this lives.
pub struct Announcement {
    daemon: ServiceDaemon,
    full_name: String,
}

impl Announcement {
    /// Announces the projector that listens at `address`, on that network alone or, for an unspecified address, on all
    /// but loopback.
    ///
    /// # Errors
    /// The system gives no socket or thread. Networks that keep multicast back are not noticed.
    pub fn start(address: SocketAddr, fingerprint: Fingerprint) -> Result<Self, Error> {
        let service = service(address, fingerprint)?;
        let full_name = service.get_fullname().to_owned();
        let daemon = ServiceDaemon::new()?;
        let mut left_out = vec![IfKind::LoopbackV4, IfKind::LoopbackV6];
        if address.is_ipv4() {
            left_out.push(IfKind::IPv6);
        }
        daemon.disable_interface(left_out)?;
        daemon.register(service)?;
        Ok(Self { daemon, full_name })
    }
}

impl Drop for Announcement {
    /// Takes the announcement back. Whoever does not hear it forgets the projector after two minutes.
    fn drop(&mut self) {
        if let Ok(done) = self.daemon.unregister(&self.full_name) {
            done.recv_timeout(FAREWELL).ok();
        }
        if let Ok(done) = self.daemon.shutdown() {
            done.recv_timeout(FAREWELL).ok();
        }
    }
}

/// What is told.
fn service(address: SocketAddr, fingerprint: Fingerprint) -> Result<ServiceInfo, Error> {
    let fingerprint = fingerprint.to_string();
    let name = format!("projector on {}", computer::name());
    // of our own: the computer's name belongs to whoever else answers for it
    let host = format!("projector-{}.local.", &fingerprint[..16]);
    let properties = [
        ("version", env!("CARGO_PKG_VERSION")),
        ("fingerprint", &fingerprint),
    ];
    let everywhere = address.ip().is_unspecified();
    let own = if everywhere {
        String::new()
    } else {
        address.ip().to_string()
    };
    let mut service =
        ServiceInfo::new(SERVICE, &name, &host, own, address.port(), &properties[..])?;
    if everywhere {
        service = service.enable_addr_auto();
    } else {
        service.set_interfaces(vec![IfKind::Addr(address.ip())]);
    }
    Ok(service)
}

#[cfg(test)]
mod tests {
    use shared::protocol::Fingerprint;

    use super::service;

    #[test]
    fn nothing_is_told_that_lets_anybody_in() {
        let fingerprint = Fingerprint([7; 32]);
        let service = service("10.0.0.7:4460".parse().unwrap(), fingerprint).unwrap();
        assert_eq!(service.get_port(), 4460);
        assert!(service.get_fullname().starts_with("projector on "));
        let mut told: Vec<_> = service
            .get_properties()
            .iter()
            .map(|property| (property.key(), property.val_str()))
            .collect();
        told.sort_unstable();
        let fingerprint = fingerprint.to_string();
        assert_eq!(
            told,
            [
                ("fingerprint", fingerprint.as_str()),
                ("version", env!("CARGO_PKG_VERSION"))
            ]
        );
    }
}
