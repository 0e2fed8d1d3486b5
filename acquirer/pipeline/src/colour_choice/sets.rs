//! Every set of four colours, judged together.
//!
//! Takes the separability of the colours, gives the sets in order: first those whose distances all exceed 3
//! standard deviations on nine tenths of the surface, then by expected error, which is half the sum of the
//! six pairs' errors and a quarter of the sum of the four colours' lost lines.

use shared::pattern::Rgb;

use super::Separability;

/// Distance, in standard deviations, that nine tenths of the surface should exceed.
pub(super) const SAFE_DISTANCE: f64 = 3.0;
/// Share of its error that a set in use must lose before another replaces it.
pub(super) const WORTH_CHANGING: f64 = 0.2;
/// Expected error at which a set in use is good enough to stay: votes along a line bury it.
pub(super) const GOOD_ENOUGH: f64 = 1e-4;

/// Four colours by their number in the trial, ascending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Set {
    /// Numbers of the colours.
    pub members: [usize; 4],
    /// Expected share of line pixels read wrongly.
    pub error: f64,
    /// Least distance among them and to no line.
    pub distance: f64,
}

impl Set {
    pub(super) fn new(members: [usize; 4], separability: &Separability) -> Self {
        let mut distance = f64::INFINITY;
        for (n, &a) in members.iter().enumerate() {
            distance = distance.min(separability.dark_distance[a]);
            for &b in &members[..n] {
                distance = distance.min(separability.distance[a][b]);
            }
        }
        Self {
            members,
            error: expected_error(members, &separability.error, &separability.dark_error),
            distance,
        }
    }

    fn is_safe(&self) -> bool {
        self.distance > SAFE_DISTANCE
    }
}

/// Expected share of line pixels read wrongly, from how often pairs of colours are mistaken and each
/// colour's lines are lost.
pub(super) fn expected_error(members: [usize; 4], pairs: &[Vec<f64>], dark: &[f64]) -> f64 {
    let error = |(n, &a): (usize, &usize)| {
        let others = members[..n].iter().map(|&b| pairs[a][b] / 2.0);
        dark[a] / 4.0 + others.sum::<f64>()
    };
    members.iter().enumerate().map(error).sum()
}

/// All sets of four, best first.
pub(super) fn rank(separability: &Separability) -> Vec<Set> {
    let n = separability.dark_error.len();
    let mut sets = Vec::new();
    for a in 0..n {
        for b in a + 1..n {
            for c in b + 1..n {
                sets.extend((c + 1..n).map(|d| Set::new([a, b, c, d], separability)));
            }
        }
    }
    sets.sort_unstable_by(|s, t| {
        (t.is_safe().cmp(&s.is_safe()))
            .then(s.error.total_cmp(&t.error))
            .then(t.distance.total_cmp(&s.distance))
            .then(s.members.cmp(&t.members))
    });
    sets
}

/// Whether a set in use should give way to another.
pub(super) fn is_worth_changing(current: &Set, best: &Set) -> bool {
    current.error > GOOD_ENOUGH && best.error < (1.0 - WORTH_CHANGING) * current.error
}

/// The members as symbols 0, 1, w, w2: the one with most errors first, because symbol 0 is the rarest of
/// a grid (3 of 15 lines), the others in palette order.
pub(super) fn symbol_order(set: &Set, separability: &Separability) -> [usize; 4] {
    let own_error = |a: usize| {
        let others = set.members.iter().filter(|&&b| b != a);
        separability.dark_error[a] + others.map(|&b| separability.error[a][b]).sum::<f64>()
    };
    let mut order = set.members;
    let worst = (0..4).max_by(|&m, &n| {
        own_error(order[m])
            .total_cmp(&own_error(order[n]))
            .then(n.cmp(&m))
    });
    if let Some(worst) = worst {
        order[..=worst].rotate_right(1);
    }
    order
}

/// The numbers of given colours in the trial, when all four were tried and differ.
pub(super) fn members_of(colours: [Rgb; 4], tried: &[Rgb]) -> Option<[usize; 4]> {
    let mut members = [0; 4];
    for (member, colour) in members.iter_mut().zip(colours) {
        *member = tried.iter().position(|known| *known == colour)?;
    }
    let mut sorted = members;
    sorted.sort_unstable();
    sorted
        .windows(2)
        .all(|pair| pair[0] != pair[1])
        .then_some(sorted)
}
