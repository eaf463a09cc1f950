//! Walks every invariant of an octree.

use crate::{
    Octree,
    level::{Bricks, Level, cell_in_brick},
    morton,
    upward::{Sums, parent_codes},
};
use glam::{IVec3, UVec3};

impl Octree {
    /// Checks every invariant; `Err` says which one is broken and where.
    ///
    /// Bricks are sorted, complete and found through their table; a node is empty exactly where its children are;
    /// empty nodes have no opacity; means are those of the children within rounding; means and SDs equal those
    /// recomputed from the leaves; `0 <= SD^2 <= mean (1 - mean)`; filters meet something exactly where a node is occupied;
    /// second copies equal the first.
    pub fn validate(&self) -> Result<(), String> {
        let mut side = self.grid.resolution;
        for (l, level) in self.levels.iter().enumerate() {
            if level.side != side {
                return Err(format!("level {l}: {} nodes a side in place of {side}", level.side));
            }
            check_table(level).map_err(|e| format!("level {l}: {e}"))?;
            check_nodes(level).map_err(|e| format!("level {l}: {e}"))?;
            check_filter(level).map_err(|e| format!("level {l}: {e}"))?;
            check_plain(level).map_err(|e| format!("level {l}: {e}"))?;
            if l > 0 {
                self.check_parents(l).map_err(|e| format!("level {l}: {e}"))?;
                self.check_moments(l as u32).map_err(|e| format!("level {l}: {e}"))?;
            }
            side /= 2;
        }
        if side == 0 { Ok(()) } else { Err("the topmost level has more than one node".into()) }
    }

    /// Masks, means and axes against the level below.
    fn check_parents(&self, l: usize) -> Result<(), String> {
        let (level, below) = (&self.levels[l], &self.levels[l - 1]);
        if level.codes != parent_codes(&below.codes) {
            return Err("bricks differ from the parents of the bricks below".into());
        }
        for_each_node(level, |cell, brick, index| {
            let children =
                (0..8).map(|c| 2 * cell + IVec3::new(c & 1, c >> 1 & 1, c >> 2)).collect::<Vec<_>>();
            let empty = children.iter().all(|&c| self.is_empty(l as u32 - 1, c));
            if level.is_occupied(brick, index) == empty {
                return Err(format!("node {cell}: emptiness differs from its children's"));
            }
            let mean: f32 = children.iter().map(|&c| self.mean_sd(l as u32 - 1, c).0).sum::<f32>() / 8.0;
            // Each of nine numbers is rounded to 65535ths.
            if (level.mean_sd(brick, index).0 - mean).abs() > 1.01 / 65535.0 + 1e-6 {
                return Err(format!("node {cell}: mean {} but {mean}", level.mean_sd(brick, index).0));
            }
            Ok(())
        })
    }

    /// Means and SDs against those of the leaves, on at most 512 nodes of a level.
    fn check_moments(&self, l: u32) -> Result<(), String> {
        let level = &self.levels[l as usize];
        let nodes = level.codes.len() * 512;
        let stride = (nodes / 512).max(1) | 1;
        for k in (0..nodes).step_by(stride) {
            let (brick, index) = ((k / 512) as u32 + 1, k % 512);
            let cell = cell_of(level, brick, index);
            if cell.max_element() >= level.side as i32 {
                continue;
            }
            let mut sums = Sums::default();
            self.add_leaves(l, cell, &mut sums);
            let [mean, sd] = sums.quantised(1 << (3 * l));
            let stored = level.mean_sd(brick, index);
            if stored != (f32::from(mean) * (1.0 / 65535.0), f32::from(sd) * (1.0 / 65535.0)) {
                return Err(format!("node {cell}: {stored:?} but its leaves have {mean}, {sd}"));
            }
        }
        Ok(())
    }

    fn add_leaves(&self, l: u32, cell: IVec3, sums: &mut Sums) {
        if self.is_empty(l, cell) {
            return;
        }
        if l > 0 {
            for c in 0..8 {
                self.add_leaves(l - 1, 2 * cell + IVec3::new(c & 1, c >> 1 & 1, c >> 2), sums);
            }
        } else {
            let q = (self.mean_sd(0, cell).0 * 255.0).round() as u64;
            sums.first += q;
            sums.second += q * q;
        }
    }
}

/// Bricks are sorted, without repeats, inside the cube, as many as the arrays hold, and found where they are.
fn check_table(level: &Level) -> Result<(), String> {
    let bricks = match &level.bricks {
        Bricks::Leaves(b) => b.len(),
        Bricks::Nodes(b) => b.len(),
    };
    if bricks != level.codes.len() + 1 || !(level.axes.is_empty() || level.axes.len() == level.codes.len()) {
        return Err("arrays of different lengths".into());
    }
    if !level.codes.is_sorted_by(|a, b| a < b) {
        return Err("bricks out of order".into());
    }
    let across = Level::bricks_per_side(level.side);
    let mut found = 0;
    for z in 0..across {
        for y in 0..across {
            for x in 0..across {
                let place = UVec3::new(x, y, z);
                let Some(brick) = level.brick_at(place) else { continue };
                if level.codes.get(brick as usize - 1) != Some(&morton::encode(place)) {
                    return Err(format!("the table has brick {brick} at {place}"));
                }
                found += 1;
            }
        }
    }
    let all = level.codes.len();
    if found == all { Ok(()) } else { Err(format!("{found} of {all} bricks are in the table")) }
}

/// The filter meets something at a place exactly where one of its eight nodes is occupied.
fn check_filter(level: &Level) -> Result<(), String> {
    let corner = |c: i32| IVec3::new(c & 1, c >> 1 & 1, c >> 2);
    let inside =
        |cell: IVec3| cell.cmpge(IVec3::ZERO).all() && cell.cmplt(IVec3::splat(level.side as i32)).all();
    let is_occupied = |cell: IVec3| {
        let found = inside(cell).then(|| level.find(cell.as_uvec3())).flatten();
        found.is_some_and(|(brick, index)| level.is_occupied(brick, index))
    };
    // Every place that a brick's nodes are met from, in bricks and in blocks without one.
    for_each_node(level, |cell, _, _| {
        for place in (0..8).map(|c| cell + corner(c)) {
            if !place.cmple(IVec3::splat(level.side as i32)).all() {
                continue;
            }
            let expected = !(0..8).any(|c| is_occupied(place - corner(c)));
            if level.is_vacant(place) != expected {
                return Err(format!("the filter at {place} should be vacant: {expected}"));
            }
        }
        Ok(())
    })
}

/// The second copy of a small level equals the first, and has nothing about the cube.
fn check_plain(level: &Level) -> Result<(), String> {
    let Some(plain) = &level.plain else { return Ok(()) };
    let (mut index, side) = (0, level.side as i32);
    for z in -1..side + 2 {
        for y in -1..side + 2 {
            for x in -1..side + 2 {
                let cell = IVec3::new(x, y, z);
                let inside = cell.cmpge(IVec3::ZERO).all() && cell.cmplt(IVec3::splat(side)).all();
                let found = inside.then(|| level.find(cell.as_uvec3())).flatten();
                let expected =
                    found.map_or([0; 2], |(brick, node)| level.bricks.moments(brick as usize, node));
                if plain.moments[index] != expected {
                    return Err(format!(
                        "node {cell} has {:?} in place of {expected:?}",
                        plain.moments[index]
                    ));
                }
                index += 1;
            }
        }
    }
    if index == plain.moments.len() { Ok(()) } else { Err("the copy of the nodes has another size".into()) }
}

/// What holds for a node by itself.
fn check_nodes(level: &Level) -> Result<(), String> {
    for_each_node(level, |cell, brick, index| {
        let ((mean, sd), occupied) = (level.mean_sd(brick, index), level.is_occupied(brick, index));
        if !occupied && (mean != 0.0 || sd != 0.0) {
            return Err(format!("empty node {cell} has mean {mean}, SD {sd}"));
        }
        if !occupied && !level.axes.is_empty() && level.axis_opacities(brick, index) != glam::Vec3::ZERO {
            return Err(format!("empty node {cell} has axis opacities"));
        }
        // SD and mean are rounded to 65535ths each.
        let bound = mean * (1.0 - mean) + 2.0 / 65535.0;
        if !(0.0..=1.0).contains(&mean) || sd < 0.0 || sd * sd > bound {
            return Err(format!("node {cell}: SD {sd} is too large for mean {mean}"));
        }
        if cell.max_element() >= level.side as i32 && occupied {
            return Err(format!("node {cell} lies outside the cube"));
        }
        Ok(())
    })
}

fn cell_of(level: &Level, brick: u32, index: usize) -> IVec3 {
    let corner = morton::decode(level.codes[brick as usize - 1]) * 8;
    let local = UVec3::new(index as u32 & 7, index as u32 >> 3 & 7, index as u32 >> 6);
    debug_assert_eq!(cell_in_brick(local), index);
    (corner + local).as_ivec3()
}

fn for_each_node(
    level: &Level,
    check: impl Fn(IVec3, u32, usize) -> Result<(), String>,
) -> Result<(), String> {
    for brick in 1..=level.codes.len() as u32 {
        for index in 0..512 {
            check(cell_of(level, brick, index), brick, index)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{OctreeOptions, filter_bits::FilterBits};
    use conray_core::{Affine3A, Geometry, TriangleMesh, Vec3};

    fn octree() -> Octree {
        let mut geometry = Geometry::default();
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.3, 1.0, 0.8)];
        let mesh = geometry.add_mesh(TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap()).unwrap();
        geometry.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        // Its leaves have their bits in blocks and their nodes in bricks alone.
        let octree =
            Octree::build(&geometry, &OctreeOptions { resolution: 512, ..Default::default() }).unwrap();
        octree.validate().unwrap();
        octree
    }

    #[test]
    fn a_wrong_bit_of_a_filter_is_found() {
        let mut octree = octree();
        for l in 0..octree.levels.len() {
            let right = octree.levels[l].filter.clone();
            match &mut octree.levels[l].filter {
                FilterBits::Plain(plain) => {
                    let byte = plain.bytes.iter_mut().find(|byte| **byte != 0).unwrap();
                    *byte &= *byte - 1;
                }
                FilterBits::Blocks(blocks) => {
                    let word = blocks.as_flattened_mut().iter_mut().find(|word| **word != 0).unwrap();
                    *word &= *word - 1;
                }
            }
            assert!(check_filter(&octree.levels[l]).unwrap_err().contains("filter"), "level {l}");
            octree.levels[l].filter = right;
        }
    }

    #[test]
    fn a_wrong_copy_of_a_node_is_found() {
        let mut octree = octree();
        let mut copies = 0;
        for l in 0..octree.levels.len() {
            let Some(plain) = &mut octree.levels[l].plain else { continue };
            for index in [0, plain.moments.len() / 2, plain.moments.len() - 1] {
                octree.levels[l].plain.as_mut().unwrap().moments[index][1] ^= 1;
                assert!(check_plain(&octree.levels[l]).unwrap_err().contains("in place of"), "level {l}");
                octree.levels[l].plain.as_mut().unwrap().moments[index][1] ^= 1;
            }
            copies += 1;
        }
        assert_eq!(copies, 8, "levels of 128 nodes a side and less");
    }
}
