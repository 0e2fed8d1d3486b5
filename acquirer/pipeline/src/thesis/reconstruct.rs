//! Grid reconstruction: which crossing of the pattern each crossing of the picture is (thesis, chapter 4.5).
//!
//! Takes the linked crossings, slides a window over them (2 x 2 crossings for 15 lines, 3 x 3 for 31 and 63,
//! 4 x 4 beyond) and looks its rows' and columns' colours up in the sequence. Every window votes for the
//! labels of its crossings; a crossing takes the label with the most votes. Then the thesis's three rules:
//! connections that disagree with the sequence are cut, loose lines that are no part of a square removed,
//! and points that could not be identified deleted. A smallest window has no redundancy: one wrong colour is
//! nearly always another window of the sequence, and its crossings are labelled wrongly without notice
//! unless their neighbours outvote it.

use std::collections::{BTreeMap, HashMap};

use shared::{
    pattern::{Axis, Grid, GridIndex},
    sequence::{Alphabet, LineLocator, Method, Symbol, line_symbols, window_order},
};

use super::lines::Links;
use crate::grid::DropReason;

/// A crossing's label.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Label {
    /// Row and column in the pattern.
    pub index: GridIndex,
    /// Share of the windows over this crossing that agree, 0 to 1.
    pub agreement: f64,
    votes: usize,
}

/// Finds windows among the lines of one direction.
#[derive(Debug)]
enum Windows {
    /// By the sequence's own locator.
    Sequence(usize, Box<LineLocator>),
    /// By search, for other people's codes.
    Listed(usize, Vec<Symbol>),
    /// No window of these lines is unique.
    None,
}

impl Windows {
    fn new(grid: &Grid, axis: Axis) -> Self {
        let symbols = grid.symbols(axis);
        let alphabet = if grid.colours().len() == 2 {
            Alphabet::Two
        } else {
            Alphabet::Four
        };
        let coded = line_symbols(alphabet, symbols.len()).is_ok_and(|coded| coded == symbols);
        if coded {
            let order = window_order(alphabet, symbols.len());
            let locator = LineLocator::new(alphabet, symbols.len(), Method::Table);
            if let (Ok(order), Ok(locator)) = (order, locator) {
                return Self::Sequence(order, Box::new(locator));
            }
        }
        let is_unique = |order: &usize| {
            let mut windows: Vec<&[Symbol]> = symbols.windows(*order).collect();
            windows.sort_unstable();
            windows.windows(2).all(|two| two[0] != two[1])
        };
        match (2..=symbols.len()).find(is_unique) {
            Some(order) => Self::Listed(order, symbols.to_vec()),
            None => Self::None,
        }
    }

    fn order(&self) -> Option<usize> {
        match self {
            Self::Sequence(order, _) | Self::Listed(order, _) => Some(*order),
            Self::None => None,
        }
    }

    fn locate(&self, window: &[Symbol]) -> Option<usize> {
        match self {
            Self::Sequence(_, locator) => locator.locate(window).ok(),
            Self::Listed(order, symbols) => symbols.windows(*order).position(|w| w == window),
            Self::None => None,
        }
    }
}

/// What one window says.
enum Reading {
    /// A link has no colour, or links of one line have different ones.
    Ambiguous,
    /// The sequence has no such window.
    Foreign,
    /// The window's first row and column.
    At(usize, usize),
}

/// Labels the crossings, or says why not; cuts the links that disagree with the labels.
pub(crate) fn reconstruct(links: &mut Links, grid: &Grid) -> Vec<Result<Label, DropReason>> {
    let windows = Axis::BOTH.map(|axis| Windows::new(grid, axis));
    let votes = vote(links, &windows);
    let mut labels: Vec<Result<Label, DropReason>> = votes.into_iter().map(Votes::label).collect();
    cut_disagreeing(links, &labels);
    links.keep_squares();
    drop_unconnected(links, &mut labels);
    drop_doubles(&mut labels);
    labels
}

/// The votes for one crossing.
#[derive(Debug, Clone, Default)]
struct Votes {
    labels: BTreeMap<GridIndex, usize>,
    ambiguous: usize,
    foreign: usize,
}

impl Votes {
    fn label(self) -> Result<Label, DropReason> {
        let most = self.labels.values().copied().max().unwrap_or(0);
        let mut best = self.labels.iter().filter(|(_, votes)| **votes == most);
        let all = self.labels.values().sum::<usize>() + self.foreign;
        match (best.next(), best.next()) {
            (Some((&index, &votes)), None) => Ok(Label {
                index,
                agreement: votes as f64 / all as f64,
                votes,
            }),
            (Some(_), Some(_)) => Err(DropReason::NotInCode),
            _ if self.foreign > 0 => Err(DropReason::NotInCode),
            _ if self.ambiguous > 0 => Err(DropReason::AmbiguousColour),
            _ => Err(DropReason::BrokenLine),
        }
    }
}

fn vote(links: &Links, windows: &[Windows; 2]) -> Vec<Votes> {
    let mut votes = vec![Votes::default(); links.right.len()];
    let [Some(rows), Some(columns)] = [&windows[0], &windows[1]].map(Windows::order) else {
        return votes;
    };
    for origin in 0..links.right.len() {
        let Some(members) = window_at(links, origin, rows, columns) else {
            continue;
        };
        let reading = read_window(links, &members, windows);
        for (i, row) in members.iter().enumerate() {
            for (j, &member) in row.iter().enumerate() {
                match reading {
                    Reading::Ambiguous => votes[member].ambiguous += 1,
                    Reading::Foreign => votes[member].foreign += 1,
                    Reading::At(row, column) => {
                        let index = GridIndex {
                            row: (row + i) as u16,
                            column: (column + j) as u16,
                        };
                        *votes[member].labels.entry(index).or_default() += 1;
                    }
                }
            }
        }
    }
    votes
}

/// The crossings of a window row by row, when all are there and each link leads where it should.
fn window_at(links: &Links, origin: usize, rows: usize, columns: usize) -> Option<Vec<Vec<usize>>> {
    let mut members: Vec<Vec<usize>> = Vec::with_capacity(rows);
    for _ in 0..rows {
        let mut row: Vec<usize> = Vec::with_capacity(columns);
        for j in 0..columns {
            let above = members
                .last()
                .map(|above| links.down[above[j]].map(|link| link.to));
            let left = j
                .checked_sub(1)
                .map(|j| links.right[row[j]].map(|link| link.to));
            row.push(match (above, left) {
                (None, None) => origin,
                (Some(from_above), None) => from_above?,
                (None, Some(from_left)) => from_left?,
                (Some(from_above), Some(from_left)) => {
                    from_above.filter(|_| from_above == from_left)?
                }
            });
        }
        members.push(row);
    }
    Some(members)
}

fn read_window(links: &Links, members: &[Vec<usize>], windows: &[Windows; 2]) -> Reading {
    let columns = members.first().map_or(0, Vec::len);
    let row_colour =
        |row: &Vec<usize>| one_colour(row[..columns - 1].iter().map(|&k| links.right[k]));
    let column_colour = |j: usize| {
        let above_last = &members[..members.len() - 1];
        one_colour(above_last.iter().map(|row| links.down[row[j]]))
    };
    let rows: Option<Vec<Symbol>> = members.iter().map(row_colour).collect();
    let columns: Option<Vec<Symbol>> = (0..columns).map(column_colour).collect();
    let (Some(rows), Some(columns)) = (rows, columns) else {
        return Reading::Ambiguous;
    };
    match (windows[0].locate(&rows), windows[1].locate(&columns)) {
        (Some(row), Some(column)) => Reading::At(row, column),
        _ => Reading::Foreign,
    }
}

/// The colour that all links of one line have.
fn one_colour(links: impl Iterator<Item = Option<super::lines::Link>>) -> Option<Symbol> {
    let mut colour = None;
    for link in links {
        let own = link?.colour?;
        if *colour.get_or_insert(own) != own {
            return None;
        }
    }
    colour.map(Symbol)
}

/// Rule (a): only connections that agree with the sequence stay.
fn cut_disagreeing(links: &mut Links, labels: &[Result<Label, DropReason>]) {
    let agrees = |from: usize, to: usize, step: (u16, u16)| {
        let (Ok(a), Ok(b)) = (&labels[from], &labels[to]) else {
            return false;
        };
        (b.index.row, b.index.column) == (a.index.row + step.0, a.index.column + step.1)
    };
    for (k, link) in links.right.iter_mut().enumerate() {
        *link = link.filter(|link| agrees(k, link.to, (0, 1)));
    }
    for (k, link) in links.down.iter_mut().enumerate() {
        *link = link.filter(|link| agrees(k, link.to, (1, 0)));
    }
}

/// Rule (c): points without a connection are deleted.
fn drop_unconnected(links: &Links, labels: &mut [Result<Label, DropReason>]) {
    let mut connected = vec![false; labels.len()];
    for links in [&links.right, &links.down] {
        for (from, link) in links.iter().enumerate() {
            if let Some(link) = link {
                connected[from] = true;
                connected[link.to] = true;
            }
        }
    }
    for (label, connected) in labels.iter_mut().zip(connected) {
        if label.is_ok() && !connected {
            *label = Err(DropReason::NotInCode);
        }
    }
}

/// Of several crossings with one label the one with the most votes keeps it, of equals the first.
fn drop_doubles(labels: &mut [Result<Label, DropReason>]) {
    let mut owners: HashMap<GridIndex, usize> = HashMap::new();
    for k in 0..labels.len() {
        let Ok(label) = labels[k] else {
            continue;
        };
        let Some(&owner) = owners.get(&label.index) else {
            owners.insert(label.index, k);
            continue;
        };
        let owner_votes = labels[owner].map_or(0, |owner| owner.votes);
        let loser = if label.votes > owner_votes { owner } else { k };
        labels[loser] = Err(DropReason::NotInCode);
        if loser == owner {
            owners.insert(label.index, k);
        }
    }
}
