// A random agent: node examples/random_agent.js [ADDRESS [GAME]]
import { connect } from "procgen-client";

const [address = "localhost:50051", game = "coinrun"] = process.argv.slice(2);
const client = await connect(address);
const pool = await client.createPool({ games: [game], envCount: 64 });
const policy = () => Array.from({ length: 64 }, () => Math.floor(Math.random() * 15));
let episodes = 0;
for await (const batch of pool.rollout(policy, { stepCount: 1000 })) {
  episodes += batch.fingerprints.length; // One for each episode that ended.
}
console.log(`${episodes} episodes of ${game}`);
await pool.close();
client.close();
