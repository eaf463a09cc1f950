// What occludes. Every struct has a twin in crates/gpu/src/scene/.

// Eight children, their boxes in bytes (Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017).
struct Node {
    // Least corner of the box.
    corner: vec3<f32>,
    // Exponents of the three axes' steps, and which children are nodes.
    exponents: u32,
    child_base: u32,
    triangle_base: u32,
    meta_low: u32,
    meta_high: u32,
    // Least and greatest planes of the children, four bytes a word: x, y, z.
    planes: array<u32, 12>,
}

struct Triangle {
    a: vec3<f32>,
    // Which material; NONE is opaque.
    material: u32,
    b: vec3<f32>,
    // Where its three UVs begin, for a material with a texture.
    uvs: u32,
    c: vec3<f32>,
    // 1: rays pass it from behind; 2: the front is where the corners go round clockwise.
    flags: u32,
}

// A tree of triangles in the world.
struct Placement {
    // Rows.
    world_from_mesh: array<vec4<f32>, 3>,
    mesh_from_world: array<vec4<f32>, 3>,
    root: u32,
    // 2: it is mirrored; 4: its triangles are those of a mesh, and not in the world yet.
    flags: u32,
    pad_a: u32,
    pad_b: u32,
}

// Opacity of a material that is not opaque.
struct Material {
    // From UVs to the texture: columns, then the translation.
    columns: vec4<f32>,
    translation: vec2<f32>,
    factor: f32,
    // Below 0 there is none.
    cutoff: f32,
    // Of the texture's first texel; width 0 where there is no texture.
    first: u32,
    width: u32,
    height: u32,
    // Wrapping in u, then in v from bit 4 on: 0 repeats, 1 mirrors, 2 clamps.
    wrap: u32,
}

const NONE: u32 = 0xffffffffu;
const ONE_SIDED: u32 = 1u;
const TURNED: u32 = 2u;
const MOVED: u32 = 4u;

// Those of the placements first, whose leaves name placements, then those of each tree of triangles.
@group(0) @binding(0) var<storage, read> nodes: array<Node>;
@group(0) @binding(1) var<storage, read> triangles: array<Triangle>;
// Opacities, as bits: where UVs and where texels begin, then the materials, then the UVs, two words each, then the texels, four a word.
@group(0) @binding(2) var<storage, read> opacities: array<u32>;
@group(0) @binding(3) var<storage, read> placements: array<Placement>;

fn material_at(index: u32) -> Material {
    let at = 2u + 12u * index;
    return Material(
        vec4(number_at(at), number_at(at + 1u), number_at(at + 2u), number_at(at + 3u)),
        vec2(number_at(at + 4u), number_at(at + 5u)), number_at(at + 6u), number_at(at + 7u),
        opacities[at + 8u], opacities[at + 9u], opacities[at + 10u], opacities[at + 11u]);
}

fn number_at(word: u32) -> f32 {
    return bitcast<f32>(opacities[word]);
}

fn uv_at(index: u32) -> vec2<f32> {
    let at = opacities[0] + 2u * index;
    return vec2(number_at(at), number_at(at + 1u));
}
