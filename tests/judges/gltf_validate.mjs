// Runs the Khronos glTF validator over the files named on stdin (a JSON list); prints a JSON list of
// {path, errors, warnings, messages}.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";

const require = createRequire(process.argv[2] + "/");
const validator = require("gltf-validator");
const paths = JSON.parse(readFileSync(0, "utf8"));
const results = [];
for (const path of paths) {
  try {
    const report = await validator.validateBytes(new Uint8Array(readFileSync(path)), {
      uri: path,
      maxIssues: 100,
      severityOverrides: {},
    });
    const serious = report.issues.messages.filter((message) => message.severity <= 1);
    results.push({
      path,
      errors: report.issues.numErrors,
      warnings: report.issues.numWarnings,
      messages: serious.slice(0, 5).map((m) => `${m.code} at ${m.pointer}: ${m.message}`),
    });
  } catch (error) {
    results.push({ path, errors: 1, warnings: 0, messages: [String(error)] });
  }
}
console.log(JSON.stringify(results));
