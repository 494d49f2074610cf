// The npm package: its files, its examples, and the examples of README.md.

import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { withServer } from "./server.js";

const it = withServer();
const source = fileURLToPath(new URL("../../../clients/node/", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "procgen-node-"));
const modules = join(folder, "node_modules");
after(() => rmSync(folder, { recursive: true }));

// Installs the packed package without the registry: its dependencies are those of the checkout.
before(() => {
  const packed = JSON.parse(execFileSync("npm", ["pack", "--json", "--ignore-scripts", "--pack-destination", folder], { cwd: source }));
  const [{ filename }] = Object.values(packed);
  mkdirSync(join(modules, "procgen-client"), { recursive: true });
  execFileSync("tar", ["-xzf", join(folder, filename), "--strip-components=1", "-C", join(modules, "procgen-client")]);
  for (const dependency of Object.keys(JSON.parse(readFileSync(join(source, "package.json"))).dependencies)) {
    mkdirSync(join(modules, dependency, ".."), { recursive: true });
    symlinkSync(join(source, "node_modules", dependency), join(modules, dependency));
  }
});

function run(file, ...args) {
  const { status, stdout, stderr } = spawnSync(process.execPath, [file, ...args], { cwd: folder, encoding: "utf8" });
  assert.equal(status, 0, stderr);
  return stdout;
}

test("the package contains the compiled client and types, without tests and sources", () => {
  const files = readdirSync(join(modules, "procgen-client"));
  assert.deepEqual(files.sort(), ["README.md", "dist", "examples", "package.json"]);
  assert(readdirSync(join(modules, "procgen-client", "dist")).includes("index.d.ts"));
});

test("the random agent plays, in no more than 15 lines", () => {
  const example = join(modules, "procgen-client", "examples", "random_agent.js");
  assert(readFileSync(example, "utf8").trimEnd().split("\n").length <= 15);
  assert.match(run(example, it.server.address, "maze"), /^\d+ episodes of maze$/m);
});

const readme = readFileSync(join(source, "README.md"), "utf8");
const examples = [...readme.matchAll(/^```(?:js|ts)\n(.*?)^```$/gms)].map(([, code]) => code);

test("README.md has examples", () => assert(examples.length >= 4));
for (const [number, code] of examples.entries()) {
  test(`example ${number} of README.md runs`, () => {
    const file = join(folder, `example_${number}.mjs`);
    assert(code.includes('"localhost:50051"'));
    writeFileSync(file, code.replaceAll('"localhost:50051"', `"${it.server.address}"`));
    run(file);
  });
}
