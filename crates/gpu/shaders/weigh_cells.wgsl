// Merges four cells of one size, or four places, into one of the next: crates/estimate/src/hybrid/cells.rs. A thread makes a cell.

//#include shared/weighing.wgsl
//#include shared/layer.wgsl
//#include shared/cells.wgsl
//#include shared/marks.wgsl

@group(1) @binding(0) var<uniform> layer: Layer;
@group(1) @binding(1) var<storage, read_write> cells: array<Cell>;
@group(1) @binding(2) var<storage, read_write> marks: array<u32>;

// Normals of one surface have at least this cosine between them.
const LIKE_COSINE: f32 = 0.95;
// Points of one surface lie within this share of a cell's size of each other's planes.
const LIKE_PLANE: f32 = 0.5;

// Footprint of the first place in a block that has a point; 0 where none has.
fn footprint(corner: vec2<u32>, side: u32) -> f32 {
    let end = min(corner + side, vec2(weighing.width, weighing.height));
    for (var y = corner.y; y < end.y; y++) {
        for (var x = corner.x; x < end.x; x++) {
            let sharpness = places[y * weighing.stride + x].sharpness;
            if sharpness > 0.0 {
                return 1.0 / sharpness;
            }
        }
    }
    return 0.0;
}

// Marks the places of a quarter of the cell as no part of it.
fn leave_out(corner: vec2<u32>) {
    let size = layer.size - 1u;
    let end = min(corner + (1u << size), vec2(weighing.width, weighing.height));
    for (var y = corner.y; y < end.y; y++) {
        for (var x = corner.x; x < end.x; x++) {
            let at = y * weighing.stride + x;
            marks[at] = with_widest(marks[at], size);
        }
    }
}

@compute @workgroup_size(GROUP)
fn weigh_cells(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let index = (group.y * groups.x + group.x) * GROUP + lane;
    let across = cells_across(layer.size);
    if index >= across.x * across.y {
        return;
    }
    let at = vec2(index % across.x, index / across.x);
    let below = grid_of(layer.size - 1u);
    var parts: array<Cell, 4>;
    var best = 4u;
    for (var k = 0u; k < 4u; k++) {
        parts[k] = cell_at(below, vec2<i32>(2u * at + vec2(k % 2u, k / 2u)));
        if parts[k].worth > 0.0 && (best == 4u || parts[k].worth > parts[best].worth) {
            best = k;
        }
    }
    var cell = Cell();
    if best < 4u {
        let centre = parts[best];
        let side = 1u << layer.size;
        let reach = LIKE_PLANE * f32(side) * footprint(at * side, side);
        for (var k = 0u; k < 4u; k++) {
            let part = parts[k];
            if part.worth <= 0.0 {
                continue;
            }
            let to = part.position - centre.position;
            let off = max(abs(dot(to, centre.normal)), abs(dot(to, part.normal)));
            if k == best || (dot(centre.normal, part.normal) >= LIKE_COSINE && off <= reach) {
                cell.worth += part.worth;
                cell.position += part.worth * part.position;
                cell.normal += part.worth * part.normal;
                cell.value += part.worth * part.value;
            } else {
                leave_out(at * side + vec2(k % 2u, k / 2u) * (side / 2u));
            }
        }
        cell.position /= cell.worth;
        cell.value /= cell.worth;
        cell.normal /= cell.worth;
        cell.normal /= max(length(cell.normal), LEAST);
    }
    cells[first_cell(layer.size) + index] = cell;
}
