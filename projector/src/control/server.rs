//! Accepts connections, as many as allowed, once the first picture is on the screen.

use std::net::SocketAddr;

use shared::protocol::{ErrorCode, ServerMessage, encode};
use tokio::{
    io::AsyncWriteExt,
    net::{TcpListener, TcpStream},
    sync::{Semaphore, mpsc, oneshot},
};

use super::{
    ControlSettings, EVENT_QUEUE, Listening,
    connection::{self, Event},
    hub::{Hub, ScreenSide},
};
use crate::{clock::Clock, state::ConnectionId};

/// Pause after the system refused a connection, so that a lasting lack of file handles costs no time.
const ACCEPT_PAUSE: std::time::Duration = std::time::Duration::from_millis(100);

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
    let limits = Limits {
        connections: settings.max_connections,
        queue: settings.queue_messages,
    };
    let (events, events_in) = mpsc::channel(EVENT_QUEUE);
    let (shown, first_shown) = oneshot::channel();
    let accepting = async move {
        if first_shown.await.is_ok() {
            ready(address);
            accept_all(&listener, &limits, &events, clock).await;
        }
    };
    tokio::select! {
        () = Hub::run(settings, screen, events_in, shown) => {}
        () = accepting => {}
    }
}

struct Limits {
    connections: usize,
    queue: usize,
}

async fn accept_all(
    listener: &TcpListener,
    limits: &Limits,
    events: &mpsc::Sender<Event>,
    clock: Clock,
) {
    let places = std::sync::Arc::new(Semaphore::new(limits.connections));
    for number in 1.. {
        let (stream, peer) = match listener.accept().await {
            Ok(accepted) => accepted,
            Err(error) => {
                tracing::warn!("a connection was not accepted: {error}");
                tokio::time::sleep(ACCEPT_PAUSE).await;
                continue;
            }
        };
        let Ok(place) = places.clone().try_acquire_owned() else {
            tracing::warn!(
                "{peer} refused: {} connections are open",
                limits.connections
            );
            refuse(stream, limits.connections);
            continue;
        };
        if let Err(error) = stream.set_nodelay(true) {
            tracing::debug!("{peer}: small messages may be delayed: {error}");
        }
        let (events, queue) = (events.clone(), limits.queue);
        tokio::spawn(async move {
            connection::run(ConnectionId(number), stream, queue, events, clock).await;
            drop(place);
        });
    }
}

/// Tells a client that there is no place, without waiting for it: a fresh connection takes one short line
/// at once, and one that does not is not told.
fn refuse(mut stream: TcpStream, most: usize) {
    let message = ServerMessage::Error {
        id: None,
        code: ErrorCode::Full,
        message: format!(
            "{most} connections are open already, the most that is allowed: close one"
        ),
    };
    tokio::spawn(async move {
        let line = encode(&message);
        let told = async {
            stream.write_all(line.as_bytes()).await?;
            stream.shutdown().await
        };
        if let Ok(Err(error)) = tokio::time::timeout(ACCEPT_PAUSE, told).await {
            tracing::debug!("refusal not told: {error}");
        }
    });
}
