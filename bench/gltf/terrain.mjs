// A large glTF to bake: a hilly square of 2 N N triangles, its UVs the square itself. What a bake of a million triangles takes:
//
//   node terrain.mjs 708 terrain.glb
//   conray bake terrain.glb -o baked.glb --size 4096 --error 0.02

import { writeFile } from 'node:fs/promises';

const [side, out] = [Number(process.argv[2]), process.argv[3]];
if (!(Number.isInteger(side) && side >= 1 && side <= 4000) || !out) {
    console.error('usage: node terrain.mjs SQUARES OUT.glb, with 1 to 4000 squares on each side');
    process.exit(2);
}

const count = (side + 1) ** 2;
const [positions, uvs] = [new Float32Array(3 * count), new Float32Array(2 * count)];
const indices = new Uint32Array(6 * side * side);
// Hills of some sizes, each half as high as the one before; steep enough to hide each other.
const height = (x, z) => {
    let sum = 0;
    for (let wave = 2, size = 0.12; wave < side / 4; wave *= 2, size /= 2) {
        sum += size * Math.sin(Math.PI * wave * x + wave) * Math.cos(Math.PI * wave * z + 2 * wave);
    }
    return sum;
};
let [low, high] = [Infinity, -Infinity];
for (let row = 0, at = 0; row <= side; row++) {
    for (let column = 0; column <= side; column++, at++) {
        const [x, z] = [column / side, row / side];
        const y = Math.fround(height(x, z));
        [low, high] = [Math.min(low, y), Math.max(high, y)];
        positions.set([x, y, z], 3 * at);
        uvs.set([x, z], 2 * at);
        if (row < side && column < side) {
            const corners = [at, at + side + 1, at + side + 2, at, at + side + 2, at + 1];
            indices.set(corners, 6 * (row * side + column));
        }
    }
}
const parts = [positions, uvs, indices].map((list) => Buffer.from(list.buffer));
let byteLength = 0;
const bufferViews = parts.map((part, k) => {
    const view = { buffer: 0, byteOffset: byteLength, byteLength: part.length, target: k < 2 ? 34962 : 34963 };
    byteLength += part.length;
    return view;
});
const json = JSON.stringify({
    asset: { version: '2.0' },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, name: 'terrain' }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2, material: 0 }] }],
    materials: [{ name: 'earth' }],
    accessors: [
        { bufferView: 0, componentType: 5126, count, type: 'VEC3', min: [0, low, 0], max: [1, high, 1] },
        { bufferView: 1, componentType: 5126, count, type: 'VEC2' },
        { bufferView: 2, componentType: 5125, count: indices.length, type: 'SCALAR' },
    ],
    bufferViews,
    buffers: [{ byteLength }],
});
const text = Buffer.from(json.padEnd(Math.ceil(json.length / 4) * 4));
const words = (...numbers) => Buffer.from(Uint32Array.from(numbers).buffer);
await writeFile(out, Buffer.concat([
    words(0x46546c67, 2, 12 + 8 + text.length + 8 + byteLength),
    words(text.length, 0x4e4f534a), text,
    words(byteLength, 0x004e4942), ...parts,
]));
