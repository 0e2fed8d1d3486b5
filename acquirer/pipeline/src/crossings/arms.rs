//! How far each crossing's arms reach: up to half way to the next crossing, without the crossing's own zone.

use shared::pattern::Axis;

use super::{CrossingSettings, Crossings};
use crate::lines::Lines;

/// The middle of all gaps between neighbours on the lines of one direction; 0 when there are none.
#[must_use]
pub fn median_gap(crossings: &Crossings, axis: Axis) -> f64 {
    let mut gaps: Vec<f64> = Vec::new();
    for track in crossings.on(axis) {
        let along = |k: usize| crossings.all[k].along(axis);
        gaps.extend(track.windows(2).map(|pair| along(pair[1]) - along(pair[0])));
    }
    let middle = gaps.len() / 2;
    if gaps.is_empty() {
        return 0.0;
    }
    *gaps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Beside a line the derivative's kernel looks so many of its widths up and down, where a leaning line that
/// crosses comes into view before it is met.
const DISTURBED_WIDTHS: f64 = 1.3;

pub(super) fn set_arms(crossings: &mut Crossings, lines: &Lines, settings: &CrossingSettings) {
    let reach = settings.reach.clamp(0.2, 1.0);
    for axis in Axis::BOTH {
        let typical = median_gap(crossings, axis);
        let other = axis.other();
        let other_width = lines.family(other).width_px;
        let undisturbed = 0.5 * other_width + settings.margin_px;
        let lean_reach = DISTURBED_WIDTHS * lines.family(axis).width_px;
        for track in crossings.on(axis).to_vec() {
            let along: Vec<f64> = track
                .iter()
                .map(|&k| crossings.all[k].along(axis))
                .collect();
            for (at, &k) in track.iter().enumerate() {
                let before = if at > 0 {
                    along[at] - along[at - 1]
                } else {
                    f64::MAX
                };
                let after = along.get(at + 1).map_or(f64::MAX, |next| next - along[at]);
                let crossing = &crossings.all[k];
                let lean = lines.family(other).tracks[crossing.arms(other).track]
                    .slope(crossing.along(other))
                    .abs();
                let inner_px = undisturbed + lean_reach * lean;
                let shortest = inner_px + 4.0;
                let longest = if typical > 0.0 {
                    1.5 * typical
                } else {
                    8.0 * other_width
                };
                let arm = |gap: f64| (reach * gap.min(longest)).max(shortest);
                // at the end of a line the gap on the other side tells the pitch
                let fallback = before.min(after).min(longest);
                let outer = |gap: f64| arm(if gap == f64::MAX { fallback } else { gap });
                let crossing = &mut crossings.all[k];
                let arms = match axis {
                    Axis::Row => &mut crossing.row,
                    Axis::Column => &mut crossing.column,
                };
                arms.inner_px = inner_px;
                arms.outer_px = [outer(before), outer(after)];
            }
        }
    }
}
