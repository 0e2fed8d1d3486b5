//! Which pattern does a frame show: a small sweep of simulated rigs, and the cases that mislead clocks.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use acquirer::session::tagging::{
    BANDS, Band, Delay, Estimate, Flash, Look, LookNoise, Seen, Settling, Tag, Timing, find_timing,
    tag_frames,
};
use image::{Rgb, RgbImage};
use rig_tests::measure::{TaggingRig, TaggingScore, score_tagging};

/// From frame to frame in these cases, in milliseconds.
const FRAME_MS: f64 = 33.0;

fn timing(latency_ms: f64) -> Timing {
    let known = |ms| Estimate {
        ms,
        uncertainty_ms: 1.0,
    };
    Timing {
        latency: known(latency_ms),
        jitter: known(2.0),
        readout: known(8.0),
        exposure: known(8.0),
        change: known(18.0),
        frame_ms: FRAME_MS,
        settling: None,
        delay: None,
    }
}

/// A frame with one colour in its upper bands and another one in the lower ones; `number` makes it differ a little from
/// all others, as noise does.
fn frame(number: usize, (above, below): ([f32; 3], [f32; 3])) -> Seen {
    let grain = 1e-3 * number as f32;
    let bands = (0..BANDS).map(|band| {
        let colour = if band < BANDS / 2 { above } else { below };
        let mean = colour.map(|value| value + grain);
        Band {
            mean,
            samples: mean.to_vec(),
        }
    });
    Seen {
        stamp_ms: FRAME_MS * number as f64,
        after_loss: false,
        look: Look::from_bands(bands.collect()),
    }
}

const BLACK: [f32; 3] = [1.0, 1.0, 1.0];
const RED: [f32; 3] = [90.0, 4.0, 3.0];
const GREEN: [f32; 3] = [5.0, 80.0, 6.0];
const BLUE: [f32; 3] = [3.0, 8.0, 70.0];

fn whole(colour: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    (colour, colour)
}

/// Tags frames of these colours while black is followed by red, green and blue every three frames.
fn tags(colours: &[([f32; 3], [f32; 3])], latency_ms: f64) -> Vec<Tag> {
    let frames = colours
        .iter()
        .enumerate()
        .map(|(k, &colour)| frame(k, colour));
    let frames: Vec<Seen> = frames.collect();
    let shown = [3.0, 6.0, 9.0].map(|k| k * FRAME_MS - 10.0 - latency_ms);
    let noise = LookNoise::of(&[], &[]);
    tag_frames(&frames, &shown, &timing(latency_ms), noise).tags
}

fn three_each(colours: &[[f32; 3]]) -> Vec<([f32; 3], [f32; 3])> {
    colours
        .iter()
        .flat_map(|&colour| [whole(colour); 3])
        .collect()
}

#[test]
fn frames_of_a_sequence_get_its_patterns_whatever_the_latency() {
    for latency_ms in [0.0, 300.0] {
        let frames = three_each(&[BLACK, RED, GREEN, BLUE]);
        let expected: Vec<Tag> = (0..12).map(|k| Tag::Shows(k / 3)).collect();
        assert_eq!(tags(&frames, latency_ms), expected);
    }
}

#[test]
fn a_torn_frame_is_mixed() {
    let mut frames = three_each(&[BLACK, RED, GREEN, BLUE]);
    frames[6] = (GREEN, RED);
    let tags = tags(&frames, 20.0);
    assert_eq!(tags[6], Tag::Mixed);
    assert_eq!((tags[5], tags[7]), (Tag::Shows(1), Tag::Shows(2)));
}

#[test]
fn a_frame_given_twice_shows_what_it_showed_whatever_its_stamp() {
    let mut frames: Vec<Seen> = three_each(&[BLACK, RED, GREEN, BLUE])
        .into_iter()
        .enumerate()
        .map(|(k, colour)| frame(k, colour))
        .collect();
    // green is up, the driver hands out red again
    frames[6].look = frames[5].look.clone();
    let shown = [3.0, 6.0, 9.0].map(|k| k * FRAME_MS - 30.0);
    let noise = LookNoise::of(&[], &[]);
    let told = tag_frames(&frames, &shown, &timing(20.0), noise);
    assert_eq!(told.tags[6], Tag::Shows(1));
    assert_eq!(told.tags[7], Tag::Shows(2));
}

#[test]
fn a_latency_that_has_changed_is_found_and_misleads_nobody() {
    let frames: Vec<Seen> = three_each(&[BLACK, BLACK, RED, GREEN, BLUE, BLUE])
        .into_iter()
        .enumerate()
        .map(|(k, colour)| frame(k, colour))
        .collect();
    // red comes two frames later than the timing says
    let shown = [4.0, 7.0, 10.0].map(|k| k * FRAME_MS - 10.0);
    let told = tag_frames(&frames, &shown, &timing(0.0), LookNoise::of(&[], &[]));
    let offset_ms = told.offset_ms.unwrap();
    // red began between the exposures of two frames: 51 to 68 ms late
    assert!((48.0..=71.0).contains(&offset_ms), "{offset_ms}");
    let expected = [0, 0, 1, 2, 3, 3].map(|k| [Tag::Shows(k); 3]).concat();
    for (tag, expected) in told.tags.iter().zip(expected) {
        assert!(*tag == expected || *tag == Tag::Unknown, "{:?}", told.tags);
    }
}

/// The clocks vouch for frames stamped 60 ms after their pattern was shown, and not later than 35 ms after the next one.
fn vouching(delay: Option<Delay>) -> Timing {
    Timing {
        settling: Some(Settling {
            old_until_ms: 35.0,
            new_from_ms: 60.0,
            hold_frames: 3,
            most_mixed: 1,
            watched: true,
        }),
        delay,
        change: Estimate {
            ms: 40.0,
            uncertainty_ms: 1.0,
        },
        ..timing(40.0)
    }
}

#[test]
fn a_sequence_is_begun_so_that_frames_come_where_the_clocks_vouch_for_them() {
    let delay = |most_ms| {
        Some(Delay {
            least_ms: 2.0,
            most_ms,
        })
    };
    // a change takes 25 ms, and its beginning is known to 35: together less than two frames of 33
    let timing = vouching(delay(37.0));
    assert_eq!(timing.hold_frames(1), 2);
    assert_eq!(timing.hold_frames(3), 4);
    let wider = vouching(delay(44.0));
    assert_eq!(wider.hold_frames(1), 3);
    for (earliest_ms, stamp_ms) in [(1000.0, 990.0), (1000.0, 1013.0), (1000.0, 20.0)] {
        let begin_ms = timing.begin_ms(earliest_ms, stamp_ms, 1);
        assert!((earliest_ms..earliest_ms + FRAME_MS).contains(&begin_ms));
        // shown as early or as late as may be, there is a frame that is vouched for
        for late_ms in [2.0, 37.0] {
            let shown_ms = begin_ms + late_ms;
            let frames = (0..60).map(|k| stamp_ms + FRAME_MS * f64::from(k));
            let vouched = frames.into_iter().filter(|stamp| {
                let since = stamp - shown_ms;
                timing.is_settled(Some(since), Some(since - 2.0 * FRAME_MS))
            });
            assert!(vouched.count() > 0, "{begin_ms}, {late_ms} ms late");
        }
        // where several frames are wanted, changes that fit between two frames fall there: half a frame away
        for (change_ms, expected) in [(20.0, FRAME_MS / 2.0), (40.0, 0.0)] {
            let mut timing = timing;
            timing.change.ms = change_ms;
            let one = timing.begin_ms(earliest_ms, stamp_ms, 1);
            let several = timing.begin_ms(earliest_ms, stamp_ms, 2);
            let apart = (one - several).rem_euclid(FRAME_MS);
            assert!((apart - expected).abs() < 1e-6, "{apart} for {change_ms}");
        }
    }
    let unknown = vouching(None).begin_ms(1000.0, 990.0, 1);
    assert!((unknown - 1000.0).abs() < 1e-9, "at once: {unknown}");
}

/// Frames of colours held for two frames each, the first of them half the colour before, and when the projector said that
/// each was shown; black is up before.
fn mixed_and_whole(colours: &[[f32; 3]]) -> (Vec<Seen>, Vec<f64>) {
    let mut frames = vec![frame(0, whole(BLACK)), frame(1, whole(BLACK))];
    let mut before = BLACK;
    for &colour in colours {
        let mixture = std::array::from_fn(|c| f32::midpoint(before[c], colour[c]));
        frames.push(frame(frames.len(), whole(mixture)));
        frames.push(frame(frames.len(), whole(colour)));
        before = colour;
    }
    let shown = (0..colours.len()).map(|k| FRAME_MS * (2.0 + 2.0 * k as f64) - 45.0);
    (frames, shown.collect())
}

#[test]
fn a_frame_between_two_mixed_ones_is_given_if_the_clocks_vouch_for_it_and_are_right_elsewhere() {
    // half of green lies between black and green, as a mixture of them does
    let half = GREEN.map(|value| value / 2.0);
    let colours = [
        RED, GREEN, BLUE, RED, GREEN, BLUE, RED, GREEN, BLUE, BLACK, half, GREEN, RED,
    ];
    let (frames, shown) = mixed_and_whole(&colours);
    let noise = LookNoise::of(&[], &[]);
    let place = 2 + 2 * 10 + 1;
    let clocks = vouching(None);
    let told = tag_frames(&frames, &shown, &clocks, noise);
    assert_eq!(told.tags[place], Tag::Shows(11));
    for (k, tag) in told.tags.iter().enumerate().skip(2) {
        let expected = Tag::Shows(k / 2);
        assert!(*tag == expected || k % 2 == 0, "frame {k}: {tag:?}");
        assert!(*tag != expected || k % 2 == 1, "frame {k} is mixed");
    }
    // not if the flashes missed frames, nor if the clocks would vouch for mixed ones too
    let mut doubtful = [clocks; 2];
    if let [Some(unwatched), Some(generous)] = doubtful.each_mut().map(|t| t.settling.as_mut()) {
        unwatched.watched = false;
        generous.new_from_ms = 40.0;
    }
    for timing in doubtful {
        let told = tag_frames(&frames, &shown, &timing, noise);
        assert_eq!(told.tags[place], Tag::Mixed);
    }
}

#[test]
fn a_little_light_of_another_pattern_is_ruled_out_before_a_frame_is_given() {
    let noise = LookNoise::of(&[], &[]);
    let mut frames = three_each(&[BLACK, RED, GREEN, BLUE]);
    let mixed = |share: f32| {
        let light = |c: usize| (1.0 - share) * GREEN[c] + share * BLUE[c];
        whole(std::array::from_fn(light))
    };
    // less than two frames of a still picture differ by under this noise
    for (share, expected) in [(0.0, Tag::Shows(2)), (0.2, Tag::Unknown)] {
        frames[8] = mixed(share);
        let looks = |k: usize| frame(k, frames[k]).look;
        let most = looks(8).most_foreign(&looks(7), &[&looks(9)], noise);
        assert!(most >= share && most < share + 0.05, "{share}: {most}");
        let tag = tags(&frames, 20.0)[8];
        assert!(tag == expected || tag == Tag::Mixed, "{share}: {tag:?}");
        assert_ne!(share > 0.0, tag == Tag::Shows(2));
    }
}

#[test]
fn two_frames_that_nearly_look_the_same_are_whole_and_a_torn_one_alone_is_not() {
    // each pattern is up for two frames, the first of which has a little of the light before
    let little =
        |of: [f32; 3], new: [f32; 3]| whole(std::array::from_fn(|c| 0.03 * of[c] + 0.97 * new[c]));
    let colours = [
        whole(BLACK),
        whole(BLACK),
        little(BLACK, RED),
        whole(RED),
        little(RED, GREEN),
        whole(GREEN),
        little(GREEN, BLUE),
        whole(BLUE),
        whole(BLUE),
    ];
    let frames: Vec<Seen> = (0..colours.len()).map(|k| frame(k, colours[k])).collect();
    let shown = [2.0, 4.0, 6.0].map(|k| k * FRAME_MS - 30.0);
    let told = tag_frames(&frames, &shown, &timing(20.0), LookNoise::of(&[], &[]));
    for (k, expected) in [(3, 1), (5, 2), (7, 3), (8, 3)] {
        assert_eq!(told.tags[k], Tag::Shows(expected), "{:?}", told.tags);
    }
}

#[test]
fn what_shows_no_pattern_of_the_sequence_is_not_labelled() {
    let grey = [[40.0, 41.0, 42.0]; 4];
    let tags = tags(&three_each(&grey), 20.0);
    assert!(
        tags.iter()
            .all(|tag| !matches!(tag, Tag::Shows(k) if *k > 0)),
        "{tags:?}"
    );
}

#[test]
fn pictures_that_differ_in_one_corner_or_in_place_only_do_not_look_the_same() {
    let noise = LookNoise::of(&[], &[]);
    let stripes = |shift: u32| {
        let picture = RgbImage::from_fn(160, 120, |x, _| {
            Rgb([if (x + shift) % 8 < 4 { 200 } else { 20 }; 3])
        });
        Look::of(&picture)
    };
    assert!(stripes(0).same(&stripes(8), noise));
    assert!(!stripes(0).same(&stripes(2), noise));
    let mut torn = RgbImage::from_pixel(160, 120, Rgb([90; 3]));
    let plain = Look::of(&torn);
    for x in 0..160 {
        torn.put_pixel(x, 119, Rgb([200; 3]));
    }
    assert!(!plain.same(&Look::of(&torn), noise));
}

#[test]
fn the_timing_is_found_from_flashes_with_its_uncertainty() {
    let (latency, readout, exposure) = (85.0, 12.0, 9.0);
    let flashes: Vec<Flash> = (0..16)
        .map(|k| Flash {
            shown_ms: 500.0 + 150.0 * f64::from(k) + 61.0 * (f64::from(k) * 0.618).fract(),
            due_ms: 490.0 + 150.0 * f64::from(k),
            white: k % 2 == 0,
        })
        .collect();
    // light since each change, seen in each band through its own exposure
    let white_until = |moment: f64| -> f64 {
        let lit = flashes.chunks(2).map(|pair| {
            let [on, off] = [pair[0], pair[1]].map(|flash| flash.shown_ms + latency);
            moment.clamp(on, off) - on
        });
        lit.sum()
    };
    let frames: Vec<(f64, Vec<Option<f32>>)> = (0..110)
        .map(|k| {
            let stamp = 33.0 * f64::from(k);
            let bands = (0..BANDS).map(|band| {
                let end = stamp + readout * (band as f64 + 0.5) / BANDS as f64;
                let share = (white_until(end) - white_until(end - exposure)) / exposure;
                Some(share as f32)
            });
            (stamp, bands.collect())
        })
        .collect();
    let timing = find_timing(&flashes, &frames, 33.0).unwrap();
    for (found, truth) in [
        (timing.latency, latency),
        (timing.readout, readout),
        (timing.exposure, exposure),
        (timing.jitter, 0.0),
    ] {
        assert!(
            (found.ms - truth).abs() <= found.uncertainty_ms,
            "{truth}: {timing:?}"
        );
        assert!(found.uncertainty_ms < 4.0, "{timing:?}");
    }
}

#[test]
fn no_frame_of_a_small_sweep_is_mislabelled_and_nearly_every_pattern_is_told() {
    let rates = [
        (60.0, 30.0),
        (50.0, 25.0),
        (59.94, 29.97),
        (75.0, 15.0),
        (120.0, 60.0),
    ];
    let mut sum = TaggingScore::default();
    for (k, (projector_hz, camera_hz)) in rates.into_iter().enumerate() {
        for loss in [0.0, 0.2] {
            let seed = 77 + k as u64;
            let rig = TaggingRig::by_chance(projector_hz, camera_hz, loss, seed);
            let scores = score_tagging(rig, seed);
            scores.iter().for_each(|score| sum.add(score));
        }
    }
    assert_eq!((sum.mislabelled, sum.timeless), (0, 0), "{sum:?}");
    assert!(sum.accepted > 500 && sum.untold <= 2, "{sum:?}");
}
