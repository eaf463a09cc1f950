//! Faces of an OBJ: `f v`, `f v/vt`, `f v//vn`, `f v/vt/vn`, from the start or back from the face.

use crate::files::error::{Fault, shown};
use crate::files::polygon::triangulate;
use crate::files::soup::{Corner, NONE, Soup};
use crate::files::text::{integer, word};
use conray_core::Vec3;

/// What a corner's three indices mean, in their order.
const KINDS: [[&str; 2]; 3] =
    [["vertex", "vertices"], ["texture coordinate", "texture coordinates"], ["normal", "normals"]];

/// Reads faces one by one; an index may point ahead of its face, so ranges are checked at the end.
#[derive(Default)]
pub(super) struct FaceReader {
    corners: Vec<Corner>,
    points: Vec<Vec3>,
    /// The highest index met of each kind, and the line it was met in.
    highest: [(u32, u64); 3],
    /// Faces with fewer than three different corners.
    pub ignored: u64,
    /// Line of the first of them.
    pub ignored_line: u64,
}

impl FaceReader {
    /// Adds the triangles of one `f` statement.
    pub(super) fn read(&mut self, mut rest: &[u8], line: u64, soup: &mut Soup) -> Result<(), Fault> {
        let counts = [soup.positions.len(), soup.uvs.len(), soup.normals.len()];
        self.corners.clear();
        loop {
            let word = word(&mut rest);
            if word.is_empty() || word.starts_with(b"#") {
                break;
            }
            let corner = self.corner(word, line, counts)?;
            // A corner that only repeats the one before it adds no area.
            if self.corners.last().is_none_or(|last| last.position != corner.position) {
                self.corners.push(corner);
            }
        }
        if self.corners.len() > 1 && self.corners[0].position == self.corners[self.corners.len() - 1].position
        {
            self.corners.pop();
        }
        match self.corners.as_slice() {
            [] | [_] | [_, _] => {
                self.ignored += 1;
                if self.ignored == 1 {
                    self.ignored_line = line;
                }
            }
            [a, b, c] => soup.triangles.push([*a, *b, *c]),
            corners => {
                // Corners that point ahead have no place yet: such a polygon counts as convex.
                self.points.clear();
                let known = |c: &Corner| soup.positions.get(c.position as usize).copied().unwrap_or_default();
                self.points.extend(corners.iter().map(known));
                triangulate(&self.points, |t| soup.triangles.push(t.map(|i| corners[i])));
            }
        }
        Ok(())
    }

    #[inline]
    fn corner(&mut self, word: &[u8], line: u64, counts: [usize; 3]) -> Result<Corner, Fault> {
        let mut indices = [NONE; 3];
        let mut parts = word.split(|&b| b == b'/');
        for kind in 0..3 {
            let Some(part) = parts.next() else { break };
            if part.is_empty() && kind > 0 {
                continue;
            }
            let written = integer(part)
                .ok_or_else(|| Fault::line(line, format!("`{}` is not a face corner", shown(word))))?;
            indices[kind] = self.index(written, kind, line, counts[kind])?;
        }
        if parts.next().is_some() {
            return Err(Fault::line(line, format!("`{}` is not a face corner", shown(word))));
        }
        Ok(Corner { position: indices[0], uv: indices[1], normal: indices[2] })
    }

    /// From an index as written (1 is the first, -1 the latest) to one from 0.
    #[inline]
    fn index(&mut self, written: i64, kind: usize, line: u64, count: usize) -> Result<u32, Fault> {
        let [singular, plural] = KINDS[kind];
        if written == 0 {
            return Err(Fault::line(line, format!("{singular} index 0: they count from 1")));
        }
        let index = if written > 0 { written - 1 } else { count as i64 + written };
        if index < 0 {
            let reason =
                format!("{singular} index {written} is out of range ({count} {plural} come before it)");
            return Err(Fault::line(line, reason));
        }
        if index >= i64::from(NONE) {
            return Err(out_of_range(kind, written, count, line));
        }
        let index = index as u32;
        if index as usize >= count && index >= self.highest[kind].0 {
            self.highest[kind] = (index, line);
        }
        Ok(index)
    }

    /// Checks all indices against how many there are in the end.
    pub(super) fn finish(&self, counts: [usize; 3]) -> Result<(), Fault> {
        for (kind, &(index, line)) in self.highest.iter().enumerate() {
            if line > 0 && index as usize >= counts[kind] {
                return Err(out_of_range(kind, i64::from(index) + 1, counts[kind], line));
            }
        }
        Ok(())
    }
}

fn out_of_range(kind: usize, written: i64, count: usize, line: u64) -> Fault {
    let [singular, plural] = KINDS[kind];
    let there_are =
        if count == 1 { format!("there is 1 {singular}") } else { format!("there are {count} {plural}") };
    Fault::line(line, format!("{singular} index {written} is out of range ({there_are})"))
}
