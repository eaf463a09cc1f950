// A small glTF to bake: the corner of a floor and two walls, with UVs side by side or, folded, over each other.
//
//   node corner.mjs OUT.glb [folded]

import { writeFile } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';

const png = (text) => Buffer.from(text, 'base64');

/** Grey PNGs of 2 x 2 texels: one dark texel, and none. */
export const DARK = png('iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAAAAABX3VL4AAAADklEQVR42mNw+M/4nwEAB0MCQFUZxLAAAAAASUVORK5CYII=');
export const WHITE = png('iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAAAAABX3VL4AAAADklEQVR42mP8z8DEwAAABQ0BA6UiEhkAAAAASUVORK5CYII=');

const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const whole = (bytes, filler) => Buffer.concat([bytes, Buffer.alloc(-bytes.length & 3, filler)]);

/** The bytes of the model, with an occlusion map or none, read by UV set `texCoord`; `change` may alter its JSON. */
export function corner({ folded = false, occlusion, texCoord = 0, change = () => {} } = {}) {
    const [positions, normals, uvs, indices] = [[], [], [], []];
    for (const [k, [u, v]] of [[[0, 0, 1], [1, 0, 0]], [[1, 0, 0], [0, 1, 0]], [[0, 1, 0], [0, 0, 1]]].entries()) {
        for (const [a, b] of [[0, 0], [1, 0], [1, 1], [0, 1]]) {
            positions.push(...u.map((_, axis) => a * u[axis] + b * v[axis]));
            normals.push(...cross(u, v));
            uvs.push(0.03 + ((folded ? 0 : k) + 0.9 * a) / 3.2, 0.03 + 0.28 * b);
        }
        indices.push(...[0, 1, 2, 0, 2, 3].map((corner) => 4 * k + corner));
    }
    const parts = [positions, normals, uvs].map((list) => Buffer.from(Float32Array.from(list).buffer));
    parts.push(Buffer.from(Uint16Array.from(indices).buffer));
    if (occlusion) parts.push(whole(occlusion, 0));
    const json = {
        asset: { version: '2.0' },
        scene: 0,
        scenes: [{ nodes: [0] }],
        nodes: [{ mesh: 0 }],
        meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices: 3, material: 0 }] }],
        materials: [{ name: 'plaster' }],
        accessors: [
            { bufferView: 0, componentType: 5126, count: 12, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 1] },
            { bufferView: 1, componentType: 5126, count: 12, type: 'VEC3' },
            { bufferView: 2, componentType: 5126, count: 12, type: 'VEC2' },
            { bufferView: 3, componentType: 5123, count: 18, type: 'SCALAR' },
        ],
        bufferViews: [],
        buffers: [{ byteLength: 0 }],
    };
    for (const [k, part] of parts.entries()) {
        json.bufferViews.push({ buffer: 0, byteOffset: json.buffers[0].byteLength, byteLength: part.length });
        json.buffers[0].byteLength += part.length;
        if (k < 4) json.bufferViews[k].target = k < 3 ? 34962 : 34963; // vertices, indices
    }
    if (occlusion) {
        json.images = [{ mimeType: 'image/png', bufferView: 4 }];
        json.textures = [{ source: 0 }];
        json.materials[0].occlusionTexture = { index: 0, texCoord };
    }
    change(json);
    const header = (words) => Buffer.from(Uint32Array.from(words).buffer);
    const text = whole(Buffer.from(JSON.stringify(json)), ' ');
    const bin = whole(Buffer.concat(parts), 0);
    const [GLTF, JSON_CHUNK, BIN_CHUNK] = [0x46546c67, 0x4e4f534a, 0x004e4942];
    const length = 12 + 8 + text.length + 8 + bin.length;
    return Buffer.concat([header([GLTF, 2, length, text.length, JSON_CHUNK]), text, header([bin.length, BIN_CHUNK]), bin]);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
    const [, , path, shape] = process.argv;
    await writeFile(path, corner({ folded: shape === 'folded' }));
}
