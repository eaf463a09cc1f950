// The page from end to end: loaded, turned, switched, given files, and told what is missing.
//
//   cargo run -p conray-page -- --build-only && npm ci && npm test

import assert from 'node:assert/strict';
import { readFile, readdir } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { PAGE, colours, drop, open, serve, until } from './browser.mjs';

/** Most bytes of the page, compressed. */
const MOST_BYTES = 10e6;
/** Most milliseconds from load to the first picture, on a software adapter. */
const FIRST_PICTURE_MS = 3000;

let server;
before(async () => (server = await serve()));
after(() => server?.end());

/** Loads that are tried: the machine may be busy with something else for one of them. */
const LOADS = 3;

/** A page of a browser that draws that way, with what goes wrong in it. */
async function visit(draws, address = server.address) {
    const browser = await open(draws);
    const page = await browser.newPage({ viewport: { width: 1100, height: 700 } });
    const faults = [];
    page.on('pageerror', (error) => faults.push(error.message));
    page.on('console', (message) => message.type() === 'error' && !/favicon/.test(message.location().url) && faults.push(message.text()));
    const start = Date.now();
    await page.goto(address);
    return { browser, page, faults, start };
}

const isWhole = ({ version, size, wished, look, picture_look }) =>
    version > 0 && String(size) === String(wished) && JSON.stringify(look) === JSON.stringify(picture_look);
const isBy = (method) => (facts) => isWhole(facts) && facts.sides.length === 1 && facts.sides[0].method === method;

/** Points of the picture, as shares of its width and height. */
const places = ({ canvas: [x0, y0, x1, y1] }) =>
    [[0.5, 0.25], [0.5, 0.5], [0.55, 0.75], [0.4, 0.6], [0.6, 0.85]].map(([x, y]) => [x0 + x * (x1 - x0), y0 + y * (y1 - y0)]);
const isGrey = ([r, g, b]) => Math.max(r, g, b) - Math.min(r, g, b) <= 2;

/** A binary glTF of two walls that meet. */
function corner() {
    const points = [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1], [0, 1, 0], [1, 1, 0]];
    const triangles = [[0, 2, 1], [0, 3, 2], [0, 1, 5], [0, 5, 4]];
    const bin = Buffer.concat([Buffer.from(new Float32Array(points.flat()).buffer), Buffer.from(new Uint16Array(triangles.flat()).buffer)]);
    const json = {
        asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
        meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
        buffers: [{ byteLength: bin.length }],
        bufferViews: [{ buffer: 0, byteLength: 72 }, { buffer: 0, byteOffset: 72, byteLength: 24 }],
        accessors: [
            { bufferView: 0, componentType: 5126, count: 6, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 1] },
            { bufferView: 1, componentType: 5123, count: 12, type: 'SCALAR' },
        ],
    };
    let text = JSON.stringify(json);
    text = text.padEnd(4 * Math.ceil(text.length / 4));
    const chunk = (kind, bytes) => Buffer.concat([Buffer.from(new Uint32Array([bytes.length]).buffer), Buffer.from(kind), bytes]);
    const chunks = [chunk('JSON', Buffer.from(text)), chunk('BIN\0', bin)];
    const length = 12 + chunks[0].length + chunks[1].length;
    return Buffer.concat([Buffer.from('glTF'), Buffer.from(new Uint32Array([2, length]).buffer), ...chunks]);
}

test('the page is small enough to load', async () => {
    const files = ['index.html', 'page.js', 'worker.js', ...(await readdir(join(PAGE, 'pkg'))).map((name) => join('pkg', name))];
    const sizes = await Promise.all(files.map(async (name) => gzipSync(await readFile(join(PAGE, name))).length));
    const bytes = sizes.reduce((sum, size) => sum + size, 0);
    console.log(`page: ${(bytes / 1e6).toFixed(2)} MB compressed`);
    assert.ok(bytes > 1e5 && bytes < MOST_BYTES, `${bytes} bytes`);
});

test('it is loaded, turned, switched, and shows what is dropped on it', async () => {
    const { browser, page, faults, start } = await visit('webgpu');
    try {
        let first = Infinity;
        for (let load = 0, begun = start; load < LOADS && first >= FIRST_PICTURE_MS; load += 1) {
            if (load > 0) {
                begun = Date.now();
                await page.reload();
            }
            await until(page, 'a first picture', ({ version }) => version > 0);
            first = Date.now() - begun;
            console.log(`first picture ${first} ms after the page was asked for`);
        }
        assert.equal(await page.evaluate(() => globalThis.conray.by), 'WebGPU');
        assert.equal(await page.evaluate(() => globalThis.conray.isShared), true);
        assert.ok(first < FIRST_PICTURE_MS, `${first} ms`);
        const loaded = await until(page, 'all pixels', isBy('hybrid'));
        assert.equal(loaded.scene, 'cornell');
        // By itself it takes no device that is a program on the CPU.
        assert.match(String(loaded.places), /^CPU/);
        const seen = await colours(page, places(loaded));
        assert.ok(seen.every(isGrey) && seen.some(([r]) => r > 150), `greys of the room: ${JSON.stringify(seen)}`);

        // An orbit by the mouse.
        const [x, y] = places(loaded)[1];
        await page.mouse.move(x, y);
        await page.mouse.down();
        await page.mouse.move(x + 60, y + 20, { steps: 6 });
        await page.mouse.up();
        const moved = JSON.stringify(loaded.look);
        const turned = await until(page, 'the turned view', (facts) => JSON.stringify(facts.look) !== moved && isWhole(facts));
        assert.deepEqual(turned.look.look_at, loaded.look.look_at);
        assert.notDeepEqual(await colours(page, places(turned)), seen, 'another picture is drawn');

        // Another method, by its key; the next is rays.
        await page.keyboard.press('m');
        const switched = await until(page, 'method rays', isBy('rays'));
        assert.ok(switched.sides[0].rays_per_pixel >= 2);
        await page.keyboard.press('m');
        await until(page, 'method cones', isBy('cones'));

        // A scene from outside, and one that cannot be read.
        await drop(page, [['corner.glb', corner()]]);
        const dropped = await until(page, 'the dropped scene', (facts) => facts.scene === 'corner' && isWhole(facts));
        assert.equal(dropped.triangles, 4);
        await drop(page, [['broken.glb', Buffer.from('glTF\x02\0\0\0\xff\0\0\0', 'latin1')]]);
        const told = await until(page, 'a message', ({ messages }) => messages.some((text) => text.includes('broken.glb')));
        assert.equal(told.scene, 'corner');
        await drop(page, [['notes.txt', Buffer.from('no scene')]]);
        await until(page, 'a message', ({ messages }) => messages.some((text) => text.includes('notes.txt')));

        // A window of no size, and back.
        await page.setViewportSize({ width: 1, height: 1 });
        await page.waitForTimeout(300);
        await page.setViewportSize({ width: 900, height: 600 });
        await until(page, 'the picture of a smaller window', (facts) => isWhole(facts) && facts.wished[0] < dropped.wished[0]);
        assert.deepEqual(faults, []);
    } finally {
        await browser.close();
    }
});

/** A truth by the key for it; what is found of it by and by is shown. Many rays: a minute where WebGPU is a program on the CPU, so there it is tested without a browser. */
async function findTruth(page) {
    await page.keyboard.press('t');
    const judged = await until(page, 'a truth', ({ truth, measured }) => truth?.[0] > 0 && measured?.[0] > 0);
    assert.ok(judged.measured[0] < 0.1, JSON.stringify(judged.measured));
}

test('pictures, passes over points and cones are made by WebGPU, and as the CPU makes them', async () => {
    const means = [];
    for (const [device, place] of [['gpu', /webgpu/i], ['cpu', /^CPU/]]) {
        const { browser, page, faults } = await visit('webgpu', `${server.address}?scene=cornell&device=${device}`);
        try {
            // Few pixels: both are programs on the CPU here.
            await page.setViewportSize({ width: 520, height: 300 });
            const made = await until(page, 'an error of 0.02', (facts) => isBy('hybrid')(facts) && facts.sides[0].expected_rmse < 0.02);
            assert.match(String(made.places), place);
            assert.deepEqual(made.messages, []);
            // The picture is there before the shaders are.
            assert.ok(made.first_pictures.length > 0);
            const found = [made.sides[0].mean_visibility];
            // The blend, which is made of both, takes a minute where WebGPU is a program on the CPU; it is tested without a browser.
            for (const method of ['rays', 'cones']) {
                await page.keyboard.press('m');
                const enough = ({ ended, rays_per_pixel }) => ended || (method === 'rays' && rays_per_pixel >= 8);
                const made = await until(page, `method ${method}`, (facts) => isBy(method)(facts) && enough(facts.sides[0]));
                assert.match(String(made.places), place, method);
                assert.deepEqual(made.messages, []);
                found.push(made.sides[0].mean_visibility);
            }
            if (device === 'cpu') await findTruth(page);
            means.push(found);
            assert.deepEqual(faults, []);
        } finally {
            await browser.close();
        }
    }
    console.log(`mean visibility of hybrid, rays, cones: ${JSON.stringify(means)}`);
    // Cones are the same; of the others one may have had more rays than the other.
    const bars = [0.004, 0.002, 1e-4];
    bars.forEach((bar, k) => assert.ok(Math.abs(means[0][k] - means[1][k]) < bar, JSON.stringify(means)));
    // The oracle can fail: the methods differ by more.
    assert.ok(Math.abs(means[0][2] - means[1][1]) > bars[2], JSON.stringify(means));
});

test('without WebGPU it draws with WebGL, and without shared memory the worker still hears', async () => {
    const plain = await serve('--plain');
    const { browser, page, faults } = await visit('webgl', plain.address);
    try {
        const loaded = await until(page, 'all pixels', isBy('hybrid'));
        assert.equal(await page.evaluate(() => globalThis.conray.by), 'WebGL');
        assert.equal(await page.evaluate(() => globalThis.conray.isShared), false);
        const alone = await until(page, 'a word about the CPU', ({ messages }) => messages.some((text) => /there is no graphics processor/.test(text)));
        assert.match(String(alone.places), /^CPU/);
        const seen = await colours(page, places(loaded));
        assert.ok(seen.every(isGrey) && seen.some(([r]) => r > 150), JSON.stringify(seen));
        await page.keyboard.press('m');
        await until(page, 'method rays', isBy('rays'));
        assert.deepEqual(faults, []);
    } finally {
        await browser.close();
        plain.end();
    }
});

test('where nothing can draw, the page says so', async () => {
    const { browser, page } = await visit('nothing');
    try {
        await page.waitForFunction(() => /neither/.test(document.getElementById('message').textContent), null, { timeout: 20_000 });
        assert.ok(await page.isVisible('#message'));
        assert.match(await page.textContent('#message'), /WebGPU or WebGL 2/);
    } finally {
        await browser.close();
    }
});
