// How like two places of a surface are: crates/estimate/src/hybrid/likeness.rs.

struct Centre {
    position: vec3<f32>,
    normal: vec3<f32>,
    by_distance: f32,
    by_plane: f32,
    by_cosine: f32,
}

struct Likeness {
    // From 1, alike, to 0.
    near: f32,
    // What planes and normals add to the exponent, an eighth of it.
    bent: f32,
}

// For cells of `1 << size` places a side.
fn centre_of(place: Place, size: u32) -> Centre {
    let side = f32(1u << size);
    let reach = side / max(place.sharpness, LEAST) * weighing.cells;
    let by_plane = place.sharpness / (side * weighing.plane);
    return Centre(
        place.position, place.normal,
        0.125 / (weighing.distance * weighing.distance + reach * reach),
        by_plane * by_plane * 0.125, 0.125 / weighing.cosine);
}

// exp(-e) as (1 - e/8)^8. The place lies `to` away.
fn likeness_of(centre: Centre, to: vec3<f32>, normal: vec3<f32>) -> Likeness {
    let plane = max(abs(dot(to, centre.normal)), abs(dot(to, normal)));
    let cosine = dot(normal, centre.normal);
    let bent = centre.by_plane * plane * plane + centre.by_cosine * max(1.0 - cosine, 0.0);
    var near = max(1.0 - bent - centre.by_distance * dot(to, to), 0.0);
    near *= near;
    near *= near;
    return Likeness(near * near, bent);
}
