//! `projector pair`, `pairings` and `revoke`: who may command this projector over a network.

use anyhow::bail;
use qrcode::{EcLevel, QrCode, render::unicode::Dense1x2};
use serde_json::json;
use shared::protocol::PairingCode;

use crate::access::{Access, CODE_LASTS_S};

pub(super) fn invite() -> anyhow::Result<()> {
    let code = Access::open()?.invite()?;
    tell(&code);
    println!("{code}");
    Ok(())
}

/// Shows a code to the person at the terminal, on standard error.
pub(super) fn tell(code: &PairingCode) {
    let text = code.to_string();
    if let Ok(drawn) = QrCode::with_error_correction_level(&text, EcLevel::L) {
        eprintln!("{}", drawn.render::<Dense1x2>().build());
    }
    eprintln!(
        "Pairing code, good once within {} minutes. On the camera's computer type:\n  acquirer pair {text}",
        CODE_LASTS_S / 60
    );
}

pub(super) fn list(json: bool) -> anyhow::Result<()> {
    let pairings = Access::open()?.pairings()?;
    if json {
        let listed = pairings
            .iter()
            .map(|pairing| json!({ "name": pairing.name, "paired_at_s": pairing.paired_at_s }));
        println!("{}", json!({ "pairings": listed.collect::<Vec<_>>() }));
        return Ok(());
    }
    for pairing in &pairings {
        println!("{}", pairing.name);
    }
    if pairings.is_empty() {
        eprintln!("nobody is paired");
    }
    Ok(())
}

pub(super) fn revoke(name: Option<&str>) -> anyhow::Result<()> {
    let revoked = Access::open()?.revoke(name)?;
    if let (0, Some(name)) = (revoked, name) {
        bail!("nobody called {name:?} is paired: `projector pairings` lists the names");
    }
    eprintln!("{revoked} revoked");
    Ok(())
}
