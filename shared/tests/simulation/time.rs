//! Pictures that change while the camera looks.

use std::{sync::Arc, time::Duration};

use super::{mean, plain_room};
use shared::{
    pattern::Pattern,
    simulation::{CameraTuning, Room, RoomCamera, Timeline},
    stage::Stage,
};

#[test]
fn a_rolling_shutter_shows_both_pictures_in_one_frame() {
    let scene = plain_room("exposure_ms = 10.0\nreadout_ms = 20.0", "", "");
    let room = Room::new(&scene, Stage::Background);
    let size = scene.projector_size();
    let mut timeline = Timeline::new(&scene);
    timeline.show(Duration::from_millis(100), &Pattern::BLACK.raster(size));
    timeline.show(Duration::from_millis(115), &Pattern::WHITE.raster(size));
    let torn = room.render_at(&timeline, Duration::from_millis(100), 0);
    let white = room.render(&scene.project(&Pattern::WHITE.raster(size)), 0);
    let share = |y: u32| mean(&torn, 0, 150..170, y..y + 1) / mean(&white, 0, 150..170, y..y + 1);
    // row y gathers light from 100 + y / 12 ms on, for 10 ms
    assert!(share(40) < 0.01, "exposed before the change: {}", share(40));
    assert!(
        (share(120) - 0.5).abs() < 0.02,
        "half and half: {}",
        share(120)
    );
    assert!(
        share(200) > 0.99,
        "exposed after the change: {}",
        share(200)
    );
    assert_eq!(
        room.render_at(&timeline, Duration::from_millis(115), 0),
        white
    );
    assert_eq!(
        mean(
            &room.render_at(&timeline, Duration::ZERO, 0),
            0,
            0..320,
            0..240
        ),
        0.0
    );
}

#[test]
fn light_follows_the_command_after_the_latency_and_old_pictures_can_be_forgotten() {
    let scene = plain_room(
        "exposure_ms = 0.1",
        "display_latency_ms = 60.0\ndisplay_jitter_ms = 5.0",
        "",
    );
    let room = Room::new(&scene, Stage::Background);
    let size = scene.projector_size();
    let mut timeline = Timeline::new(&scene);
    timeline.show(Duration::from_secs(1), &Pattern::WHITE.raster(size));
    timeline.show(Duration::from_secs(2), &Pattern::BLACK.raster(size));
    let level = |timeline: &Timeline, ms: u64| {
        mean(
            &room.render_at(timeline, Duration::from_millis(ms), 0),
            0,
            150..170,
            110..130,
        )
    };
    assert_eq!(level(&timeline, 1059), 0.0);
    assert!(level(&timeline, 1066) > 150.0);
    assert!(level(&timeline, 2059) > 150.0);
    assert_eq!(level(&timeline, 2066), 0.0);
    timeline.forget_before(Duration::from_millis(1500));
    assert!(
        level(&timeline, 2000) > 150.0,
        "what is still shown is kept"
    );
    timeline.forget_before(Duration::from_secs(3));
    assert_eq!(level(&timeline, 3000), 0.0);
}

#[test]
fn a_camera_that_keeps_the_light_of_the_frame_before_takes_the_same_frames() {
    let scene = plain_room("exposure_ms = 10.0\nreadout_ms = 20.0", "", "");
    let [room, other] = Stage::BOTH.map(|stage| Arc::new(Room::new(&scene, stage)));
    let mut timeline = Timeline::new(&scene);
    let mut camera = RoomCamera::new(Arc::clone(&room));
    let tuning = CameraTuning::of(&scene);
    for (number, picture) in [
        &Pattern::BLACK,
        &Pattern::WHITE,
        &Pattern::WHITE,
        &Pattern::BLACK,
        &Pattern::WHITE,
    ]
    .into_iter()
    .enumerate()
    {
        // in the middle of a frame
        let number = number as u64;
        let shown = Duration::from_millis(40 * number + 15);
        timeline.show(shown, &picture.raster(scene.projector_size()));
        let start = Duration::from_millis(40 * number);
        let room = if number < 4 { &room } else { &other };
        camera.look_at(room);
        let frame = camera.take(&timeline, start, number, &tuning);
        assert_eq!(frame, room.render_at(&timeline, start, number));
    }
    let brighter = CameraTuning {
        exposure: 2 * tuning.exposure,
        ..tuning
    };
    let start = Duration::from_millis(400);
    let [dim, bright] = [tuning, brighter].map(|tuning| {
        let frame = camera.take(&timeline, start, 9, &tuning);
        mean(&frame, 0, 150..170, 110..130)
    });
    assert!(bright > 1.2 * dim, "{dim} {bright}");
}
