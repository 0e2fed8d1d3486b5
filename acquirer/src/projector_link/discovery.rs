//! Projectors that announce themselves on the network, by multicast DNS.
//!
//! Anybody may announce anything, so nothing follows from an announcement but an address to try: a projector is known by
//! its certificate, and is connected to only if this computer was paired with it.

use std::{
    collections::BTreeMap,
    io,
    net::{IpAddr, SocketAddr},
    time::{Duration, Instant},
};

use mdns_sd::{IfKind, ResolvedService, ServiceDaemon, ServiceEvent};
use serde::Serialize;
use shared::protocol::{Fingerprint, SERVICE};
use thiserror::Error;

use super::pairing::{is_paired, remember_at};

/// What stands in place of an address for the paired projector that announces itself.
pub const AUTO: &str = "auto";

/// How long is listened: the question is asked at once and after a second.
const LISTEN: Duration = Duration::from_millis(2500);
/// Most projectors that are told of.
const MAX_FOUND: usize = 64;
/// Most characters of a stranger's text.
const MAX_CHARS: usize = 63;

/// Why there is no projector to connect to.
#[derive(Debug, Error)]
pub enum FindError {
    /// Nobody announces anything.
    #[error(
        "no projector announces itself on this network: start it with --listen 0.0.0.0:4460; where the network or a \
         firewall keeps multicast DNS (UDP port 5353) back, give its address"
    )]
    None,
    /// None of those found is paired.
    #[error(
        "not paired with {0}: type `acquirer pair CODE` with the code that `projector pair` makes there"
    )]
    NotPaired(String),
    /// More than one is paired.
    #[error("paired with {0}: give the address of one")]
    Several(String),
    /// The network can't be listened to.
    #[error("projectors can't be looked for, give the projector's address")]
    Network(#[from] mdns_sd::Error),
    /// The list of paired projectors.
    #[error("the list of paired projectors can't be used")]
    Remembered(#[from] io::Error),
}

/// A projector that announces itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Found {
    /// Where it says it listens, HOST:PORT.
    pub address: String,
    /// What it calls itself.
    pub name: String,
    /// The version that it says its program has.
    pub version: String,
    /// SHA-256 of the certificate that it says it has, in hexadecimal digits.
    pub fingerprint: String,
    /// Whether this computer is paired with the projector of that certificate.
    pub paired: bool,
}

/// Listens for 2.5 s; gives all that announce themselves, by their names.
///
/// # Errors
/// No socket or thread, a list of paired projectors that can't be read.
pub fn find() -> Result<Vec<Found>, FindError> {
    let daemon = ServiceDaemon::new()?;
    let found = listen(&daemon);
    // nothing more is to be done where it has ended by itself
    daemon.shutdown().ok();
    found?.values().filter_map(read).collect()
}

/// An address as it is, or that of the paired projector on the network for [`AUTO`], which is remembered by it from then
/// on.
///
/// # Errors
/// No paired projector is found, or more than one; as [`find`].
pub fn resolve(address: &str) -> Result<String, FindError> {
    if address != AUTO {
        return Ok(address.to_owned());
    }
    let found = find()?;
    let one = the_paired_one(&found)?;
    remember_at(&one.fingerprint, &one.address)?;
    Ok(one.address.clone())
}

fn the_paired_one(found: &[Found]) -> Result<&Found, FindError> {
    let list = |found: &[&Found]| {
        let named = found.iter().map(|f| format!("{} at {}", f.name, f.address));
        named.collect::<Vec<_>>().join(", ")
    };
    let paired: Vec<_> = found.iter().filter(|found| found.paired).collect();
    match paired[..] {
        [one] => Ok(one),
        [] if found.is_empty() => Err(FindError::None),
        [] => Err(FindError::NotPaired(list(
            &found.iter().collect::<Vec<_>>(),
        ))),
        _ => Err(FindError::Several(list(&paired))),
    }
}

fn listen(daemon: &ServiceDaemon) -> Result<BTreeMap<String, ResolvedService>, FindError> {
    daemon.disable_interface(vec![IfKind::LoopbackV4, IfKind::LoopbackV6])?;
    let events = daemon.browse(SERVICE)?;
    let mut found = BTreeMap::new();
    let deadline = Instant::now() + LISTEN;
    while let Ok(event) = events.recv_deadline(deadline) {
        match event {
            ServiceEvent::ServiceResolved(service) if found.len() < MAX_FOUND => {
                found.insert(service.get_fullname().to_owned(), *service);
            }
            ServiceEvent::ServiceRemoved(_, name) => {
                found.remove(&name);
            }
            _ => {}
        }
    }
    Ok(found)
}

/// Nothing for what is no projector of ours.
fn read(service: &ResolvedService) -> Option<Result<Found, FindError>> {
    let fingerprint = service.get_property_val_str("fingerprint")?;
    let fingerprint: Fingerprint = fingerprint.parse().ok()?;
    let addresses = service.get_addresses().iter();
    let address = best_address(addresses.map(mdns_sd::ScopedIp::to_ip_addr))?;
    let name = service.get_fullname().split(&format!(".{SERVICE}")).next();
    let version = service.get_property_val_str("version");
    Some(match is_paired(fingerprint) {
        Ok(paired) => Ok(Found {
            address: SocketAddr::new(address, service.get_port()).to_string(),
            name: clean(name.unwrap_or_default()),
            version: clean(version.unwrap_or_default()),
            fingerprint: fingerprint.to_string(),
            paired,
        }),
        Err(error) => Err(error.into()),
    })
}

/// IPv4 before IPv6; an IPv6 address of one link alone says too little to connect to.
fn best_address(addresses: impl Iterator<Item = IpAddr>) -> Option<IpAddr> {
    let usable = addresses.filter(|address| match address {
        IpAddr::V4(_) => true,
        IpAddr::V6(address) => !address.is_unicast_link_local(),
    });
    usable.min()
}

/// A stranger's text, fit for a terminal.
fn clean(text: &str) -> String {
    let printable = text.chars().filter(|letter| !letter.is_control());
    printable.take(MAX_CHARS).collect()
}

#[cfg(test)]
mod tests {
    use super::{FindError, Found, best_address, clean, the_paired_one};

    fn found(address: &str, paired: bool) -> Found {
        Found {
            address: address.to_owned(),
            name: "projector".to_owned(),
            version: String::new(),
            fingerprint: String::new(),
            paired,
        }
    }

    #[test]
    fn the_only_paired_projector_is_taken_whoever_else_announces_himself() {
        let [paired, stranger] = [found("10.0.0.7:4460", true), found("10.0.0.8:4460", false)];
        let both = [stranger.clone(), paired.clone()];
        assert_eq!(the_paired_one(&both).unwrap(), &paired);
        assert!(matches!(the_paired_one(&[]), Err(FindError::None)));
        let error = the_paired_one(std::slice::from_ref(&stranger)).unwrap_err();
        assert!(error.to_string().contains("projector at 10.0.0.8:4460"));
        assert!(matches!(error, FindError::NotPaired(_)));
        let two = [paired.clone(), stranger, paired];
        assert!(matches!(the_paired_one(&two), Err(FindError::Several(_))));
    }

    #[test]
    fn addresses_and_texts_of_strangers_are_fit_for_use() {
        let best = |texts: &[&str]| best_address(texts.iter().map(|text| text.parse().unwrap()));
        let usable = "10.0.0.7".parse().ok();
        assert_eq!(best(&["fe80::1", "2001:db8::1", "10.0.0.7"]), usable);
        assert_eq!(best(&["fe80::1"]), None);
        assert_eq!(clean("lab\u{1b}[2J\n2"), "lab[2J2");
        assert_eq!(clean(&"x".repeat(300)).len(), 63);
    }
}
