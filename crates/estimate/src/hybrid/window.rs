//! Rows of cells about a row of pixels, each cell repeated for the pixels that it covers.
//!
//! So every neighbour of sixteen pixels of a row is one load away, whatever the size of the cells.

use conray_core::LANES;

/// Some rows of some channels.
pub(super) struct Window {
    values: Vec<f32>,
    channels: usize,
    /// Cells on either side of a pixel's own, in both directions.
    reach: usize,
    /// Places in a row of the window.
    stride: usize,
    /// Places before the first pixel.
    before: usize,
    /// The row of the grid in each row of the window, plus the reach; rows take turns, so that moving on by one loads one.
    held: Vec<usize>,
    /// The row of the grid at the top of the window, plus the reach.
    top: usize,
}

/// How cells lie, row by row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Places in a row.
    pub(super) stride: usize,
}

impl Window {
    /// For rows of `stride` pixels and cells of `1 << size` pixels a side.
    pub(super) fn new(stride: usize, size: usize, reach: usize, channels: usize) -> Self {
        let before = (reach << size).next_multiple_of(LANES);
        let stride = stride + 2 * before;
        let rows = 2 * reach + 1;
        let values = vec![0.0; rows * channels * stride];
        Self { values, channels, reach, stride, before, held: vec![usize::MAX; rows], top: 0 }
    }

    /// Moves on to the rows about row `row` of the channels of one grid; what lies outside it is 0.
    pub(super) fn load(&mut self, grid: &Grid, channels: &[&[f32]], row: usize, size: usize) {
        self.top = row;
        for key in row..row + self.held.len() {
            let slot = key % self.held.len();
            if self.held[slot] == key {
                continue;
            }
            self.held[slot] = key;
            let rows = &mut self.values[slot * self.channels * self.stride..][..self.channels * self.stride];
            let Some(y) = key.checked_sub(self.reach).filter(|&y| y < grid.height) else {
                rows.fill(0.0);
                continue;
            };
            for (out, channel) in rows.chunks_mut(self.stride).zip(channels) {
                let from = &channel[y * grid.stride..][..grid.width];
                let (out, rest) =
                    out[self.before..].split_at_mut((grid.width << size).min(self.stride - self.before));
                if size == 0 {
                    out.copy_from_slice(&from[..out.len()]);
                } else {
                    for (out, &value) in out.chunks_mut(1 << size).zip(from) {
                        out.fill(value);
                    }
                }
                rest.fill(0.0);
            }
        }
    }

    /// Sixteen values of a channel: those of the cells `column` and `row` from the top left of the window about pixels `x` and
    /// on, in cells of `1 << size` pixels.
    #[inline(always)]
    pub(super) fn sixteen(&self, channel: usize, [column, row]: [usize; 2], x: usize, size: usize) -> &[f32] {
        let from = self.before + x + (column << size) - (self.reach << size);
        let slot = (self.top + row) % self.held.len();
        &self.values[(slot * self.channels + channel) * self.stride + from..][..LANES]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_finds_its_neighbours_in_cells_of_every_size() {
        for size in 0..3 {
            let (width, height) = (7usize, 3usize);
            let cells: Vec<f32> = (0..width * height).map(|i| 1.0 + i as f32).collect();
            let twice: Vec<f32> = cells.iter().map(|c| 2.0 * c).collect();
            let channels = [&cells[..], &twice[..]];
            let grid = Grid { width, height, stride: width };
            let pixels = (width << size).next_multiple_of(LANES);
            let mut window = Window::new(pixels, size, 1, 2);
            for row in [0, 1, 2, 0, 2] {
                window.load(&grid, &channels, row, size);
                for x in (0..pixels).step_by(LANES) {
                    for (dx, dy) in (0..9).map(|k| (k % 3, k / 3)) {
                        let found = [0, 1].map(|c| window.sixteen(c, [dx, dy], x, size));
                        for (lane, (&found, &twice)) in found[0].iter().zip(found[1]).enumerate() {
                            let (cx, cy) = (((x + lane) >> size) + dx, row + dy);
                            let inside = (1..=width).contains(&cx) && (1..=height).contains(&cy);
                            let expected = if inside { cells[(cy - 1) * width + cx - 1] } else { 0.0 };
                            assert_eq!(found, expected, "size {size}, row {row}, pixel {}", x + lane);
                            assert_eq!(twice, 2.0 * expected);
                        }
                    }
                }
            }
        }
    }
}
