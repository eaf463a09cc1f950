//! Where the members of structs lie that shaders read too, for the tests to compare.

use crate::{
    points::{AoUniform, GpuPoint, GpuTally},
    scene::{GpuMaterial, GpuPlacement, GpuTriangle},
};
use obvhs::cwbvh::node::CwBvhNode;
use std::mem::offset_of;

/// A struct by its name in the shaders: members with their offsets, and its size.
pub type StructLayout = (&'static str, Vec<(&'static str, usize)>, usize);

macro_rules! layout {
    ($name:literal, $type:ty, $($member:ident),+) => {
        ($name, vec![$((stringify!($member), offset_of!($type, $member))),+], size_of::<$type>())
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
        ("Node", node, size_of::<CwBvhNode>()),
        layout!("Triangle", GpuTriangle, a, material, b, uvs, c, flags),
        layout!("Material", GpuMaterial, columns, translation, factor, cutoff, first, width, height, wrap),
        layout!("Placement", GpuPlacement, world_from_mesh, mesh_from_world, root, flags, pad_a, pad_b),
        layout!(
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
        layout!("Point", GpuPoint, origin, id, geometric_normal, pad_a, shading_normal, pad_b),
        layout!("Tally", GpuTally, open, rays, sum, squares, pad_a, pad_b),
    ]
}
