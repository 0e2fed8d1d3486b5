//! The curve that makes light add up best: weighted least squares, round by round (Gauss-Newton).

use nalgebra::{DMatrix, DVector};

use super::{
    curve::{KNOTS, ResponseCurve, Splines, srgb},
    equations::{Group, Kind},
};

/// The powers of the sRGB curve that are tried: from beyond a camera without any curve to twice as steep as sRGB.
const POWERS: [f64; 2] = [0.35, 2.0];
/// How much the curve bends otherwise than such a power from knot to knot, standard deviation, light.
const BEND: f64 = 0.002;
/// Weight of what keeps the scale of light, which the equations leave open: above all others.
const SCALE_WEIGHT: f64 = 1e12;
/// Miss from which on a block counts as an outlier in the choice of the power, byte values.
const OUTLIER_LEVELS: f64 = 2.0;
/// Standard deviation of a grey's share of white around that of a projector of gamma 2.2.
const GREY_SPREAD: f64 = 0.1;
const ROUNDS: usize = 15;

/// Unknowns of the curve: the first knot is fixed.
const FREE: usize = KNOTS - 1;

/// One equation at the present curve.
struct Row {
    /// Factors of the knots' differences from sRGB.
    knots: [f64; FREE],
    /// What the sRGB part of the curve leaves.
    rest: f64,
    /// Change with the grey's share.
    share: f64,
    /// Miss, byte values.
    levels: f64,
    /// Byte values to light.
    slope: f64,
}

/// The curve on its way: the knots' differences from sRGB.
pub(super) struct Fit {
    splines: Splines,
    differences: [f64; KNOTS],
    /// Those of the power of sRGB that it bends around.
    base: [f64; KNOTS],
    table: [f64; 256],
}

impl Fit {
    pub(super) fn new() -> Self {
        let splines = Splines::new();
        let differences = [0.0; KNOTS];
        Self {
            table: splines.table(&differences),
            splines,
            differences,
            base: differences,
        }
    }

    pub(super) fn light(&self, byte: f64) -> f64 {
        let low = (byte.max(0.0) as usize).min(254);
        self.table[low] + (byte - low as f64) * (self.table[low + 1] - self.table[low])
    }

    fn slope(&self, byte: f64) -> f64 {
        let low = (byte.max(0.0) as usize).min(254);
        (self.table[low + 1] - self.table[low]).max(1e-5)
    }

    /// By how much an equation misses, byte values.
    fn levels(&self, group: &Group, bytes: &[f64; 4]) -> f64 {
        let (mut miss, mut slope) = (0.0, 0.0_f64);
        for (&byte, factor) in bytes.iter().zip(group.factors()) {
            miss += factor * self.light(byte);
            slope += (factor * self.slope(byte)).powi(2);
        }
        miss / slope.sqrt()
    }

    fn row(&self, group: &Group, bytes: &[f64; 4]) -> Row {
        let factors = group.factors();
        let (mut knots, mut rest, mut miss, mut slope) = ([0.0; FREE], 0.0, 0.0, 0.0_f64);
        for (&byte, factor) in bytes.iter().zip(factors) {
            let weights = self.splines.at(byte);
            for (sum, weight) in knots.iter_mut().zip(&weights[1..]) {
                *sum += factor * weight;
            }
            rest += factor * srgb(byte);
            miss += factor * self.light(byte);
            slope += (factor * self.slope(byte)).powi(2);
        }
        let share = match group.kind {
            Kind::Pair => 0.0,
            Kind::Grey => self.light(bytes[1]) - self.light(bytes[2]),
        };
        let slope = slope.sqrt();
        Row {
            knots,
            rest,
            share,
            levels: miss / slope,
            slope,
        }
    }

    /// How far the equations of one kind miss, byte values, in rising order.
    fn misses(&self, groups: &[Group], kind: Kind) -> Vec<f64> {
        let groups = groups.iter().filter(|group| group.kind == kind);
        let mut misses: Vec<f64> = groups
            .flat_map(|group| {
                let levels = |bytes| self.levels(group, bytes).abs();
                group.bytes.iter().map(levels)
            })
            .collect();
        misses.sort_by(f64::total_cmp);
        misses
    }

    /// Root mean square of what is missed by the kind that misses more, byte values, the largest twentieth left out.
    pub(super) fn residual(&self, groups: &[Group]) -> f64 {
        const KEPT: f64 = 0.95;
        let residual = |kind| {
            let mut misses = self.misses(groups, kind);
            misses.truncate((KEPT * misses.len() as f64) as usize);
            (misses.iter().map(|v| v * v).sum::<f64>() / misses.len().max(1) as f64).sqrt()
        };
        residual(Kind::Pair).max(residual(Kind::Grey))
    }

    /// The typical miss of pairs and of greys, as a standard deviation, byte values: each kind by itself, so that
    /// many good greys do not make outliers of all pairs while the curve is still wrong.
    fn scales(&self, groups: &[Group]) -> [f64; 2] {
        [Kind::Pair, Kind::Grey].map(|kind| {
            let misses = self.misses(groups, kind);
            let median = misses.get(misses.len() / 2).copied().unwrap_or(1.0);
            (1.4826 * median).max(0.05)
        })
    }

    /// Takes the power of the sRGB curve with which everything adds up best (golden section search).
    pub(super) fn take_best_power(&mut self, groups: &mut [Group]) {
        const STEPS: usize = 14; // narrows the powers tried to 0.2 % of themselves
        let part = 0.5 * (5.0_f64.sqrt() - 1.0);
        let [mut low, mut high] = POWERS.map(f64::ln);
        let mut cost_at = |place: f64| {
            self.take_power(place.exp());
            self.settle_shares(groups);
            self.cost(groups)
        };
        let (mut a, mut b) = (high - part * (high - low), low + part * (high - low));
        let (mut cost_a, mut cost_b) = (cost_at(a), cost_at(b));
        for _ in 0..STEPS {
            if cost_a < cost_b {
                (high, b, cost_b) = (b, a, cost_a);
                a = high - part * (high - low);
                cost_a = cost_at(a);
            } else {
                (low, a, cost_a) = (a, b, cost_b);
                b = low + part * (high - low);
                cost_b = cost_at(b);
            }
        }
        cost_at(0.5 * (low + high));
    }

    fn take_power(&mut self, power: f64) {
        let byte = |k: usize| 255.0 * k as f64 / (KNOTS - 1) as f64;
        self.base = std::array::from_fn(|k| srgb(byte(k)).powf(power) - srgb(byte(k)));
        self.take(self.base);
    }

    pub(super) fn take(&mut self, differences: [f64; KNOTS]) {
        self.differences = differences;
        self.table = self.splines.table(&differences);
    }

    /// What all misses cost together, those of outliers little, and shares far from their nominal values.
    fn cost(&self, groups: &[Group]) -> f64 {
        let costs = groups.iter().map(|group| {
            let off = (group.share - group.nominal_share) / GREY_SPREAD;
            let miss = |bytes| (self.levels(group, bytes) / OUTLIER_LEVELS).powi(2).ln_1p();
            group.bytes.iter().map(miss).sum::<f64>() + off * off
        });
        costs.sum()
    }

    /// Fits the greys' shares alone, with the curve as it is.
    pub(super) fn settle_shares(&self, groups: &mut [Group]) {
        const ROUNDS: usize = 2; // the second one knows the outliers
        for group in groups.iter_mut().filter(|group| group.kind == Kind::Grey) {
            group.share = group.nominal_share;
            for round in 0..ROUNDS {
                let (mut mixed, mut square) = (0.0, 0.0);
                for bytes in &group.bytes {
                    let levels = if round == 0 {
                        0.0
                    } else {
                        self.levels(group, bytes)
                    };
                    let [grey, black, white] = [0, 1, 2].map(|k| self.light(bytes[k]));
                    let weight =
                        (self.slope(bytes[0]) * (1.0 + (levels / OUTLIER_LEVELS).powi(2))).recip();
                    mixed += weight * (grey - black) * (white - black);
                    square += weight * (white - black).powi(2);
                }
                if square > 0.0 {
                    group.share = mixed / square;
                }
            }
        }
    }

    /// Fits curve and shares; the curve that rises everywhere, the smoother the less the data allow.
    pub(super) fn refine(&mut self, groups: &mut [Group]) -> ResponseCurve {
        let mut bend = BEND;
        let mut best = None;
        for _ in 0..ROUNDS {
            let scales = self.scales(groups);
            let sums: Vec<Sums> = groups
                .iter()
                .map(|group| self.sums(group, scales))
                .collect();
            let now = self.differences;
            let scale = self.scale_of_light(groups);
            while let Some(differences) = solve(&sums, [&now, &self.base], &scale, bend) {
                if let Some(curve) = ResponseCurve::from_srgb_plus(&differences, &self.splines) {
                    self.take(differences);
                    best = Some(curve);
                    break;
                }
                bend *= 0.5;
            }
            let change: [f64; FREE] = std::array::from_fn(|k| self.differences[k + 1] - now[k + 1]);
            for (group, sums) in groups.iter_mut().zip(&sums) {
                group.share += sums.step(&change);
            }
        }
        best.unwrap_or_else(ResponseCurve::srgb)
    }

    /// How much each knot adds to the light of white above black, mean over the greys' blocks. That light is kept, else
    /// the curve that makes everything dark would fit best.
    fn scale_of_light(&self, groups: &[Group]) -> [f64; FREE] {
        let mut mean = [0.0; FREE];
        let greys = groups.iter().filter(|group| group.kind == Kind::Grey);
        let mut count = 0;
        for [_, black, white, _] in greys.flat_map(|group| &group.bytes) {
            let [white, black] = [white, black].map(|&byte| self.splines.at(byte));
            for (k, sum) in mean.iter_mut().enumerate() {
                *sum += white[k + 1] - black[k + 1];
            }
            count += 1;
        }
        mean.map(|sum| sum / f64::from(count.max(1)))
    }

    fn sums(&self, group: &Group, scales: [f64; 2]) -> Sums {
        let scale = scales[group.kind as usize];
        let mut sums = Sums::of(group);
        for bytes in &group.bytes {
            let row = self.row(group, bytes);
            // Cauchy's weight: a block that moved or shines does not decide
            let robust = 1.0 / (1.0 + (row.levels / (2.4 * scale)).powi(2));
            sums.add(&row, robust / (scale * row.slope).powi(2));
        }
        sums
    }
}

/// Normal equations of one group: the curve's unknowns and the grey's share.
struct Sums {
    curve: [[f64; FREE]; FREE],
    right: [f64; FREE],
    mixed: [f64; FREE],
    share: f64,
    /// Gradient of the share at the present curve.
    pull: f64,
}

impl Sums {
    fn of(group: &Group) -> Self {
        let (share, pull) = match group.kind {
            Kind::Pair => (0.0, 0.0),
            Kind::Grey => {
                let weight = GREY_SPREAD.powi(-2);
                (weight, -weight * (group.share - group.nominal_share))
            }
        };
        Self {
            curve: [[0.0; FREE]; FREE],
            right: [0.0; FREE],
            mixed: [0.0; FREE],
            share,
            pull,
        }
    }

    fn add(&mut self, row: &Row, weight: f64) {
        let miss = row.levels * row.slope;
        for i in 0..FREE {
            let scaled = weight * row.knots[i];
            for j in 0..FREE {
                self.curve[i][j] += scaled * row.knots[j];
            }
            self.right[i] -= scaled * row.rest;
            self.mixed[i] += scaled * row.share;
        }
        self.share += weight * row.share * row.share;
        self.pull -= weight * row.share * miss;
    }

    /// Change of the share for a change of the curve.
    fn step(&self, change: &[f64; FREE]) -> f64 {
        let mixed: f64 = self.mixed.iter().zip(change).map(|(m, d)| m * d).sum();
        if self.share > 0.0 {
            (self.pull - mixed) / self.share
        } else {
            0.0
        }
    }
}

/// The knots' differences that all groups together want, the shares eliminated (Schur complement), the scale of light
/// kept, and second differences around those of `base` with a deviation of `bend`.
fn solve(
    groups: &[Sums],
    [now, base]: [&[f64; KNOTS]; 2],
    scale_of_light: &[f64; FREE],
    bend: f64,
) -> Option<[f64; KNOTS]> {
    let mut matrix = DMatrix::<f64>::zeros(FREE, FREE);
    let mut right = DVector::<f64>::zeros(FREE);
    for sums in groups {
        let scale = if sums.share > 0.0 {
            1.0 / sums.share
        } else {
            0.0
        };
        // the share moves from where it is, the curve is solved for as a whole
        let mixed_now: f64 = (0..FREE).map(|k| sums.mixed[k] * now[k + 1]).sum();
        for i in 0..FREE {
            for j in 0..FREE {
                matrix[(i, j)] += sums.curve[i][j] - scale * sums.mixed[i] * sums.mixed[j];
            }
            right[i] += sums.right[i] - scale * sums.mixed[i] * (sums.pull + mixed_now);
        }
    }
    let mut keep = |factors: &[f64; FREE], weight: f64| {
        let wanted: f64 = (0..FREE).map(|k| factors[k] * base[k + 1]).sum();
        for i in 0..FREE {
            for j in 0..FREE {
                matrix[(i, j)] += weight * factors[i] * factors[j];
            }
            right[i] += weight * factors[i] * wanted;
        }
    };
    keep(scale_of_light, SCALE_WEIGHT);
    for middle in 1..KNOTS - 1 {
        let mut bends = [0.0; FREE];
        (bends[middle - 1], bends[middle]) = (-2.0, 1.0);
        if middle > 1 {
            bends[middle - 2] = 1.0;
        }
        keep(&bends, bend.powi(-2));
    }
    let solved = matrix.cholesky()?.solve(&right);
    let mut differences = [0.0; KNOTS];
    differences[1..].copy_from_slice(solved.as_slice());
    Some(differences)
}
