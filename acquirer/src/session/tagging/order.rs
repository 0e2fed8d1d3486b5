//! An order of colours in which each is easily told from a mixture of its neighbours, and which view may be first.
//!
//! Takes the colours of a sequence, gives the order. A frame that lies between its neighbours may be a mixture of them
//! (see `runs`), so each colour should stand out from both of its neighbours, by being brighter or darker than both
//! in some channel: orange between red and yellow never does.

use shared::pattern::Rgb;

/// The places of the colours in an order in which the least outstanding one stands out most.
///
/// Greedy from each start, the best start wins: close to the best order, found at once.
#[must_use]
pub fn outstanding_order(colours: &[Rgb]) -> Vec<usize> {
    let orders = (0..colours.len()).map(|start| {
        let order = greedy(colours, start);
        (least_outstanding(colours, &order), order)
    });
    let best = orders.max_by_key(|(least, _)| *least);
    best.map_or_else(Vec::new, |(_, order)| order)
}

/// Has the first of some views differ from what is up, so that its begin is seen, by changing places with the second one
/// where that helps; false when another view must be shown before them.
pub fn begin_seen<T>(views: &mut [T], is_up: impl Fn(&T) -> bool) -> bool {
    match views {
        [first, second, ..] if is_up(first) && !is_up(second) => {
            std::mem::swap(first, second);
            true
        }
        [first, ..] => !is_up(first),
        [] => true,
    }
}

fn greedy(colours: &[Rgb], start: usize) -> Vec<usize> {
    let mut order = vec![start];
    while order.len() < colours.len() {
        let left = (0..colours.len()).filter(|k| !order.contains(k));
        let value = |&k: &usize| match order[..] {
            [.., before, last] => outstanding(colours[last], [colours[before], colours[k]]),
            [last] => outstanding(colours[last], [colours[k], colours[k]]),
            [] => 0,
        };
        match left.max_by_key(value) {
            Some(next) => order.push(next),
            None => break,
        }
    }
    order
}

fn least_outstanding(colours: &[Rgb], order: &[usize]) -> u8 {
    let triples = order.windows(3);
    let values = triples.map(|t| outstanding(colours[t[1]], [colours[t[0]], colours[t[2]]]));
    values.min().unwrap_or(u8::MAX)
}

/// By how much, in the channel where it is most, a colour is above or below both of its neighbours.
fn outstanding(colour: Rgb, neighbours: [Rgb; 2]) -> u8 {
    let margin = |c: usize| {
        let (own, [a, b]) = (colour.0[c], neighbours.map(|n| n.0[c]));
        let above = own.saturating_sub(a.max(b));
        let below = a.min(b).saturating_sub(own);
        above.max(below)
    };
    (0..3).map(margin).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use shared::pattern::Palette;

    use super::*;

    #[test]
    fn a_view_that_is_up_is_not_first_where_another_one_may_be() {
        let begin = |views: &[char]| {
            let mut views = views.to_vec();
            let seen = begin_seen(&mut views, |view| *view == 'k');
            (views.into_iter().collect::<String>(), seen)
        };
        assert_eq!(begin(&['k', 'w', 'c']), ("wkc".into(), true));
        assert_eq!(begin(&['w', 'k']), ("wk".into(), true));
        assert_eq!(begin(&['k', 'k', 'w']), ("kkw".into(), false));
        assert_eq!(begin(&['k']), ("k".into(), false));
        assert_eq!(begin(&[]), (String::new(), true));
    }

    #[test]
    fn every_colour_of_the_palette_stands_out_by_half_the_range() {
        let palette = Palette::default();
        let colours: Vec<Rgb> = palette.colours().iter().map(|c| c.colour).collect();
        let order = outstanding_order(&colours);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..colours.len()).collect::<Vec<_>>());
        assert!(least_outstanding(&colours, &order) >= 127, "{order:?}");
    }
}
