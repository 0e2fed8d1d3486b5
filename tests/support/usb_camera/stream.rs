//! The video endpoint: frames cut into payloads, each the answer to one read.

use std::time::{Duration, Instant};

use acquirer::camera::Camera;
use acquirer::clock::monotonic_now;
use image::codecs::jpeg::JpegEncoder;
use image::{RgbImage, imageops};

use super::descriptors::{Coding, PAYLOAD};
use super::requests::Mode;
use super::wire::{Replies, Submit};
use super::{LOOK, Shared, lock};
use crate::frame_server::yuyv;

/// Bytes before the data of a payload: their own number and the flags.
const HEAD: usize = 2;
/// Flags of a payload: one that changes from frame to frame, the last one of a frame, a frame that went wrong, and no
/// more head behind.
const PARITY: u8 = 0x01;
const LAST: u8 = 0x02;
const ERROR: u8 = 0x40;
const END_OF_HEAD: u8 = 0x80;
/// Longest wait for a frame of the room.
const PATIENCE: Duration = Duration::from_secs(20);
/// Quality of a webcam's MJPEG.
const JPEG_QUALITY: u8 = 90;

/// Trouble that was ordered and has not been had yet.
#[derive(Debug, Default)]
pub(super) struct Faults {
    /// Sends nothing for so long.
    pub(super) stall_ms: u64,
    /// So many frames are flagged as broken.
    pub(super) errors: u32,
    /// So many frames end half-way.
    pub(super) cut: u32,
}

/// What becomes of the next frame.
struct Fault {
    stall: Duration,
    error: bool,
    cut: bool,
}

impl Faults {
    fn next(&mut self) -> Fault {
        let one_of = |count: &mut u32| {
            let had = *count > 0;
            *count = count.saturating_sub(1);
            had
        };
        Fault {
            stall: Duration::from_millis(std::mem::take(&mut self.stall_ms)),
            error: one_of(&mut self.errors),
            cut: one_of(&mut self.cut),
        }
    }
}

/// Sends frames at the agreed rate while the driver streams, always the newest.
pub(super) fn send_frames(
    shared: &Shared,
    replies: &Replies,
    ended: &impl Fn() -> bool,
) -> anyhow::Result<()> {
    let (mut due, mut parity) = (Instant::now(), 0);
    while !ended() {
        let Some((mode, picture)) = next_picture(shared)? else {
            std::thread::sleep(LOOK);
            due = Instant::now();
            continue;
        };
        let fault = lock(&shared.faults).next();
        std::thread::sleep(fault.stall);
        let frame = coded(&picture, mode.coding())?;
        let length = frame.len() / if fault.cut { 2 } else { 1 };
        let flags = END_OF_HEAD | parity | if fault.error { ERROR } else { 0 };
        parity ^= PARITY;
        let still = || !ended() && lock(&shared.device).streams == Some(mode);
        let mut pieces = frame[..length].chunks(PAYLOAD - HEAD).peekable();
        while let Some(piece) = pieces.next() {
            let Some(read) = next_read(shared, &still) else {
                break;
            };
            let last = if pieces.peek().is_none() { LAST } else { 0 };
            let payload = [&[HEAD as u8, flags | last], piece].concat();
            replies.data(&read, &payload)?;
        }
        let frame_time = Duration::from_nanos(100 * u64::from(mode.interval));
        due = (due + frame_time).max(Instant::now());
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    Ok(())
}

/// The newest picture in the size that is streamed; nothing while there is no stream.
fn next_picture(shared: &Shared) -> anyhow::Result<Option<(Mode, RgbImage)>> {
    let mut device = lock(&shared.device);
    let Some(mode) = device.streams else {
        return Ok(None);
    };
    let picture = device
        .camera
        .frame_after(monotonic_now(), PATIENCE)?
        .picture;
    let [width, height] = mode.size(device.size);
    Ok(Some(if picture.dimensions() == (width, height) {
        (mode, picture)
    } else {
        (mode, imageops::thumbnail(&picture, width, height))
    }))
}

/// The driver's next read; nothing when it has stopped streaming.
fn next_read(shared: &Shared, still: &impl Fn() -> bool) -> Option<Submit> {
    let mut pending = lock(&shared.pending);
    while pending.is_empty() {
        let waited = shared.arrived.wait_timeout(pending, LOOK);
        pending = waited.unwrap_or_else(std::sync::PoisonError::into_inner).0;
        if pending.is_empty() && !still() {
            return None;
        }
    }
    Some(pending.remove(0))
}

fn coded(picture: &RgbImage, coding: Coding) -> anyhow::Result<Vec<u8>> {
    Ok(match coding {
        Coding::Yuyv => yuyv(picture),
        Coding::Mjpeg => {
            let mut bytes = Vec::new();
            JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY).encode_image(picture)?;
            bytes
        }
    })
}
