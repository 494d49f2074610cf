// Client: a connection to a server.

import type { MessageInitShape } from "@bufbuild/protobuf";
import { Connection, type CallOptions } from "./connection.js";
import { credentialsFromEnvironment, type Credentials } from "./credentials.js";
import { DeadlineExceededError, InternalError, ProcgenError, UnavailableError, UnimplementedError } from "./errors.js";
import { CatalogService, type Catalog, type Load } from "./generated/procgen/v1/catalog_pb.js";
import { ClusterService, type ListNodesResponse, type WatchNodesResponse } from "./generated/procgen/v1/cluster_pb.js";
import {
  PoolService, Transport,
  type Pool as PoolMessage, type PoolSpecSchema,
} from "./generated/procgen/v1/pools_pb.js";
import { Pool, type PoolOptions } from "./pool.js";
import { callTimeoutDefaultMs, connectTimeoutDefaultMs, reasonTimeoutMs, reconnectTimeoutDefaultMs } from "./timing.js";
import { checkPool, poolPagesMax } from "./validation.js";

export interface ClientOptions {
  // Timeout of connect, in milliseconds; it waits for a server that is starting. Default: 10 000.
  timeoutMs?: number;
  // Timeout of each unary call, in milliseconds. Default: 60 000.
  callTimeoutMs?: number;
  // Time that a pool's stream tries to resume after a broken connection, in milliseconds. The
  // server keeps its answers meanwhile. 0: a broken connection ends the stream, and the server
  // keeps nothing. Default: 60 000.
  reconnectTimeoutMs?: number;
  // TLS certificates and token. Default: credentialsFromEnvironment().
  credentials?: Credentials;
}

export type PoolSpecInit = MessageInitShape<typeof PoolSpecSchema>;

// A connection to a server. Creates pools and returns existing ones.
export class Client {
  readonly #connection: Connection;
  readonly #reconnectTimeoutMs: number;
  #catalog!: Catalog;

  private constructor(connection: Connection, reconnectTimeoutMs: number) {
    this.#connection = connection;
    this.#reconnectTimeoutMs = reconnectTimeoutMs;
  }

  // Connects to a server: "localhost:50051", "unix:/run/procgen.sock".
  // Throws UnavailableError: no server answered in time.
  static async connect(
    address: string,
    {
      timeoutMs = connectTimeoutDefaultMs,
      callTimeoutMs = callTimeoutDefaultMs,
      reconnectTimeoutMs = reconnectTimeoutDefaultMs,
      credentials = credentialsFromEnvironment(),
    }: ClientOptions = {},
  ): Promise<Client> {
    const client = new Client(new Connection(address, callTimeoutMs, credentials), reconnectTimeoutMs);
    try {
      client.#catalog = await client.#firstCatalog(timeoutMs);
    } catch (error) {
      client.close();
      throw error;
    }
    return client;
  }

  get address(): string {
    return this.#connection.address;
  }

  // What the server offers: games, modes, options, actions, limits
  // (proto/procgen/v1/catalog.proto). Constant while the server runs; fetched once by connect.
  get catalog(): Catalog {
    return this.#catalog;
  }

  // Returns the current load of the server.
  load(options?: CallOptions): Promise<Load> {
    return this.#connection.unary(CatalogService.method.getLoad, {}, options);
  }

  // Returns the servers of the cluster, or this server if it is in none.
  listNodes(options?: CallOptions): Promise<ListNodesResponse> {
    return this.#connection.unary(ClusterService.method.listNodes, {}, options);
  }

  // Yields the servers of the cluster now, and again after each change. Throws UnavailableError
  // when the server stops or the connection breaks. Leaving the loop ends the call.
  watchNodes({ signal }: Pick<CallOptions, "signal"> = {}): AsyncGenerator<WatchNodesResponse, void, void> {
    return this.#connection.serverStream(ClusterService.method.watchNodes, {}, signal);
  }

  // Creates a pool; every environment is at the first step of its first level. `spec`: a PoolSpec
  // (proto/procgen/v1/pools.proto). `poolId`: last part of its name; default: chosen by the server.
  // Throws UnimplementedError: spec.transport is SHARED_MEMORY.
  async createPool(
    spec: PoolSpecInit,
    { poolId = "", signal, timeoutMs, ...poolOptions }: { poolId?: string } & PoolOptions & CallOptions = {},
  ): Promise<Pool> {
    if (spec.transport === Transport.SHARED_MEMORY) {
      throw new UnimplementedError("Node.js cannot map memory without native code; transport is TRANSPORT_STREAM here");
    }
    const options = { signal, timeoutMs };
    const message = await this.#connection.unary(PoolService.method.createPool, { poolId, spec }, options);
    checkPool(message, poolId === "" ? undefined : `pools/${poolId}`, spec.envCount);
    return this.#pool(message, true, poolOptions);
  }

  // Returns an existing pool; close() does not delete it.
  async getPool(
    name: string,
    { signal, timeoutMs, ...poolOptions }: PoolOptions & CallOptions = {},
  ): Promise<Pool> {
    const message = await this.#connection.unary(PoolService.method.getPool, { name }, { signal, timeoutMs });
    checkPool(message, name);
    return this.#pool(message, false, poolOptions);
  }

  // Yields the caller's pools, oldest first, as messages.
  async *listPools(options?: CallOptions): AsyncGenerator<PoolMessage, void, void> {
    const request = { pageToken: "" };
    for (let i = 0; i < poolPagesMax; i += 1) {
      const page = await this.#connection.unary(PoolService.method.listPools, request, options);
      yield* page.pools;
      request.pageToken = page.nextPageToken;
      if (request.pageToken === "") {
        return;
      }
    }
    throw new InternalError(`the server's answer: a list of pools of more than ${poolPagesMax} pages, expected: an end`);
  }

  // Deletes a pool; an attached stream ends with AbortedError.
  async deletePool(name: string, options?: CallOptions): Promise<void> {
    await this.#connection.unary(PoolService.method.deletePool, { name }, options);
  }

  // Closes the connection; pools stay on the server until they are deleted or their lease expires.
  close(): void {
    this.#connection.close();
  }

  #pool(message: PoolMessage, deletesOnClose: boolean, options: PoolOptions): Pool {
    return new Pool(this.#connection, message, {
      ...options,
      deletesOnClose,
      reconnectTimeoutMs: this.#reconnectTimeoutMs,
      limits: this.#catalog.limits!,
    });
  }

  async #firstCatalog(timeoutMs: number): Promise<Catalog> {
    let catalog: Catalog;
    try {
      catalog = await this.#connection.unary(CatalogService.method.getCatalog, {}, { timeoutMs }, true);
    } catch (error) {
      if (!(error instanceof DeadlineExceededError)) {
        throw error;
      }
      throw new UnavailableError(
        `no server answers at ${this.address} (${await this.#reason()}); waited ${timeoutMs / 1000} s`,
      );
    }
    if (catalog.games.length === 0 || catalog.limits === undefined) {
      throw new InternalError(`the server at ${this.address} has a catalog without games or limits`);
    }
    return catalog;
  }

  // Returns gRPC's error text for the failed connection.
  async #reason(): Promise<string> {
    try {
      await this.#connection.unary(CatalogService.method.getCatalog, {}, { timeoutMs: reasonTimeoutMs });
    } catch (error) {
      return (error as ProcgenError).message;
    }
    return "it has just started to answer";
  }
}

// Connects to a server. Same as Client.connect.
export function connect(address: string, options?: ClientOptions): Promise<Client> {
  return Client.connect(address, options);
}
