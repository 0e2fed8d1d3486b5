//! Belief propagation over the links of a patch.
//!
//! Takes what each crossing has against each place of its patch in the code, gives the place that each settles on:
//! min-sum messages with a constant cost for neighbours that differ (Potts model; P. Felzenszwalb and
//! D. Huttenlocher 2006).

use bumpalo::{Bump, collections::Vec, vec};

/// The crossings within a number of links of `start`.
pub(super) fn neighbourhood(
    start: usize,
    neighbours: &[Vec<'_, usize>],
    steps: usize,
    seen_at: &mut [usize],
    found: &mut Vec<'_, usize>,
) {
    found.clear();
    found.push(start);
    seen_at[start] = start;
    let mut first = 0;
    for _ in 0..steps {
        let last = found.len();
        for k in first..last {
            for &next in &neighbours[found[k]] {
                if seen_at[next] != start {
                    seen_at[next] = start;
                    found.push(next);
                }
            }
        }
        first = last;
    }
}

/// Min-sum belief propagation with a constant cost for neighbours that differ; gives the cheapest label of
/// each node. `costs` has as many values for each node as there are labels.
pub(super) fn propagate<'a>(
    costs: &[f32],
    neighbours: &[Vec<'_, usize>],
    (cut, rounds): (f32, usize),
    bump: &'a Bump,
) -> Vec<'a, usize> {
    let labels = costs.len() / neighbours.len().max(1);
    let mailbox = Mailbox::new(neighbours, bump);
    let mut inbox = vec![in bump; 0.0f32; mailbox.slots() * labels];
    let mut next = inbox.clone();
    let (mut belief, mut without) = (vec![in bump; 0.0; labels], vec![in bump; 0.0; labels]);
    let believe = |node: usize, inbox: &[f32], belief: &mut [f32]| {
        belief.copy_from_slice(&costs[node * labels..][..labels]);
        let [first, end] = [mailbox.starts[node], mailbox.starts[node + 1]];
        for message in inbox[first * labels..end * labels].chunks_exact(labels.max(1)) {
            belief.iter_mut().zip(message).for_each(|(b, m)| *b += m);
        }
    };
    for _ in 0..rounds.min(200) {
        next.copy_from_slice(&inbox);
        for node in 0..neighbours.len() {
            believe(node, &inbox, &mut belief);
            for slot in mailbox.starts[node]..mailbox.starts[node + 1] {
                let own = &inbox[slot * labels..][..labels];
                for ((without, all), own) in without.iter_mut().zip(&belief).zip(own) {
                    *without = all - own;
                }
                let least = without.iter().copied().fold(f32::MAX, f32::min);
                let message = &mut next[mailbox.back[slot] * labels..][..labels];
                for (message, value) in message.iter_mut().zip(&without) {
                    // half old, half new: loops settle instead of swinging
                    *message = 0.5 * *message + 0.5 * ((value - least).min(cut));
                }
            }
        }
        std::mem::swap(&mut inbox, &mut next);
    }
    let cheapest = (0..neighbours.len()).map(|node| {
        believe(node, &inbox, &mut belief);
        (0..labels).fold(0, |best, k| if belief[k] < belief[best] { k } else { best })
    });
    Vec::from_iter_in(cheapest, bump)
}

/// A place for the message from each neighbour of each node.
struct Mailbox<'a> {
    /// Where the places of each node begin, and one past the last.
    starts: Vec<'a, usize>,
    /// For each of a node's places the one that the node has at that neighbour.
    back: Vec<'a, usize>,
}

impl<'a> Mailbox<'a> {
    fn new(neighbours: &[Vec<'_, usize>], bump: &'a Bump) -> Self {
        let mut starts = Vec::with_capacity_in(neighbours.len() + 1, bump);
        starts.push(0);
        let mut slots = 0;
        for around in neighbours {
            slots += around.len();
            starts.push(slots);
        }
        let mut back = Vec::with_capacity_in(slots, bump);
        for (a, around) in neighbours.iter().enumerate() {
            for &b in around {
                let at = neighbours[b].iter().position(|&c| c == a).unwrap_or(0);
                back.push(starts[b] + at);
            }
        }
        Self { starts, back }
    }

    fn slots(&self) -> usize {
        self.back.len()
    }
}
