//! Where the members of structs lie that shaders read too, for the tests to compare.

use crate::{
    bundles::{BundlesUniform, GpuUnit, GpuUnitTold},
    cone_rays::{ConeRaysUniform, GpuCone},
    frame::{CameraUniform, LatticeUniform, ShownUniform},
    octree::MarchUniform,
    points::{AoUniform, GpuPoint, GpuTally},
    scene::{GpuMaterial, GpuPlacement, GpuTriangle},
    weighing::{
        Counts, GpuCell, GpuPlace, GpuPlaceTally, GpuSums, LayerUniform, WeighingState, WeighingUniform,
    },
};
use conray_voxel::PackedLevel;
use obvhs::cwbvh::node::CwBvhNode;
use std::mem::offset_of;

/// A struct by its file and its name there: members with their offsets, and its size.
pub type StructLayout = ([&'static str; 2], Vec<(&'static str, usize)>, usize);

macro_rules! layout {
    ($file:literal, $name:literal, $type:ty, $($member:ident),+) => {
        ([$file, $name], vec![$((stringify!($member), offset_of!($type, $member))),+], size_of::<$type>())
    };
}

/// All of them.
pub fn layouts() -> Vec<StructLayout> {
    // The tree's builder has names of its own: each is put beside that of the shader.
    let node = vec![
        ("corner", offset_of!(CwBvhNode, p)),
        ("exponents", offset_of!(CwBvhNode, e)),
        ("child_base", offset_of!(CwBvhNode, child_base_idx)),
        ("triangle_base", offset_of!(CwBvhNode, primitive_base_idx)),
        ("meta_low", offset_of!(CwBvhNode, child_meta)),
        ("meta_high", offset_of!(CwBvhNode, child_meta) + 4),
        ("planes", offset_of!(CwBvhNode, child_min_x)),
    ];
    vec![
        (["rays.wgsl", "Node"], node, size_of::<CwBvhNode>()),
        layout!("rays.wgsl", "Triangle", GpuTriangle, a, material, b, uvs, c, flags),
        layout!(
            "rays.wgsl",
            "Material",
            GpuMaterial,
            columns,
            translation,
            factor,
            cutoff,
            first,
            width,
            height,
            wrap
        ),
        layout!(
            "rays.wgsl",
            "Placement",
            GpuPlacement,
            world_from_mesh,
            mesh_from_world,
            root,
            flags,
            pad_a,
            pad_b
        ),
        layout!(
            "rays.wgsl",
            "Ao",
            AoUniform,
            distance,
            reach,
            bias,
            falloff,
            seed,
            first_sample,
            samples,
            points,
            stride,
            pad_a,
            pad_b,
            pad_c
        ),
        layout!("rays.wgsl", "Point", GpuPoint, origin, id, geometric_normal, pad_a, shading_normal, pad_b),
        layout!(
            "cone_rays.wgsl",
            "ConeRays",
            ConeRaysUniform,
            distance,
            bias,
            falloff,
            seed,
            frames_start,
            frames_end,
            first,
            stride,
            cones,
            points,
            pad_a,
            pad_b
        ),
        layout!(
            "bundles.wgsl",
            "Bundles",
            BundlesUniform,
            distance,
            reach,
            bias,
            falloff,
            seed,
            units,
            pad_a,
            pad_b
        ),
        layout!("bundles.wgsl", "Unit", GpuUnit, point, index),
        layout!("bundles.wgsl", "UnitTold", GpuUnitTold, bent, mean, variance, of_full, pad_a, pad_b),
        layout!("cone_rays.wgsl", "Cone", GpuCone, axis, cos_half_angle, low, edge, pad),
        layout!("cones.wgsl", "Level", PackedLevel, side, across, table, words),
        layout!(
            "cones.wgsl",
            "March",
            MarchUniform,
            origin,
            voxel_size,
            resolution,
            spread,
            step,
            lift,
            distance,
            top,
            falloff,
            cones,
            points,
            pad_a,
            pad_b,
            pad_c
        ),
        layout!("cones.wgsl", "Point", GpuPoint, origin, id, geometric_normal, pad_a, shading_normal, pad_b),
        layout!(
            "weigh.wgsl",
            "Weighing",
            WeighingUniform,
            width,
            height,
            stride,
            points,
            unit,
            full,
            enough,
            distance,
            cells,
            plane,
            cosine,
            slope,
            bend,
            prior_samples,
            beyond_chance,
            least_noise,
            doubt_units,
            pad_a,
            pad_b,
            pad_c
        ),
        layout!(
            "see.wgsl",
            "Camera",
            CameraUniform,
            eye,
            width,
            right,
            height,
            up,
            stride,
            forward,
            pixel_side,
            unit,
            pad_a,
            pad_b,
            pad_c
        ),
        layout!(
            "lattice.wgsl",
            "Lattice",
            LatticeUniform,
            distance,
            reach,
            bias,
            falloff,
            seed,
            width,
            height,
            stride,
            first_rank,
            ranks,
            unit,
            pad
        ),
        layout!("resolve.wgsl", "Shown", ShownUniform, background, width, pad_a, pad_b),
        layout!("see.wgsl", "Place", GpuPlace, position, sharpness, normal, pad),
        layout!("lattice.wgsl", "PlaceTally", GpuPlaceTally, units, sum, in_units, in_fulls),
        layout!("weigh.wgsl", "Place", GpuPlace, position, sharpness, normal, pad),
        layout!("weigh.wgsl", "PlaceTally", GpuPlaceTally, units, sum, in_units, in_fulls),
        layout!("weigh.wgsl", "Cell", GpuCell, position, worth, normal, value),
        layout!("weigh_guess.wgsl", "Layer", LayerUniform, size, again, pad_a, pad_b),
        layout!("weigh.wgsl", "State", WeighingState, unit, sizes, unit_variance, pad, factors),
        layout!("weigh_guess.wgsl", "LiveCounts", Counts, sizes, lacking),
        layout!("weigh_sums.wgsl", "Counts", Counts, sizes, lacking),
        layout!("weigh.wgsl", "Sums", GpuSums, samples, unit_variance, variance, pad, guesses),
        layout!("rays.wgsl", "Tally", GpuTally, open, rays, sum, squares, pad_a, pad_b),
    ]
}
