// A picture of the page at rest.
//
//   node picture.mjs OUT.png [SCENE]

import { open, serve, until } from './browser.mjs';

const [out, scene = 'cornell'] = process.argv.slice(2);
const server = await serve();
const browser = await open('webgpu');
try {
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: 'dark' });
    await page.goto(`${server.address}?scene=${encodeURIComponent(scene)}`);
    await until(page, 'rest', ({ busy, sides }) => busy === null && sides.length > 0 && sides[0].ended, 300_000);
    await page.waitForTimeout(500);
    await page.screenshot({ path: out });
} finally {
    await browser.close();
    server.end();
}
