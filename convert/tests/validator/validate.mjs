// Validates glTF files: node validate.mjs MODULES FILE…
// MODULES is the folder that holds node_modules. Prints one JSON object a line: file, errors, warnings, messages; a file
// on which the validator itself fails has the one error VALIDATION_FAILED.

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
  const bytes = new Uint8Array(await readFile(file));
  try {
    const { numErrors, numWarnings, messages } = (await validator.validateBytes(bytes, options)).issues;
    console.log(JSON.stringify({ file, errors: numErrors, warnings: numWarnings, messages }));
  } catch (error) {
    // A file so broken that the validator gives up on it.
    const messages = [{ code: 'VALIDATION_FAILED', message: String(error), severity: 0 }];
    console.log(JSON.stringify({ file, errors: 1, warnings: 0, messages }));
  }
}
