// A browser that draws in software, and the page served for it.

import { spawn } from 'node:child_process';
import { access, constants } from 'node:fs/promises';
import { delimiter, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const ROOT = join(dirname(fileURLToPath(import.meta.url)), '../../..');
/** The folder of the page, as `conray-page --build-only` leaves it. */
export const PAGE = join(ROOT, 'target/page');
/** The program that serves it, as `cargo test --workspace` or `cargo build -p conray-page` leaves it; CONRAY_PAGE names another. */
const SERVER = process.env.CONRAY_PAGE ?? join(ROOT, 'target/debug/conray-page');

/** How the browser draws. */
export const DRAWS = {
    webgpu: ['--enable-unsafe-webgpu', '--use-webgpu-adapter=swiftshader', '--enable-features=Vulkan', '--use-vulkan=swiftshader', '--use-angle=swiftshader'],
    webgl: ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-features=WebGPU,WebGPUService'],
    nothing: ['--disable-gpu', '--disable-3d-apis', '--disable-software-rasterizer', '--disable-features=WebGPU,WebGPUService'],
};

/** Serves the page on a free port; gives its address and a way to end it. */
export async function serve(...options) {
    const server = spawn(SERVER, ['--serve-only', '--port', '0', '--out', PAGE, ...options], { stdio: ['ignore', 'pipe', 'inherit'] });
    const address = await new Promise((found, failed) => {
        server.once('error', failed);
        server.once('exit', (code) => failed(new Error(`the server ended with ${code}`)));
        server.stdout.on('data', (text) => {
            const [address] = /http:\S+/.exec(text) ?? [];
            if (address) found(address);
        });
    });
    return { address, end: () => server.kill() };
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

/** A browser that draws that way, without a window. */
export async function open(draws) {
    return chromium.launch({ executablePath: await browserPath(), args: ['--no-sandbox', '--disable-quic', ...DRAWS[draws]] });
}

/** The colours of points of the page as it is shown: [red, green, blue] of each. */
export async function colours(page, points) {
    const picture = (await page.screenshot()).toString('base64');
    return page.evaluate(async ({ picture, points }) => {
        const bytes = Uint8Array.from(atob(picture), (c) => c.charCodeAt(0));
        const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
        const canvas = new OffscreenCanvas(image.width, image.height);
        const context = canvas.getContext('2d');
        context.drawImage(image, 0, 0);
        return points.map(([x, y]) => [...context.getImageData(Math.round(x), Math.round(y), 1, 1).data.slice(0, 3)]);
    }, { picture, points });
}

/** Drops files, by name and bytes, on the page. */
export async function drop(page, files) {
    const transfer = await page.evaluateHandle((files) => {
        const transfer = new DataTransfer();
        for (const [name, text] of files) {
            transfer.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
        }
        return transfer;
    }, files.map(([name, bytes]) => [name, Buffer.from(bytes).toString('base64')]));
    for (const event of ['dragover', 'drop']) await page.dispatchEvent('#canvas', event, { dataTransfer: transfer });
}

/** What the page shows, once that is what is waited for. */
export async function until(page, what, isIt, patience = 60_000) {
    const end = Date.now() + patience;
    for (;;) {
        const facts = await page.evaluate(() => globalThis.conray?.facts() ?? null);
        if (facts && isIt(facts)) return facts;
        if (Date.now() > end) throw new Error(`${what}: ${JSON.stringify(facts)}`);
        await page.waitForTimeout(30);
    }
}
