//! How long the three methods take to locate every window of the sequence of 255 symbols.

use criterion::{Criterion, criterion_group, criterion_main};
use shared::field::{Element, appendix_a};
use shared::sequence::{Locator, Method, Sequence, SequenceError};
use std::hint::black_box;
use std::num::NonZeroUsize;

/// About the square root of the period: as many milestones as steps between them.
const SPACING: NonZeroUsize = NonZeroUsize::new(16).unwrap();

fn locate(criterion: &mut Criterion) {
    let sequence = sequence().expect("Appendix A lists this code");
    let windows: Vec<Vec<Element>> = (0..255).map(|index| sequence.window(index)).collect();
    let mut group = criterion.benchmark_group("255 windows of 4 over GF(4)");
    let milestones = Method::Milestones { spacing: SPACING };
    for (name, method) in [
        ("serial", Method::Serial),
        ("table", Method::Table),
        ("milestones", milestones),
    ] {
        let locator = Locator::new(&sequence, method);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                for window in &windows {
                    black_box(locator.locate(black_box(window)).ok());
                }
            });
        });
    }
    group.finish();
}

fn sequence() -> Result<Sequence, SequenceError> {
    let gf4 = appendix_a::field(4)?;
    Sequence::new(&gf4, &appendix_a::primitive_polynomial(&gf4, 4)?)
}

criterion_group!(benches, locate);
criterion_main!(benches);
