//! What an examination says.

use serde::Serialize;

use crate::session::Rig;

/// Everything that was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnosis {
    /// Whether nothing is wrong.
    pub well: bool,
    /// The names of the findings that are not good.
    pub bad: Vec<&'static str>,
    /// The camera, in one line.
    pub camera: String,
    /// Size, rate and pixel format of its frames.
    pub format: String,
    /// The projector's address.
    pub projector: String,
    /// One for each question, in the order in which they were asked.
    pub findings: Vec<Finding>,
}

impl Diagnosis {
    pub(super) fn new(rig: &Rig, findings: Vec<Finding>) -> Self {
        let bad = findings
            .iter()
            .filter(|finding| finding.state == State::Bad);
        let bad: Vec<&'static str> = bad.map(|finding| finding.name).collect();
        Self {
            well: bad.is_empty(),
            bad,
            camera: rig.camera.description(),
            format: rig.camera.format().to_string(),
            projector: rig.projector.settings().address.clone(),
            findings,
        }
    }
}

/// What was found about one question.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Which question: `network`, `screen`, `automatics`, `frames`, `latency`, `exposure`, `mains_flicker`,
    /// `colour_wheel`, `pixels` or `focus`.
    pub name: &'static str,
    /// Whether it is good.
    pub state: State,
    /// What was found, in plain words.
    pub says: String,
    /// What to do; `None` when nothing is to be done.
    pub fix: Option<String>,
    /// The figures behind it.
    pub measured: Vec<Measured>,
}

/// The state of a [`Finding`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// All is well.
    Good,
    /// Something is wrong, the finding says what to do.
    Bad,
    /// It could not be told, the finding says why.
    NotChecked,
}

/// One figure of a finding.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measured {
    /// What was measured.
    pub what: &'static str,
    /// The value.
    pub value: f64,
    /// Its unit, as it is written behind the number.
    pub unit: &'static str,
    /// The value up to which it is good, if it is judged by that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// The value from which on it is good, if it is judged by that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
}

impl Measured {
    pub(super) fn new(what: &'static str, value: f64, unit: &'static str) -> Self {
        Self {
            what,
            value,
            unit,
            at_most: None,
            at_least: None,
        }
    }

    pub(super) fn at_most(mut self, limit: f64) -> Self {
        self.at_most = Some(limit);
        self
    }

    pub(super) fn at_least(mut self, limit: f64) -> Self {
        self.at_least = Some(limit);
        self
    }

    /// Whether the value keeps its limits; a value that is no number does not.
    pub(super) fn is_kept(&self) -> bool {
        self.at_most.is_none_or(|limit| self.value <= limit)
            && self.at_least.is_none_or(|limit| self.value >= limit)
    }
}

impl Finding {
    /// Judged by its figures: good when all limits are kept. `bad` gives what is said then and what to do.
    pub(super) fn judged(
        name: &'static str,
        measured: Vec<Measured>,
        good: String,
        bad: impl FnOnce() -> (String, String),
    ) -> Self {
        if measured.iter().all(Measured::is_kept) {
            Self::good(name, measured, good)
        } else {
            let (says, fix) = bad();
            Self::bad(name, measured, says, fix)
        }
    }

    pub(super) fn good(name: &'static str, measured: Vec<Measured>, says: String) -> Self {
        Self {
            name,
            state: State::Good,
            says,
            fix: None,
            measured,
        }
    }

    pub(super) fn bad(
        name: &'static str,
        measured: Vec<Measured>,
        says: String,
        fix: String,
    ) -> Self {
        Self {
            name,
            state: State::Bad,
            says,
            fix: Some(fix),
            measured,
        }
    }

    pub(super) fn not_checked(name: &'static str, reason: &str) -> Self {
        Self {
            name,
            state: State::NotChecked,
            says: format!("not checked: {reason}"),
            fix: None,
            measured: vec![],
        }
    }

    /// Whether it is good.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.state == State::Good
    }
}
