//! Accepts connections once the first picture is on the screen.

use std::net::SocketAddr;

use socket2::{SockRef, TcpKeepalive};
use tokio::{
    net::{TcpListener, TcpStream},
    sync::{mpsc, oneshot},
};

use super::{
    ControlSettings, EVENT_QUEUE, Listening,
    connection::{self, Event, Service},
    hub::{Hub, ScreenSide},
    places::Places,
};
use crate::{access::Access, clock::Clock, state::ConnectionId};

/// How often the projector looks whether a pairing code was opened.
const CODE_CHECK: std::time::Duration = std::time::Duration::from_secs(1);

/// Pause after the system refused a connection, so that a lasting lack of file handles costs no time.
const ACCEPT_PAUSE: std::time::Duration = std::time::Duration::from_millis(100);

/// A client of which nothing is heard for so long is asked whether it is still there, so often, so many times: one whose
/// network was cut is gone after 25 s.
const SILENCE: std::time::Duration = std::time::Duration::from_secs(10);
const ASK_EVERY: std::time::Duration = std::time::Duration::from_secs(5);
const ASK_TIMES: u32 = 3;

/// Runs the hub, and the connections once the first picture is shown.
pub(super) async fn serve(
    listening: Listening,
    settings: ControlSettings,
    screen: ScreenSide,
    clock: Clock,
    ready: impl FnOnce(SocketAddr),
) {
    let address = listening.address();
    let listener = match TcpListener::from_std(listening.listener) {
        Ok(listener) => listener,
        Err(error) => {
            tracing::error!("cannot listen on {address}: {error}");
            return;
        }
    };
    let places = Places::new(settings.max_connections);
    let (events, events_in) = mpsc::channel(EVENT_QUEUE);
    let service = Service {
        queue_messages: settings.queue_messages,
        access: settings.access.clone(),
        events: events.clone(),
        clock,
    };
    let access = settings.access.clone();
    let (shown, first_shown) = oneshot::channel();
    let accepting = async move {
        if first_shown.await.is_ok() {
            ready(address);
            accept_all(&listener, &places, &service).await;
        }
    };
    tokio::select! {
        () = Hub::run(settings, clock, screen, events_in, shown) => {}
        () = accepting => {}
        () = watch_codes(access.as_deref(), &events) => {}
    }
}

/// Tells the hub which pairing code is open, whoever opened it, for as long as there is a hub.
async fn watch_codes(access: Option<&Access>, events: &mpsc::Sender<Event>) {
    let Some(access) = access else {
        return std::future::pending().await;
    };
    let mut told = None;
    loop {
        match access.open_code() {
            Ok(open) => {
                let open = open.map(|code| code.to_string());
                if open != told {
                    told.clone_from(&open);
                    if events.send(Event::PairingCode(open)).await.is_err() {
                        return;
                    }
                }
            }
            Err(error) => tracing::warn!("pairing codes can't be looked up: {error}"),
        }
        tokio::time::sleep(CODE_CHECK).await;
    }
}

async fn accept_all(listener: &TcpListener, places: &Places, service: &Service) {
    for number in 1.. {
        let Some(chair) = places.chair().await else {
            return;
        };
        let (stream, peer) = match listener.accept().await {
            Ok(accepted) => accepted,
            Err(error) => {
                tracing::warn!("a connection was not accepted: {error}");
                tokio::time::sleep(ACCEPT_PAUSE).await;
                continue;
            }
        };
        if let Err(error) = prepare(&stream) {
            tracing::debug!(
                "{peer}: small messages and a cut network may be noticed late: {error}"
            );
        }
        let stranger = places.wait(number, peer.ip(), chair);
        tokio::spawn(connection::run(
            ConnectionId(number),
            stream,
            stranger,
            service.clone(),
        ));
    }
}

/// Messages go out at once, and a client whose network was cut is noticed.
fn prepare(stream: &TcpStream) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    let socket = SockRef::from(stream);
    let keepalive = TcpKeepalive::new()
        .with_time(SILENCE)
        .with_interval(ASK_EVERY)
        .with_retries(ASK_TIMES);
    socket.set_tcp_keepalive(&keepalive)?;
    // the same when something was sent that nobody acknowledges
    #[cfg(target_os = "linux")]
    socket.set_tcp_user_timeout(Some(SILENCE + ASK_EVERY * ASK_TIMES))?;
    Ok(())
}
