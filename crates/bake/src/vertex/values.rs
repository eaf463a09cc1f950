//! What a vertex bake comes to.

use super::{fit::Element, solve::Touching};

/// Values at the vertices of surfaces, one for each slot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexValues {
    /// Visibility, 1 is open; in [0, 1].
    pub visibility: Vec<f32>,
    /// Its expected error: the mean of the estimates' about the vertex, as if all had one cause. Those of independent estimates even out to less. Infinite
    /// where nothing is known: there the visibility is 1.
    pub error: Vec<f32>,
    /// Root mean square difference, over the surface, between the estimates and what is drawn between the values: what triangles of that size cannot show,
    /// and the estimates' own errors.
    pub misfit: f64,
    /// Slots that no estimate tells of, which took the values about them.
    pub filled: usize,
    /// Steps of the solver.
    pub steps: usize,
}

impl VertexValues {
    /// Gives slots that are not known values: the mean over the triangles about them, ring by ring from those that are known. Where no triangle leads to a known
    /// one the surface is taken as open.
    pub(super) fn fill(&mut self, mut unknown: Vec<u32>, triangles: &Touching, elements: &[Element]) {
        self.filled = unknown.len();
        for &slot in &unknown {
            (self.visibility[slot as usize], self.error[slot as usize]) = (f32::NAN, f32::INFINITY);
        }
        while !unknown.is_empty() {
            let about = |slot: u32| {
                let corners = triangles.of(slot as usize).flat_map(|item| elements[item].slots);
                let known =
                    corners.map(|other| other as usize).filter(|&other| !self.visibility[other].is_nan());
                known.fold([0.0f64; 3], |[value, error, count], other| {
                    [
                        value + f64::from(self.visibility[other]),
                        error + f64::from(self.error[other]),
                        count + 1.0,
                    ]
                })
            };
            let found: Vec<(u32, [f64; 3])> =
                unknown.iter().map(|&slot| (slot, about(slot))).filter(|(_, sums)| sums[2] > 0.0).collect();
            if found.is_empty() {
                break;
            }
            for (slot, [value, error, count]) in found {
                let slot = slot as usize;
                (self.visibility[slot], self.error[slot]) = ((value / count) as f32, (error / count) as f32);
            }
            unknown.retain(|&slot| self.visibility[slot as usize].is_nan());
        }
        unknown.iter().for_each(|&slot| self.visibility[slot as usize] = 1.0);
    }
}
