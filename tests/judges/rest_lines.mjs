// Runs an example of a bundle's README for so many seconds of simulated time and prints where every object is then, as
// rest_lines.py does for Python.
//
//     node rest_lines.mjs ENVIRONMENT SECONDS < example.js    # in the bundle's folder
//
// The example's names are `mujoco`, `model` and `data`; its packages are those of ENVIRONMENT/node_modules.

import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

// mjOBJ_BODY
const BODY = 1;
const [environment, seconds] = process.argv.slice(2);
const example = fs.readFileSync(0, "utf8");
const count = `Math.round(${Number(seconds)} / model.opt.timestep)`;
const asked = example.replace(/< \d+;/, `< ${count};`);
if (asked === example) throw new Error("the example has no loop of steps");
const [before, loop] = asked.split(/^(?=for \(let )/m);
const told = `
const spent = process.cpuUsage();
${loop}
const { user, system } = process.cpuUsage(spent);
const names = JSON.parse(readFileSync("scene.json", "utf8")).instances.map((instance) => instance.name);
const poses = Object.fromEntries(names.map((name) => {
  const body = mujoco.mj_name2id(model, ${BODY}, name);
  const [w, x, y, z] = data.xquat.slice(4 * body, 4 * body + 4);
  return [name, [...data.xpos.slice(3 * body, 3 * body + 3), x, y, z, w]];
}));
const step_s = model.opt.timestep;
if (data.time < (${count} - 0.5) * step_s) throw new Error("the simulation diverged and began anew");
console.log("\\nrest: " + JSON.stringify({ poses, step_s, simulated_s: ${count} * step_s, cpu_s: 1e-6 * (user + system) }));
`;
const file = path.join(environment, `example-${process.pid}.mjs`);
fs.writeFileSync(file, before + told);
try {
  await import(pathToFileURL(file));
} finally {
  fs.rmSync(file);
}
