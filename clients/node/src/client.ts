// A connection to a server, over which pools are made and stepped.

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
  // How long to wait for the server; one that is just starting is waited for. Default: 10 000.
  timeoutMs?: number;
  // How long each call besides stepping may take. Default: 60 000.
  callTimeoutMs?: number;
  // How long a pool's stream whose connection broke tries to go on, each time; the server keeps its answers meanwhile. 0: a
  // broken connection ends the stream, and the server keeps nothing. Default: 60 000.
  reconnectTimeoutMs?: number;
  // For a server that speaks TLS or asks who calls. Default: what the environment says (credentialsFromEnvironment).
  credentials?: Credentials;
}

export type PoolSpecInit = MessageInitShape<typeof PoolSpecSchema>;

export class Client {
  readonly #connection: Connection;
  readonly #reconnectTimeoutMs: number;
  #catalog!: Catalog;

  private constructor(connection: Connection, reconnectTimeoutMs: number) {
    this.#connection = connection;
    this.#reconnectTimeoutMs = reconnectTimeoutMs;
  }

  // Connects to a server: "localhost:50051", "unix:/run/procgen.sock". UnavailableError: no server answered in time.
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

  // What the server offers: games, modes, options, actions, limits (proto/procgen/v1/catalog.proto). It does not change
  // while the server runs, so it was asked for once, on connecting.
  get catalog(): Catalog {
    return this.#catalog;
  }

  // How busy the server is at this moment.
  load(options?: CallOptions): Promise<Load> {
    return this.#connection.unary(CatalogService.method.getLoad, {}, options);
  }

  // Which servers there are in the server's cluster; it alone where it has none.
  listNodes(options?: CallOptions): Promise<ListNodesResponse> {
    return this.#connection.unary(ClusterService.method.listNodes, {}, options);
  }

  // Which servers there are: at first as they are now, then as they are after a change. Ends with UnavailableError when the
  // server stops or the connection breaks; leaving a loop over it ends the call.
  watchNodes({ signal }: Pick<CallOptions, "signal"> = {}): AsyncGenerator<WatchNodesResponse, void, void> {
    return this.#connection.serverStream(ClusterService.method.watchNodes, {}, signal);
  }

  // Makes a pool; every environment stands at the first step of its first level. `spec` is the contract's PoolSpec, whose
  // comments are the manual (proto/procgen/v1/pools.proto); `poolId`: the last part of its name.
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

  // A pool that is there already; closing it leaves it there.
  async getPool(
    name: string,
    { signal, timeoutMs, ...poolOptions }: PoolOptions & CallOptions = {},
  ): Promise<Pool> {
    const message = await this.#connection.unary(PoolService.method.getPool, { name }, { signal, timeoutMs });
    checkPool(message, name);
    return this.#pool(message, false, poolOptions);
  }

  // The pools that the caller owns, oldest first, as messages.
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

  // Ends a pool and frees its environments; a stream that is attached to it ends with AbortedError.
  async deletePool(name: string, options?: CallOptions): Promise<void> {
    await this.#connection.unary(PoolService.method.deletePool, { name }, options);
  }

  // Closes the connection; pools stay on the server until they are deleted.
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
      throw new InternalError(`the server at ${this.address} tells of no games, or of no limits`);
    }
    return catalog;
  }

  // Why the connection fails, in gRPC's words.
  async #reason(): Promise<string> {
    try {
      await this.#connection.unary(CatalogService.method.getCatalog, {}, { timeoutMs: reasonTimeoutMs });
    } catch (error) {
      return (error as ProcgenError).message;
    }
    return "it has just begun to";
  }
}

// Connects to a server; the same as Client.connect.
export function connect(address: string, options?: ClientOptions): Promise<Client> {
  return Client.connect(address, options);
}
