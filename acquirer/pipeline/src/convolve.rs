//! Sums of weighted pairs of rows: what every separable filter here comes down to.
//!
//! Works block by block, so that the sums stay in registers while the taps go by. Must be inlined into a
//! function that was compiled for the processor's wide registers ([`wide`]); each sum has its own order of
//! additions, so the width of the registers does not change a bit.

use pulp::{Arch, NullaryFnOnce};

/// Values that are summed up together.
const BLOCK: usize = 64;

/// How the two rows of a tap are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pair {
    /// Their sum, for even kernels. The middle tap comes as a pair of one row with itself at half its weight.
    Sum,
    /// The second less the first, for odd kernels.
    Difference,
}

/// Sets `out` to the sum over taps of weight times pair. `tap` gives the two rows of a tap, as long as `out`.
#[inline(always)]
pub(super) fn convolve<'a>(
    out: &mut [f32],
    weights: &[f32],
    pair: Pair,
    tap: impl Fn(usize) -> (&'a [f32], &'a [f32]),
) {
    let first = usize::from(pair == Pair::Difference); // an odd kernel's middle is 0
    for (n, block) in out.chunks_mut(BLOCK).enumerate() {
        let range = n * BLOCK..n * BLOCK + block.len();
        let mut sums = [0.0f32; BLOCK];
        for (k, &weight) in weights.iter().enumerate().skip(first) {
            let (a, b) = tap(k);
            let (a, b) = (&a[range.clone()], &b[range.clone()]);
            let weight = match (pair, k) {
                (Pair::Sum, 0) => 0.5 * weight,
                _ => weight,
            };
            match (<&[f32; BLOCK]>::try_from(a), <&[f32; BLOCK]>::try_from(b)) {
                (Ok(a), Ok(b)) => add(&mut sums, a, b, weight, pair),
                _ => add(&mut sums[..a.len()], a, b, weight, pair),
            }
        }
        match <&mut [f32; BLOCK]>::try_from(&mut *block) {
            Ok(whole) => *whole = sums,
            Err(_) => block.copy_from_slice(&sums[..block.len()]),
        }
    }
}

#[inline(always)]
fn add(sums: &mut [f32], a: &[f32], b: &[f32], weight: f32, pair: Pair) {
    let pairs = sums.iter_mut().zip(a).zip(b);
    match pair {
        Pair::Sum => pairs.for_each(|((sum, &a), &b)| *sum += weight * (a + b)),
        Pair::Difference => pairs.for_each(|((sum, &a), &b)| *sum += weight * (b - a)),
    }
}

/// Fills what lies before and behind the middle of a padded row with the middle's ends.
#[inline(always)]
pub(super) fn pad_ends(row: &mut [f32], pad: usize) {
    let end = row.len() - pad;
    let (first, last) = (row[pad], row[end - 1]);
    row[..pad].fill(first);
    row[end..].fill(last);
}

/// Runs work compiled for the widest registers that the processor has (AVX2 on PCs of the last decade). The
/// work's `call` and all that it calls must be `#[inline(always)]`.
pub(super) fn wide<W: NullaryFnOnce>(work: W) -> W::Output {
    Arch::new().dispatch(work)
}
