// Client for Procgen Server. README.md has examples.

export { Client, connect, type ClientOptions, type PoolSpecInit } from "./client.js";
export type { CallOptions } from "./connection.js";
export { credentialsFromEnvironment, type Credentials } from "./credentials.js";
export { observationOf, type Batch, type BatchArrays, type Part } from "./batch.js";
export {
  Pool,
  type AttachOptions, type PoolOptions, type RolloutOptions, type Reset, type SliceOptions, type StepOptions,
} from "./pool.js";
export type { CloneSource, WatchOptions } from "./pool_resource.js";
export { ServerProcess, type ServerProcessOptions } from "./server_process.js";
export { ObservationDecoder } from "./encoding.js";
export * from "./errors.js";
export * from "./generated/procgen/v1/catalog_pb.js";
export { NodeRole, type ListNodesResponse, type Node, type WatchNodesResponse } from "./generated/procgen/v1/cluster_pb.js";
export {
  AutoresetMode, Color, DistributionMode, Encoding, Layout, PoolSchema, PoolSpecSchema, Transport,
  type EnvironmentOptions, type LevelSampler, type ObservationFormat, type Pool as PoolMessage, type PoolSpec,
} from "./generated/procgen/v1/pools_pb.js";
export type { Frame, WatchPoolResponse } from "./generated/procgen/v1/render_pb.js";
export {
  EpisodeOutcome, EpisodeSelector, IncompleteReason, type Episode, type LevelChange,
} from "./generated/procgen/v1/states_pb.js";
export {
  StepPoolRequestSchema, StepPoolResponseSchema,
  type StepPoolRequest, type StepPoolResponse,
} from "./generated/procgen/v1/step_pb.js";
