//! Our own V4L2 backend behind nokhwa's camera interface.
//!
//! Takes a device and a mode, gives buffers cut to what the driver filled, and beside each the
//! facts that nokhwa's interface has no place for: sequence number, time stamp, and what became of
//! it. Waiting has a limit, so the thread that owns the camera can be stopped and can tell a stall
//! from an unplugged device.

mod interface;

use std::cell::Cell;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Duration;

use nokhwa::NokhwaError;
use nokhwa::utils::{CameraIndex, CameraInfo as NokhwaInfo};
use v4l::buffer::{Flags, Metadata, Type};
use v4l::format::{FourCC, Quantization};
use v4l::fraction::Fraction;
use v4l::io::traits::{CaptureStream, Stream};
use v4l::prelude::MmapStream;
use v4l::video::Capture;
use v4l::video::capture::Parameters;
use v4l::{Device, Format};

use super::list::{self, CameraInfo, guarded};
use crate::camera::pixels::Layout;
use crate::camera::{CameraError, CaptureFormat, PixelFormat, Rate};

/// Another program holds the device.
pub(super) const EBUSY: i32 = 16;
/// The device has gone.
const ENODEV: i32 = 19;
/// `poll` for a filled buffer.
const POLLIN: i16 = 1;
/// One being read, one being filled, one waiting: more would only hold older frames.
const BUFFERS: u32 = 3;
/// V4L2 gives at most this many buffers (VIDEO_MAX_FRAME).
const MOST_BUFFERS: usize = 32;
/// Longest wait for a frame before the thread looks whether it should stop.
const WAIT: Duration = Duration::from_millis(200);

/// What became of the last call for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// A whole buffer.
    Good,
    /// The driver marked the buffer as broken.
    Damaged,
    /// No frame within [`WAIT`].
    Nothing,
    /// The device has gone.
    Gone,
    /// Another program streams from the device.
    Busy,
    /// The stream failed and must be started again.
    Failed,
}

/// What nokhwa's buffer cannot carry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    /// The driver's frame number, from 0 at each start of the stream.
    pub(super) sequence: u32,
    /// The driver's stamp, if it is on the monotonic clock.
    pub(super) stamp: Option<Duration>,
    /// What became of the frame.
    pub(super) outcome: Outcome,
}

/// An opened device.
pub(super) struct Backend {
    path: PathBuf,
    device: Device,
    camera: CameraInfo,
    nokhwa_info: NokhwaInfo,
    mode: CaptureFormat,
    layout: Layout,
    stream: Option<MmapStream<'static>>,
    facts: Rc<Cell<Facts>>,
}

impl Backend {
    /// Opens a device in the mode that `choose` picks from what it offers.
    pub(super) fn open(
        path: &Path,
        choose: impl FnOnce(&CameraInfo) -> Option<CaptureFormat>,
    ) -> Result<Self, CameraError> {
        let (device, identity) = list::identify(path)?;
        let camera = CameraInfo {
            formats: list::formats_of(&device),
            ..identity
        };
        let Some(mode) = choose(&camera) else {
            let codes: Vec<_> = camera
                .formats
                .iter()
                .map(|format| format.fourcc.as_str())
                .collect();
            let offered = if codes.is_empty() {
                "nothing".into()
            } else {
                codes.join(", ")
            };
            return Err(CameraError::NoUsableFormat {
                path: path.into(),
                offered,
            });
        };
        let layout = Layout {
            format: mode.pixels,
            width: mode.width,
            height: mode.height,
            stride: 0,
            full_range: false,
        };
        let index = CameraIndex::String(path.display().to_string());
        let mut backend = Self {
            path: path.into(),
            nokhwa_info: NokhwaInfo::new(&camera.name, &camera.driver, &camera.bus, index),
            device,
            camera,
            mode,
            layout,
            stream: None,
            facts: Rc::new(Cell::new(Facts {
                sequence: 0,
                stamp: None,
                outcome: Outcome::Nothing,
            })),
        };
        backend
            .apply(mode)
            .map_err(|error| backend.setup_error("setting the format", &error))?;
        Ok(backend)
    }

    pub(super) fn camera(&self) -> &CameraInfo {
        &self.camera
    }

    pub(super) fn mode(&self) -> CaptureFormat {
        self.mode
    }

    pub(super) fn layout(&self) -> Layout {
        self.layout
    }

    /// Shared with the thread that calls nokhwa: the facts of the last frame.
    pub(super) fn facts(&self) -> Rc<Cell<Facts>> {
        Rc::clone(&self.facts)
    }

    /// The error of a step of setting up, in the operator's words.
    fn setup_error(&self, step: &'static str, error: &io::Error) -> CameraError {
        match error.raw_os_error() {
            Some(EBUSY) => CameraError::Busy {
                path: self.path.clone(),
            },
            Some(ENODEV) => CameraError::Unplugged {
                name: self.camera.name.clone(),
            },
            _ => CameraError::Setup {
                path: self.path.clone(),
                step,
                reason: error.to_string(),
            },
        }
    }

    /// Sets format and rate. Always both: the device may stand at any rate, and setting the format
    /// may change it.
    fn apply(&mut self, mode: CaptureFormat) -> io::Result<()> {
        let fourcc = fourcc(mode.pixels);
        let wanted = Format::new(mode.width, mode.height, fourcc);
        let got = guarded(|| self.device.set_format(&wanted))?;
        if (got.width, got.height, got.fourcc) != (mode.width, mode.height, fourcc) {
            let reason = format!(
                "{mode} was asked for, the driver chose {}x{} {}",
                got.width, got.height, got.fourcc
            );
            return Err(io::Error::other(reason));
        }
        let (numerator, denominator) = mode.rate.fraction();
        let interval = Parameters::new(Fraction::new(denominator, numerator));
        let rate = match guarded(|| self.device.set_params(&interval)) {
            Ok(set) => {
                Rate::new(set.interval.denominator, set.interval.numerator).unwrap_or(mode.rate)
            }
            // Some drivers know one rate only and refuse the question.
            Err(error) if error.raw_os_error() != Some(EBUSY) => mode.rate,
            Err(error) => return Err(error),
        };
        let full_range = matches!(got.quantization, Quantization::FullRange);
        self.layout = Layout {
            format: mode.pixels,
            width: mode.width,
            height: mode.height,
            stride: got.stride as usize,
            full_range,
        };
        self.mode = CaptureFormat { rate, ..mode };
        Ok(())
    }

    /// Maps the buffers and starts the stream.
    ///
    /// All buffers but the first are queued here, because the stream's `next` queues the one that
    /// it gave last, and it takes the first for that. Left to itself, `next` would queue a buffer
    /// twice after a time-out.
    fn start(&mut self) -> io::Result<()> {
        self.stop();
        let mut stream =
            guarded(|| MmapStream::with_buffers(&self.device, Type::VideoCapture, BUFFERS))?;
        stream.set_timeout(WAIT);
        for index in 1..MOST_BUFFERS {
            if CaptureStream::queue(&mut stream, index).is_err() {
                break; // the driver gave fewer buffers
            }
        }
        stream.start()?;
        self.stream = Some(stream);
        Ok(())
    }

    /// Stops the stream. The v4l crate panics if the driver refuses, which a failing device does.
    fn stop(&mut self) {
        if let Some(stream) = self.stream.take()
            && catch_unwind(AssertUnwindSafe(|| drop(stream))).is_err()
        {
            tracing::debug!(camera = %self.camera.name, "the driver refused to stop the stream");
        }
    }

    /// The next buffer, cut to what the driver filled.
    fn grab(&mut self) -> io::Result<(&[u8], Facts)> {
        let stream = self
            .stream
            .as_mut()
            .ok_or_else(|| io::Error::other("the stream is not open"))?;
        if stream
            .handle()
            .poll(POLLIN, i32::try_from(WAIT.as_millis()).unwrap_or(i32::MAX))?
            == 0
        {
            return Err(io::ErrorKind::TimedOut.into());
        }
        let (bytes, meta) = CaptureStream::next(stream)?;
        let facts = Facts::of(meta);
        // Some drivers leave the length at zero and mean the whole buffer.
        let filled = if meta.bytesused == 0 {
            bytes.len()
        } else {
            bytes.len().min(meta.bytesused as usize)
        };
        Ok((&bytes[..filled], facts))
    }

    /// The next buffer with its outcome noted for the thread that asked.
    fn next_buffer(&mut self) -> Result<&[u8], NokhwaError> {
        let noted = Rc::clone(&self.facts);
        let (outcome, reason) = match self.grab() {
            Ok((bytes, facts)) => {
                noted.set(facts);
                if facts.outcome == Outcome::Good {
                    return Ok(bytes);
                }
                return Err(NokhwaError::ReadFrameError(
                    "the driver marked the frame as broken".into(),
                ));
            }
            Err(error) if error.kind() == io::ErrorKind::TimedOut => (Outcome::Nothing, error),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => (Outcome::Nothing, error),
            Err(error) if error.raw_os_error() == Some(ENODEV) => (Outcome::Gone, error),
            Err(error) => (Outcome::Failed, error),
        };
        noted.set(Facts {
            outcome,
            ..noted.get()
        });
        Err(NokhwaError::ReadFrameError(reason.to_string()))
    }
}

impl Facts {
    fn of(meta: &Metadata) -> Self {
        let monotonic = u32::from(meta.flags) & u32::from(Flags::TIMESTAMP_MASK)
            == u32::from(Flags::TIMESTAMP_MONOTONIC);
        let seconds = u64::try_from(meta.timestamp.sec).ok();
        let micros = u64::try_from(meta.timestamp.usec).ok();
        let stamp = seconds
            .zip(micros)
            .map(|(s, us)| Duration::from_secs(s).saturating_add(Duration::from_micros(us)));
        let outcome = if meta.flags.contains(Flags::ERROR) {
            Outcome::Damaged
        } else {
            Outcome::Good
        };
        Self {
            sequence: meta.sequence,
            stamp: stamp.filter(|stamp| monotonic && !stamp.is_zero()),
            outcome,
        }
    }
}

fn fourcc(format: PixelFormat) -> FourCC {
    let code = format.fourcc().as_bytes();
    FourCC::new(&[code[0], code[1], code[2], code[3]])
}
