// Rays through the trees: what they let through, and what they meet first.
//
// A thread should trace few rays in one dispatch: llvmpipe, under lavapipe, ends all loops of an invocation after 65 535 rounds together, and
// what it had not reached by then is lost without a word.

struct Ray {
    origin: vec3<f32>,
    direction: vec3<f32>,
    // Hits count beyond the first and up to the second.
    from_t: f32,
    to_t: f32,
}

struct Crossing {
    t: f32,
    // Of the corners.
    weights: vec3<f32>,
    is_back: bool,
}

const STACK: u32 = 32u;
// Boxes are taken a little larger than bytes say, by eight roundings of 2^-24 of all that the distances to their planes come from.
const SLACK: f32 = 4.7683716e-7;

// Roundings of a point's distance from a plane, over the largest that it could be: eight of 2^-24.
const IN_PLANE: f32 = 4.7683716e-7;

// How a ray is sheared so that it becomes the z axis: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013.
struct Shear {
    axis: u32,
    shear: vec3<f32>,
}

fn turned(p: vec3<f32>, axis: u32) -> vec3<f32> {
    // The axis becomes z; the winding stays.
    if axis == 0u {
        return p.yzx;
    }
    return select(p, p.zxy, axis == 1u);
}

fn shear_of(direction: vec3<f32>) -> Shear {
    let size = abs(direction);
    var axis = select(1u, 0u, size.x >= size.y);
    axis = select(axis, 2u, size.z > max(size.x, size.y));
    let d = turned(direction, axis);
    return Shear(axis, vec3(d.x / d.z, d.y / d.z, 1.0 / d.z));
}

fn sheared(corner: vec3<f32>, ray: Ray, shear: Shear) -> vec3<f32> {
    let p = turned(corner - ray.origin, shear.axis);
    return vec3(p.x - shear.shear.x * p.z, p.y - shear.shear.y * p.z, shear.shear.z * p.z);
}

// Where a ray crosses a triangle; `t` is below 0 where it does not. On an edge both triangles are met.
fn crossing(triangle: Triangle, ray: Ray, shear: Shear) -> Crossing {
    let a = sheared(triangle.a, ray, shear);
    let b = sheared(triangle.b, ray, shear);
    let c = sheared(triangle.c, ray, shear);
    let edges = vec3(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
    let missed = Crossing(-1.0, vec3(0.0), false);
    if any(edges < vec3(0.0)) && any(edges > vec3(0.0)) {
        return missed;
    }
    let sum = edges.x + edges.y + edges.z;
    if sum == 0.0 {
        return missed;
    }
    let weights = edges / sum;
    let t = weights.x * a.z + weights.y * b.z + weights.z * c.z;
    if !(t > ray.from_t && t <= ray.to_t) {
        return missed;
    }
    // A ray that starts in the triangle's plane, as near as can be told, does not meet it.
    let from_a = triangle.a - ray.origin;
    let normal = cross(triangle.b - triangle.a, triangle.c - triangle.a);
    if abs(dot(normal, from_a)) <= IN_PLANE * dot(abs(normal), abs(from_a)) {
        return missed;
    }
    // Of a front, met from outside, the corners go round counter-clockwise as the ray sees them.
    let along = select(-1.0, 1.0, shear.shear.z > 0.0);
    let from_front = along * sum > 0.0;
    return Crossing(t, weights, from_front == ((triangle.flags & TURNED) != 0u));
}

fn byte(low: u32, high: u32, child: u32) -> u32 {
    return (select(low, high, child >= 4u) >> (8u * (child & 3u))) & 0xffu;
}

// No direction is exactly along a plane: 0 times infinity would be no number.
fn inverse_of(direction: vec3<f32>) -> vec3<f32> {
    return 1.0 / select(direction, vec3(1e-30), abs(direction) < vec3(1e-30));
}

// Which children of a node a ray meets: nodes, then leaves. The ray's origin may be off by `off`.
fn children_met(index: u32, ray: Ray, inverse: vec3<f32>, off: f32) -> vec2<u32> {
    let e = nodes[index].exponents;
    let step = vec3(
        bitcast<f32>((e & 0xffu) << 23u), bitcast<f32>(((e >> 8u) & 0xffu) << 23u),
        bitcast<f32>(((e >> 16u) & 0xffu) << 23u)) * inverse;
    let base = (nodes[index].corner - ray.origin) * inverse;
    let slack = SLACK * (abs(base) + 255.0 * abs(step)) + off * abs(inverse);
    var met = 0u;
    for (var child = 0u; child < 8u; child++) {
        if byte(nodes[index].meta_low, nodes[index].meta_high, child) == 0u {
            continue;
        }
        var low = vec3<f32>();
        var high = vec3<f32>();
        for (var axis = 0u; axis < 3u; axis++) {
            let at = 4u * axis;
            low[axis] = f32(byte(nodes[index].planes[at], nodes[index].planes[at + 1u], child));
            high[axis] = f32(byte(nodes[index].planes[at + 2u], nodes[index].planes[at + 3u], child));
        }
        let p = low * step + base;
        let q = high * step + base;
        let enter = min(p, q) - slack;
        let leave = max(p, q) + slack;
        let from_t = max(max(enter.x, enter.y), max(enter.z, ray.from_t));
        let to_t = min(min(leave.x, leave.y), min(leave.z, ray.to_t));
        if from_t <= to_t {
            met |= 1u << child;
        }
    }
    let inner = e >> 24u;
    return vec2(met & inner, met & ~inner);
}

// A way through a tree: nodes whose children are left. A group tells where the children begin, which of them are left (low byte) and which
// are nodes (next byte).
struct Walk {
    stack: array<vec2<u32>, STACK>,
    depth: u32,
    group: vec2<u32>,
}

fn walk_from(root: u32) -> Walk {
    var walk: Walk;
    walk.group = vec2(root, 0x101u);
    return walk;
}

// The next node, or NONE.
fn next(walk: ptr<function, Walk>) -> u32 {
    if ((*walk).group.y & 0xffu) == 0u {
        if (*walk).depth == 0u {
            return NONE;
        }
        (*walk).depth -= 1u;
        (*walk).group = (*walk).stack[(*walk).depth];
    }
    let slot = firstTrailingBit((*walk).group.y & 0xffu);
    (*walk).group.y &= ~(1u << slot);
    let inner = ((*walk).group.y >> 8u) & 0xffu;
    return (*walk).group.x + countOneBits(inner & ((1u << slot) - 1u));
}

fn push(walk: ptr<function, Walk>, index: u32, met: u32) {
    if ((*walk).group.y & 0xffu) != 0u && (*walk).depth < STACK {
        (*walk).stack[(*walk).depth] = (*walk).group;
        (*walk).depth += 1u;
    }
    (*walk).group = vec2(nodes[index].child_base, met | ((nodes[index].exponents >> 24u) << 8u));
}

// What a trace is for, and what it found.
struct Trace {
    // True: the nearest surface of such an opacity. False: what all surfaces together let through.
    nearest: bool,
    least: f32,
    // True where backs that rays pass count as well.
    backs: bool,
    transmittance: f32,
    t: f32,
    opacity: f32,
    // The nearest one.
    triangle: u32,
    placement: u32,
    weights: vec3<f32>,
    ray: Ray,
    shear: Shear,
}

fn placed(rows: array<vec4<f32>, 3>, p: vec4<f32>) -> vec3<f32> {
    return vec3(dot(rows[0], p), dot(rows[1], p), dot(rows[2], p));
}

// The triangles of a leaf; false where nothing further can matter.
fn meet(first: u32, count: u32, placement: u32, found: ptr<function, Trace>) -> bool {
    let rows = placements[placement].world_from_mesh;
    let turn = placements[placement].flags & TURNED;
    let moved = (placements[placement].flags & MOVED) != 0u;
    for (var k = first; k < first + count; k++) {
        var triangle = triangles[k];
        if moved {
            // In the world, as the CPU places them too: what meets there meets here.
            triangle.a = placed(rows, vec4(triangle.a, 1.0));
            triangle.b = placed(rows, vec4(triangle.b, 1.0));
            triangle.c = placed(rows, vec4(triangle.c, 1.0));
            triangle.flags ^= turn;
        }
        let met = crossing(triangle, (*found).ray, (*found).shear);
        if met.t < 0.0 || (met.is_back && (triangle.flags & ONE_SIDED) != 0u && !(*found).backs) {
            continue;
        }
        let opacity = opacity_at(triangle, met.weights);
        if (*found).nearest {
            if opacity >= (*found).least {
                (*found).ray.to_t = met.t;
                (*found).t = met.t;
                (*found).opacity = opacity;
                (*found).triangle = k;
                (*found).placement = placement;
                (*found).weights = met.weights;
            }
        } else {
            (*found).transmittance *= 1.0 - opacity;
            if (*found).transmittance <= 0.0 {
                return false;
            }
        }
    }
    return true;
}

// The tree of a placement; false where nothing further can matter.
fn through(placement: u32, found: ptr<function, Trace>) -> bool {
    var ray = (*found).ray;
    var off = 0.0;
    if (placements[placement].flags & MOVED) != 0u {
        let rows = placements[placement].mesh_from_world;
        let most = abs(vec4(ray.origin, 1.0));
        off = SLACK * max(dot(abs(rows[0]), most), max(dot(abs(rows[1]), most), dot(abs(rows[2]), most)));
        ray.origin = placed(rows, vec4(ray.origin, 1.0));
        // Not a unit vector: distances stay those of the world.
        ray.direction = placed(rows, vec4(ray.direction, 0.0));
    }
    let inverse = inverse_of(ray.direction);
    var walk = walk_from(placements[placement].root);
    loop {
        let index = next(&walk);
        if index >= arrayLength(&nodes) {
            return true;
        }
        ray.to_t = (*found).ray.to_t;
        let met = children_met(index, ray, inverse, off);
        for (var leaves = met.y; leaves != 0u; leaves &= leaves - 1u) {
            let about = byte(nodes[index].meta_low, nodes[index].meta_high, firstTrailingBit(leaves));
            let first = nodes[index].triangle_base + (about & 31u);
            if !meet(first, countOneBits(about >> 5u), placement, found) {
                return false;
            }
        }
        push(&walk, index, met.x);
    }
    return true;
}

// What all surfaces together let through, or the nearest one that blocks anything.
fn trace(ray: Ray, nearest: bool) -> Trace {
    return traced(ray, nearest, 1e-30, false);
}

// The nearest surface that blocks half of the light, from either side; `t` is below 0 where there is none.
fn first_surface(ray: Ray) -> Trace {
    return traced(ray, true, 0.5, true);
}

fn traced(ray: Ray, nearest: bool, least: f32, backs: bool) -> Trace {
    var found =
        Trace(nearest, least, backs, 1.0, -1.0, 0.0, NONE, NONE, vec3(0.0), ray, shear_of(ray.direction));
    let inverse = inverse_of(ray.direction);
    var walk = walk_from(0u);
    loop {
        let index = next(&walk);
        if index >= arrayLength(&nodes) {
            break;
        }
        let met = children_met(index, found.ray, inverse, 0.0);
        for (var leaves = met.y; leaves != 0u; leaves &= leaves - 1u) {
            let about = byte(nodes[index].meta_low, nodes[index].meta_high, firstTrailingBit(leaves));
            let first = nodes[index].triangle_base + (about & 31u);
            for (var k = 0u; k < countOneBits(about >> 5u); k++) {
                if !through(first + k, &found) {
                    return found;
                }
            }
        }
        push(&walk, index, met.x);
    }
    return found;
}

// Surfaces that a ray with a falloff meets one behind the other: what little is behind so many counts as open. Of surfaces at one distance it meets one.
const MOST_LAYERS: u32 = 1024u;

// Visibility along a ray of the AO distance, with the falloff of that number: crates/bvh/src/query.rs.
fn visibility(ray: Ray, falloff: u32) -> f32 {
    if falloff == 0u || ray.to_t >= 3.4e38 {
        return trace(ray, false).transmittance;
    }
    var left = 1.0;
    var blocked = 0.0;
    var part = ray;
    for (var layer = 0u; layer < MOST_LAYERS && left > 0.0; layer++) {
        let met = trace(part, true);
        if met.t < 0.0 {
            break;
        }
        let x = clamp(met.t / ray.to_t, 0.0, 1.0);
        let weight = select(1.0 - x * x * (3.0 - 2.0 * x), 1.0 - x, falloff == 1u);
        blocked += left * met.opacity * weight;
        left *= 1.0 - met.opacity;
        part.from_t = met.t;
    }
    return clamp(1.0 - blocked, 0.0, 1.0);
}
