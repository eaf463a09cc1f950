//! Fills pixels that are not finished from those that are.

/// Visibility of pending pixels where nothing at all is finished: neither open nor closed.
const UNKNOWN: f32 = 0.5;

/// Replaces each NaN by the value of the nearest pixel that is covered and not NaN.
///
/// A breadth-first search from all finished pixels at once, over rows and columns; ties go to the pixel that comes first
/// from the top. Pixels without coverage pass values on but keep their own.
pub(crate) fn fill_pending(width: usize, values: &mut [f32], coverage: &[f32]) {
    let mut nearest = vec![f32::NAN; values.len()];
    let mut queue: Vec<usize> =
        (0..values.len()).filter(|&i| coverage[i] > 0.0 && !values[i].is_nan()).collect();
    for &i in &queue {
        nearest[i] = values[i];
    }
    let mut head = 0;
    while let Some(&i) = queue.get(head) {
        head += 1;
        let x = i % width;
        let neighbours = [
            i.checked_sub(width),
            (x > 0).then(|| i - 1),
            (x + 1 < width).then_some(i + 1),
            (i + width < values.len()).then_some(i + width),
        ];
        for j in neighbours.into_iter().flatten() {
            if nearest[j].is_nan() {
                nearest[j] = nearest[i];
                queue.push(j);
            }
        }
    }
    for (value, near) in values.iter_mut().zip(nearest) {
        if value.is_nan() {
            *value = if near.is_nan() { UNKNOWN } else { near };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn pending_pixels_take_a_nearest_finished_value(
            width in 1usize..9, height in 1usize..9, kinds in prop::collection::vec(0u8..4, 72),
        ) {
            let kinds = &kinds[..width * height];
            // Kinds: 0 background, 1 finished, else pending. Finished values differ from each other.
            let coverage: Vec<f32> = kinds.iter().map(|&k| f32::from(k != 0)).collect();
            let value = |(i, &k): (usize, &u8)| match k { 0 => 1.0, 1 => i as f32, _ => f32::NAN };
            let before: Vec<f32> = kinds.iter().enumerate().map(value).collect();
            let mut after = before.clone();
            fill_pending(width, &mut after, &coverage);
            let distance = |a: usize, b: usize| {
                (a / width).abs_diff(b / width) + (a % width).abs_diff(b % width)
            };
            let finished: Vec<usize> = (0..kinds.len()).filter(|&i| kinds[i] == 1).collect();
            for i in 0..kinds.len() {
                if kinds[i] < 2 {
                    prop_assert_eq!(after[i], before[i]);
                } else if let Some(best) = finished.iter().map(|&f| distance(i, f)).min() {
                    prop_assert_eq!(kinds[after[i] as usize], 1);
                    prop_assert_eq!(distance(i, after[i] as usize), best);
                } else {
                    prop_assert_eq!(after[i], UNKNOWN);
                }
            }
        }
    }
}
