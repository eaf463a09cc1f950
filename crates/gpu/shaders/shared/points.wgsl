// What is asked, where, and what is known of it. Every struct has a twin in crates/gpu/src/points.rs.

struct Ao {
    // Infinite as the greatest number.
    distance: f32,
    reach: f32,
    bias: f32,
    // 0 none, 1 linear, 2 smooth.
    falloff: u32,
    seed: u32,
    first_sample: u32,
    // Of each point; at most the stride.
    samples: u32,
    points: u32,
    // Threads of each point, a power of two up to a workgroup.
    stride: u32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

@group(1) @binding(0) var<uniform> ao: Ao;
@group(1) @binding(1) var<storage, read> points: array<Point>;
@group(1) @binding(2) var<storage, read_write> tallies: array<Tally>;
