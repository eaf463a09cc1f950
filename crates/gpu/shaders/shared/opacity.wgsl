// Opacity of a triangle's material at weights of its corners: crates/core/src/opacity.rs.

fn texel(material: Material, x: u32, y: u32) -> f32 {
    let at = material.first + y * material.width + x;
    return f32((opacities[opacities[1] + at / 4u] >> (8u * (at % 4u))) & 0xffu);
}

// The two texels either side of a coordinate and, in z as bits, the weight of the second.
fn taps(coordinate: f32, size: u32, wrap: u32) -> vec3<u32> {
    var wrapped = coordinate - floor(coordinate);
    if wrap == 1u {
        let half_turn = coordinate * 0.5;
        wrapped = 1.0 - abs(2.0 * (half_turn - floor(half_turn)) - 1.0);
    } else if wrap == 2u {
        wrapped = clamp(coordinate, 0.0, 1.0);
    }
    let place = wrapped * f32(size) - 0.5;
    let low = floor(place);
    let last = i32(size) - 1;
    var first = i32(low);
    var second = first + 1;
    if wrap == 0u {
        first = select(first, last, first < 0);
        second = select(second, 0, second > last);
    }
    // Also what rounding would put outside.
    return vec3(u32(clamp(first, 0, last)), u32(clamp(second, 0, last)), bitcast<u32>(place - low));
}

fn opacity_at(triangle: Triangle, weights: vec3<f32>) -> f32 {
    if triangle.material == NONE {
        return 1.0;
    }
    let material = material_at(triangle.material);
    var value = material.factor;
    if material.width > 0u {
        let uv = weights.x * uv_at(triangle.uvs) + weights.y * uv_at(triangle.uvs + 1u)
            + weights.z * uv_at(triangle.uvs + 2u);
        let place = material.columns.xy * uv.x + material.columns.zw * uv.y + material.translation;
        let x = taps(place.x, material.width, material.wrap & 15u);
        let y = taps(place.y, material.height, material.wrap >> 4u);
        let along = vec2(bitcast<f32>(x.z), bitcast<f32>(y.z));
        let top = mix(texel(material, x.x, y.x), texel(material, x.y, y.x), along.x);
        let bottom = mix(texel(material, x.x, y.y), texel(material, x.y, y.y), along.x);
        value *= mix(top, bottom, along.y) / 255.0;
    }
    if material.cutoff >= 0.0 {
        return select(0.0, 1.0, value >= material.cutoff);
    }
    return clamp(value, 0.0, 1.0);
}
