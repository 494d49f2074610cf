// The messages and methods of the API, from the descriptor set that the server delivers.

import { create, createFileRegistry, FileDescriptorSetSchema, fromBinary, toBinary } from "../vendor/protobuf.js";

const DESCRIPTORS = "/assets/api.binpb";
const PACKAGE = "procgen.v1";

// Messages are those of @bufbuild/protobuf: fields in camelCase, 64-bit integers as bigint, a oneof as { case, value }.
export class Api {
  #registry;

  static async load() {
    const response = await fetch(DESCRIPTORS);
    return new Api(new Uint8Array(await response.arrayBuffer()));
  }

  // `descriptors`: a serialized google.protobuf.FileDescriptorSet.
  constructor(descriptors) {
    this.#registry = createFileRegistry(fromBinary(FileDescriptorSetSchema, descriptors));
  }

  // How to call a method, such as "PoolService.GetPool": { path, encode(request), decode(bytes), decodeRequest(bytes) }.
  method(name) {
    const [serviceName, methodName] = name.split(".");
    const service = this.#registry.getService(`${PACKAGE}.${serviceName}`);
    const { input, output } = service.methods.find((each) => each.name === methodName);
    return {
      path: `/${service.typeName}/${methodName}`,
      encode: (request) => toBinary(input, create(input, request)),
      decode: (bytes) => fromBinary(output, bytes),
      decodeRequest: (bytes) => fromBinary(input, bytes),
    };
  }

  // Serializes a message of a type, such as "procgen.web.v1.BridgeRequest".
  encode(type, message) {
    const schema = this.#registry.getMessage(type);
    return toBinary(schema, create(schema, message));
  }

  decode(type, bytes) {
    return fromBinary(this.#registry.getMessage(type), bytes);
  }
}
