// What the official validator says of recordings; fails if one has an error or a warning.

import { readFile } from 'node:fs/promises';
import { validateBytes } from 'gltf-validator';

for (const file of process.argv.slice(2)) {
  const { issues, info } = await validateBytes(new Uint8Array(await readFile(file)));
  const counts = `${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} infos`;
  console.log(`${file}: ${counts}, ${info.drawCallCount} draw calls, ${info.totalTriangleCount} triangles`);
  issues.messages.forEach((message) => console.log(`  ${message.code} at ${message.pointer}: ${message.message}`));
  if (issues.numErrors + issues.numWarnings > 0) {
    process.exitCode = 1;
  }
}
