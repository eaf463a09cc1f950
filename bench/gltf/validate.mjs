// Whether baking made a glTF worse in the eyes of the Khronos validator.
//
//   node validate.mjs BEFORE AFTER [BEFORE AFTER ...]
//
// Counts the validator's issues by code, in the model as it was and as it was baked, and prints what differs. Exit code 1 where AFTER has more
// errors or warnings of a code than BEFORE, 2 where the request or a file is at fault. More infos and hints are printed and pass.

import { readFile } from 'node:fs/promises';
import { basename, dirname, join } from 'node:path';
import validator from 'gltf-validator';

const SEVERITIES = ['error', 'warning', 'info', 'hint'];

/** Issues of a model: those of each code, in words. */
async function issues(path) {
    const report = await validator.validateBytes(new Uint8Array(await readFile(path)), {
        uri: basename(path),
        maxIssues: 0, // all of them
        externalResourceFunction: async (uri) =>
            new Uint8Array(await readFile(join(dirname(path), decodeURIComponent(uri)))),
    });
    const found = new Map();
    for (const { severity, code, pointer, message } of report.issues.messages) {
        const key = `${SEVERITIES[severity]} ${code}`;
        found.set(key, [...(found.get(key) ?? []), `${pointer ?? 'the file'}: ${message}`]);
    }
    return found;
}

/** `2 errors, 0 warnings, ...` */
function totals(found) {
    const count = (severity) =>
        [...found].filter(([key]) => key.startsWith(severity)).reduce((sum, [, all]) => sum + all.length, 0);
    return SEVERITIES.map((severity) => `${count(severity)} ${severity}${count(severity) === 1 ? '' : 's'}`).join(', ');
}

/** Prints a pair; true where the second has no more errors and warnings. */
async function compare(before, after) {
    const [was, is] = [await issues(before), await issues(after)];
    let passes = true;
    const lines = [];
    for (const key of [...new Set([...was.keys(), ...is.keys()])].sort()) {
        const [then, now] = [was.get(key) ?? [], is.get(key) ?? []];
        if (now.length === then.length) continue;
        const fails = now.length > then.length && /^(error|warning)/.test(key);
        passes &&= !fails;
        const [more, less] = now.length > then.length ? [now, then] : [then, now];
        const example = more.find((issue) => !less.includes(issue)) ?? more[0];
        lines.push(`  ${fails ? 'FAILS ' : ''}${key}: ${then.length} before, ${now.length} after, such as ${example}`);
    }
    console.log([`${passes ? 'ok' : 'FAILED'} ${after}: before ${totals(was)}; after ${totals(is)}`, ...lines].join('\n'));
    return passes;
}

const models = process.argv.slice(2);
if (models.length === 0 || models.length % 2 !== 0) {
    console.error('usage: node validate.mjs BEFORE AFTER [BEFORE AFTER ...]');
    process.exit(2);
}
try {
    let pass = true;
    for (let k = 0; k < models.length; k += 2) pass = (await compare(models[k], models[k + 1])) && pass;
    process.exitCode = pass ? 0 : 1;
} catch (error) {
    console.error(`validate: ${error.message ?? error}`);
    process.exitCode = 2;
}
