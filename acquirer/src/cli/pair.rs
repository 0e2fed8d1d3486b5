//! `acquirer pair`: gets to know a projector on the network by its pairing code, pasted or seen by the camera.

use std::time::{Duration, Instant};

use anyhow::bail;
use image::RgbImage;
use shared::{computer, protocol::PairingCode};

use super::args::ConfigArgs;
use crate::{
    camera::{CameraSpec, open_camera},
    projector_link::pair,
    session::Cancel,
};

/// `acquirer pair`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acquirer pair SLP1/192.168.0.7:4460/...            the code as it was printed
  acquirer pair --camera /dev/video0                  the code as the projector shows it")]
pub(super) struct PairArgs {
    /// The pairing code.
    #[arg(value_name = "CODE", conflicts_with = "camera")]
    pub code: Option<String>,
    /// Read the code from the wall through this camera.
    #[arg(long, value_name = "CAMERA")]
    pub camera: Option<CameraSpec>,
    /// Reach the projector by this address instead of the code's own.
    #[arg(long, value_name = "HOST:PORT")]
    pub projector: Option<String>,
    /// Settings.
    #[command(flatten)]
    pub config: ConfigArgs,
}

/// Longest look for a code through the camera.
const LOOK: Duration = Duration::from_secs(60);
/// Longest wait for one frame.
const FRAME_TIMEOUT: Duration = Duration::from_secs(5);

pub(super) fn run(args: &PairArgs, cancel: &Cancel) -> anyhow::Result<()> {
    let code = match (&args.code, &args.camera) {
        (Some(code), _) => code.parse()?,
        (None, Some(camera)) => look_for_code(camera, args, cancel)?,
        (None, None) => bail!("give the pairing code, or --camera to read it from the wall"),
    };
    let name = format!("acquirer on {}", computer::name());
    let address = pair(&code, args.projector.as_deref(), &name)?;
    eprintln!("paired; from now on: --projector {address}");
    println!("{address}");
    Ok(())
}

fn look_for_code(
    spec: &CameraSpec,
    args: &PairArgs,
    cancel: &Cancel,
) -> anyhow::Result<PairingCode> {
    let config = args.config.load()?;
    let mut camera = open_camera(spec, &config.camera, None)?;
    let deadline = Instant::now() + LOOK;
    while Instant::now() < deadline && !cancel.is_cancelled() {
        let frame = camera.next_frame(FRAME_TIMEOUT)?;
        if let Some(code) = code_in(&frame.picture) {
            return Ok(code);
        }
    }
    bail!(
        "the camera saw no pairing code within {} s: point it at the projected QR code, so that it fills a good part \
         of the picture, or paste the code",
        LOOK.as_secs()
    )
}

/// The pairing code that a picture shows as a QR code.
#[must_use]
pub fn code_in(picture: &RgbImage) -> Option<PairingCode> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let mut prepared = rqrr::PreparedImage::prepare_from_greyscale(width, height, |x, y| {
        let [red, green, blue] = picture.get_pixel(x as u32, y as u32).0.map(u32::from);
        ((2 * red + 5 * green + blue) / 8) as u8
    });
    let found = prepared.detect_grids();
    let texts = found.iter().filter_map(|grid| grid.decode().ok());
    texts.filter_map(|(_, text)| text.parse().ok()).next()
}
