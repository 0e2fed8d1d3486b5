//! How long the window's repaints take.

/// Repaints at the start that load fonts and shaders, and do not count.
const WARM_UP: u64 = 20;
/// Times are counted in steps of this, in milliseconds, up to the last step.
const STEP_MS: f32 = 0.5;
const STEPS: usize = 400;

/// The times of the repaints so far.
#[derive(Debug, Clone)]
pub(super) struct Repaints {
    own: Times,
    whole: Times,
    seen: u64,
}

impl Default for Repaints {
    fn default() -> Self {
        Self {
            own: Times::new(),
            whole: Times::new(),
            seen: 0,
        }
    }
}

impl Repaints {
    /// Counts a repaint, in milliseconds: events and panels alone, and the whole with drawing.
    pub(super) fn count(&mut self, own_ms: f32, whole_ms: f32) {
        self.seen += 1;
        self.own.last_ms = own_ms;
        if self.seen > WARM_UP {
            self.own.count(own_ms);
            self.whole.count(whole_ms);
        }
    }

    /// Time of the newest one, without drawing, in milliseconds.
    pub(super) fn last_ms(&self) -> f32 {
        self.own.last_ms
    }

    /// All in a sentence.
    pub(super) fn sentence(&self) -> String {
        format!(
            "{} repaints: {}; with drawing {}",
            self.seen,
            self.own.words(),
            self.whole.words()
        )
    }
}

#[derive(Debug, Clone)]
struct Times {
    last_ms: f32,
    longest_ms: f32,
    counts: Vec<u32>,
}

impl Times {
    fn new() -> Self {
        Self {
            last_ms: 0.0,
            longest_ms: 0.0,
            counts: vec![0; STEPS],
        }
    }

    fn count(&mut self, ms: f32) {
        self.longest_ms = self.longest_ms.max(ms);
        let step = (ms / STEP_MS) as usize;
        self.counts[step.min(STEPS - 1)] += 1;
    }

    /// The time that this share of the repaints stays below.
    fn below_ms(&self, share: f64) -> f32 {
        let all: u32 = self.counts.iter().sum();
        let mut left = (share * f64::from(all)).ceil() as u32;
        for (step, &count) in self.counts.iter().enumerate() {
            left = left.saturating_sub(count);
            if left == 0 {
                return (step + 1) as f32 * STEP_MS;
            }
        }
        self.longest_ms
    }

    fn words(&self) -> String {
        format!(
            "half below {:.1} ms, 99 % below {:.1} ms, the longest {:.1} ms",
            self.below_ms(0.5),
            self.below_ms(0.99),
            self.longest_ms
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_the_longest_are_told_and_the_first_repaints_do_not_count() {
        let mut repaints = Repaints::default();
        for _ in 0..WARM_UP {
            repaints.count(900.0, 900.0);
        }
        for k in 0..100 {
            repaints.count(if k < 98 { 2.2 } else { 30.1 }, 8.0);
        }
        let own = "120 repaints: half below 2.5 ms, 99 % below 30.5 ms, the longest 30.1 ms";
        let told = repaints.sentence();
        assert!(told.starts_with(own), "{told}");
        assert!(told.ends_with("the longest 8.0 ms"), "{told}");
    }
}
