//! How far each crossing's arms reach: up to half way to the next crossing, without the crossing's own zone.

use shared::pattern::Axis;

use super::{CrossingSettings, Crossings};
use crate::lines::Lines;

/// The middle of all gaps between neighbours on the lines of one direction; 0 when there are none.
pub(super) fn median_gap(crossings: &Crossings, axis: Axis, gaps: &mut Vec<f64>) -> f64 {
    gaps.clear();
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
        let typical = crossings.gap_px(axis);
        let other = axis.other();
        let other_width = lines.family(other).width_px;
        let undisturbed = 0.5 * other_width + settings.margin_px;
        let lean_reach = DISTURBED_WIDTHS * lines.family(axis).width_px;
        let Crossings {
            all,
            on_rows,
            on_columns,
            ..
        } = &mut *crossings;
        let on = match axis {
            Axis::Row => on_rows,
            Axis::Column => on_columns,
        };
        for track in on {
            for (at, &k) in track.iter().enumerate() {
                let along = all[k].along(axis);
                let gap = |beside: Option<&usize>| {
                    beside.map_or(f64::MAX, |&k| (all[k].along(axis) - along).abs())
                };
                let before = gap(at.checked_sub(1).and_then(|at| track.get(at)));
                let after = gap(track.get(at + 1));
                let crossing = &all[k];
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
                let outer_px = [outer(before), outer(after)];
                let crossing = &mut all[k];
                let arms = match axis {
                    Axis::Row => &mut crossing.row,
                    Axis::Column => &mut crossing.column,
                };
                (arms.inner_px, arms.outer_px) = (inner_px, outer_px);
            }
        }
    }
}
