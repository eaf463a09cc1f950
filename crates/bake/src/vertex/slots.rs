//! Which values a surface gets: one where corners meet smoothly, several where a hard edge parts them.

use conray::Session;
use conray_core::{Geometry, TriangleMesh, Vec3};
use conray_scene::Origin;
use rayon::prelude::*;
use std::collections::HashMap;

/// Normals of corners that share a value have at least this cosine, as on both sides of the seams of maps.
const SMOOTH_COSINE: f32 = 0.98;
/// Where more normals than this meet in a point, each is compared with so many before it, so that the time stays linear.
const MOST_COMPARED: usize = 64;
/// No value yet.
const NONE: u32 = u32::MAX;

/// The values of some surfaces, called slots and numbered from 0: which corners of their triangles show which.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slots {
    surfaces: Vec<SlotSurface>,
    count: usize,
}

/// A surface whose vertices have one slot each; those that need several are split.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SlotSurface {
    /// The scene's instance.
    pub instance: u32,
    /// For each vertex the one of the scene's mesh that it is: all of the mesh in their order, behind them those that were split off.
    pub vertices: Vec<u32>,
    /// Slot of each vertex.
    pub slots: Vec<u32>,
    /// The mesh's triangles, in their order, by these vertices.
    pub triangles: Vec<[u32; 3]>,
}

impl SlotSurface {
    /// Slots of a triangle's corners.
    ///
    /// # Panics
    /// Where the triangle does not exist.
    pub fn corners(&self, triangle: usize) -> [u32; 3] {
        self.triangles[triangle].map(|vertex| self.slots[vertex as usize])
    }

    /// True where it has more vertices than its mesh.
    pub fn is_split(&self) -> bool {
        // Those that were split off repeat others; the mesh's own count up.
        self.vertices.last().is_some_and(|&last| last as usize + 1 < self.vertices.len())
    }

    /// `of` are the slots of the triangles' corners. A vertex that no triangle uses gets a slot of its own from `count`, which then goes up.
    fn new(instance: u32, mesh: &TriangleMesh, of: &[[u32; 3]], count: &mut u32) -> Self {
        let mut vertices: Vec<u32> = (0..mesh.positions().len() as u32).collect();
        let mut slots = vec![NONE; vertices.len()];
        let mut split: HashMap<(u32, u32), u32> = HashMap::new();
        let mut shown = |vertex: u32, slot: u32| {
            let own = &mut slots[vertex as usize];
            if *own == NONE {
                *own = slot;
            }
            if *own == slot {
                return vertex;
            }
            *split.entry((vertex, slot)).or_insert_with(|| {
                vertices.push(vertex);
                slots.push(slot);
                vertices.len() as u32 - 1
            })
        };
        let triangle = |(triangle, of): (&[u32; 3], &[u32; 3])| [0, 1, 2].map(|k| shown(triangle[k], of[k]));
        let triangles = mesh.triangles().iter().zip(of).map(triangle).collect();
        for slot in slots.iter_mut().filter(|slot| **slot == NONE) {
            (*slot, *count) = (*count, *count + 1);
        }
        Self { instance, vertices, slots, triangles }
    }
}

impl Slots {
    /// Finds the slots of instances: corners share one where they are at one place of one object, to the bit of their world positions, and their
    /// shading normals agree within 11 degrees, whatever UVs or materials part them. Normals that agree by way of others agree.
    ///
    /// `objects` says for each instance of the scene what it is a part of ([`objects`]). Corners of triangles without area go with others of their vertex.
    ///
    /// # Panics
    /// Where an instance does not exist or has no object.
    pub fn of(session: &Session, instances: &[u32], objects: &[u32]) -> Self {
        let mut parts: HashMap<u32, usize> = HashMap::new();
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (place, &instance) in instances.iter().enumerate() {
            let group = *parts.entry(objects[instance as usize]).or_insert(groups.len());
            if group == groups.len() {
                groups.push(Vec::new());
            }
            groups[group].push(place);
        }
        let welded = |group: &Vec<usize>| {
            let instances: Vec<u32> = group.iter().map(|&place| instances[place]).collect();
            Corners::of(session, &instances).welded(session)
        };
        let found: Vec<Welded> = session.install(|| groups.par_iter().map(welded).collect());
        let (mut surfaces, mut count) = (vec![SlotSurface::default(); instances.len()], 0u32);
        for (group, mut welded) in groups.iter().zip(found) {
            let first = count;
            count += welded.count;
            for (&place, corners) in group.iter().zip(&mut welded.corners) {
                corners.as_flattened_mut().iter_mut().for_each(|slot| *slot += first);
                let mesh = session.geometry().mesh_of(instances[place] as usize);
                surfaces[place] = SlotSurface::new(instances[place], mesh, corners, &mut count);
            }
        }
        Self { surfaces, count: count as usize }
    }

    /// The surfaces, in the order of the instances.
    pub fn surfaces(&self) -> &[SlotSurface] {
        &self.surfaces
    }

    /// How many values there are.
    pub fn count(&self) -> usize {
        self.count
    }
}

/// For each instance of a scene the object that it is a part of: in a glTF that is the node that shows it (each copy for itself), elsewhere the instances of
/// one name. `origins` are [`conray_scene::Scene::origins`].
pub fn objects(geometry: &Geometry, origins: &[Origin]) -> Vec<u32> {
    fn numbered<K: Eq + std::hash::Hash>(keys: impl Iterator<Item = K>) -> Vec<u32> {
        let mut known = HashMap::new();
        keys.map(|key| {
            let next = known.len() as u32;
            *known.entry(key).or_insert(next)
        })
        .collect()
    }
    if origins.len() == geometry.instances().len() {
        numbered(origins.iter().map(|origin| (origin.node, origin.copy)))
    } else {
        numbered(geometry.instances().iter().map(|instance| &instance.name))
    }
}

/// The corners of the triangles of an object.
struct Corners<'a> {
    instances: &'a [u32],
    /// The first corner of each instance, and how many there are in all.
    starts: Vec<usize>,
    /// World positions by their bits, with the corner: sorted, so that those at one place follow each other.
    places: Vec<([u32; 3], u32)>,
    /// World-space unit normals; zero where a triangle has no area.
    normals: Vec<Vec3>,
}

/// Slots of the corners of each instance of an object.
struct Welded {
    corners: Vec<Vec<[u32; 3]>>,
    count: u32,
}

impl<'a> Corners<'a> {
    fn of(session: &Session, instances: &'a [u32]) -> Self {
        let (mut starts, mut places, mut normals) = (vec![0], Vec::new(), Vec::new());
        for &instance in instances {
            let triangles = session.geometry().mesh_of(instance as usize).triangles().len();
            let start = places.len();
            let place = |at: usize| {
                let corner = session.bvh().world_corners(instance, (at / 3) as u32)[at % 3];
                // Zero is the same with either sign.
                ((corner + 0.0).to_array().map(f32::to_bits), (start + at) as u32)
            };
            let normal = |at: usize| {
                let weights = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][at % 3];
                session.bvh().front_point(instance, (at / 3) as u32, weights).shading_normal
            };
            places.par_extend((0..3 * triangles).into_par_iter().map(place));
            normals.par_extend((0..3 * triangles).into_par_iter().map(normal));
            starts.push(places.len());
        }
        places.par_sort_unstable();
        Self { instances, starts, places, normals }
    }

    fn welded(&self, session: &Session) -> Welded {
        // The first corner of its slot, for each.
        let mut first = vec![NONE; self.normals.len()];
        for at_one_place in self.places.chunk_by(|a, b| a.0 == b.0) {
            let corners: Vec<u32> = at_one_place.iter().map(|(_, corner)| *corner).collect();
            let normals: Vec<Vec3> = corners.iter().map(|&corner| self.normals[corner as usize]).collect();
            let mut groups = alike(&normals);
            for at in (0..corners.len()).filter(|&at| normals[at] == Vec3::ZERO) {
                groups[at] = self.company(session, &corners, &normals, at).map_or(0, |other| groups[other]);
            }
            for (&corner, group) in corners.iter().zip(groups) {
                first[corner as usize] = corners[group];
            }
        }
        let (mut number, mut count) = (vec![NONE; first.len()], 0);
        for &corner in &first {
            let slot = &mut number[corner as usize];
            if *slot == NONE {
                (*slot, count) = (count, count + 1);
            }
        }
        let slots: Vec<u32> = first.iter().map(|&corner| number[corner as usize]).collect();
        let of_instance = |ends: &[usize]| slots[ends[0]..ends[1]].as_chunks::<3>().0.to_vec();
        Welded { corners: self.starts.windows(2).map(of_instance).collect(), count }
    }

    /// Of the corners at a place one with a normal: of the same vertex as that one, else any.
    fn company(&self, session: &Session, corners: &[u32], normals: &[Vec3], at: usize) -> Option<usize> {
        let vertex = |corner: u32| {
            let corner = corner as usize;
            let surface = self.starts.partition_point(|&start| start <= corner) - 1;
            let triangles = session.geometry().mesh_of(self.instances[surface] as usize).triangles();
            (surface, triangles.as_flattened()[corner - self.starts[surface]])
        };
        let has_normal = |other: &usize| normals[*other] != Vec3::ZERO;
        let mut others = (0..corners.len()).filter(has_normal);
        let any = others.clone().next();
        others.find(|&other| vertex(corners[other]) == vertex(corners[at])).or(any)
    }
}

/// For each normal the first of those that it agrees with, by way of others too.
fn alike(normals: &[Vec3]) -> Vec<usize> {
    let mut first: Vec<usize> = (0..normals.len()).collect();
    fn root(first: &[usize], mut at: usize) -> usize {
        while first[at] != at {
            at = first[at];
        }
        at
    }
    for at in 0..normals.len() {
        for other in at.saturating_sub(MOST_COMPARED)..at {
            if normals[at].dot(normals[other]) >= SMOOTH_COSINE {
                let (a, b) = (root(&first, at), root(&first, other));
                first[a.max(b)] = a.min(b);
            }
        }
    }
    (0..normals.len()).map(|at| root(&first, at)).collect()
}

#[cfg(test)]
mod tests;
