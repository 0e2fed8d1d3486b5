//! The window without a display: what it says, what its buttons ask for, and how it looks.

mod fixture;
mod hang;

use eframe::egui::{self, Key};
use egui_kittest::kittest::{NodeT, Queryable};
use image::RgbImage;
use shared::{
    pattern::{GridSettings, Palette, Pattern},
    stage::Stage,
};

use super::{
    events::{Event, FileJob, Job, Place, Who},
    live_picture::{LivePicture, LiveReading, screen_image},
    model::{Side, Tab, Weight},
    open_scan::{OpenScan, StageView},
    preferences::Theme,
};
use crate::{
    config::Config,
    session::{Cancel, LiveMode, Progress},
};
use fixture::{RASTER, Tested, controls, cube_scan, looks_as_before, measured, rig};

#[test]
fn without_a_rig_the_window_says_what_to_do() {
    let mut tested = Tested::new(Theme::Dark);
    let reason = "projector bench:4460: nobody listens there";
    tested.tell(Event::Disconnected(reason.into()));
    assert!(tested.says(reason) && tested.says("Start the projector program"));
    tested.click("Scan");
    let record = tested.harness.get_by_label("Record without object");
    assert!(record.accesskit_node().is_disabled());
}

#[test]
fn every_switch_over_the_picture_changes_what_is_wanted() {
    let mut tested = Tested::connected();
    let before = tested.harness.state().preferences.clone();
    for switch in [
        "After",
        "No background",
        "Histogram",
        "Grid",
        "Labels",
        "Holes",
        "Clipping",
        "Shadow",
    ] {
        tested.click(switch);
    }
    let after = tested.harness.state().preferences.clone();
    assert!(after.after && after.histogram && !after.subtract);
    let (old, new) = (before.overlays, after.overlays);
    assert_eq!(
        [new.grid, new.labels, new.holes, new.clipping, new.shadow],
        [
            !old.grid,
            !old.labels,
            !old.holes,
            !old.clipping,
            !old.shadow
        ]
    );
    tested.click("Read");
    assert_eq!(
        tested.jobs.try_recv(),
        Ok(Job::ReadLive(Some(LiveMode::Dynamic)))
    );
}

#[test]
fn colours_are_measured_shown_overridden_with_their_cost_and_applied() {
    let mut tested = Tested::connected();
    tested.click("Colours");
    tested.click("Measure all sixteen");
    assert_eq!(
        tested.jobs.try_recv(),
        Ok(Job::PickColours { apply: false })
    );
    let selection = measured();
    tested.tell(Event::ColoursSoFar(Box::new(selection.clone())));
    assert!(
        !tested.says("Expected to be misread"),
        "not all are measured yet"
    );
    tested.tell(Event::Colours(Box::new(selection.clone()), false));
    tested.tell(Event::Idle(Who::Rig));
    assert!(tested.says("Expected to be misread"));
    assert!(tested.says(&selection.reasons[0]), "the reason is told");

    let worse = selection.thesis_choice.colours;
    let other = Palette::default()
        .colours()
        .iter()
        .map(|c| c.colour)
        .find(|c| !selection.best.contains(c));
    let by_hand = if worse == selection.best {
        [other.unwrap(), worse[1], worse[2], worse[3]]
    } else {
        worse
    };
    let colours = &mut tested.harness.state_mut().colours;
    (colours.best, colours.overridden) = (by_hand, true);
    tested.harness.run_steps(2);
    assert!(tested.says("By hand:") && tested.says("the best set"));
    tested.click("Back to the best");
    assert_eq!(tested.harness.state().colours.best, selection.best);
    tested.click("Apply to the projector");
    let applied = Job::ApplyColours(selection.best, selection.unary);
    assert_eq!(tested.jobs.try_recv(), Ok(applied));
}

#[test]
fn a_scan_is_recorded_judged_kept_and_computed_by_clicks() {
    let scans = cube_scan();
    let dir = scans.path().join("cube");
    let config = Config::default();
    let mut tested = Tested::connected();
    tested.click("Scan");
    for (stage, record) in [
        (Stage::Background, "Record without object"),
        (Stage::Object, "Record with object"),
    ] {
        tested.click(record);
        assert_eq!(tested.jobs.try_recv(), Ok(Job::Record(stage)));
        tested.tell(Event::Recorded(stage, dir.clone()));
        tested.tell(Event::Idle(Who::Rig));
        let read = FileJob::ReadStage(dir.clone(), stage);
        assert_eq!(tested.files.try_recv(), Ok(read));
        let settings = &config.pipeline;
        let view = StageView::read((&dir, stage), settings, &Cancel::default(), &mut |_| ());
        let view = view.unwrap();
        assert!(view.quality.coverage_percent() > 80.0);
        let text = format!(
            "{:.1} % of the crossings read",
            view.quality.coverage_percent()
        );
        tested.tell(Event::StageRead(dir.clone(), view.into()));
        tested.tell(Event::Idle(Who::Files));
        assert!(tested.says(&text), "{text}");
        tested.click("Keep");
    }
    let read = FileJob::Read(dir.clone(), Place::Result);
    assert_eq!(tested.files.try_recv(), Ok(read));
    let scan = OpenScan::read(&dir, &config, &Cancel::default(), &mut |_| ()).unwrap();
    tested.tell(Event::Read(Box::new(scan), Place::Result));
    tested.tell(Event::Idle(Who::Files));
    assert_eq!(tested.harness.state().tab, Tab::Result);
    assert!(tested.says("vertices shifted") && tested.says("object up to"));
    tested.click("Table");
    assert!(tested.says("UPPER_LEFT") || tested.says("upper_left"));
    tested.click("Surface");
    let model = tested.harness.state_mut();
    (model.save_name, model.scan.dir) = ("cube-kept".into(), Some("cube".into()));
    let mut tested = looks_as_before(tested, "result");

    // a crossing of the decoded grid tells its window
    tested.harness.state_mut().steps.crossing = Some(40);
    tested.click("Steps");
    assert!(tested.says("occurs once in the sequence"));
    let mut tested = looks_as_before(tested, "steps");
    let result = tested.harness.state_mut().result.as_mut();
    result.unwrap().dir = "cube".into();
    tested.click("Compare");
    assert!(tested.says("No scan is chosen"));
    let mut tested = looks_as_before(tested, "compare");
    tested.click("Next object");
    assert_eq!(tested.jobs.try_recv(), Ok(Job::NextObject));
}

#[test]
fn a_long_action_tells_its_progress_and_can_be_cancelled() {
    let mut tested = Tested::connected();
    let progress = Progress {
        what: "recording background".into(),
        done: 1,
        of: 4,
    };
    tested.tell(Event::Progress(Who::Rig, progress));
    assert!(tested.says("recording background") && !tested.cancel.is_cancelled());
    tested.click("Cancel");
    assert!(tested.cancel.is_cancelled());
}

#[test]
fn the_reading_of_a_scan_can_be_stopped() {
    let mut tested = Tested::connected();
    let progress = Progress {
        what: "reading cube".into(),
        done: 3,
        of: 8,
    };
    tested.tell(Event::Progress(Who::Files, progress));
    tested.click("Stop reading");
    assert!(tested.cancel_files.is_cancelled() && !tested.cancel.is_cancelled());
    assert!(tested.says("Stopping the reading"));

    let scans = cube_scan();
    let dir = scans.path().join("cube");
    let mut told = Vec::new();
    let read = OpenScan::read(&dir, &Config::default(), &tested.cancel_files, &mut |p| {
        told.push(p.done);
    });
    let error = read.unwrap_err().to_string();
    assert!(error.contains("stopped by the operator"), "{error}");
    assert_eq!(told, [0]);
    assert!(!dir.join("results").exists());
}

#[test]
fn warnings_are_told_until_they_are_dismissed_and_stay_in_the_list() {
    let mut tested = Tested::connected();
    let told = "lines are 2 px apart: the camera can't resolve them";
    tested.tell(Event::Warning(told.into()));
    tested.tell(Event::Warning(told.into()));
    assert_eq!(tested.harness.state().warnings, [told]);
    assert!(tested.says(told));
    tested.click("Dismiss warnings");
    assert!(tested.harness.state().warnings.is_empty());
    let messages = &tested.harness.state().messages;
    assert!(
        messages
            .iter()
            .any(|m| m.text == told && m.weight == Weight::Warning)
    );
}

#[test]
fn the_way_of_live_reading_is_chosen_in_the_window() {
    let mut tested = Tested::connected();
    tested.click("Read");
    let asked = tested.jobs.try_recv();
    assert_eq!(asked, Ok(Job::ReadLive(Some(LiveMode::Dynamic))));
    tested.harness.get_by_value("moving").click();
    tested.harness.run_steps(3);
    tested.click("tracking");
    let asked = tested.jobs.try_recv();
    assert_eq!(asked, Ok(Job::ReadLive(Some(LiveMode::Tracking))));
    tested.click("Read");
    assert_eq!(tested.jobs.try_recv(), Ok(Job::ReadLive(None)));
}

#[test]
fn the_cameras_controls_are_listed_set_locked_and_exposed_for() {
    let mut tested = Tested::connected();
    tested.tell(Event::Controls(Ok(controls())));
    tested.click("Source settings");
    tested.harness.run_steps(20);
    assert!(tested.harness.state().controls.are_shown);
    for name in ["exposure time", "gain", "power line frequency"] {
        assert!(tested.says(name), "{name}");
    }
    tested.click("white balance automatic on or off");
    let id = controls()[0].id;
    assert_eq!(tested.jobs.try_recv(), Ok(Job::SetControl(id, 0)));
    tested.tell(Event::Idle(Who::Rig));
    tested.click("Lock all");
    assert_eq!(tested.jobs.try_recv(), Ok(Job::LockAutomatics));
    tested.tell(Event::Idle(Who::Rig));
    tested.click("Set the exposure");
    assert_eq!(tested.jobs.try_recv(), Ok(Job::SetExposure));
    tested.tell(Event::Idle(Who::Rig));
    looks_as_before(tested, "source");
}

#[test]
fn more_than_can_be_taken_is_told_and_never_waited_for() {
    let mut tested = Tested::connected();
    for _ in 0..9 {
        tested.harness.state_mut().ask(Job::Identify);
    }
    tested.harness.run_steps(2);
    assert!(tested.says("too much was asked for at once"));
}

#[test]
fn an_error_is_told_until_it_is_dismissed() {
    let mut tested = Tested::connected();
    let told = "the camera does not see the projector: point it at the picture";
    tested.tell(Event::Failed(told.into()));
    assert!(tested.says(told));
    tested.click("Dismiss");
    assert_eq!(tested.harness.state().error, None);
}

#[test]
fn keys_do_what_buttons_do() {
    let mut tested = Tested::connected();
    for (key, tab) in [
        (Key::Num2, Tab::Steps),
        (Key::Num4, Tab::Compare),
        (Key::Num1, Tab::Live),
    ] {
        tested.harness.key_press(key);
        tested.harness.run_steps(2);
        assert_eq!(tested.harness.state().tab, tab);
    }
    tested.harness.key_press(Key::F);
    tested.harness.run_steps(2);
    assert_eq!(tested.jobs.try_recv(), Ok(Job::Record(Stage::Background)));
    assert_eq!(tested.harness.state().side, Side::Scan);
}

#[test]
fn the_help_tells_the_way_and_all_keys() {
    let mut tested = Tested::connected();
    tested.harness.key_press(Key::F1);
    tested.harness.run_steps(3);
    assert!(tested.says("From start to a saved scan"));
    assert!(tested.says("record without object (F)"));
    looks_as_before(tested, "help");
}

#[test]
fn what_somebody_sets_at_the_projector_appears_here() {
    let mut tested = Tested::connected();
    let mut state = rig().projector;
    state.grid = state.grid.with_lines(31, 63).unwrap();
    tested.tell(Event::Projector(Box::new(state)));
    assert!(tested.says("31 rows, 63 columns"));
}

#[test]
fn live_picture_and_colours_look_as_they_did() {
    let mut tested = Tested::new(Theme::Light);
    tested.tell(Event::Connected(Box::new(rig())));
    let raster = Pattern::from(GridSettings::default().coded).raster(RASTER);
    let picture = RgbImage::from_raw(RASTER.width, RASTER.height, raster.into_bytes()).unwrap();
    tested.harness.state_mut().live.picture = Some(LivePicture {
        image: screen_image(&picture),
        marks: None,
        number: 900,
        rate_hz: 30.0,
        lost: 2,
        reading: Some(LiveReading {
            mode: LiveMode::Static,
            pattern: "coded",
            crossings: 220,
            possible: 225,
            reasons: [("broken_line", 5)].into(),
            ms: 5.2,
            overlay: Default::default(),
        }),
        recovered: None,
    });
    tested.click("Colours");
    tested.tell(Event::Colours(Box::new(measured()), false));
    tested.tell(Event::Idle(Who::Rig));
    assert!(tested.says("still: 220 of 225 crossings read"));
    looks_as_before(tested, "colours");
}

#[test]
fn the_window_fits_a_small_screen_and_grows_with_its_scale() {
    for (size, zoom) in [([1280.0, 720.0], 1.0), ([3840.0, 2160.0], 2.0)] {
        let mut tested = Tested::connected();
        tested.harness.set_size(egui::Vec2::from(size) / zoom);
        tested.harness.set_pixels_per_point(zoom);
        tested.harness.run_steps(3);
        let inside = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::Vec2::from(size) / zoom);
        for label in ["Live", "Help", "Shadow", "Identify", "Colours", "Scan"] {
            let rect = tested.harness.get_by_label(label).rect();
            assert!(
                inside.contains_rect(rect),
                "{label} at {rect:?} of {size:?}"
            );
        }
    }
}
