//! Maps in portions of their rows, so that what is known of points at one time has a bound whatever the maps' sizes.

use super::texels::MapSize;
use std::ops::Range;

/// Rows of a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which map.
    pub map: usize,
    /// Its rows.
    pub rows: Range<u32>,
}

/// Rows of maps that are asked about together: one under the other in an image, so that neighbours in a map are neighbours there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Portion {
    /// From the top.
    pub parts: Vec<Part>,
    /// Size of the image: the widest part, and all rows; in parts of texels where those are divided.
    pub size: [u32; 2],
    /// Id of the image's first place; each place of all portions has an id of its own.
    pub first: u32,
}

/// Divides maps into portions of at most `most` places, or of one row. With `supersample` n a texel has n x n places.
///
/// `None` where there are more places than ids.
pub(super) fn portions(sizes: &[MapSize], supersample: u32, most: u64) -> Option<Vec<Portion>> {
    let mut found: Vec<Portion> = Vec::new();
    let mut open = Open::default();
    let (fine, mut first) = (u64::from(supersample), 0u64);
    let mut close = |open: &mut Open| {
        if open.parts.is_empty() {
            return Some(());
        }
        let Open { parts, width, height } = std::mem::take(open);
        let size = [u32::try_from(width * fine).ok()?, u32::try_from(height * fine).ok()?];
        found.push(Portion { parts, size, first: u32::try_from(first).ok()? });
        first += width * fine * height * fine;
        u32::try_from(first).ok().map(|_| ())
    };
    for (map, size) in sizes.iter().enumerate() {
        let (width, mut row) = (u64::from(size.width), 0);
        while row < size.height {
            let wider = width.max(open.width);
            let room = most / (wider * fine * fine).max(1);
            let rows = u64::from(size.height - row).min(room.saturating_sub(open.height)) as u32;
            // Rather a portion of its own than a few rows below another map.
            let is_whole = rows == size.height - row;
            if !open.parts.is_empty() && !is_whole {
                close(&mut open)?;
                continue;
            }
            let rows = rows.max(1);
            open.parts.push(Part { map, rows: row..row + rows });
            open.width = wider;
            open.height += u64::from(rows);
            row += rows;
        }
    }
    close(&mut open)?;
    Some(found)
}

/// A portion that may take more.
#[derive(Default)]
struct Open {
    parts: Vec<Part>,
    width: u64,
    height: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn size(width: u32, height: u32) -> MapSize {
        MapSize { width, height }
    }

    #[test]
    fn small_maps_stand_together_and_large_ones_are_divided() {
        let found = portions(&[size(10, 5), size(20, 5), size(30, 100)], 1, 1000).unwrap();
        let parts: Vec<Vec<(usize, Range<u32>)>> = found
            .iter()
            .map(|portion| portion.parts.iter().map(|part| (part.map, part.rows.clone())).collect())
            .collect();
        assert_eq!(
            parts,
            [
                vec![(0, 0..5), (1, 0..5)],
                vec![(2, 0..33)],
                vec![(2, 33..66)],
                vec![(2, 66..99)],
                vec![(2, 99..100)]
            ]
        );
        assert_eq!((found[0].size, found[1].first), ([20, 10], 200));
    }

    #[test]
    fn more_places_than_ids_are_none() {
        let maps = [size(1 << 14, 1 << 14); 4];
        assert!(portions(&maps, 1, 1 << 22).is_some());
        assert!(portions(&maps, 2, 1 << 22).is_none());
    }

    proptest! {
        #[test]
        fn each_row_is_in_one_portion(
            sizes in prop::collection::vec((1u32..50, 1u32..50), 0..12), fine in 1u32..4, most in 1u64..5000,
        ) {
            let sizes: Vec<MapSize> = sizes.into_iter().map(|(width, height)| size(width, height)).collect();
            let found = portions(&sizes, fine, most).unwrap();
            let mut next = vec![0; sizes.len()];
            let mut first = 0;
            for portion in &found {
                prop_assert_eq!(portion.first, first);
                first += portion.size[0] * portion.size[1];
                let rows: u32 = portion.parts.iter().map(|part| part.rows.len() as u32).sum();
                prop_assert_eq!(portion.size[1], rows * fine);
                prop_assert!(rows == 1 || u64::from(portion.size[0] * portion.size[1]) <= most);
                for part in &portion.parts {
                    prop_assert_eq!(part.rows.start, next[part.map]);
                    next[part.map] = part.rows.end;
                    prop_assert!(sizes[part.map].width * fine <= portion.size[0]);
                }
            }
            prop_assert!(next.iter().zip(&sizes).all(|(next, size)| *next == size.height));
        }
    }
}
