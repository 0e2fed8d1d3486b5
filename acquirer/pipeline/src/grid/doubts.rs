//! Reasons to doubt crossings that have a place, and the causes behind those that have none.
//!
//! Takes the outcome of the decoding, changes it: two crossings of one label, the edge of a surface through a crossing,
//! colours that speak against the line they are seen on, light that was too weak or too strong.

use bumpalo::{collections::Vec, vec};
use shared::pattern::Axis;

use super::{
    DropReason,
    code::Orientation,
    find::{Outcome, Reading},
    labels::{Label, Labels},
    vertices::Placement,
};

impl<'a> Reading<'a> {
    /// Crossings whose line becomes another one before its next crossing, with a colour that does not tell the two
    /// apart: the edge of a surface may pass through such a crossing, and part of its vertices stand elsewhere.
    pub(super) fn before_an_edge(
        &self,
        placement: &Placement<'_>,
        outcome: &[Outcome],
    ) -> Vec<'a, bool> {
        let crossings = self.observed.crossings;
        let mut before_edge = vec![in self.bump; false; outcome.len()];
        for (family, gap_px) in Axis::BOTH.into_iter().zip(self.gaps_px) {
            let axis = placement.orientation.pattern_axis(family);
            let symbols = self.projected.pattern.coded.symbols(axis);
            let evidence = self.observed.colours.on(family);
            let may_be = |node: usize, line: u16, other: u16| {
                let nats =
                    |line: u16| evidence[node].nats[usize::from(symbols[usize::from(line)].0)];
                f64::from(nats(line) - nats(other)) < self.settings.contradiction_nats
            };
            for pair in crossings.on(family).iter().flat_map(|on| on.windows(2)) {
                let [a, b] = [pair[0], pair[1]];
                let gap = crossings.all[b].along(family) - crossings.all[a].along(family);
                let (Ok(one), Ok(other)) = (&outcome[a], &outcome[b]) else {
                    continue;
                };
                let [one, other] = [one, other].map(|crossing| crossing.index.line(axis));
                if one != other && gap < self.settings.longest_gap * gap_px {
                    before_edge[a] |= may_be(a, one, other);
                    before_edge[b] |= may_be(b, other, one);
                }
            }
        }
        before_edge
    }

    /// A crossing without a place whose own colour speaks against the line that it is seen on breaks that line: it
    /// may be another one there.
    pub(super) fn find_contradictions(
        &self,
        orientation: Orientation,
        labels: &Labels<'_>,
        outcome: &mut [Outcome],
    ) {
        let mut against = Vec::new_in(self.bump);
        for (family, code) in Axis::BOTH
            .into_iter()
            .zip(self.decoding.codes_of(orientation))
        {
            let number = |node: &usize| match &labels[*node] {
                Some(Label::Known { flat, steep, .. }) if outcome[*node].is_ok() => {
                    Some(if family == Axis::Row { *flat } else { *steep })
                }
                _ => None,
            };
            let evidence = self.observed.colours.on(family);
            for on in self.observed.crossings.on(family) {
                for (at, &node) in on.iter().enumerate().filter(|(_, k)| outcome[**k].is_err()) {
                    let before = on[..at].iter().rev().find_map(number);
                    let after = on[at + 1..].iter().find_map(number);
                    let mut around = [before, after].into_iter().flatten().peekable();
                    let fits = |line: u16| {
                        code.symbol(line.into()).is_some_and(|symbol| {
                            let nats = f64::from(evidence[node].nats[usize::from(symbol)]);
                            nats >= -self.settings.contradiction_nats
                        })
                    };
                    if around.peek().is_some() && !around.any(fits) {
                        against.push(node);
                    }
                }
            }
        }
        for node in against {
            outcome[node] = Err(DropReason::AmbiguousColour);
        }
    }

    /// Behind a broken line or an unclear colour often stands light that was too weak or too strong.
    pub(super) fn find_causes(&self, outcome: &mut [Outcome]) {
        for (node, outcome) in outcome.iter_mut().enumerate() {
            let Err(reason @ (DropReason::BrokenLine | DropReason::AmbiguousColour)) = outcome
            else {
                continue;
            };
            let on = Axis::BOTH.map(|axis| self.observed.colours.on(axis)[node]);
            if on.iter().any(|evidence| evidence.clipped > 0.5) {
                *reason = DropReason::Clipped;
            } else if on
                .iter()
                .any(|evidence| f64::from(evidence.signal) < self.settings.dark_sigma)
            {
                *reason = DropReason::TooDark;
            }
        }
    }

    /// Of crossings with one label a whole one stays, then the most confident.
    pub(super) fn keep_one_of_each(&self, outcome: &mut [Outcome]) {
        let all = &self.observed.crossings.all;
        let placed = outcome.iter().enumerate();
        let placed = placed.filter_map(|(k, outcome)| Some((outcome.as_ref().ok()?.index, k)));
        let mut placed = Vec::from_iter_in(placed, self.bump);
        placed.sort_unstable();
        for same in placed.chunk_by(|a, b| a.0 == b.0) {
            let rank = |k: usize| {
                let confidence = outcome[k].as_ref().map_or(0.0, |c| c.confidence);
                (all[k].is_whole(), confidence)
            };
            let best = same.iter().fold(
                same[0].1,
                |best, &(_, k)| {
                    if rank(k) > rank(best) { k } else { best }
                },
            );
            for &(_, k) in same.iter().filter(|(_, k)| *k != best) {
                outcome[k] = Err(DropReason::OffEpipolarLine);
            }
        }
    }
}
