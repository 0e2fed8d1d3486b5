//! What the projector shows and who decides it: the only place where that changes.
//!
//! Takes changes (commands, connections, the screen's reports) and gives effects (a picture to present, a
//! timer to start). It opens no socket and no window and asks no clock, so every rule of the protocol is
//! tested here without either. A refused change leaves everything as it was.

mod picture;

mod overview;

pub use overview::{Member, Overview};
pub use picture::Picture;

use std::{
    collections::{BTreeMap, VecDeque},
    time::Duration,
};

use shared::{
    pattern::{GridSettings, Pattern, PatternError, RasterSize},
    protocol::{
        Command, ErrorCode, Hello, MAX_CANDIDATES, MAX_HOLD_MS, MAX_STEPS, MAX_TEXT_CHARS,
        ProjectorState, Role, ScreenInfo, Selection, SequenceStep, ServerMessage, Shown, VERSION,
        View,
    },
};
use thiserror::Error;

/// Number of a connection, never used twice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ConnectionId(pub u64);

/// Longest time the identify card may be asked for, in seconds.
const MAX_IDENTIFY_S: u32 = 60;

/// Why a change was refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Refusal {
    /// The client speaks another version of the protocol.
    #[error(
        "this projector speaks version {VERSION} of the protocol, the client version {0}: \
         use programs of the same release"
    )]
    Version(u32),
    /// Another client is the controller.
    #[error("the controller is {0:?}: end it, or say hello with \"take_over\":true")]
    ControllerTaken(String),
    /// A watcher asked for what only the controller may do.
    #[error("only the controller may do this, and that is {}", .0.as_ref().map_or("nobody".to_owned(), |name| format!("{name:?}")))]
    NotController(Option<String>),
    /// Lines, widths or colours that no grid can have.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// A value of a command out of its range.
    #[error("{0}")]
    Invalid(String),
}

impl Refusal {
    /// The code that goes to the client.
    #[must_use]
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::Version(_) => ErrorCode::Version,
            Self::ControllerTaken(_) => ErrorCode::ControllerTaken,
            Self::NotController(_) => ErrorCode::NotController,
            Self::Pattern(_) | Self::Invalid(_) => ErrorCode::Invalid,
        }
    }

    /// The message that tells the client.
    #[must_use]
    pub fn reply(&self, id: Option<u64>) -> ServerMessage {
        ServerMessage::Error {
            id,
            code: self.code(),
            message: self.to_string(),
        }
    }
}

/// What to do after a change.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[must_use]
pub struct Effects {
    /// Another picture is to be presented.
    pub present: Option<Picture>,
    /// Everybody is to be told the state.
    pub changed: bool,
    /// The identify card is to be ended after this time.
    pub identify_for: Option<Duration>,
    /// The next step of the sequence is to be taken after this time.
    pub next_step_in: Option<Duration>,
    /// The first step of a sequence is to be taken when the projector's clock shows this.
    pub first_step_at_ns: Option<u64>,
}

#[derive(Debug, Clone)]
struct Controller {
    connection: ConnectionId,
    name: String,
}

/// The state of the projector.
#[derive(Debug, Clone)]
pub struct State {
    screen: ScreenInfo,
    grid: GridSettings,
    view: View,
    blank: bool,
    identifying: bool,
    /// The pairing code that is shown instead of the view.
    pairing_code: Option<String>,
    controller: Option<Controller>,
    /// The names of all that are connected.
    members: BTreeMap<ConnectionId, String>,
    selection: Option<Selection>,
    /// Steps of the running sequence that were not taken yet.
    steps: VecDeque<SequenceStep>,
    /// What is asked of the screen.
    picture: Picture,
    /// What the screen has presented.
    shown: Shown,
}

impl State {
    /// The state at the start, with its first picture still to be presented.
    #[must_use]
    pub fn new(screen: ScreenInfo, grid: GridSettings, view: View) -> Self {
        let raster = screen.raster;
        let nothing = Shown {
            serial: 0,
            pattern: Pattern::BLACK,
            raster,
            presented_ns: 0,
        };
        let picture = Picture {
            serial: 1,
            pattern: picture::of_view(&view, &grid, &screen.name),
        };
        Self {
            screen,
            grid,
            view,
            blank: false,
            identifying: false,
            pairing_code: None,
            controller: None,
            members: BTreeMap::new(),
            selection: None,
            steps: VecDeque::new(),
            picture,
            shown: nothing,
        }
    }

    /// The picture that is asked of the screen.
    #[must_use]
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// The picture the screen has presented last.
    #[must_use]
    pub fn shown(&self) -> &Shown {
        &self.shown
    }

    /// Whether the identify card is shown for some seconds.
    #[must_use]
    pub fn is_identifying(&self) -> bool {
        self.identifying
    }

    /// Whether a sequence is running.
    #[must_use]
    pub fn has_steps(&self) -> bool {
        !self.steps.is_empty()
    }

    /// The state as clients see it.
    #[must_use]
    pub fn report(&self) -> ProjectorState {
        ProjectorState {
            screen: self.screen.clone(),
            grid: self.grid.clone(),
            view: self.view.clone(),
            blank: self.blank,
            shown: self.shown.clone(),
            controller: self.controller_name(),
            selection: self.selection.clone(),
        }
    }

    /// The state as the operator at the projector sees it.
    #[must_use]
    pub fn overview(&self) -> Overview {
        let member = |(&connection, name): (&ConnectionId, &String)| Member {
            name: name.clone(),
            role: if self.is_controller(connection) {
                Role::Controller
            } else {
                Role::Watcher
            },
        };
        Overview {
            state: self.report(),
            members: self.members.iter().map(member).collect(),
            identifying: self.identifying,
            steps_left: self.steps.len(),
            on_its_way: self.picture.serial != self.shown.serial,
        }
    }

    /// The name of the controller, if there is one.
    #[must_use]
    pub fn controller_name(&self) -> Option<String> {
        self.controller
            .as_ref()
            .map(|controller| controller.name.clone())
    }

    /// Whether this connection is the controller's.
    #[must_use]
    pub fn is_controller(&self, connection: ConnectionId) -> bool {
        self.controller
            .as_ref()
            .is_some_and(|controller| controller.connection == connection)
    }

    /// Lets a client in.
    ///
    /// # Errors
    /// Another version, a name that is empty or too long, or a second controller that does not take over.
    pub fn join(&mut self, connection: ConnectionId, hello: &Hello) -> Result<Role, Refusal> {
        if hello.version != VERSION {
            return Err(Refusal::Version(hello.version));
        }
        check_text("name", &hello.name)?;
        if hello.name.trim().is_empty() {
            return Err(Refusal::Invalid(
                "name is empty: give one that people understand".into(),
            ));
        }
        if hello.role == Role::Controller {
            if let Some(holder) = &self.controller
                && !hello.take_over
            {
                return Err(Refusal::ControllerTaken(holder.name.clone()));
            }
            self.steps.clear();
            self.controller = Some(Controller {
                connection,
                name: hello.name.clone(),
            });
        }
        self.members.insert(connection, hello.name.clone());
        Ok(hello.role)
    }

    /// Lets a client go; gives the controller's name if it was the controller.
    pub fn leave(&mut self, connection: ConnectionId) -> Option<String> {
        self.members.remove(&connection);
        let was_controller = self.is_controller(connection);
        let controller = if was_controller {
            self.steps.clear();
            self.controller.take()
        } else {
            None
        };
        controller.map(|controller| controller.name)
    }

    /// Does what a client asks for.
    ///
    /// # Errors
    /// The client may not, or a value is out of its range; nothing has changed then.
    pub fn request(&mut self, from: ConnectionId, command: Command) -> Result<Effects, Refusal> {
        if command.needs_control() && !self.is_controller(from) {
            return Err(Refusal::NotController(self.controller_name()));
        }
        self.apply(command)
    }

    /// Does what a command says, whoever gave it: the controller, or the operator at the projector.
    ///
    /// # Errors
    /// A value is out of its range; nothing has changed then.
    pub fn apply(&mut self, command: Command) -> Result<Effects, Refusal> {
        let before = self.clone();
        let mut identify_for = None;
        match command {
            Command::State | Command::Ping => return Ok(Effects::default()),
            Command::ReportSelection { selection } => {
                check_selection(&selection)?;
                self.selection = Some(selection);
                return Ok(Effects {
                    changed: true,
                    ..Effects::default()
                });
            }
            Command::ShowSequence { steps, begin_ns } => {
                check_steps(&steps)?;
                self.steps = steps.into();
                if begin_ns.is_none() {
                    return Ok(self.next_step());
                }
                return Ok(Effects {
                    first_step_at_ns: begin_ns,
                    ..Effects::default()
                });
            }
            Command::Identify { seconds } => {
                identify_for = Some(check_seconds(seconds)?);
            }
            Command::Show { view } => {
                self.view = view;
                self.blank = false;
            }
            Command::SetColours { colours, unary } => {
                self.grid = self.grid.with_colours(&colours, unary)?;
            }
            Command::SetWidths {
                row_width_px,
                column_width_px,
            } => {
                self.grid = self.grid.with_widths(row_width_px, column_width_px)?;
            }
            Command::SetLines { rows, columns } => {
                self.grid = self.grid.with_lines(rows, columns)?;
            }
            Command::Blank { on } => self.blank = on,
        }
        self.steps.clear();
        self.pairing_code = None;
        self.identifying = identify_for.is_some();
        let changed =
            (&before.grid, &before.view, before.blank) != (&self.grid, &self.view, self.blank);
        Ok(Effects {
            present: self.renew(false),
            changed,
            identify_for,
            ..Effects::default()
        })
    }

    /// Takes the next step of the sequence, if there is one. Clients are told the state with the last one.
    pub fn next_step(&mut self) -> Effects {
        let Some(step) = self.steps.pop_front() else {
            return Effects::default();
        };
        self.view = step.view;
        self.pairing_code = None;
        self.blank = false;
        self.identifying = false;
        let hold = Duration::from_secs_f64(step.hold_ms / 1000.0);
        Effects {
            present: self.renew(true),
            changed: !self.has_steps(),
            next_step_in: self.has_steps().then_some(hold),
            ..Effects::default()
        }
    }

    /// Turns the picture black because nobody is there to control it.
    pub fn blank_for_lost_controller(&mut self) -> Effects {
        let changed = !std::mem::replace(&mut self.blank, true);
        self.identifying = false;
        self.steps.clear();
        Effects {
            present: self.renew(false),
            changed,
            ..Effects::default()
        }
    }

    /// Shows a pairing code until something else is asked for, or ends it.
    pub fn show_pairing_code(&mut self, code: Option<String>) -> Effects {
        if code.is_some() {
            self.steps.clear();
        }
        self.pairing_code = code;
        Effects {
            present: self.renew(false),
            ..Effects::default()
        }
    }

    /// Ends the identify card.
    pub fn end_identify(&mut self) -> Effects {
        self.identifying = false;
        Effects {
            present: self.renew(false),
            ..Effects::default()
        }
    }

    /// Takes over what the screen tells about itself. A picture of another size is another picture.
    pub fn screen_changed(&mut self, screen: ScreenInfo) -> Effects {
        let changed = screen != self.screen;
        self.screen = screen;
        let resized = self.shown.serial > 0 && self.shown.raster != self.screen.raster;
        Effects {
            present: self.renew(resized),
            changed,
            ..Effects::default()
        }
    }

    /// Takes over that the screen has presented a picture; gives what to tell everybody, `None` for a
    /// picture that is not asked for any more.
    pub fn presented(&mut self, serial: u64, raster: RasterSize, now_ns: u64) -> Option<&Shown> {
        if serial != self.picture.serial || serial == self.shown.serial {
            return None;
        }
        let pattern = self.picture.pattern.clone();
        self.shown = Shown {
            serial,
            pattern,
            raster,
            presented_ns: now_ns,
        };
        Some(&self.shown)
    }

    /// The next picture if it is another one than the last, or in any case if forced.
    fn renew(&mut self, force: bool) -> Option<Picture> {
        let pattern = if let Some(text) = self.pairing_code.clone() {
            Pattern::PairingCode { text }
        } else if self.identifying {
            Pattern::Identify {
                label: self.screen.name.clone(),
            }
        } else if self.blank {
            Pattern::BLACK
        } else {
            picture::of_view(&self.view, &self.grid, &self.screen.name)
        };
        if pattern == self.picture.pattern && !force {
            return None;
        }
        self.picture = Picture {
            serial: self.picture.serial + 1,
            pattern,
        };
        Some(self.picture.clone())
    }
}

fn check_text(what: &str, text: &str) -> Result<(), Refusal> {
    if text.chars().count() > MAX_TEXT_CHARS {
        return Err(Refusal::Invalid(format!(
            "{what} is longer than {MAX_TEXT_CHARS} characters"
        )));
    }
    Ok(())
}

fn check_seconds(seconds: u32) -> Result<Duration, Refusal> {
    if (1..=MAX_IDENTIFY_S).contains(&seconds) {
        return Ok(Duration::from_secs(seconds.into()));
    }
    Err(Refusal::Invalid(format!(
        "identify for {seconds} s: choose 1 to {MAX_IDENTIFY_S}"
    )))
}

fn check_steps(steps: &[SequenceStep]) -> Result<(), Refusal> {
    if !(1..=MAX_STEPS).contains(&steps.len()) {
        return Err(Refusal::Invalid(format!(
            "a sequence of {} steps: send 1 to {MAX_STEPS}",
            steps.len()
        )));
    }
    let wrong = steps
        .iter()
        .find(|step| !(1.0..=MAX_HOLD_MS).contains(&step.hold_ms));
    match wrong {
        None => Ok(()),
        Some(step) => Err(Refusal::Invalid(format!(
            "a step of {} ms: choose 1 to {MAX_HOLD_MS}",
            step.hold_ms
        ))),
    }
}

fn check_selection(selection: &Selection) -> Result<(), Refusal> {
    check_text("reason", &selection.reason)?;
    let most = selection.candidates.len().max(selection.colours.len());
    if most > MAX_CANDIDATES {
        return Err(Refusal::Invalid(format!(
            "{most} colours: report at most {MAX_CANDIDATES}"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
