// The client's requests and its parsing of responses match the wire fixtures (clients/wire_fixtures).

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createHash } from "node:crypto";
import { once } from "node:events";
import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { Color, connect, DistributionMode, Encoding } from "../../../clients/node/dist/index.js";

const folder = fileURLToPath(new URL("../../../clients/wire_fixtures/", import.meta.url));
const expected = JSON.parse(readFileSync(`${folder}expected.json`, "utf8"));

class Check {
  constructor(name) {
    this.process = spawn(process.env.PROCGEN_SYSTEM_PYTHON ?? "python3", ["-B", `${folder}check.py`, name]);
    this.lines = createInterface(this.process.stdout);
  }

  async address() {
    return (await once(this.lines, "line"))[0].replace("listening on ", "");
  }

  async end() {
    const said = [];
    this.lines.on("line", (line) => said.push(line));
    this.process.stdin.end();
    const [status] = await once(this.process, "close");
    assert.equal(status, 0, said.join("\n"));
  }
}

const digest = (pictures) => ({
  bytes: pictures.length,
  sha256: createHash("sha256").update(pictures).digest("hex"),
});

function check(batch, values) {
  for (const [name, field] of [
    ["rewards", "rewards"], ["level_seeds", "levelSeeds"], ["prev_level_seeds", "prevLevelSeeds"],
    ["episode_returns", "episodeReturns"], ["episode_lengths", "episodeLengths"],
  ]) {
    assert.deepEqual([...batch[field]], values[name], name);
  }
  for (const [name, field] of [
    ["first", "first"], ["terminated", "terminated"], ["truncated", "truncated"],
    ["prev_level_complete", "prevLevelComplete"],
  ]) {
    assert.deepEqual([...batch[field]].map(Boolean), values[name], name);
  }
  assert.equal(batch.firstEnv, values.first_env);
  assert.deepEqual([...batch.fingerprints].map(String), values.fingerprints);
  assert.deepEqual(digest(batch.finalObservations), values.final_observations);
  assert.deepEqual(digest(batch.observations), values.observations);
}

for (const [name, encoding] of [["raw", Encoding.RAW], ["zstd", Encoding.DELTA_ZSTD]]) {
  test(`the wire fixtures replay: ${name}`, async (t) => {
    const checking = new Check(name);
    t.after(() => checking.process.kill());
    const client = await connect(await checking.address());
    const pool = await client.createPool({
      games: ["maze"],
      envCount: 2,
      options: { distributionMode: DistributionMode.EASY, randSeed: 5n, useMonochromeAssets: true },
      observationFormat: { color: Color.GRAYSCALE, sizePx: 16 },
      encoding,
    });
    const batches = [
      await pool.observe(),
      await pool.step([4, 7]),
      await pool.step([-1, 3], { finalObservations: true }),
      await pool.step([8], { firstEnv: 1, repeatCount: 3, nextLevels: new Map([[1, 42]]) }),
      await pool.step([4, 4], { observe: false, resets: [{ environment: 1 }] }),
      await pool.reset([{ environment: 0, levelSeed: 7, randSeed: 9n }]),
      await pool.setLevelSampler({ levelSeeds: [3, 5], weights: [1, 2], randSeed: 1n }),
      await pool.reset(),
      await pool.step([2, 6]),
    ];
    await pool.close();
    client.close();
    await checking.end();
    for (const [i, batch] of batches.entries()) {
      if (batch !== undefined) {
        check(batch, expected[i + 1]);
      }
    }
  });
}
