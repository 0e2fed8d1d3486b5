//! What the device tells of itself: a camera of the USB video class 1.0.
//!
//! "Universal Serial Bus Device Class Definition for Video Devices", revision 1.1, section 3, and the documents on
//! uncompressed and MJPEG payloads. All numbers are little-endian.

/// Numbers of the entities behind which the controls are.
pub(super) const CAMERA: u8 = 1;
pub(super) const PROCESSING: u8 = 2;
const OUTPUT: u8 = 3;
/// Interfaces.
pub(super) const CONTROL: u8 = 0;
pub(super) const STREAMING: u8 = 1;
/// The endpoint that frames come from.
const VIDEO: u8 = 0x81;
/// Bytes of one payload, which is one read of the driver: 32 packets of a fast bulk endpoint.
pub(super) const PAYLOAD: usize = 16384;
/// Frame times offered for each size, in units of 100 ns: 29.97, 15, 10, 5 and 2 frames a second.
pub(super) const INTERVALS: [u32; 5] = [333_667, 666_667, 1_000_000, 2_000_000, 5_000_000];

/// How pixels are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    Yuyv,
    Mjpeg,
}

/// In the order of their numbers, which begin at 1.
pub(super) const CODINGS: [Coding; 2] = [Coding::Yuyv, Coding::Mjpeg];

/// The sizes of each coding, in the order of their numbers, which begin at 1: the camera's own and half of it.
pub(super) fn sizes([width, height]: [u32; 2]) -> [[u32; 2]; 2] {
    [[width, height], [width / 2, height / 2]]
}

/// Bytes of the largest frame of a size.
pub(super) fn most_bytes([width, height]: [u32; 2]) -> u32 {
    2 * width * height
}

/// The device descriptor.
pub(super) fn device() -> Vec<u8> {
    let mut bytes = vec![18, 1];
    bytes.extend(0x0200_u16.to_le_bytes());
    bytes.extend([0xef, 2, 1, 64]); // functions are told by association
    bytes.extend(0x1209_u16.to_le_bytes()); // pid.codes, whose product 1 is for tests
    bytes.extend(0x0001_u16.to_le_bytes());
    bytes.extend(0x0100_u16.to_le_bytes());
    bytes.extend([1, 2, 3, 1]);
    bytes
}

/// A string descriptor; 0 is the list of languages.
pub(super) fn string(number: u8) -> Option<Vec<u8>> {
    let text = match number {
        0 => return Some(vec![4, 3, 0x09, 0x04]),
        1 => "rig tests",
        2 => "Simulated USB camera",
        3 => "0001",
        _ => return None,
    };
    let units: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let mut bytes = vec![2 + units.len() as u8, 3];
    bytes.extend(units);
    Some(bytes)
}

/// The configuration with all that belongs to it, for a camera of this size.
pub(super) fn configuration(size: [u32; 2]) -> Vec<u8> {
    let mut body = vec![8, 11, CONTROL, 2, 0x0e, 3, 0, 2];
    body.extend([9, 4, CONTROL, 0, 0, 0x0e, 1, 0, 2]);
    body.extend(video_control());
    body.extend([9, 4, STREAMING, 0, 1, 0x0e, 2, 0, 0]);
    body.extend(video_streaming(size));
    body.extend([7, 5, VIDEO, 2]);
    body.extend(512_u16.to_le_bytes());
    body.push(0);
    let mut bytes = vec![9, 2];
    bytes.extend((9 + body.len() as u16).to_le_bytes());
    bytes.extend([2, 1, 0, 0x80, 250]);
    bytes.extend(body);
    bytes
}

/// The entities: camera, processing unit, output.
fn video_control() -> Vec<u8> {
    // exposure mode and time; white balance and its automatic, gain, mains frequency
    let (camera_controls, processing_controls): (u32, u16) =
        (1 << 1 | 1 << 3, 1 << 6 | 1 << 9 | 1 << 10 | 1 << 12);
    let mut body = vec![18, 0x24, 2, CAMERA, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3];
    body.extend(&camera_controls.to_le_bytes()[..3]);
    body.extend([11, 0x24, 5, PROCESSING, CAMERA, 0, 0, 2]);
    body.extend(processing_controls.to_le_bytes());
    body.push(0);
    body.extend([9, 0x24, 3, OUTPUT, 0x01, 0x01, 0, PROCESSING, 0]);
    let mut bytes = vec![13, 0x24, 1];
    bytes.extend(0x0100_u16.to_le_bytes());
    bytes.extend((13 + body.len() as u16).to_le_bytes());
    bytes.extend(1_000_000_u32.to_le_bytes());
    bytes.extend([1, STREAMING]);
    bytes.extend(body);
    bytes
}

/// The formats with their sizes and rates.
fn video_streaming(size: [u32; 2]) -> Vec<u8> {
    const YUY2: [u8; 16] = [
        b'Y', b'U', b'Y', b'2', 0, 0, 0x10, 0, 0x80, 0, 0, 0xaa, 0, 0x38, 0x9b, 0x71,
    ];
    let mut body = Vec::new();
    for (number, coding) in (1..).zip(CODINGS) {
        let sizes = sizes(size);
        let count = sizes.len() as u8;
        let kind = match coding {
            Coding::Yuyv => {
                body.extend([27, 0x24, 4, number, count]);
                body.extend(YUY2);
                body.extend([16, 1, 0, 0, 0, 0]);
                5
            }
            Coding::Mjpeg => {
                body.extend([11, 0x24, 6, number, count, 1, 1, 0, 0, 0, 0]);
                7
            }
        };
        for (number, size) in (1..).zip(sizes) {
            body.extend(frame(kind, number, size));
        }
        body.extend([6, 0x24, 0x0d, 1, 1, 4]);
    }
    let count = CODINGS.len() as u8;
    let mut bytes = vec![13 + count, 0x24, 1, count];
    bytes.extend((13 + u16::from(count) + body.len() as u16).to_le_bytes());
    bytes.extend([VIDEO, 0, OUTPUT, 0, 0, 0, 1]);
    bytes.extend(CODINGS.map(|_| 0));
    bytes.extend(body);
    bytes
}

fn frame(kind: u8, number: u8, size: [u32; 2]) -> Vec<u8> {
    let count = INTERVALS.len() as u8;
    let most = most_bytes(size);
    let mut bytes = vec![26 + 4 * count, 0x24, kind, number, 0];
    bytes.extend(size.map(|length| (length as u16).to_le_bytes()).concat());
    let rate = |interval: u32| (u64::from(most) * 8 * 10_000_000 / u64::from(interval)) as u32;
    let rates = INTERVALS.map(rate);
    bytes.extend(rates[rates.len() - 1].to_le_bytes());
    bytes.extend(rates[0].to_le_bytes());
    bytes.extend(most.to_le_bytes());
    bytes.extend(INTERVALS[0].to_le_bytes());
    bytes.push(count);
    bytes.extend(INTERVALS.map(u32::to_le_bytes).concat());
    bytes
}
