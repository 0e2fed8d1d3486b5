//! `acquirer find`: which projectors announce themselves on the network.

use serde_json::json;

use super::args::FindArgs;
use crate::projector_link::{FindError, find};

pub(super) fn run(args: &FindArgs) -> anyhow::Result<()> {
    let found = find()?;
    if found.is_empty() {
        return Err(FindError::None.into());
    }
    if args.json {
        println!("{}", json!({ "projectors": found }));
        return Ok(());
    }
    for projector in &found {
        let paired = if projector.paired {
            "paired"
        } else {
            "not paired"
        };
        println!(
            "{:<22}{:<44}version {:<10}{paired}",
            projector.address, projector.name, projector.version
        );
    }
    Ok(())
}
