//! The simulated room as a stream of frames over TCP, for a camera device in the guest.
//!
//! Takes a scene and a running projector, serves what the room's camera sees: a line `WIDTH HEIGHT
//! RATE`, then YUYV frames (BT.601, limited range, as a webcam sends them), each acknowledged by a byte, to
//! one `frame_feeder` after the other. A second port takes the lines `background` and `object`, in
//! the place of the person who puts the object in, and answers `done`.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use acquirer::camera::{Camera, SimulatedCamera};
use image::RgbImage;
use shared::stage::Stage;

use crate::listening::{Threads, client, listener};

/// Longest wait for a frame of the room, and for its object to be put in.
const PATIENCE: Duration = Duration::from_secs(20);

/// A stage to change to, and where to say that it is done.
type Change = (Stage, SyncSender<()>);

/// A server that runs until it is dropped.
#[derive(Debug)]
pub struct FrameServer {
    frames: SocketAddr,
    stages: SocketAddr,
    _threads: Threads,
}

impl FrameServer {
    /// Opens the room of a scene in front of a projector (`HOST:PORT`) and serves `rate` frames a
    /// second.
    ///
    /// # Errors
    /// When the room cannot be opened or no port is free.
    pub fn start(scene: &str, projector: &str, rate: u32) -> anyhow::Result<Self> {
        let camera = SimulatedCamera::open(scene, projector)?;
        let (frames, stages) = (listener()?, listener()?);
        let addresses = (frames.local_addr()?, stages.local_addr()?);
        let (change, changes) = sync_channel(1);
        let mut threads = Threads::default();
        threads.start(move |stop| {
            let mut room = Room {
                camera,
                changes,
                rate: rate.max(1),
                stop: Arc::clone(stop),
            };
            room.serve(&frames);
        });
        threads.start(move |stop| take_stages(&stages, &change, stop));
        Ok(Self {
            frames: addresses.0,
            stages: addresses.1,
            _threads: threads,
        })
    }

    /// Port of the frames, on this machine.
    #[must_use]
    pub fn frame_port(&self) -> u16 {
        self.frames.port()
    }

    /// Port that takes the stage.
    #[must_use]
    pub fn stage_port(&self) -> u16 {
        self.stages.port()
    }
}

fn take_stages(listener: &TcpListener, change: &SyncSender<Change>, stop: &AtomicBool) {
    while let Some(mut stream) = client(listener, stop) {
        let mut line = String::new();
        let read = stream
            .try_clone()
            .and_then(|stream| BufReader::new(stream).read_line(&mut line));
        let stage = Stage::BOTH
            .into_iter()
            .find(|stage| read.is_ok() && stage.name() == line.trim());
        let answer = stage.map_or("unknown stage\n", |stage| {
            let (done, answer) = sync_channel(1);
            let changed =
                change.send((stage, done)).is_ok() && answer.recv_timeout(PATIENCE).is_ok();
            if changed { "done\n" } else { "failed\n" }
        });
        stream.write_all(answer.as_bytes()).ok(); // whoever asked may have gone
    }
}

struct Room {
    camera: SimulatedCamera,
    changes: Receiver<Change>,
    rate: u32,
    stop: Arc<AtomicBool>,
}

impl Room {
    fn serve(&mut self, listener: &TcpListener) {
        let stop = Arc::clone(&self.stop);
        while let Some(stream) = client(listener, &stop) {
            if let Err(error) = self.send_frames(stream) {
                eprintln!("frame server: the feeder has gone: {error}");
            }
        }
    }

    /// Sends frames at the server's rate, always the newest, until the client or the server ends.
    fn send_frames(&mut self, mut stream: TcpStream) -> anyhow::Result<()> {
        let format = self.camera.format();
        stream.set_write_timeout(Some(PATIENCE))?;
        stream.set_read_timeout(Some(PATIENCE))?;
        writeln!(stream, "{} {} {}", format.width, format.height, self.rate)?;
        let mut due = Instant::now();
        while !self.stop.load(Ordering::Relaxed) {
            self.change_stage();
            let frame = self.camera.next_frame(PATIENCE)?;
            stream.write_all(&yuyv(&frame.picture))?;
            stream.read_exact(&mut [0])?; // the feeder has taken it
            due = (due + Duration::from_secs(1) / self.rate).max(Instant::now());
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
        Ok(())
    }

    fn change_stage(&mut self) {
        if let Ok((stage, done)) = self.changes.try_recv() {
            self.camera.set_stage(stage);
            done.send(()).ok(); // whoever asked may have gone
        }
    }
}

/// A picture as packed 4:2:2; of an odd width the last column is left out.
pub(crate) fn yuyv(picture: &RgbImage) -> Vec<u8> {
    let pairs = picture
        .as_raw()
        .chunks_exact(picture.width().max(1) as usize * 3)
        .flat_map(|row| row.chunks_exact(6));
    pairs
        .flat_map(|pair| {
            let (left, right) = (yuv(&pair[..3]), yuv(&pair[3..]));
            let mean = |k: usize| ((left[k] + right[k] + 1) / 2) as u8;
            [left[0] as u8, mean(1), right[0] as u8, mean(2)]
        })
        .collect()
}

/// BT.601 in limited range: luma 16 to 235, chroma 16 to 240.
fn yuv(rgb: &[u8]) -> [i32; 3] {
    let [r, g, b] = [0, 1, 2].map(|channel| i32::from(rgb[channel]));
    [
        ((66 * r + 129 * g + 25 * b + 128) >> 8) + 16,
        ((-38 * r - 74 * g + 112 * b + 128) >> 8) + 128,
        ((112 * r - 94 * g - 18 * b + 128) >> 8) + 128,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_black_and_red_become_the_bytes_of_bt601() {
        let colours = [[255, 255, 255], [0, 0, 0], [255, 0, 0], [255, 0, 0]].concat();
        let picture = RgbImage::from_raw(4, 1, colours).unwrap();
        assert_eq!(yuyv(&picture), [235, 128, 16, 128, 82, 90, 82, 240]);
    }
}
