// Runs the engine beside the page: orders come in as bytes, reports go out as bytes.

import init, { WorkerEngine } from './pkg/conray_viewer.js';

let engine;
let shared;
let seen = 0;
let isRunning = false;
let isWorking = false;
// Orders that came in before the engine was there, or while it waited for a device.
const waiting = [];
const next = new MessageChannel();

globalThis.conray_post = (bytes) => postMessage(bytes.buffer, [bytes.buffer]);
// Asked in the middle of work: orders that came in since wait outside until the work ends.
globalThis.conray_is_newer = () => shared !== undefined && Atomics.load(shared, 0) !== seen;

/** Does a piece of work, then lets orders in before the next. */
async function run() {
    isWorking = true;
    const hasMore = await engine.step();
    isWorking = false;
    isRunning = hasMore;
    if (hasMore) next.port2.postMessage(null);
    waiting.splice(0).forEach(take);
}
next.port1.onmessage = run;

function take(buffer) {
    seen += 1;
    engine.take(new Uint8Array(buffer));
    if (!isRunning) {
        isRunning = true;
        next.port2.postMessage(null);
    }
}

onmessage = async ({ data }) => {
    if (data instanceof ArrayBuffer) {
        if (engine && !isWorking) take(data);
        else waiting.push(data);
        return;
    }
    ({ shared, seen } = data);
    await init({ module_or_path: data.module });
    engine = new WorkerEngine();
    waiting.splice(0).forEach(take);
};
