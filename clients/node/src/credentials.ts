// How a client knows its server, and what it shows to it.

import { readFileSync } from "node:fs";
import { BlockList, isIP } from "node:net";
import { credentials as grpcCredentials, Metadata, type ChannelCredentials } from "@grpc/grpc-js";
import { InvalidArgumentError, NotFoundError } from "./errors.js";

// PEM is given as bytes, or as the path of a file.
export interface Credentials {
  // Certificates that vouch for the server. Given: TLS is spoken. Absent: plain text.
  ca?: string | Uint8Array;
  // The client's own, for servers that ask for one; with `key` and `ca`.
  certificate?: string | Uint8Array;
  // The key of `certificate`.
  key?: string | Uint8Array;
  // Bears out who calls, for servers with tokens. Without TLS it is sent to this machine only (loopback, unix
  // sockets), unless `tokenInPlainText`.
  token?: string;
  tokenInPlainText?: boolean;
}

// What PROCGEN_SERVER_CA, _CERTIFICATE, _KEY (paths) and _TOKEN (the token itself) say, if they are there.
export function credentialsFromEnvironment(): Credentials {
  const said = (name: string) => process.env[`PROCGEN_SERVER_${name}`] || undefined;
  return { ca: said("CA"), certificate: said("CERTIFICATE"), key: said("KEY"), token: said("TOKEN") };
}

// For gRPC. Throws InvalidArgumentError for a certificate without its key or without `ca`, and for a token that would be
// sent to another machine in plain text; NotFoundError where a file cannot be read.
export function channelCredentials(given: Credentials, address: string): ChannelCredentials {
  if ((given.certificate === undefined) !== (given.key === undefined)) {
    throw new InvalidArgumentError("a client's certificate or its key is given alone; give both or none");
  }
  if (given.ca !== undefined) {
    return grpcCredentials.createSsl(pem(given.ca, "ca"), pem(given.key, "key"), pem(given.certificate, "certificate"));
  }
  if (given.certificate !== undefined) {
    throw new InvalidArgumentError(
      "a client's certificate is given without certificates that vouch for the server; give ca, or set PROCGEN_SERVER_CA",
    );
  }
  if (given.token && !given.tokenInPlainText && !isThisMachine(address)) {
    throw new InvalidArgumentError(
      `the token would go to ${address} in plain text; give certificates that vouch for the server (ca, or ` +
        "PROCGEN_SERVER_CA), or say tokenInPlainText",
    );
  }
  return grpcCredentials.createInsecure();
}

// What each call bears.
export function callMetadata(given: Credentials, waitForReady: boolean): Metadata {
  const metadata = new Metadata({ waitForReady });
  if (given.token) {
    metadata.set("authorization", `Bearer ${given.token}`);
  }
  return metadata;
}

const loopback = new BlockList();
loopback.addSubnet("127.0.0.0", 8);
loopback.addAddress("::1", "ipv6");

// Whether nobody else can listen on the way to `address`.
export function isThisMachine(address: string): boolean {
  if (address.startsWith("unix:")) {
    return true;
  }
  const host = address.replace(/^dns:\/\/\//, "").replace(/:[^:]*$/, "").replace(/^\[(.*)\]$/, "$1");
  // By its exact form: "127.0.0.1.example.com" is a name.
  const version = isIP(host);
  return host.toLowerCase() === "localhost" || (version !== 0 && loopback.check(host, version === 4 ? "ipv4" : "ipv6"));
}

function pem(given: string | Uint8Array | undefined, name: string): Buffer | null {
  if (given === undefined) {
    return null;
  }
  if (typeof given !== "string") {
    return Buffer.from(given);
  }
  try {
    return readFileSync(given);
  } catch (error) {
    throw new NotFoundError(`${name} is ${given}: ${(error as Error).message}`, { cause: error });
  }
}
