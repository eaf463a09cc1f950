// Owen-scrambled Sobol points: crates/core/src/sobol.rs, bit for bit.

fn hash_u32(value: u32) -> u32 {
    var x = value;
    x ^= x >> 16u;
    x *= 0x7feb352du;
    x ^= x >> 15u;
    x *= 0x846ca68bu;
    return x ^ (x >> 16u);
}

fn owen_scramble(fraction: u32, seed: u32) -> u32 {
    var x = reverseBits(fraction);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

fn sobol_dimension_1(index: u32) -> u32 {
    var x = index;
    x ^= (x >> 1u) & 0x55555555u;
    x ^= (x >> 2u) & 0x33333333u;
    x ^= (x >> 4u) & 0x0f0f0f0fu;
    x ^= (x >> 8u) & 0x00ff00ffu;
    x ^= (x >> 16u) & 0x0000ffffu;
    return reverseBits(x);
}

fn unit_float(bits: u32) -> f32 {
    return f32(bits >> 8u) * (1.0 / 16777216.0);
}

fn owen_sobol_2d(index: u32, seed: u32) -> vec2<f32> {
    let shuffled = owen_scramble(index, hash_u32(seed));
    let x = owen_scramble(reverseBits(shuffled), hash_u32(seed ^ 0x51673e4du));
    let y = owen_scramble(sobol_dimension_1(shuffled), hash_u32(seed ^ 0xa3d895b1u));
    return vec2(unit_float(x), unit_float(y));
}
