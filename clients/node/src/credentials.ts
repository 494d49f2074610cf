// TLS certificates and token of a client.

import { readFileSync } from "node:fs";
import { BlockList, isIP } from "node:net";
import { credentials as grpcCredentials, Metadata, type ChannelCredentials } from "@grpc/grpc-js";
import { InvalidArgumentError, NotFoundError } from "./errors.js";

// PEM fields are bytes, or the path of a file.
export interface Credentials {
  // CA certificates of the server. Set: the client uses TLS. Absent: plain text.
  ca?: string | Uint8Array;
  // Client certificate, for servers that require one; requires `key` and `ca`.
  certificate?: string | Uint8Array;
  // Key of `certificate`.
  key?: string | Uint8Array;
  // Token for servers that require one. Without TLS it is sent to this machine only (loopback, unix
  // sockets), unless `tokenInPlainText`.
  token?: string;
  tokenInPlainText?: boolean;
}

// Reads PROCGEN_SERVER_CA, _CERTIFICATE, _KEY (paths) and _TOKEN (the token itself); each is
// optional.
export function credentialsFromEnvironment(): Credentials {
  const variable = (name: string) => process.env[`PROCGEN_SERVER_${name}`] || undefined;
  return {
    ca: variable("CA"), certificate: variable("CERTIFICATE"), key: variable("KEY"), token: variable("TOKEN"),
  };
}

// Converts credentials to gRPC's. Throws InvalidArgumentError: a certificate without its key or
// without `ca`, or a token that would be sent to another machine in plain text. NotFoundError: a
// file cannot be read.
export function channelCredentials(given: Credentials, address: string): ChannelCredentials {
  if ((given.certificate === undefined) !== (given.key === undefined)) {
    throw new InvalidArgumentError("a client certificate or its key is given alone; give both or none");
  }
  if (given.ca !== undefined) {
    return grpcCredentials.createSsl(pem(given.ca, "ca"), pem(given.key, "key"), pem(given.certificate, "certificate"));
  }
  if (given.certificate !== undefined) {
    throw new InvalidArgumentError(
      "a client certificate is given without the server's CA certificates; give ca, or set PROCGEN_SERVER_CA",
    );
  }
  if (given.token && !given.tokenInPlainText && !isThisMachine(address)) {
    throw new InvalidArgumentError(
      `the token would go to ${address} in plain text; give the server's CA certificates (ca, or PROCGEN_SERVER_CA), or ` +
        "set tokenInPlainText",
    );
  }
  return grpcCredentials.createInsecure();
}

// Metadata of each call.
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

// Whether the address is loopback or a unix socket, where plain text is safe.
export function isThisMachine(address: string): boolean {
  if (address.startsWith("unix:")) {
    return true;
  }
  const host = address.replace(/^dns:\/\/\//, "").replace(/:[^:]*$/, "").replace(/^\[(.*)\]$/, "$1");
  // Parses the whole host: "127.0.0.1.example.com" is a name.
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
