//! Reasons to doubt crossings that have a place, and the causes behind those that have none.
//!
//! Takes the outcome of the decoding, changes it: two crossings of one label, the edge of a surface through a crossing,
//! colours that speak against the line they are seen on, light that was too weak or too strong.

use std::collections::BTreeMap;

use shared::pattern::{Axis, GridIndex};

use super::{
    DropReason,
    code::Orientation,
    find::{Labels, Outcome, Reading},
    labels::Label,
    vertices::Placement,
};

impl Reading<'_> {
    /// Crossings whose line becomes another one before its next crossing, with a colour that does not tell the two
    /// apart: the edge of a surface may pass through such a crossing, and part of its vertices stand elsewhere.
    pub(super) fn before_an_edge(
        &self,
        placement: &Placement<'_>,
        outcome: &[Outcome],
    ) -> Vec<bool> {
        let crossings = self.observed.crossings;
        let mut before_edge = vec![false; outcome.len()];
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
        labels: &Labels,
        outcome: &mut [Outcome],
    ) {
        let mut against = Vec::new();
        for (family, code) in Axis::BOTH
            .into_iter()
            .zip(self.decoding.codes_of(orientation))
        {
            let number = |node: &usize| match labels.get(node) {
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
        let mut best: BTreeMap<GridIndex, (usize, (bool, f64))> = BTreeMap::new();
        for k in 0..outcome.len() {
            let Ok(crossing) = &outcome[k] else { continue };
            let (index, rank) = (crossing.index, (all[k].is_whole(), crossing.confidence));
            let loser = match best.get(&index) {
                Some(&(_, other)) if other >= rank => Some(k),
                Some(&(other, _)) => {
                    best.insert(index, (k, rank));
                    Some(other)
                }
                None => {
                    best.insert(index, (k, rank));
                    None
                }
            };
            if let Some(loser) = loser {
                outcome[loser] = Err(DropReason::OffEpipolarLine);
            }
        }
    }
}
