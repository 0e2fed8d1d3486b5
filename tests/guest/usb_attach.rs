//! Hands a USB device that comes over TCP to the guest's kernel, as if it had been plugged in.
//!
//! Takes an address at which a device of the tests is served; the kernel's virtual USB host keeps the connection.

use std::fs;
use std::net::TcpStream;
use std::os::fd::AsRawFd;

use anyhow::Context;

/// Where the kernel takes devices.
const ATTACH: &str = "/sys/devices/platform/vhci_hcd.0/attach";
/// The first port for fast devices, a number that tells devices apart, and USB 2.0's high speed.
const PORT: u32 = 0;
const DEVICE: u32 = 1 << 16 | 1;
const HIGH_SPEED: u32 = 3;

fn main() -> anyhow::Result<()> {
    let address = std::env::args().nth(1).context("usb_attach HOST:PORT")?;
    let device =
        TcpStream::connect(&address).with_context(|| format!("connecting to {address}"))?;
    let order = format!("{PORT} {} {DEVICE} {HIGH_SPEED}", device.as_raw_fd());
    fs::write(ATTACH, order).with_context(|| format!("writing to {ATTACH}"))
}
