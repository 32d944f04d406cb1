//! Whether two figures rank rows in the same order.

/// Returns Spearman's rank correlation of pairs, in [−1, 1]: Pearson's correlation of their ranks, where equal values
/// share the mean of their ranks (Kendall and Gibbons, Rank Correlation Methods, chapter 3). `None` for fewer than
/// three pairs, or if one figure is the same in all pairs.
pub fn spearman(pairs: &[(f64, f64)]) -> Option<f64> {
    if pairs.len() < 3 {
        return None;
    }
    let [x, y] =
        [|p: &(f64, f64)| p.0, |p: &(f64, f64)| p.1].map(|of| ranks(&pairs.iter().map(of).collect::<Vec<_>>()));
    let middle = (pairs.len() as f64 + 1.0) / 2.0;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - middle) * (b - middle)).sum::<f64>();
    let squares = product(&x, &x) * product(&y, &y);
    (squares > 0.0).then(|| product(&x, &y) / squares.sqrt())
}

/// Returns the rank of each value, 1 for the smallest.
fn ranks(values: &[f64]) -> Vec<f64> {
    let rank = |value: &f64| {
        let (below, equal) = values.iter().fold((0.0, 0.0), |(below, equal), other| match other.total_cmp(value) {
            std::cmp::Ordering::Less => (below + 1.0, equal),
            std::cmp::Ordering::Equal => (below, equal + 1.0),
            std::cmp::Ordering::Greater => (below, equal),
        });
        below + (equal + 1.0) / 2.0
    };
    values.iter().map(rank).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without ties the correlation is 1 − 6 Σ d² / (n (n² − 1)).
    #[test]
    fn known_orders() {
        let of = |ys: &[f64]| spearman(&ys.iter().enumerate().map(|(x, y)| (x as f64, *y)).collect::<Vec<_>>());
        assert_eq!((of(&[1.0, 20.0, 300.0]), of(&[3.0, 2.0, 1.0])), (Some(1.0), Some(-1.0)));
        // d = 1, −1, 0, 0: 1 − 6 × 2 / (4 × 15).
        assert!((of(&[2.0, 1.0, 3.0, 4.0]).expect("four") - 0.8).abs() < 1e-15);
        // Ranks 1.5, 1.5, 3 against 1, 2, 3.
        assert!((of(&[5.0, 5.0, 9.0]).expect("three") - 1.5 / 3f64.sqrt()).abs() < 1e-15);
        assert_eq!((of(&[1.0, 2.0]), of(&[1.0; 4])), (None, None));
    }
}
