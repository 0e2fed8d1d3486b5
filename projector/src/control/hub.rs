//! Does the events one by one: the only owner of the state.
//!
//! While a picture is on its way to the screen no further event is taken, so requests are done strictly in
//! their order and each reply tells about its own picture. A screen that does not present in time is told to
//! the client; the picture is announced when it comes after all.

use std::{collections::BTreeMap, sync::Arc, time::Duration};

use shared::protocol::{
    Command, ControllerChange, ErrorCode, Hello, MAX_HOLD_MS, Request, Role, ScreenInfo,
    ServerMessage, VERSION, encode,
};
use tokio::{
    sync::{mpsc, oneshot, watch},
    time::{Instant, sleep_until},
};

use super::{
    ControlSettings, OnControllerLost,
    connection::{Event, Peer},
};
use crate::{
    clock::Clock,
    screen::{Orders, Presented},
    state::{ConnectionId, Effects, Refusal, State},
};

/// Longest time a screen may take for a picture. It usually takes 0.07 s; a software driver on a busy machine
/// takes a second for a picture that is not made of lines.
const PRESENT_TIMEOUT: Duration = Duration::from_secs(5);

/// A step of a sequence that is taken later than this begins the count of its time anew; less is made up for.
const LATE: Duration = Duration::from_millis(8);

/// The hub's way to and from the screen.
pub(super) struct ScreenSide {
    pub(super) orders: Arc<Orders>,
    pub(super) info: watch::Receiver<Option<ScreenInfo>>,
    pub(super) presented: mpsc::Receiver<Presented>,
    pub(super) operator: mpsc::Receiver<Command>,
}

/// A picture on its way to the screen.
struct InFlight {
    due: Instant,
    /// Who waits for it.
    client: Option<(ConnectionId, u64)>,
    /// The state is to be told after it.
    changed: bool,
}

/// The state and those who are told about it.
pub(super) struct Hub {
    state: State,
    peers: BTreeMap<ConnectionId, Peer>,
    orders: Arc<Orders>,
    in_flight: Option<InFlight>,
    identify_end: Option<Instant>,
    /// When the next step of the running sequence is due.
    step_due: Option<Instant>,
    on_controller_lost: OnControllerLost,
    clock: Clock,
    first_shown: Option<oneshot::Sender<()>>,
}

impl Hub {
    /// Waits for the screen, shows the first picture, and then does what comes.
    pub(super) async fn run(
        settings: ControlSettings,
        clock: Clock,
        mut screen: ScreenSide,
        mut events: mpsc::Receiver<Event>,
        first_shown: oneshot::Sender<()>,
    ) {
        let Some(info) = first_info(&mut screen.info).await else {
            return;
        };
        let mut hub = Self {
            state: State::new(info, settings.grid, settings.view),
            peers: BTreeMap::new(),
            orders: screen.orders.clone(),
            in_flight: None,
            identify_end: None,
            step_due: None,
            on_controller_lost: settings.on_controller_lost,
            clock,
            first_shown: Some(first_shown),
        };
        hub.orders.show(hub.state.picture().clone());
        hub.wait_for_picture(None, false);
        hub.orders.tell(hub.state.overview());
        while hub.step(&mut screen, &mut events).await {
            hub.orders.tell(hub.state.overview());
        }
    }

    /// Does one thing; whether the program goes on.
    async fn step(&mut self, screen: &mut ScreenSide, events: &mut mpsc::Receiver<Event>) -> bool {
        let idle = self.in_flight.is_none();
        let due = self.in_flight.as_ref().map(|flight| flight.due);
        let identify_end = self.identify_end;
        let step_due = self.step_due;
        tokio::select! {
            presented = screen.presented.recv() => match presented {
                Some(presented) => self.presented(presented),
                None => return false,
            },
            () = at(due), if due.is_some() => self.not_presented(),
            changed = screen.info.changed(), if idle => {
                let info = screen.info.borrow_and_update().clone();
                if let (Ok(()), Some(info)) = (changed, info) {
                    let effects = self.state.screen_changed(info);
                    self.carry_out(effects, None);
                }
            }
            () = at(identify_end), if idle && identify_end.is_some() => {
                let effects = self.state.end_identify();
                self.carry_out(effects, None);
            }
            () = at(step_due), if idle && step_due.is_some() => {
                let effects = self.state.next_step();
                self.carry_out(effects, None);
            }
            Some(command) = screen.operator.recv(), if idle => self.operator(command),
            event = events.recv(), if idle => match event {
                Some(event) => self.event(event),
                None => return false,
            },
        }
        true
    }

    fn event(&mut self, event: Event) {
        match event {
            Event::Hello(id, hello, peer) => self.hello(id, &hello, peer),
            Event::Request(id, request) => self.request(id, request),
            Event::Gone(id) => self.gone(id),
            Event::PairingCode(code) => {
                let effects = self.state.show_pairing_code(code);
                self.carry_out(effects, None);
            }
        }
    }

    fn hello(&mut self, id: ConnectionId, hello: &Hello, peer: Peer) {
        match self.state.join(id, hello) {
            Ok(role) => {
                tracing::info!("{:?} joined as {role:?}", hello.name);
                let state = self.state.report();
                if peer.send(&ServerMessage::Welcome {
                    version: VERSION,
                    role,
                    state,
                }) {
                    self.peers.insert(id, peer);
                }
                if role == Role::Controller {
                    self.tell_controller(ControllerChange::Joined, hello.name.clone());
                }
            }
            Err(refusal) => {
                tracing::warn!("{:?} refused: {refusal}", hello.name);
                peer.send(&refusal.reply(None));
                peer.close();
            }
        }
    }

    fn request(&mut self, id: ConnectionId, request: Request) {
        // The hello of a connection that is not among the peers was refused: it is being closed.
        if !self.peers.contains_key(&id) {
            return;
        }
        let Request {
            id: number,
            command,
        } = request;
        let is_state = command == Command::State;
        let is_noted = matches!(
            command,
            Command::ReportSelection { .. } | Command::ShowSequence { .. }
        );
        let begins = self.check_begin(&command);
        match begins.and_then(|()| self.state.request(id, command)) {
            Err(refusal) => self.tell(id, &refusal.reply(Some(number))),
            Ok(_) if is_state => {
                let state = self.state.report();
                self.tell(id, &ServerMessage::State { id: number, state });
            }
            Ok(effects) if is_noted => {
                self.tell(id, &ServerMessage::Noted { id: number });
                self.carry_out(effects, None);
            }
            Ok(effects) => self.carry_out(effects, Some((id, number))),
        }
    }

    /// Whether a command that tells when it begins tells a time soon enough.
    fn check_begin(&self, command: &Command) -> Result<(), Refusal> {
        let Command::ShowSequence {
            begin_ns: Some(begin_ns),
            ..
        } = command
        else {
            return Ok(());
        };
        let wait = self.until(*begin_ns);
        if 1000.0 * wait.as_secs_f64() <= MAX_HOLD_MS {
            return Ok(());
        }
        Err(Refusal::Invalid(format!(
            "a sequence that begins in {} s: choose a time within {} s, by the clock that ping tells",
            wait.as_secs(),
            MAX_HOLD_MS / 1000.0
        )))
    }

    /// Time until the projector's clock shows this; none if it did already.
    fn until(&self, clock_ns: u64) -> Duration {
        Duration::from_nanos(clock_ns.saturating_sub(self.clock.now_ns()))
    }

    fn gone(&mut self, id: ConnectionId) {
        self.peers.remove(&id);
        let Some(name) = self.state.leave(id) else {
            return;
        };
        tracing::info!("the controller {name:?} left");
        self.tell_controller(ControllerChange::Left, name);
        if self.on_controller_lost == OnControllerLost::Blank {
            let effects = self.state.blank_for_lost_controller();
            self.carry_out(effects, None);
        }
    }

    fn operator(&mut self, command: Command) {
        match self.state.apply(command) {
            Ok(effects) => self.carry_out(effects, None),
            Err(refusal) => tracing::warn!("key refused: {refusal}"),
        }
    }

    /// Does what a change asks for; the client gets its reply when the picture is shown.
    fn carry_out(&mut self, effects: Effects, client: Option<(ConnectionId, u64)>) {
        if let Some(picture) = effects.present {
            self.orders.show(picture);
        }
        if let Some(time) = effects.identify_for {
            self.identify_end = Some(Instant::now() + time);
        } else if !self.state.is_identifying() {
            self.identify_end = None;
        }
        if let Some(begin_ns) = effects.first_step_at_ns {
            self.step_due = Some(Instant::now() + self.until(begin_ns));
        } else if let Some(hold) = effects.next_step_in {
            self.step_due = Some(next_due(self.step_due, hold));
        } else if !self.state.has_steps() {
            self.step_due = None;
        }
        // Also true for a picture that was asked for before and did not come in time.
        if self.state.picture().serial == self.state.shown().serial {
            self.settle(client, effects.changed);
        } else {
            self.wait_for_picture(client, effects.changed);
        }
    }

    fn wait_for_picture(&mut self, client: Option<(ConnectionId, u64)>, changed: bool) {
        self.in_flight = Some(InFlight {
            due: Instant::now() + PRESENT_TIMEOUT,
            client,
            changed,
        });
    }

    fn presented(&mut self, report: Presented) {
        let shown = self
            .state
            .presented(report.serial, report.raster, report.now_ns)
            .cloned();
        let Some(shown) = shown else { return };
        tracing::debug!("picture {} shown in {}", shown.serial, shown.raster);
        self.tell_everybody(&ServerMessage::Shown(shown));
        if let Some(first_shown) = self.first_shown.take()
            && first_shown.send(()).is_err()
        {
            tracing::error!("nobody accepts connections any more");
        }
        if let Some(flight) = self.in_flight.take() {
            self.settle(flight.client, flight.changed);
        }
    }

    /// Tells the state, if it changed, and then the client that its request is done.
    fn settle(&mut self, client: Option<(ConnectionId, u64)>, changed: bool) {
        if changed {
            self.tell_everybody(&ServerMessage::StateChanged {
                state: self.state.report(),
            });
        }
        if let Some((connection, id)) = client {
            let shown = self.state.shown().clone();
            self.tell(connection, &ServerMessage::Done { id, shown });
        }
    }

    fn not_presented(&mut self) {
        let Some(flight) = self.in_flight.take() else {
            return;
        };
        let serial = self.state.picture().serial;
        let problem = self.state.report().screen.problem.unwrap_or_else(|| {
            "the window may be covered, minimised, or on a locked desktop".to_owned()
        });
        let seconds = PRESENT_TIMEOUT.as_secs();
        let message = format!("picture {serial} was not presented within {seconds} s: {problem}");
        tracing::warn!("{message}");
        if flight.changed {
            self.tell_everybody(&ServerMessage::StateChanged {
                state: self.state.report(),
            });
        }
        if let Some((connection, id)) = flight.client {
            let code = ErrorCode::NotPresented;
            self.tell(
                connection,
                &ServerMessage::Error {
                    id: Some(id),
                    code,
                    message,
                },
            );
        }
    }

    fn tell_controller(&mut self, change: ControllerChange, name: String) {
        self.tell_everybody(&ServerMessage::Controller { change, name });
    }

    fn tell(&mut self, id: ConnectionId, message: &ServerMessage) {
        if let Some(peer) = self.peers.get(&id)
            && !peer.send(message)
        {
            self.peers.remove(&id);
        }
    }

    fn tell_everybody(&mut self, message: &ServerMessage) {
        let line: Arc<str> = encode(message).into();
        self.peers.retain(|_, peer| peer.send_line(line.clone()));
    }
}

/// When the step after this one is due: as long after this one as it was to be, so that small delays do not add up.
fn next_due(due: Option<Instant>, hold: Duration) -> Instant {
    let now = Instant::now();
    let in_time = due.filter(|&due| due <= now && now - due < LATE);
    in_time.unwrap_or(now) + hold
}

/// What the screen is, once it knows; `None` if it ended before.
async fn first_info(info: &mut watch::Receiver<Option<ScreenInfo>>) -> Option<ScreenInfo> {
    let known = info.wait_for(Option::is_some).await.ok()?.clone();
    info.mark_unchanged();
    known
}

/// Waits until a time; for ever without one.
async fn at(time: Option<Instant>) {
    match time {
        Some(time) => sleep_until(time).await,
        None => std::future::pending().await,
    }
}
