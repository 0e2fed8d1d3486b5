//! The backend as nokhwa sees it: its trait, in its words.
//!
//! nokhwa knows whole rates only; ours are rounded for it, while the device keeps the exact one.

use std::borrow::Cow;
use std::collections::HashMap;
use std::rc::Rc;

use nokhwa::camera_traits::CaptureBackendTrait;
use nokhwa::utils::{
    ApiBackend, CameraControl, CameraFormat, CameraInfo as NokhwaInfo, ControlValueSetter,
    FrameFormat, KnownCameraControl, Resolution,
};
use nokhwa::{Buffer, NokhwaError};

use super::super::modes;
use super::{Backend, EBUSY, ENODEV, Facts, Outcome};
use crate::camera::{CaptureFormat, PixelFormat, Rate};

/// nokhwa's name of a format; it calls V4L2's GREY "GRAY", which is why its own backend finds no
/// grey camera.
fn nokhwa_format(format: PixelFormat) -> FrameFormat {
    match format {
        PixelFormat::Yuyv => FrameFormat::YUYV,
        PixelFormat::Nv12 => FrameFormat::NV12,
        PixelFormat::Rgb => FrameFormat::RAWRGB,
        PixelFormat::Bgr => FrameFormat::RAWBGR,
        PixelFormat::Mjpeg => FrameFormat::MJPEG,
        PixelFormat::Grey => FrameFormat::GRAY,
    }
}

fn from_nokhwa(format: FrameFormat) -> PixelFormat {
    PixelFormat::ALL
        .into_iter()
        .find(|ours| nokhwa_format(*ours) == format)
        .unwrap_or(PixelFormat::Yuyv)
}

fn unsupported(what: &str) -> NokhwaError {
    NokhwaError::GeneralError(format!(
        "{what} is set by its V4L2 number on a second handle"
    ))
}

impl CaptureBackendTrait for Backend {
    fn backend(&self) -> ApiBackend {
        ApiBackend::Video4Linux
    }

    fn camera_info(&self) -> &NokhwaInfo {
        &self.nokhwa_info
    }

    fn refresh_camera_format(&mut self) -> Result<(), NokhwaError> {
        Ok(()) // nobody else can change it while the device is open
    }

    fn camera_format(&self) -> CameraFormat {
        CameraFormat::new(self.resolution(), self.frame_format(), self.frame_rate())
    }

    fn set_camera_format(&mut self, wanted: CameraFormat) -> Result<(), NokhwaError> {
        let streaming = self.is_stream_open();
        self.stop(); // a driver refuses another format while buffers exist
        let mode = CaptureFormat {
            width: wanted.width(),
            height: wanted.height(),
            rate: Rate::per_second(wanted.frame_rate()),
            pixels: from_nokhwa(wanted.format()),
        };
        self.apply(mode)
            .map_err(|error| NokhwaError::GeneralError(error.to_string()))?;
        if streaming {
            self.open_stream()
        } else {
            Ok(())
        }
    }

    fn compatible_list_by_resolution(
        &mut self,
        wanted: FrameFormat,
    ) -> Result<HashMap<Resolution, Vec<u32>>, NokhwaError> {
        let code = from_nokhwa(wanted).fourcc();
        let sizes = self
            .camera
            .formats
            .iter()
            .filter(|format| format.fourcc == code)
            .flat_map(|format| &format.sizes);
        let rates = |rates: &[Rate]| rates.iter().map(|rate| modes::whole(*rate)).collect();
        Ok(sizes
            .map(|size| (Resolution::new(size.width, size.height), rates(&size.rates)))
            .collect())
    }

    fn compatible_fourcc(&mut self) -> Result<Vec<FrameFormat>, NokhwaError> {
        let codes = self
            .camera
            .formats
            .iter()
            .map(|format| format.fourcc.as_str());
        Ok(codes
            .filter_map(PixelFormat::from_fourcc)
            .map(nokhwa_format)
            .collect())
    }

    fn resolution(&self) -> Resolution {
        Resolution::new(self.mode.width, self.mode.height)
    }

    fn set_resolution(&mut self, resolution: Resolution) -> Result<(), NokhwaError> {
        self.set_camera_format(CameraFormat::new(
            resolution,
            self.frame_format(),
            self.frame_rate(),
        ))
    }

    fn frame_rate(&self) -> u32 {
        modes::whole(self.mode.rate)
    }

    fn set_frame_rate(&mut self, rate: u32) -> Result<(), NokhwaError> {
        self.set_camera_format(CameraFormat::new(
            self.resolution(),
            self.frame_format(),
            rate,
        ))
    }

    fn frame_format(&self) -> FrameFormat {
        nokhwa_format(self.mode.pixels)
    }

    fn set_frame_format(&mut self, format: FrameFormat) -> Result<(), NokhwaError> {
        self.set_camera_format(CameraFormat::new(
            self.resolution(),
            format,
            self.frame_rate(),
        ))
    }

    fn camera_control(&self, control: KnownCameraControl) -> Result<CameraControl, NokhwaError> {
        Err(unsupported(&control.to_string()))
    }

    fn camera_controls(&self) -> Result<Vec<CameraControl>, NokhwaError> {
        Ok(vec![])
    }

    fn set_camera_control(
        &mut self,
        id: KnownCameraControl,
        _value: ControlValueSetter,
    ) -> Result<(), NokhwaError> {
        Err(unsupported(&id.to_string()))
    }

    fn open_stream(&mut self) -> Result<(), NokhwaError> {
        self.start().map_err(|error| {
            let outcome = match error.raw_os_error() {
                Some(ENODEV) => Outcome::Gone,
                Some(EBUSY) => Outcome::Busy,
                _ => Outcome::Failed,
            };
            self.facts.set(Facts {
                outcome,
                ..self.facts.get()
            });
            NokhwaError::OpenStreamError(
                self.setup_error("starting the stream", &error).to_string(),
            )
        })
    }

    fn is_stream_open(&self) -> bool {
        self.stream.is_some()
    }

    fn frame(&mut self) -> Result<Buffer, NokhwaError> {
        let (resolution, format) = (self.resolution(), self.frame_format());
        let stamps = Rc::clone(&self.facts);
        let bytes = self.next_buffer()?;
        Ok(Buffer::with_timestamp(
            resolution,
            bytes,
            format,
            stamps.get().stamp,
        ))
    }

    fn frame_raw(&mut self) -> Result<Cow<'_, [u8]>, NokhwaError> {
        self.next_buffer().map(Cow::Borrowed)
    }

    fn stop_stream(&mut self) -> Result<(), NokhwaError> {
        self.stop();
        Ok(())
    }
}
