//! A network between the programs that is slow and loses packets: a relay that holds bytes back.
//!
//! TCP makes up for a lost packet by sending it again, so a client sees it as a pause: that is what this does, with a
//! pause of a usual retransmission.

use std::{
    io::{Read, Write},
    net::{Shutdown, SocketAddr, TcpListener, TcpStream},
    sync::mpsc,
    thread,
    time::{Duration, Instant},
};

/// How bad the network is.
#[derive(Debug, Clone, Copy)]
pub struct Network {
    /// From one end to the other.
    pub delay: Duration,
    /// One of so many packets is lost.
    pub loses_one_in: u32,
    /// How long a lost packet takes more.
    pub retransmission: Duration,
}

/// Opens a port of this computer from which everything goes to `target` through the network, for as long as the program
/// lives.
///
/// # Errors
/// No free port.
pub fn relay(target: &str, network: Network) -> anyhow::Result<SocketAddr> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let (address, target) = (listener.local_addr()?, target.to_owned());
    thread::spawn(move || {
        for client in listener.incoming().flatten() {
            let Ok(server) = TcpStream::connect(&target) else {
                continue;
            };
            for (from, to, seed) in [(&client, &server, 7), (&server, &client, 11)] {
                if let (Ok(from), Ok(to)) = (from.try_clone(), to.try_clone()) {
                    carry(from, to, network, seed);
                }
            }
        }
    });
    Ok(address)
}

/// Carries one direction, in its order, each piece when it is due.
fn carry(mut from: TcpStream, mut to: TcpStream, network: Network, seed: u32) {
    let (pieces, due) = mpsc::sync_channel::<(Instant, Vec<u8>)>(1024);
    thread::spawn(move || {
        let (mut chunk, mut random) = ([0; 1400], seed);
        while let Ok(count @ 1..) = from.read(&mut chunk) {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let lost = (random >> 16).is_multiple_of(network.loses_one_in);
            let pause = if lost {
                network.retransmission
            } else {
                Duration::ZERO
            };
            let at = Instant::now() + network.delay + pause;
            if pieces.send((at, chunk[..count].to_vec())).is_err() {
                return;
            }
        }
    });
    thread::spawn(move || {
        for (at, piece) in due {
            thread::sleep(at.saturating_duration_since(Instant::now()));
            if to.write_all(&piece).is_err() {
                break;
            }
        }
        // the other end may have gone already
        to.shutdown(Shutdown::Write).ok();
    });
}
