//! Averages along the lines: each sample sees its own pixels and, with less weight, its neighbours'.

/// A box of `step` pixels over a box of three: with steps of one pixel the mean of three, with steps of two
/// weights 1 2 2 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct AlongKernel {
    /// Pixels from sample to sample.
    pub(super) step: usize,
}

impl AlongKernel {
    /// Weights of the pixels from one before the sample's own to one behind.
    #[inline(always)]
    pub(super) fn weights(self) -> impl Iterator<Item = f32> {
        let Self { step } = self;
        (0..step + 2).map(move |k| (k + 1).min(step + 2 - k).min(step).min(3) as f32)
    }

    /// Their sum.
    pub(super) fn weight(self) -> f32 {
        self.weights().sum()
    }

    /// Weight of independent noise, as a root sum of squares.
    pub(super) fn noise(self) -> f32 {
        self.weights().map(|w| w * w).sum::<f32>().sqrt()
    }

    /// A pixel in the middle of a sample.
    #[inline(always)]
    pub(super) fn middle(self, sample: usize) -> usize {
        sample * self.step + self.step / 2
    }

    /// The weighted sum of rows; `row(k)` is the k-th of them.
    #[inline(always)]
    pub(super) fn sum_rows<'a>(self, row: impl Fn(usize) -> &'a [f32], out: &mut [f32]) {
        for (k, weight) in self.weights().enumerate() {
            let pairs = out.iter_mut().zip(row(k));
            if k == 0 {
                pairs.for_each(|(sum, &gain)| *sum = weight * gain);
            } else {
                pairs.for_each(|(sum, &gain)| *sum += weight * gain);
            }
        }
    }

    /// The weighted sums around the samples of a row from `first` on; beyond the border the border's value holds.
    #[inline(always)]
    pub(super) fn sum_along(self, row: &[f32], first: usize, out: &mut [f32]) {
        let (step, last) = (self.step, row.len() - 1);
        // the picture's first sample looks beyond the border, and those whose last pixel is the row's last
        let from = usize::from(first == 0).min(out.len());
        let to = (last / step).saturating_sub(first).clamp(from, out.len());
        let begin = (first + from) * step;
        if from < to {
            let length = (to - from) * step + 2;
            self.sum_inside(&row[begin - 1..][..length], &mut out[from..to]);
        }
        for k in (0..from).chain(to..out.len()) {
            let pixels =
                (0..).map(|pixel| ((first + k) * step + pixel).saturating_sub(1).min(last));
            let terms = pixels.zip(self.weights());
            out[k] = terms.map(|(pixel, weight)| weight * row[pixel]).sum();
        }
    }

    #[inline(always)]
    fn sum_inside(self, row: &[f32], out: &mut [f32]) {
        match self.step {
            1 => {
                let pixels = row.iter().zip(&row[1..]).zip(&row[2..]);
                let sums = out.iter_mut().zip(pixels);
                sums.for_each(|(sum, ((a, b), c))| *sum = a + b + c);
            }
            2 => {
                let pixels = row.chunks_exact(2).zip(row[2..].chunks_exact(2));
                let sums = out.iter_mut().zip(pixels);
                sums.for_each(|(sum, (a, b))| *sum = (a[0] + b[1]) + 2.0 * (a[1] + b[0]));
            }
            step => {
                for (k, sum) in out.iter_mut().enumerate() {
                    let pixels = row[k * step..].iter().zip(self.weights());
                    *sum = pixels.map(|(gain, weight)| weight * gain).sum();
                }
            }
        }
    }
}
