// Filtered look-ups in the octree: crates/voxel/src/lookup.rs. Every struct has a twin in crates/gpu/src/octree.rs.

struct Level {
    side: u32,
    across: u32,
    table: u32,
    words: u32,
}

@group(0) @binding(0) var<storage, read> levels: array<Level>;
// Numbers of bricks.
@group(0) @binding(1) var<storage, read> table: array<u32>;
// Opacities: four leaves a word, or a mean and an SD.
@group(0) @binding(2) var<storage, read> words: array<u32>;

struct Slope {
    mean: f32,
    sd: f32,
    // Change of the mean along each axis, per leaf.
    gradient: vec3<f32>,
}

// Mean and SD of a node in 65535ths; `place` is the node's, one brick on.
fn moments(level: u32, place: vec3<u32>) -> vec2<f32> {
    let at = levels[level];
    let brick = place / 8u;
    let number = table[at.table + (brick.z * at.across + brick.y) * at.across + brick.x];
    let local = place % 8u;
    let node = local.x | (local.y << 3u) | (local.z << 6u);
    if level == 0u {
        let word = words[at.words + number * 128u + node / 4u];
        return vec2(257.0 * f32((word >> (8u * (node % 4u))) & 0xffu), 0.0);
    }
    let word = words[at.words + number * 512u + node];
    return vec2(f32(word & 0xffffu), f32(word >> 16u));
}

// Two nodes in a row along x.
fn row(level: u32, place: vec3<u32>) -> vec4<f32> {
    return vec4(moments(level, place), moments(level, place + vec3(1u, 0u, 0u)));
}

// About a position in leaves.
fn trilinear(level: u32, position: vec3<f32>) -> Slope {
    let size = f32(1u << level);
    let place = position / size + 0.5;
    let side = f32(levels[level].side);
    if !(all(place >= vec3(0.0)) && all(place < vec3(side + 1.0))) {
        return Slope(0.0, 0.0, vec3(0.0));
    }
    let high = floor(place);
    let share = place - high;
    // The lower node, one brick on.
    let low = vec3<u32>(high) + 7u;
    let at_00 = row(level, low);
    let at_10 = row(level, low + vec3(0u, 1u, 0u));
    let low_by_z = row(level, low + vec3(0u, 0u, 1u)) - at_00;
    let high_by_z = row(level, low + vec3(0u, 1u, 1u)) - at_10;
    let bottom = at_00 + low_by_z * share.z;
    let by_y = at_10 + high_by_z * share.z - bottom;
    let at = bottom + by_y * share.y;
    let by_z = low_by_z + (high_by_z - low_by_z) * share.y;
    let by_x = at.z - at.x;
    let unit = 1.0 / 65535.0;
    let gradient = vec3(by_x, by_y.x + (by_y.z - by_y.x) * share.x, by_z.x + (by_z.z - by_z.x) * share.x);
    return Slope((at.x + by_x * share.x) * unit, (at.y + (at.w - at.y) * share.x) * unit, gradient * (unit / size));
}

fn slope_at(level: u32, share: f32, position: vec3<f32>) -> Slope {
    let fine = trilinear(level, position);
    if share <= 0.0 {
        return fine;
    }
    let coarse = trilinear(level + 1u, position);
    return Slope(mix(fine.mean, coarse.mean, share), mix(fine.sd, coarse.sd, share), mix(fine.gradient, coarse.gradient, share));
}
