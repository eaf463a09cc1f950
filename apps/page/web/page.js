// Starts the viewer: loads the module once, for the page and its workers, and says what is missing where it cannot.

import init, { facts, failure, start } from './pkg/conray_viewer.js';

const message = document.getElementById('message');

function say(text) {
    message.textContent = text;
    message.hidden = false;
}

/** Whether the browser can draw: WebGPU with an adapter, or else WebGL 2. */
async function drawsBy() {
    const adapter = await navigator.gpu?.requestAdapter().catch(() => null);
    if (adapter) return 'WebGPU';
    return document.createElement('canvas').getContext('webgl2') ? 'WebGL' : null;
}

/** Memory that page and workers share: there alone where the server isolates the page. */
function counter() {
    return globalThis.crossOriginIsolated ? new Int32Array(new SharedArrayBuffer(4)) : undefined;
}

async function run() {
    if (typeof WebAssembly !== 'object' || typeof Worker !== 'function') {
        return say('conray needs WebAssembly and web workers, which this browser does not offer.');
    }
    const by = await drawsBy();
    if (!by) {
        return say('conray draws with WebGPU or WebGL 2, and this browser offers neither. A newer browser, or its setting for hardware acceleration, may help.');
    }
    const module = await WebAssembly.compileStreaming(fetch(new URL('pkg/conray_viewer_bg.wasm', import.meta.url)));
    await init({ module_or_path: module });
    const shared = counter();
    const makeWorker = () => {
        const worker = new Worker(new URL('worker.js', import.meta.url), { type: 'module' });
        // A new worker has seen as many orders as there were by then.
        worker.postMessage({ module, shared, seen: shared ? Atomics.load(shared, 0) : 0 });
        return worker;
    };
    const asked = (name) => new URLSearchParams(location.search).get(name) ?? undefined;
    await start(document.getElementById('canvas'), makeWorker, shared, asked('scene'), asked('device'));
    message.hidden = true;
    // For tests: what is shown, and by what it is drawn.
    globalThis.conray = { facts: () => JSON.parse(facts() ?? 'null'), by, isShared: Boolean(shared) };
    setInterval(() => {
        const failed = failure();
        if (failed) say(`conray has stopped: ${failed}. Load the page again.`);
    }, 1000);
}

run().catch((error) => say(`conray cannot start: ${error?.message ?? error}`));
