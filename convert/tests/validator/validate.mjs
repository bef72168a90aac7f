// Validates glTF files: node validate.mjs MODULES FILE…
// MODULES is the folder that holds node_modules. Prints one JSON object a line: file, errors, warnings, messages.

import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';

const [modules, ...files] = process.argv.slice(2);
const validator = createRequire(join(modules, 'package.json'))('gltf-validator');

for (const file of files) {
  const options = {
    uri: file,
    maxIssues: 1000,
    externalResourceFunction: async (uri) => new Uint8Array(await readFile(join(dirname(file), decodeURIComponent(uri)))),
  };
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), options);
  const { numErrors, numWarnings, messages } = report.issues;
  console.log(JSON.stringify({ file, errors: numErrors, warnings: numWarnings, messages }));
}
