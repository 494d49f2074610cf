// Pools as the live view shows them, from messages.

import { millisecondsOf, secondsOf } from "../connection/times.js";
import { kindOf } from "../run/kinds.js";
import { optionsOf } from "../run/options.js";

// A Pool as { name, displayName, labels, owner, kind, games, mode, options, envCount, ... }. Figures that there are none of yet are null.
// `gameReturns`: mean return by game, if there are several.
export function poolOf(pool) {
  const { spec } = pool;
  const hasEpisodes = pool.episodeCount > 0n;
  const ofEpisodes = (value) => (hasEpisodes ? value : null);
  return {
    name: pool.name, displayName: spec.displayName, labels: spec.labels, owner: pool.owner, kind: kindOf(pool.name), games: spec.games,
    ...optionsOf(spec.options), envCount: spec.envCount, firstEnv: spec.firstEnv, paused: pool.paused,
    createTimeS: secondsOf(pool.createTime), stepCount: Number(pool.stepCount), episodeCount: Number(pool.episodeCount),
    meanReturn: ofEpisodes(pool.meanEpisodeReturn), meanLength: ofEpisodes(pool.meanEpisodeLength),
    requestP50Ms: millisecondsOf(pool.requestDurationP50), requestP99Ms: millisecondsOf(pool.requestDurationP99),
    gameNames: pool.gameReturns.map(({ game }) => game),
  };
}

// A row of the history of a pool with these games, as a row of a Series.
export function rowOf(row, games) {
  return {
    timeS: secondsOf(row.time), stepCount: Number(row.stepCount), stepsPerSecond: row.stepsPerSecond, episodeCount: Number(row.episodeCount),
    meanReturn: row.meanEpisodeReturn, meanLength: row.meanEpisodeLength,
    requestP50Ms: toMilliseconds(row.requestDurationP50S), requestP99Ms: toMilliseconds(row.requestDurationP99S),
    returnMin: row.minEpisodeReturn, returnMax: row.maxEpisodeReturn, returnDeviation: row.episodeReturnDeviation,
    gameReturns: Object.fromEntries(games.map((game, i) => [game, Number.isNaN(row.gameReturns[i]) ? null : row.gameReturns[i]])),
  };
}

function toMilliseconds(seconds) {
  return seconds === undefined ? undefined : seconds * 1000;
}
