//! Which line of the pattern each line of a patch is.
//!
//! Takes patches with integer places and the colour evidence of their crossings; gives each crossing a
//! line number per family, or a reason why not. Rows and columns are independent codes. For each patch and
//! family the log-likelihood of every place in the code is the sum of all its crossings' evidence
//! (maximum likelihood over the whole patch: one wrong colour then does no harm). Where parts of a patch
//! want different places, because a depth edge was linked, min-sum belief propagation over the likeliest
//! places (Potts model on the links) cuts it into parts of one place each. A part is accepted with a
//! margin to the second place and with more lines than a window has; with a calibration also a smaller part, if
//! colours and epipolar lines together leave one place only. Two surfaces whose colours agree
//! along the wrong link stay together quietly; the position checks may tell.

use std::collections::BTreeMap;

use shared::pattern::Axis;

use super::{
    DecodeSettings, DropReason,
    code::{Code, Fit, LineEvidence},
    expected::ExpectedLines,
    links::{Link, Patch},
    propagate::{neighbourhood, propagate},
};
use crate::colours::Colours;

/// What was found out about one crossing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Label {
    /// Its line numbers in the picture's order of counting, and the probability that they are right.
    Known {
        flat: u16,
        steep: u16,
        confidence: f64,
    },
    /// Not labelled.
    Dropped(DropReason),
}

/// A crossing's distance from the epipolar line of a flat and a steep line's numbers; `None` where it can't be seen.
pub(super) type EpipolarDistance<'a> = dyn Fn(usize, u16, u16) -> Option<f64> + 'a;

/// Decodes patches against the codes of the flat and the steep family.
#[derive(Clone, Copy)]
pub(super) struct Decoder<'a> {
    /// The codes of the flat and of the steep family.
    pub(super) codes: [&'a Code; 2],
    pub(super) colours: &'a Colours,
    pub(super) links: &'a [Link],
    pub(super) settings: &'a DecodeSettings,
    /// Where the geometry is known: how far a crossing lies from the epipolar line that it would have with these
    /// numbers of its flat and its steep line, as a share of the largest distance that is allowed.
    pub(super) epipolar: Option<&'a EpipolarDistance<'a>>,
    /// With coarser grids read before: the lines that crossings should lie on.
    pub(super) expected: Option<&'a ExpectedLines>,
}

impl Decoder<'_> {
    /// Labels the crossings of all patches; crossings in no patch are left out.
    pub(super) fn label(&self, patches: &[Patch]) -> BTreeMap<usize, Label> {
        let mut labels = BTreeMap::new();
        for patch in patches {
            for part in self.parts(patch) {
                self.label_part(&part, &mut labels);
            }
        }
        labels
    }

    fn code(&self, family: Axis) -> &Code {
        match family {
            Axis::Row => self.codes[0],
            Axis::Column => self.codes[1],
        }
    }

    pub(super) fn evidence(
        &self,
        family: Axis,
        nodes: impl Iterator<Item = (usize, (i32, i32))>,
    ) -> LineEvidence {
        let mut lines = LineEvidence::default();
        for (node, place) in nodes {
            lines.add(line_of(family, place), &self.colours.on(family)[node].nats);
        }
        lines
    }

    /// Every place of a patch's lines in the code, likeliest first.
    pub(super) fn places(&self, family: Axis, patch: &Patch, lines: &LineEvidence) -> Vec<Fit> {
        let code = self.code(family);
        let mut fits = code.places(lines, self.settings.outside_nats as f32);
        if let Some(expected) = self.expected {
            for fit in &mut fits {
                let costs = patch.members().map(|(node, place)| {
                    let line = line_of(family, place) as i32 + fit.offset;
                    expected.cost(family, node, line)
                });
                fit.nats -= costs.sum::<f32>();
            }
            fits.sort_by(|a, b| b.nats.total_cmp(&a.nats).then(a.offset.cmp(&b.offset)));
        }
        fits
    }

    /// Cuts a patch where its parts stand at different places of the code.
    pub(super) fn parts(&self, patch: &Patch) -> Vec<Patch> {
        if Axis::BOTH.iter().all(|&family| self.agrees(family, patch)) {
            return vec![patch.clone()];
        }
        let neighbours = self.neighbours(patch);
        let flat = self.settle(Axis::Row, patch, &neighbours);
        let steep = self.settle(Axis::Column, patch, &neighbours);
        let same = |a: usize, b: usize| flat[a] == flat[b] && steep[a] == steep[b];
        let mut part_of = vec![usize::MAX; patch.nodes.len()];
        let mut parts: Vec<Patch> = Vec::new();
        for start in 0..patch.nodes.len() {
            if part_of[start] != usize::MAX {
                continue;
            }
            let mut part = Patch {
                nodes: Vec::new(),
                places: Vec::new(),
            };
            let mut open = vec![start];
            part_of[start] = parts.len();
            while let Some(at) = open.pop() {
                part.nodes.push(patch.nodes[at]);
                part.places.push(patch.places[at]);
                for &next in &neighbours[at] {
                    if part_of[next] == usize::MAX && same(at, next) {
                        part_of[next] = parts.len();
                        open.push(next);
                    }
                }
            }
            part.start_at_zero();
            parts.push(part);
        }
        parts
    }

    /// Linked crossings of each crossing, as positions in the patch.
    fn neighbours(&self, patch: &Patch) -> Vec<Vec<usize>> {
        let at: BTreeMap<usize, usize> = patch
            .nodes
            .iter()
            .enumerate()
            .map(|(k, &n)| (n, k))
            .collect();
        let mut neighbours = vec![Vec::new(); patch.nodes.len()];
        for link in self.links {
            if let (Some(&a), Some(&b)) = (at.get(&link.a), at.get(&link.b)) {
                neighbours[a].push(b);
                neighbours[b].push(a);
            }
        }
        neighbours
    }

    /// The place in the code (number of the patch's line 0) that each crossing of a patch votes for, its
    /// neighbours considered.
    fn settle(&self, family: Axis, patch: &Patch, neighbours: &[Vec<usize>]) -> Vec<i32> {
        let whole = self.places(family, patch, &self.evidence(family, patch.members()));
        let Some(best) = whole.first() else {
            return vec![0; patch.nodes.len()];
        };
        let doubts = self.doubts(family, patch, best.offset);
        let candidates = self.candidates(family, (patch, &doubts), neighbours, best.offset);
        if candidates.len() == 1 {
            return vec![best.offset; patch.nodes.len()];
        }
        let costs: Vec<Vec<f32>> = patch
            .members()
            .map(|(node, place)| self.costs(family, node, place, &candidates))
            .collect();
        let choice = propagate(
            &costs,
            neighbours,
            self.settings.cut_nats as f32,
            self.settings.rounds,
        );
        choice.into_iter().map(|k| candidates[k]).collect()
    }

    /// What each crossing of a patch has against the patch's place in the code, in nats.
    fn doubts(&self, family: Axis, patch: &Patch, offset: i32) -> Vec<f32> {
        let cost = |(node, place)| self.cost(family, node, place, offset);
        patch.members().map(cost).collect()
    }

    /// Whether all crossings of a patch together have so little against its place in the code that none of its
    /// neighbourhoods can prefer another one clearly.
    fn agrees(&self, family: Axis, patch: &Patch) -> bool {
        let lines = self.evidence(family, patch.members());
        let place = self
            .code(family)
            .best_place(&lines, self.settings.outside_nats as f32);
        place.is_none_or(|(offset, _)| {
            let cost = |(node, place)| self.cost(family, node, place, offset);
            patch.members().map(cost).sum::<f32>() <= self.settings.cut_nats as f32
        })
    }

    /// Places that some neighbourhood of the patch clearly prefers, with the whole patch's best first.
    fn candidates(
        &self,
        family: Axis,
        (patch, doubts): (&Patch, &[f32]),
        neighbours: &[Vec<usize>],
        best: i32,
    ) -> Vec<i32> {
        const MOST: usize = 16;
        let code = self.code(family);
        let steps = code.window + 1;
        let mut votes: BTreeMap<i32, usize> = BTreeMap::new();
        let mut seen_at = vec![usize::MAX; patch.nodes.len()];
        let (mut around, mut lines) = (Vec::new(), LineEvidence::default());
        for start in 0..patch.nodes.len() {
            neighbourhood(start, neighbours, steps, &mut seen_at, &mut around);
            // another place can't lead by more than what speaks against the best
            if around.iter().map(|&k| doubts[k]).sum::<f32>() <= self.settings.cut_nats as f32 {
                continue;
            }
            lines.clear();
            for &k in &around {
                let line = line_of(family, patch.places[k]);
                lines.add(line, &self.colours.on(family)[patch.nodes[k]].nats);
            }
            if lines.lines() < code.window {
                continue;
            }
            let place = code.best_place(&lines, self.settings.outside_nats as f32);
            if let Some((offset, lead)) = place
                && lead > self.settings.cut_nats as f32
            {
                *votes.entry(offset).or_default() += 1;
            }
        }
        for (node, place) in patch.members() {
            let line = self.expected.and_then(|e| e.nearest(family, node));
            if let Some(line) = line {
                *votes
                    .entry(line - line_of(family, place) as i32)
                    .or_default() += 1;
            }
        }
        votes.remove(&best);
        let mut others: Vec<(usize, i32)> =
            votes.into_iter().map(|(offset, n)| (n, offset)).collect();
        others.sort_by_key(|&(n, offset)| (std::cmp::Reverse(n), offset));
        let mut candidates = vec![best];
        candidates.extend(others.into_iter().take(MOST - 1).map(|(_, offset)| offset));
        candidates
    }

    /// What a crossing has against a place of its patch in the code, in nats.
    fn cost(&self, family: Axis, node: usize, place: (i32, i32), offset: i32) -> f32 {
        let line = line_of(family, place) as i32;
        let expected = self
            .expected
            .map_or(0.0, |e| e.cost(family, node, line + offset));
        match self.code(family).symbol(line + offset) {
            Some(symbol) => expected - self.colours.on(family)[node].nats[usize::from(symbol)],
            None => self.settings.outside_nats as f32,
        }
    }

    fn costs(&self, family: Axis, node: usize, place: (i32, i32), candidates: &[i32]) -> Vec<f32> {
        let cost = |&offset: &i32| self.cost(family, node, place, offset);
        candidates.iter().map(cost).collect()
    }

    /// Accepts or drops a part whose crossings all stand at one place of the code.
    fn label_part(&self, part: &Patch, labels: &mut BTreeMap<usize, Label>) {
        let placed = self.place_by_colour(part);
        let placed = placed.or_else(|reason| self.place_by_epipolar_lines(part).ok_or(reason));
        for (node, place) in part.members() {
            let label = match placed {
                Ok((offsets, certainty)) => self.label_one(node, place, offsets, certainty),
                Err(reason) => Label::Dropped(reason),
            };
            labels.insert(node, label);
        }
    }

    /// The offsets of a part's lines in both codes from its colours alone, and the probability that they are
    /// right.
    fn place_by_colour(&self, part: &Patch) -> Result<([i32; 2], f64), DropReason> {
        let mut offsets = [0; 2];
        let mut certainty = 1.0;
        for (k, family) in Axis::BOTH.into_iter().enumerate() {
            let lines = self.evidence(family, part.members());
            let places = self.places(family, part, &lines);
            let second = places.get(1).map_or(f32::MIN, |fit| fit.nats);
            let margin = places.first().map_or(0.0, |fit| fit.nats - second);
            // where coarser grids tell the place, a part needs no window of its own
            let is_told = self.expected.is_some_and(|e| e.knows_most(&part.nodes));
            if lines.lines() < self.code(family).window + 1 && !is_told {
                return Err(DropReason::BrokenLine);
            }
            if f64::from(margin) < self.settings.margin_nats {
                return Err(self.why_unclear(part, family));
            }
            offsets[k] = places[0].offset;
            certainty /= 1.0 + rest(places[1..].iter().map(|fit| fit.nats), places[0].nats);
        }
        Ok((offsets, certainty))
    }

    /// The offsets of a part too small or too unclear for its colours alone: both codes together, each pair of
    /// offsets weighed by how well the crossings then lie on their epipolar lines.
    fn place_by_epipolar_lines(&self, part: &Patch) -> Option<([i32; 2], f64)> {
        self.epipolar?;
        if part.nodes.len() < 2 * self.window() {
            return None; // in a long code a few crossings find a place of their colours by chance
        }
        let [flat, steep] = Axis::BOTH.map(|family| {
            let lines = self.evidence(family, part.members());
            let mut places = self.places(family, part, &lines);
            let least = places.first().map_or(0.0, |fit| fit.nats) - HOPELESS_NATS;
            places.retain(|fit| fit.nats > least);
            places
        });
        let pairs = flat.iter().flat_map(|a| steep.iter().map(move |b| (a, b)));
        let fits = pairs.map(|(a, b)| {
            let offsets = [a.offset, b.offset];
            (a.nats + b.nats - self.epipolar_cost(part, offsets), offsets)
        });
        self.clearly_best(part, fits)
    }

    /// The longer window of the two codes.
    pub(super) fn window(&self) -> usize {
        self.codes[0].window.max(self.codes[1].window)
    }

    /// The likeliest offsets if they lead by the margin and the part then lies near its epipolar lines, and the
    /// probability that they are right.
    pub(super) fn clearly_best(
        &self,
        part: &Patch,
        fits: impl Iterator<Item = (f32, [i32; 2])>,
    ) -> Option<([i32; 2], f64)> {
        let mut fits: Vec<(f32, [i32; 2])> = fits.collect();
        fits.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
        let &(best, offsets) = fits.first()?;
        let second = fits.get(1).map_or(f32::MIN, |fit| fit.0);
        let near = part
            .members()
            .filter(|&m| self.off_line(m, offsets) < NEAR_NATS);
        let near = 2 * near.count() > part.nodes.len();
        let clear = f64::from(best - second) >= self.settings.margin_nats;
        let certainty = 1.0 / (1.0 + rest(fits[1..].iter().map(|fit| fit.0), best));
        (near && clear).then_some((offsets, certainty))
    }

    /// What the distances from the epipolar lines speak against these offsets, in nats.
    pub(super) fn epipolar_cost(&self, part: &Patch, offsets: [i32; 2]) -> f32 {
        let costs = part.members().map(|member| self.off_line(member, offsets));
        costs.sum()
    }

    /// What one crossing's distance from its epipolar line speaks against these offsets, in nats.
    fn off_line(&self, (node, place): (usize, (i32, i32)), offsets: [i32; 2]) -> f32 {
        /// It may be badly placed.
        const MOST_NATS: f64 = 8.0;
        /// Standard deviation, as a share of the largest distance that is allowed.
        const SIGMA: f64 = 1.0 / 3.0;
        let number = |k: usize| {
            let line = line_of(Axis::BOTH[k], place) as i32 + offsets[k];
            u16::try_from(line).ok()
        };
        let distance = number(0)
            .zip(number(1))
            .and_then(|(flat, steep)| self.epipolar?(node, flat, steep));
        distance.map_or(MOST_NATS, |d| (0.5 * (d / SIGMA).powi(2)).min(MOST_NATS)) as f32
    }

    pub(super) fn label_one(
        &self,
        node: usize,
        place: (i32, i32),
        offsets: [i32; 2],
        certainty: f64,
    ) -> Label {
        let mut confidence = certainty;
        let mut numbers = [0u16; 2];
        for (k, family) in Axis::BOTH.into_iter().enumerate() {
            let line = line_of(family, place) as i32 + offsets[k];
            let Some(symbol) = self.code(family).symbol(line) else {
                return Label::Dropped(DropReason::NotInCode);
            };
            if self
                .expected
                .is_some_and(|e| e.contradicts(family, node, line))
            {
                return Label::Dropped(DropReason::OffEpipolarLine);
            }
            let evidence = &self.colours.on(family)[node];
            let own = f64::from(evidence.nats[usize::from(symbol)]);
            if own < -self.settings.contradiction_nats {
                return Label::Dropped(DropReason::AmbiguousColour);
            }
            // the patch says the line, its own colour may agree more or less
            confidence *= 0.8 + 0.2 * own.exp();
            numbers[k] = line as u16;
        }
        Label::Known {
            flat: numbers[0],
            steep: numbers[1],
            confidence: confidence.clamp(0.0, 1.0),
        }
    }

    /// Why a part's evidence leaves more than one place open.
    fn why_unclear(&self, part: &Patch, family: Axis) -> DropReason {
        let share = |holds: &dyn Fn(usize) -> bool| {
            let count = part.nodes.iter().filter(|&&node| holds(node)).count();
            2 * count > part.nodes.len()
        };
        let evidence = self.colours.on(family);
        if share(&|node| evidence[node].clipped > 0.5) {
            DropReason::Clipped
        } else if share(&|node| f64::from(evidence[node].signal) < self.settings.dark_sigma) {
            DropReason::TooDark
        } else if share(&|node| {
            let mut nats = evidence[node].nats;
            nats.sort_by(|a, b| b.total_cmp(a));
            nats[1] > -3.0
        }) {
            DropReason::AmbiguousColour
        } else {
            DropReason::NotInCode
        }
    }
}

/// A crossing lies near its epipolar line, 1.4 standard deviations, when that costs less, nats.
const NEAR_NATS: f32 = 1.0;

/// Places in the code whose colours fit so much worse than the best are not looked at again.
const HOPELESS_NATS: f32 = 25.0;

/// Summed likelihoods of what fits worse, relative to the best.
fn rest(others: impl Iterator<Item = f32>, best: f32) -> f64 {
    others.map(|nats| f64::from(nats - best).exp()).sum()
}

/// Which line of a family a place is on.
pub(super) fn line_of(family: Axis, place: (i32, i32)) -> usize {
    let line = match family {
        Axis::Row => place.0,
        Axis::Column => place.1,
    };
    line.max(0) as usize
}
