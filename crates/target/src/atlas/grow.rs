//! Islands extended into the empty texels about them.

/// The texels of a map that have a value.
pub(super) struct Known<'a> {
    pub(super) width: usize,
    pub(super) has: &'a mut [bool],
}

/// Extends islands ring by ring over texels that `may` be given a value, each taking the mean of its neighbours of the rings before; by
/// so many texels, or until they meet.
///
/// `mix(at, from)` gives texel `at` the mean of texels `from`.
pub(super) fn grow(
    known: &mut Known<'_>,
    padding: Option<u32>,
    may: impl Fn(usize) -> bool,
    mut mix: impl FnMut(usize, &[usize]),
) {
    let (width, height) = (known.width, known.has.len() / known.width.max(1));
    let mut waiting = vec![false; known.has.len()];
    let mut ring: Vec<usize> = (0..known.has.len()).filter(|&at| !known.has[at] && may(at)).collect();
    ring.retain(|&at| neighbours(at, width, height).any(|near| known.has[near]));
    ring.iter().for_each(|&at| waiting[at] = true);
    let mut left = padding.unwrap_or(u32::MAX);
    while left > 0 && !ring.is_empty() {
        left -= 1;
        let mut from = Vec::with_capacity(8);
        for &at in &ring {
            from.clear();
            from.extend(neighbours(at, width, height).filter(|&near| known.has[near]));
            mix(at, &from);
        }
        ring.iter().for_each(|&at| known.has[at] = true);
        let mut next = Vec::new();
        for &at in &ring {
            for near in neighbours(at, width, height).filter(|&near| !known.has[near] && may(near)) {
                if !std::mem::replace(&mut waiting[near], true) {
                    next.push(near);
                }
            }
        }
        // In the order of the map, so that the result is that of its texels and not of how they were reached.
        next.sort_unstable();
        ring = next;
    }
}

/// The up to eight texels about one.
fn neighbours(at: usize, width: usize, height: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (at % width, at / width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    rows.flat_map(move |v| (x.saturating_sub(1)..(x + 2).min(width)).map(move |u| v * width + u))
        .filter(move |&near| near != at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grown(has: &[(usize, f32)], [width, height]: [usize; 2], padding: Option<u32>) -> Vec<f32> {
        let mut values = vec![f32::NAN; width * height];
        let mut known = vec![false; values.len()];
        for &(at, value) in has {
            (values[at], known[at]) = (value, true);
        }
        grow(
            &mut Known { width, has: &mut known },
            padding,
            |_| true,
            |at, from| {
                values[at] = from.iter().map(|&near| values[near]).sum::<f32>() / from.len() as f32;
            },
        );
        assert!(values.iter().zip(&known).all(|(value, known)| value.is_nan() != *known));
        values
    }

    #[test]
    fn islands_grow_until_they_meet() {
        let values = grown(&[(0, 0.25), (9, 0.75)], [10, 1], None);
        assert_eq!(values[..5], [0.25; 5]);
        assert_eq!(values[5..], [0.75; 5]);
        // Two islands of which one texel lies between: it is their mean.
        assert_eq!(grown(&[(0, 0.0), (2, 1.0)], [3, 1], None)[1], 0.5);
        assert!(grown(&[], [4, 4], None).iter().all(|value| value.is_nan()), "nothing to extend");
    }

    #[test]
    fn only_texels_that_may_are_given_values() {
        let mut known = [true, false, false, true, false];
        let mut given = Vec::new();
        grow(
            &mut Known { width: 5, has: &mut known },
            None,
            |at| at != 2,
            |at, from| given.push((at, from.to_vec())),
        );
        assert_eq!(given, [(1, vec![0]), (4, vec![3])]);
    }

    #[test]
    fn padding_says_how_far() {
        let values = grown(&[(12, 0.5)], [5, 5], Some(1));
        let known = |at: usize| (at % 5).abs_diff(2) <= 1 && (at / 5).abs_diff(2) <= 1;
        assert!((0..25).all(|at| values[at].is_nan() != known(at)));
        assert_eq!(grown(&[(12, 0.5)], [5, 5], Some(0)).iter().filter(|value| !value.is_nan()).count(), 1);
    }
}
