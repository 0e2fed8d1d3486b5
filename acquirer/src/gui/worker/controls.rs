//! The camera's controls: told to the window, set as it asks, and set again when the same camera is opened anew.

use std::time::{Duration, Instant};

use super::{RigWorker, Session};
use crate::{
    camera::{
        CameraSpec, ControlInfo,
        controls::{by_id, ids, sort_for_people},
    },
    gui::events::Event,
    session::{Rig, set_exposure},
};

/// Time between two looks at controls that an automatic may change.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Controls that change how long a frame is exposed, and with it the latency.
const TIMES: [u32; 4] = [
    ids::EXPOSURE_TIME,
    ids::EXPOSURE_OLD,
    ids::AUTO_EXPOSURE,
    ids::EXPOSURE_DYNAMIC_FRAMERATE,
];

/// What was done to the controls of a camera.
#[derive(Default)]
pub(super) struct ControlsSet {
    camera: Option<CameraSpec>,
    values: Vec<(u32, i64)>,
    are_locked: bool,
    /// What the window was told last, and when.
    told: Option<(Vec<ControlInfo>, Instant)>,
}

impl ControlsSet {
    fn remember(&mut self, id: u32, value: i64) {
        self.values.retain(|(known, _)| *known != id);
        self.values.push((id, value));
    }
}

impl RigWorker {
    /// Gives a camera that was opened anew the values that the operator gave it, and tells all controls.
    pub(super) fn begin_controls(&self, rig: &mut Rig, session: &mut Session) {
        let set = &mut session.controls;
        if set.camera != self.source.camera {
            *set = ControlsSet {
                camera: self.source.camera.clone(),
                ..ControlsSet::default()
            };
        }
        if set.are_locked
            && let Err(error) = rig.camera.hold_automatics()
        {
            let told = format!("the camera's automatics are not locked again: {error}");
            self.teller.tell(Event::Warning(told));
        }
        for &(id, value) in &set.values {
            if let Err(error) = rig.camera.set_control(id, value) {
                let told = format!("a control of the camera is not set again: {error}");
                self.teller.tell(Event::Warning(told));
            }
        }
        set.told = None;
        self.tell_controls(rig, session);
    }

    /// Tells controls that have changed by themselves, now and then, while the window shows them.
    pub(super) fn watch_controls(&self, rig: &Rig, session: &mut Session) {
        let told = session.controls.told.as_ref();
        if self.live.wishes().controls && told.is_none_or(|(_, at)| at.elapsed() > LOOK_EVERY) {
            self.tell_controls(rig, session);
        }
    }

    fn tell_controls(&self, rig: &Rig, session: &mut Session) {
        match rig.camera.controls() {
            Ok(mut list) => {
                sort_for_people(&mut list);
                let told = session.controls.told.take();
                if told.is_none_or(|(told, _)| told != list) {
                    self.teller.tell(Event::Controls(Ok(list.clone())));
                }
                session.controls.told = Some((list, Instant::now()));
            }
            Err(error) => {
                let reason = format!("the camera does not tell its controls: {error}");
                self.teller.tell(Event::Controls(Err(reason)));
                session.controls.told = Some((Vec::new(), Instant::now()));
            }
        }
    }

    /// Sets one control.
    pub(super) fn set_control(
        &self,
        (id, value): (u32, i64),
        rig: &mut Rig,
        session: &mut Session,
    ) -> anyhow::Result<()> {
        let set = rig.camera.set_control(id, value);
        // also after a refusal, so that the window shows what holds
        session.controls.told = None;
        self.tell_controls(rig, session);
        let taken = set?;
        session.controls.remember(id, taken);
        if TIMES.contains(&id) {
            rig.latency = None;
        }
        if taken != value {
            let controls = rig.camera.controls()?;
            if let Some(control) = by_id(&controls, id) {
                self.teller.tell(Event::Warning(format!(
                    "{}: {} was asked for, the camera took {}",
                    control.name,
                    control.value_text(value),
                    control.value_text(taken)
                )));
            }
        }
        Ok(())
    }

    /// Makes all automatics stand still.
    pub(super) fn lock_automatics(
        &self,
        rig: &mut Rig,
        session: &mut Session,
    ) -> anyhow::Result<()> {
        let held = rig.camera.hold_automatics()?;
        session.controls.are_locked = true;
        let mut still = Vec::new();
        for held in &held {
            match &held.refused {
                None => still.push(held.name),
                Some(reason) => {
                    let told = format!("the camera's {} can't be locked: {reason}", held.name);
                    self.teller.tell(Event::Warning(told));
                }
            }
        }
        let note = match still.is_empty() {
            true => "this camera has no automatic that could be locked".to_owned(),
            false => format!("locked: {}", still.join(", ")),
        };
        self.teller.tell(Event::Note(note));
        self.tell_controls(rig, session);
        Ok(())
    }

    /// Sets the exposure, and the gain if it must, to where white does not clip.
    pub(super) fn set_exposure(&self, rig: &mut Rig, session: &mut Session) -> anyhow::Result<()> {
        let settings = &self.config.exposure;
        let set = set_exposure(rig, settings, &self.cancel, &mut |p| self.progress(p));
        rig.latency = None;
        session.controls.are_locked = true;
        self.tell_controls(rig, session);
        let found = set?;
        self.teller.tell(Event::Note(found.sentence()));
        for control in rig.camera.controls()? {
            let is_set = matches!(
                control.id,
                ids::EXPOSURE_TIME | ids::EXPOSURE_OLD | ids::GAIN
            );
            if let Some(value) = control.value.filter(|_| is_set && !control.read_only) {
                session.controls.remember(control.id, value);
            }
        }
        Ok(())
    }
}
