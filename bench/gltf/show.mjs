// Whether three.js shows the occlusion of a glTF, and a picture of what it shows.
//
//   node show.mjs MODEL OUT.png [--before MODEL]
//
// Loads the model in a headless Chromium that draws in software, white and under ambient light alone, and takes a picture of its front and back; the
// model before is shown at the left. Exit code 1 where three.js or the console tells an error, where no material has an occlusion map or a mesh
// lacks the UVs for one, or where the picture is blank or occlusion changes nothing of it; 2 where the request is at fault.
// The browser is the first of chromium, chromium-browser and google-chrome on PATH, or what CHROMIUM names.

import { createServer } from 'node:http';
import { access, constants, readFile } from 'node:fs/promises';
import { basename, delimiter, dirname, extname, join, relative, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';
import { chromium } from 'playwright-core';

const HERE = dirname(fileURLToPath(import.meta.url));
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.png': 'image/png', '.jpg': 'image/jpeg' };
/** Less than half a step of 8 bits: nothing is seen. */
const UNSEEN = 0.5 / 255;
const PATIENCE_MS = 120_000;

/** Serves folders under their names, and nothing beside them; tells its address. */
async function serve(folders) {
    const server = createServer(async (request, response) => {
        try {
            const [, name, ...path] = decodeURIComponent(new URL(request.url, 'http://localhost').pathname).split('/');
            const file = name in folders ? resolve(folders[name], path.join('/')) : join(HERE, name);
            if (name in folders && relative(folders[name], file).startsWith('..')) throw new Error('outside');
            const bytes = await readFile(file);
            response.writeHead(200, { 'content-type': TYPES[extname(file)] ?? 'application/octet-stream' }).end(bytes);
        } catch {
            response.writeHead(404).end();
        }
    });
    await new Promise((listens) => server.listen(0, 'localhost', listens));
    return { server, address: `http://localhost:${server.address().port}` };
}

async function browserPath() {
    if (process.env.CHROMIUM) return process.env.CHROMIUM;
    for (const name of ['chromium', 'chromium-browser', 'google-chrome']) {
        for (const folder of (process.env.PATH ?? '').split(delimiter)) {
            const path = join(folder, name);
            if (await access(path, constants.X_OK).then(() => true, () => false)) return path;
        }
    }
    throw new Error('no chromium on PATH: install it, or name it in CHROMIUM');
}

/** Shows models side by side and writes the picture; tells what the page saw and what went wrong. */
async function take(models, out) {
    const folders = { three: join(HERE, 'node_modules/three') };
    models.forEach((model, k) => (folders[`model${k}`] = resolve(dirname(model))));
    const urls = models.map((model, k) => `/model${k}/${encodeURIComponent(basename(model))}`);
    const { server, address } = await serve(folders);
    const browser = await chromium.launch({
        executablePath: await browserPath(),
        args: ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic'],
    });
    try {
        const page = await browser.newPage({ viewport: { width: 640 * models.length, height: 1280 } });
        const faults = [];
        page.on('console', (message) => message.type() === 'error' && faults.push(`console: ${message.text()}`));
        page.on('pageerror', (error) => faults.push(`page: ${error.message}`));
        await page.goto(`${address}/show.html`);
        await page.waitForFunction(() => 'show' in window, null, { timeout: 60_000 });
        const report = await page.evaluate((urls) => window.show(urls), urls).catch((error) => {
            faults.push(`three.js: ${error.message.split('\n')[0]}`);
            return [];
        });
        await page.locator('#picture').screenshot({ path: out });
        return { report, faults };
    } finally {
        await browser.close();
        server.closeAllConnections?.();
        server.close();
    }
}

/** Prints what of a model is seen; gives what is wrong with it. */
function judge({ materials, pixels, mean, sd, darkening }, name) {
    const shown = materials.filter(({ size }) => size);
    console.log(`${name}: ${shown.length} of ${materials.length} materials have an occlusion map`);
    for (const { name, size, channel } of shown) console.log(`  ${name || 'no name'}: ${size.join(' x ')}, UV channel ${channel}`);
    console.log(`  ${pixels} pixels, mean ${mean.toFixed(3)}, SD ${sd.toFixed(3)}; occlusion darkens by ${darkening.toFixed(3)}`);
    return [
        shown.length === 0 && 'no material has an occlusion map',
        ...shown.map(({ name, size }) => Math.min(...size) === 0 && `the occlusion map of ${name} has no size`),
        ...shown.map(({ name, lacking }) => lacking && `a mesh has no UVs for the occlusion map of ${name}`),
        (pixels === 0 || sd < UNSEEN) && 'the picture is blank',
        darkening < UNSEEN && 'occlusion changes nothing of the picture',
    ].filter(Boolean);
}

const request = () => {
    const { values, positionals } = parseArgs({ options: { before: { type: 'string' } }, allowPositionals: true });
    if (positionals.length !== 2) throw new Error('usage: node show.mjs MODEL OUT.png [--before MODEL]');
    return { model: positionals[0], out: positionals[1], before: values.before };
};

setTimeout(() => {
    console.error(`show: no picture within ${PATIENCE_MS / 1000} s`);
    process.exit(1);
}, PATIENCE_MS).unref();
try {
    const { model, out, before } = request();
    const models = before ? [before, model] : [model];
    for (const file of models) await access(file);
    const { report, faults } = await take(models, out);
    // The model before may have no occlusion: what is seen of it is printed alone.
    if (report.length === 2) judge(report[0], `${before} (before)`);
    if (report.length > 0) faults.push(...judge(report.at(-1), model).map((fault) => `${model}: ${fault}`));
    faults.forEach((fault) => console.error(`show: ${fault}`));
    process.exitCode = faults.length > 0 ? 1 : 0;
} catch (error) {
    console.error(`show: ${error.message}`);
    process.exitCode = 2;
}
