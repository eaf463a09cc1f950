// What a camera sees: crates/bvh/src/surface.rs. A thread looks through a pixel, a workgroup through 8 x 8 of them.

//#include shared/scene.wgsl
//#include shared/opacity.wgsl
//#include shared/trace.wgsl
//#include shared/point.wgsl
//#include shared/place.wgsl

struct Camera {
    eye: vec3<f32>,
    width: u32,
    right: vec3<f32>,
    height: u32,
    up: vec3<f32>,
    // Places from row to row, a multiple of 16.
    stride: u32,
    forward: vec3<f32>,
    // Side of a pixel on the plane at unit depth.
    pixel_side: f32,
    // The length in which places are told.
    unit: f32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

@group(1) @binding(0) var<uniform> camera: Camera;
// Three for each triangle, of the world, or of the mesh where the triangle is; without length where a mesh has none.
@group(1) @binding(1) var<storage, read> normals: array<f32>;
@group(1) @binding(2) var<storage, read_write> places: array<Place>;
@group(1) @binding(3) var<storage, read_write> points: array<Point>;
@group(1) @binding(4) var<storage, read_write> tallies: array<PlaceTally>;

const GROUP: u32 = 64u;
const SIDE: u32 = 8u;
// Browsers refuse the greatest number itself, written out.
const MOST: f32 = 3.4028234e38;
// gamma(2) and gamma(24): roundings of a mean of corners, and of what lies between them. See crates/bvh/src/surface.rs.
const GAMMA_2: f32 = 1.1920932e-7;
const GAMMA_24: f32 = 1.4305136e-6;
// How far points are drawn back along their ray, in error bounds.
const DRAWN_BACK: f32 = 4.0;
// From one float to the next, at most.
const NEXT: f32 = 1.1920929e-7;
const SHARPEST: f32 = 1e6;

fn normal_at(triangle: u32, corner: u32) -> vec3<f32> {
    let at = 9u * triangle + 3u * corner;
    return vec3(normals[at], normals[at + 1u], normals[at + 2u]);
}

// The greatest of a vector's members.
fn most_of(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

struct Sight {
    place: Place,
    point: Point,
}

fn sight_of(found: Trace, direction: vec3<f32>, id: u32) -> Sight {
    var triangle = triangles[found.triangle];
    let weights = found.weights;
    var shading = weights.x * normal_at(found.triangle, 0u) + weights.y * normal_at(found.triangle, 1u)
        + weights.z * normal_at(found.triangle, 2u);
    let placement = placements[found.placement];
    if (placement.flags & MOVED) != 0u {
        triangle.a = placed(placement.world_from_mesh, vec4(triangle.a, 1.0));
        triangle.b = placed(placement.world_from_mesh, vec4(triangle.b, 1.0));
        triangle.c = placed(placement.world_from_mesh, vec4(triangle.c, 1.0));
        let rows = placement.mesh_from_world;
        shading = shading.x * rows[0].xyz + shading.y * rows[1].xyz + shading.z * rows[2].xyz;
    }
    let to_b = triangle.b - triangle.a;
    let to_c = triangle.c - triangle.a;
    let on_triangle = triangle.a + weights.y * to_b + weights.z * to_c;
    let reach = most_of(max(max(abs(to_b), abs(to_c)), abs(triangle.c - triangle.b)));
    let error = (GAMMA_2 * most_of(abs(on_triangle)) + GAMMA_24 * reach) * 1.000001 + 1.1754944e-38;
    let position = on_triangle - DRAWN_BACK * error * direction;
    let across = cross(to_b, to_c);
    let area = length(across);
    var geometric = select(-direction, across / max(area, 1.1754944e-38), area > 1.1754944e-38);
    geometric *= select(1.0, -1.0, dot(geometric, direction) > 0.0);
    // Only the side of the ray counts.
    shading *= select(1.0, -1.0, dot(shading, geometric) < 0.0);
    let size = length(shading);
    if size > 1.1754944e-38 && dot(shading, geometric) > 0.0 {
        shading /= size;
    } else {
        shading = geometric;
    }
    let bound = (1.0 + DRAWN_BACK) * error + GAMMA_2 * most_of(abs(position));
    let moved = position + bound * dot(abs(geometric), vec3(1.0)) * geometric;
    let origin = moved + sign(geometric) * (NEXT * abs(moved) + 1.1754944e-38);
    let to = position - camera.eye;
    let footprint = max(dot(to, camera.forward), 0.0) * camera.pixel_side / camera.unit;
    let sharpness = clamp(1.0 / max(footprint, 1.0 / SHARPEST), 1.1754944e-38, SHARPEST);
    return Sight(
        Place(to / camera.unit, sharpness, shading, 0u),
        Point(origin, id, geometric, 0u, shading, 0u));
}

@compute @workgroup_size(GROUP)
fn see(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let block = group.y * groups.x + group.x;
    let across = camera.stride / SIDE;
    let x = block % across * SIDE + lane % SIDE;
    let y = block / across * SIDE + lane / SIDE;
    if y >= camera.height {
        return;
    }
    let at = y * camera.stride + x;
    tallies[at] = PlaceTally();
    var sight = Sight();
    if x < camera.width {
        let right = (f32(x) + 0.5 - 0.5 * f32(camera.width)) * camera.pixel_side;
        let up = (0.5 * f32(camera.height) - f32(y) - 0.5) * camera.pixel_side;
        let direction = normalize(camera.forward + right * camera.right + up * camera.up);
        let found = first_surface(Ray(camera.eye, direction, 0.0, MOST));
        if found.t > 0.0 {
            sight = sight_of(found, direction, y * camera.width + x);
        }
    }
    places[at] = sight.place;
    points[at] = sight.point;
}
