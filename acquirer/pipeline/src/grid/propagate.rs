//! Belief propagation over the links of a patch.
//!
//! Takes what each crossing has against each place of its patch in the code, gives the place that each settles on:
//! min-sum messages with a constant cost for neighbours that differ (Potts model; P. Felzenszwalb and
//! D. Huttenlocher 2006).

/// The crossings within a number of links of `start`.
pub(super) fn neighbourhood(
    start: usize,
    neighbours: &[Vec<usize>],
    steps: usize,
    seen_at: &mut [usize],
    found: &mut Vec<usize>,
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
/// each node.
pub(super) fn propagate(
    costs: &[Vec<f32>],
    neighbours: &[Vec<usize>],
    cut: f32,
    rounds: usize,
) -> Vec<usize> {
    let labels = costs.first().map_or(0, Vec::len);
    let reverse: Vec<Vec<usize>> = neighbours
        .iter()
        .enumerate()
        .map(|(a, around)| {
            let back = |&b: &usize| neighbours[b].iter().position(|&c| c == a).unwrap_or(0);
            around.iter().map(back).collect()
        })
        .collect();
    let blank = |around: &Vec<usize>| vec![vec![0.0f32; labels]; around.len()];
    let mut inbox: Vec<Vec<Vec<f32>>> = neighbours.iter().map(blank).collect();
    for _ in 0..rounds.min(200) {
        let mut next = inbox.clone();
        for (a, around) in neighbours.iter().enumerate() {
            let belief = sum(&costs[a], &inbox[a]);
            for (k, &b) in around.iter().enumerate() {
                let without: Vec<f32> = belief
                    .iter()
                    .zip(&inbox[a][k])
                    .map(|(all, own)| all - own)
                    .collect();
                let least = without.iter().copied().fold(f32::MAX, f32::min);
                let slot = &mut next[b][reverse[a][k]];
                for (message, value) in slot.iter_mut().zip(without) {
                    // half old, half new: loops settle instead of swinging
                    *message = 0.5 * *message + 0.5 * ((value - least).min(cut));
                }
            }
        }
        inbox = next;
    }
    costs
        .iter()
        .zip(&inbox)
        .map(|(cost, messages)| {
            let belief = sum(cost, messages);
            (0..labels).fold(0, |best, k| if belief[k] < belief[best] { k } else { best })
        })
        .collect()
}

fn sum(cost: &[f32], messages: &[Vec<f32>]) -> Vec<f32> {
    let mut belief = cost.to_vec();
    for message in messages {
        belief.iter_mut().zip(message).for_each(|(b, m)| *b += m);
    }
    belief
}
