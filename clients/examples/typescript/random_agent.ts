// A random agent: random_agent ADDRESS STEPS
import { credentials, status, type ServiceError } from "@grpc/grpc-js";

import { type DeepPartial } from "./gen/procgen/v1/pools";
import { PoolServiceClient } from "./gen/procgen/v1/pool_service";
import { RunPoolRequest, RunPoolResponse, type State } from "./gen/procgen/v1/run";

const ENV_COUNT = 4;
const ROUND_STEPS = 100; // Steps between two checkpoints.
const ACTION_COUNT = 15;

// What a run needs to continue on a new stream.
interface Checkpoint {
  states: State[];
  step: number;
  returns: number[]; // Of the episodes that have ended.
}

// Steps a pool from a checkpoint, and updates it after each round. The pool lives as long as the
// stream.
async function run(client: PoolServiceClient, steps: number, saved: Checkpoint) {
  const stream = client.runPool();
  const responses = stream[Symbol.asyncIterator]();
  async function call(request: DeepPartial<RunPoolRequest>): Promise<RunPoolResponse> {
    stream.write(RunPoolRequest.fromPartial(request));
    return (await responses.next()).value;
  }

  const spec = { games: ["coinrun"], envCount: ENV_COUNT };
  await call({ start: { spec, states: saved.states } });
  while (saved.step < steps) {
    const returns = [...saved.returns];
    for (let i = 0; i < ROUND_STEPS; ++i) {
      const actions = Array.from({ length: ENV_COUNT }, () =>
        Math.floor(Math.random() * ACTION_COUNT),
      );
      const { batch } = await call({ step: { slice: { envCount: ENV_COUNT }, actions } });
      // batch.observations: uint8 [4, 64, 64, 3]
      returns.push(
        ...batch!.episodeReturns.filter((_, env) => batch!.terminated[env] || batch!.truncated[env]),
      );
    }
    const { states } = await call({ saveStates: {} });
    saved.states = states!.states;
    saved.returns = returns;
    saved.step += ROUND_STEPS;
  }
  stream.end();
}

async function main(address: string, steps: number) {
  const client = new PoolServiceClient(address, credentials.createInsecure());
  const saved: Checkpoint = { states: [], step: 0, returns: [] };
  for (let attempt = 0; saved.step < steps; ++attempt) {
    try {
      await run(client, steps, saved);
    } catch (error) {
      if ((error as ServiceError).code !== status.UNAVAILABLE || attempt === 30) {
        throw error;
      }
      await new Promise((resume) => setTimeout(resume, 1000));
      console.log(`continuing after ${saved.step} steps: ${(error as ServiceError).message}`);
    }
  }
  client.close();
  const mean = saved.returns.reduce((sum, value) => sum + value, 0) / saved.returns.length;
  console.log(`${saved.returns.length} episodes, mean return ${mean.toFixed(3)}`);
}

void main(process.argv[2], Number(process.argv[3]));
