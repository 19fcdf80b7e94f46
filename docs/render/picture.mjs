// A picture of a recording at some time: see README.md.

import { readFile, writeFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join } from 'node:path';
import { parseArgs } from 'node:util';
import puppeteer from 'puppeteer-core';

const { values: options, positionals: [recording, picture] } = parseArgs({
  allowPositionals: true,
  options: {
    time: { type: 'string', default: '0' },
    width: { type: 'string', default: '960' },
    height: { type: 'string', default: '600' },
    browser: { type: 'string', default: '/usr/bin/chromium' },
  },
});
if (!picture) {
  throw new Error('usage: npm run picture -- RECORDING.glb PICTURE.png [--time SECONDS] [--width PIXELS] [--height PIXELS]');
}

const here = import.meta.dirname;
const files = { '/': join(here, 'page.html'), '/recording.glb': recording };
const types = { '.html': 'text/html', '.js': 'text/javascript', '.glb': 'model/gltf-binary' };

// Modules load from a server only.
const server = createServer(async (request, response) => {
  const file = files[request.url] ?? join(here, 'node_modules', request.url);
  try {
    const content = await readFile(file);
    response.writeHead(200, { 'Content-Type': types[extname(file)] ?? 'text/plain' }).end(content);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((listening) => server.listen(0, '127.0.0.1', listening));

const browser = await puppeteer.launch({
  executablePath: options.browser,
  // Without a graphics card.
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
try {
  const page = await browser.newPage();
  page.on('pageerror', (error) => console.error(error));
  await page.setViewport({ width: +options.width, height: +options.height });
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  await page.evaluate((time) => window.show(time), +options.time);
  await writeFile(picture, await page.screenshot());
} finally {
  await browser.close();
  server.close();
}
