//! Tallies and numbers as bytes, little-endian.

use super::{StateError, damaged};
use crate::hybrid::tallies::{Tally, UNIT};
use conray_core::Vec3;

/// Bytes of a tally.
pub(super) const TALLY_BYTES: usize = 28;
/// More units than any budget pays for at one point.
const MOST_UNITS: u32 = u32::MAX / UNIT;

/// Writes tallies.
pub(super) fn put(bytes: &mut Vec<u8>, tallies: &[Tally]) {
    for tally in tallies {
        bytes.extend(tally.units.to_le_bytes());
        for value in [tally.sum, tally.in_units, tally.in_fulls, tally.bent.x, tally.bent.y, tally.bent.z] {
            bytes.extend(value.to_le_bytes());
        }
    }
}

/// Fewer bytes than there should be.
pub(super) fn cut_short() -> StateError {
    damaged("it is cut short")
}

/// What is left to read.
pub(super) struct Cursor<'a>(pub(super) &'a [u8]);

impl<'a> Cursor<'a> {
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], StateError> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or_else(cut_short)?;
        self.0 = rest;
        Ok(taken)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], StateError> {
        let (taken, rest) = self.0.split_first_chunk().ok_or_else(cut_short)?;
        self.0 = rest;
        Ok(*taken)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn tallies(&mut self, count: usize) -> Result<Vec<Tally>, StateError> {
        let bytes = self.take(count.checked_mul(TALLY_BYTES).ok_or_else(cut_short)?)?;
        let one = |bytes: &[u8; TALLY_BYTES]| {
            let mut words = bytes.as_chunks::<4>().0.iter().copied();
            let units = u32::from_le_bytes(words.next().unwrap_or_default());
            let mut float = || f32::from_le_bytes(words.next().unwrap_or_default());
            let (sum, in_units, in_fulls) = (float(), float(), float());
            Tally { units, sum, in_units, in_fulls, bent: Vec3::new(float(), float(), float()) }
        };
        let tallies: Vec<Tally> = bytes.as_chunks().0.iter().map(one).collect();
        if tallies.iter().all(can_be) { Ok(tallies) } else { Err(damaged("it tells of rays that cannot be")) }
    }
}

/// No rays tell anything else: each is open by 0 to 1, and no point gets more of them than there are.
fn can_be(tally: &Tally) -> bool {
    let most = tally.units as f32 * (1.0 + 1e-4);
    tally.units <= MOST_UNITS
        && (0.0..=most).contains(&tally.sum)
        && [tally.in_units, tally.in_fulls].iter().all(|variance| (0.0..=most).contains(variance))
        && tally.bent.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tallies_are_read_back_and_senseless_ones_refused() {
        let sound =
            Tally { units: 4, sum: 3.0, in_units: 0.01, in_fulls: 0.02, bent: Vec3::new(0.0, 1.0, -2.0) };
        let read = |tally: Tally| {
            let mut bytes = Vec::new();
            put(&mut bytes, &[Tally::default(), tally]);
            assert_eq!(bytes.len(), 2 * TALLY_BYTES);
            Cursor(&bytes).tallies(2)
        };
        assert_eq!(read(sound).unwrap(), [Tally::default(), sound]);
        for wrong in [
            Tally { sum: f32::NAN, ..sound },
            Tally { sum: 4.1, ..sound },
            Tally { sum: -0.1, ..sound },
            Tally { in_units: f32::INFINITY, ..sound },
            Tally { in_fulls: -1.0, ..sound },
            Tally { bent: Vec3::NAN, ..sound },
            Tally { units: u32::MAX, ..sound },
        ] {
            assert!(matches!(read(wrong), Err(StateError::Damaged(_))), "{wrong:?}");
        }
        assert_eq!(Cursor(&[0; TALLY_BYTES]).tallies(usize::MAX), Err(cut_short()));
    }
}
