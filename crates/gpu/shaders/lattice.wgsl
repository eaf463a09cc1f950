// Rays of a picture, at places spread evenly: crates/estimate/src/hybrid/start.rs and spread.rs. A thread traces one ray, sixteen a unit;
// units that belong to one block of 16 x 16 pixels stand side by side.

//#include shared/scene.wgsl
//#include shared/opacity.wgsl
//#include shared/trace.wgsl
//#include shared/bundle.wgsl
//#include shared/place.wgsl

struct Lattice {
    // Infinite as the greatest number.
    distance: f32,
    reach: f32,
    bias: f32,
    // 0 none, 1 linear, 2 smooth.
    falloff: u32,
    // The hash of the plan's.
    seed: u32,
    width: u32,
    height: u32,
    // Places from row to row.
    stride: u32,
    // Places of each block that get rays, from which rank on and how many.
    first_rank: u32,
    ranks: u32,
    // Which unit of each place's sequence.
    unit: u32,
    pad: u32,
}

@group(1) @binding(0) var<uniform> lattice_plan: Lattice;
@group(1) @binding(1) var<storage, read> places: array<Place>;
@group(1) @binding(2) var<storage, read> points: array<Point>;
@group(1) @binding(3) var<storage, read_write> tallies: array<PlaceTally>;

// Pixels on each side of a block, as a power of two.
const BITS: u32 = 4u;

// Which pixel of a block has that rank.
fn of_rank(rank: u32) -> vec2<u32> {
    var at = vec2<u32>();
    for (var bit = 0u; bit < BITS; bit++) {
        let digit = (rank >> (2u * (BITS - 1u - bit))) & 3u;
        let y = digit & 1u;
        at |= vec2((digit >> 1u) ^ y, y) << vec2(bit);
    }
    return at;
}

@compute @workgroup_size(GROUP)
fn lattice(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let plan = lattice_plan;
    let unit = ((group.y * groups.x + group.x) * GROUP + lane) / UNIT;
    let blocks = (plan.width + (1u << BITS) - 1u) >> BITS;
    let block = unit / plan.ranks;
    let pixel = (vec2(block % blocks, block / blocks) << vec2(BITS)) + of_rank(plan.first_rank + unit % plan.ranks);
    let at = pixel.y * plan.stride + pixel.x;
    var is_asked = pixel.x < plan.width && pixel.y < plan.height;
    if is_asked {
        is_asked = places[at].sharpness > 0.0;
    }
    if is_asked {
        send(lane, points[at], plan.unit * UNIT + lane % UNIT, plan.seed, plan.reach, Reach(plan.distance, plan.bias, plan.falloff));
    }
    workgroupBarrier();
    if is_asked && lane % UNIT == 0u {
        let before = tallies[at];
        let variance = before.in_units + within(lane, UNIT, true);
        tallies[at] = PlaceTally(before.units + 1u, before.sum + mean_of_unit(lane).x, variance, 0.0);
    }
}
