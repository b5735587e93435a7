//! Thresholds between classes of grey: Otsu's criterion for two and three classes.

/// Bins of a histogram.
pub const BINS: usize = 256;

/// Counts of values between two ends; what lies beyond is in the outer bins.
pub(super) fn histogram(values: impl Iterator<Item = f64>, [low, high]: [f64; 2]) -> [u32; BINS] {
    let mut counts = [0; BINS];
    let scale = BINS as f64 / (high - low).max(1e-12);
    for value in values {
        counts[((value - low) * scale).clamp(0.0, (BINS - 1) as f64) as usize] += 1;
    }
    counts
}

/// The bins at which a histogram falls into `classes` (2 or 3) classes with the largest variance between them
/// (N. Otsu, IEEE Transactions on Systems, Man and Cybernetics 9, 62, 1979): each bin given is the first of the next class.
pub(super) fn otsu(counts: &[u32; BINS], classes: usize) -> Vec<usize> {
    // Sums from the left: number and moment. Between-class variance is Σ moment²/number up to a constant.
    let mut sums = [[0.0; 2]; BINS + 1];
    for (bin, count) in counts.iter().enumerate() {
        let n = f64::from(*count);
        sums[bin + 1] = [sums[bin][0] + n, sums[bin][1] + n * (bin as f64 + 0.5)];
    }
    let worth = |from: usize, to: usize| {
        let n = sums[to][0] - sums[from][0];
        let moment = sums[to][1] - sums[from][1];
        if n > 0.0 { moment * moment / n } else { 0.0 }
    };
    let mut best = (f64::NEG_INFINITY, vec![BINS / 2; classes - 1]);
    let mut consider = |value: f64, cuts: &[usize]| {
        if value > best.0 {
            best = (value, cuts.to_vec());
        }
    };
    for first in 1..BINS {
        if classes == 2 {
            consider(worth(0, first) + worth(first, BINS), &[first]);
            continue;
        }
        for second in first + 1..BINS {
            consider(worth(0, first) + worth(first, second) + worth(second, BINS), &[first, second]);
        }
    }
    best.1
}
