// The checks pass what is right and fail what is wrong: node --test test.mjs

import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdtemp, rm, stat, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { DARK, WHITE, corner } from './corner.mjs';

const HERE = dirname(fileURLToPath(import.meta.url));
let folder;
before(async () => (folder = await mkdtemp(join(tmpdir(), 'gltf-'))));
after(() => rm(folder, { recursive: true }));

const at = (name) => join(folder, name);
const model = async (name, parts) => {
    await writeFile(at(name), corner(parts));
    return at(name);
};

/** Runs a script and asserts its exit code and what it says. */
const expect = (code, says, script, ...words) =>
    new Promise((done, fail) =>
        execFile(process.execPath, [join(HERE, script), ...words], (error, out, err) => {
            try {
                assert.equal(error?.code ?? 0, code, out + err);
                assert.match(out + err, says);
                done();
            } catch (fault) {
                fail(fault);
            }
        }),
    );

test('validate passes a model that gained occlusion', async () => {
    const [plain, dark] = [await model('plain.glb'), await model('dark.glb', { occlusion: DARK })];
    await expect(0, /^ok .*0 errors, 0 warnings/, 'validate.mjs', plain, dark);
});

test('validate fails an error and a warning that were not there before', async () => {
    const plain = await model('plain.glb');
    const bounds = await model('bounds.glb', { change: (json) => (json.accessors[0].max = [1, 1, 0.5]) });
    await expect(1, /FAILS error ACCESSOR_/, 'validate.mjs', plain, plain, plain, bounds);
    await expect(0, /^ok/, 'validate.mjs', bounds, bounds);
    await expect(0, /0 errors.*\n.*error ACCESSOR_.*before, 0 after/, 'validate.mjs', bounds, plain);
    const extension = await model('extension.glb', { change: (json) => (json.materials[0].extensions = { NOT_USED: {} }) });
    await expect(1, /FAILS /, 'validate.mjs', plain, extension);
    const unused = await model('unused.glb', { change: (json) => json.accessors.push(json.accessors[3]) });
    await expect(0, /^ok .*\n.*info UNUSED_OBJECT: 1 before, 2 after/, 'validate.mjs', plain, unused);
});

test('validate reads the files beside a text document', async () => {
    const text = async (name, uri) => {
        await writeFile(at(name), JSON.stringify({ asset: { version: '2.0' }, buffers: [{ uri, byteLength: 4 }] }));
        return at(name);
    };
    await writeFile(at('a b.bin'), Buffer.alloc(4));
    const [there, missing] = [await text('there.gltf', 'a%20b.bin'), await text('missing.gltf', 'none.bin')];
    await expect(0, /after 0 errors/, 'validate.mjs', there, there);
    await expect(1, /FAILS error IO_ERROR: 0 before, 1 after/, 'validate.mjs', there, missing);
});

test('show passes occlusion that is seen, beside the model without it', async () => {
    const [plain, dark] = [await model('plain.glb'), await model('dark.glb', { occlusion: DARK })];
    await expect(0, /1 of 1 materials.*\n  plaster: 2 x 2, UV channel 0/, 'show.mjs', dark, at('dark.png'), '--before', plain);
    assert.ok((await stat(at('dark.png'))).size > 1000);
});

test('show fails what shows no occlusion', async () => {
    const shown = (code, says, path) => expect(code, says, 'show.mjs', path, at('out.png'));
    await shown(1, /no material has an occlusion map/, await model('plain.glb'));
    await shown(1, /the picture is blank/, await model('white.glb', { occlusion: WHITE }));
    await shown(1, /no UVs for the occlusion map of plaster/, await model('uvs.glb', { occlusion: DARK, texCoord: 1 }));
    await shown(1, /load texture/, await model('image.glb', { occlusion: Buffer.alloc(64) }));
    await writeFile(at('cut.glb'), corner().subarray(0, 300));
    await shown(1, /three\.js: /, at('cut.glb'));
});

test('requests that are at fault are told', async () => {
    await expect(2, /usage/, 'validate.mjs', 'one.glb');
    await expect(2, /no such file.*nothing\.glb/, 'validate.mjs', at('nothing.glb'), at('nothing.glb'));
    await expect(2, /usage/, 'show.mjs');
    await expect(2, /no such file.*nothing\.glb/, 'show.mjs', at('nothing.glb'), at('out.png'));
});
