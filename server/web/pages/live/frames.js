// What the frames of a watch say beside their images.

// The episode that a frame shows the end of: { return, length, levelSeed, levelComplete, truncated }, or null.
export function episodeOf(episode) {
  return episode ? {
    return: episode.episodeReturn, length: episode.episodeLength, levelSeed: episode.levelSeed, levelComplete: episode.levelComplete,
    truncated: episode.truncated,
  } : null;
}

// A step of an environment: { action: null at the start of an episode, reward, return, length, levelSeed, annotations }, or undefined.
// Values that are not finite are null.
export function stepOf(step) {
  return step && {
    action: step.action ?? null, reward: step.reward, return: step.episodeReturn, length: step.episodeLength, levelSeed: step.levelSeed,
    annotations: step.annotations.map(({ name, values }) => ({ name, values: values.map((value) => (Number.isFinite(value) ? value : null)) })),
  };
}
