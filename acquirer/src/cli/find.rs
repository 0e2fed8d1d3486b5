//! `acquirer find`: which projectors announce themselves on the network.

use serde_json::json;

use crate::projector_link::{FindError, find};

/// `acquirer find`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acquirer find
  acquirer scan --out cup --projector auto           with the only one that is paired

Exit codes: 0 some were found, 1 none or it failed, 2 wrong use.")]
pub(super) struct FindArgs {
    /// One JSON object on standard output.
    #[arg(long)]
    pub json: bool,
}

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
