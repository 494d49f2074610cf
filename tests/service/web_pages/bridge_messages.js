// The messages between a page and its server, decoded.

import { Api } from "../../../server/web/pages/connection/api.js";

const REQUEST = "procgen.web.v1.BridgeRequest";
const RESPONSE = "procgen.web.v1.BridgeResponse";

// Decodes the messages of a page from now on. `onSent(request)` and `onReceived(response)` are called with { call, method, message,
// length: bytes on the socket, time: by performance.now() } for each message of a call; `method` is such as "RunPool". Returns a promise
// that resolves when the page may be opened. `server`: its descriptors.
export async function decodeMessages(page, server, { onSent = () => {}, onReceived = () => {} }) {
  const response = await fetch(server.page("/assets/api.binpb"));
  const api = new Api(new Uint8Array(await response.arrayBuffer()));
  const methods = new Map();  // by number of the call
  page.on("websocket", (socket) => {
    socket.on("framesent", ({ payload }) => {
      const { call, request: { case: kind, value } } = api.decode(REQUEST, payload);
      if (kind === "method") {
        const [service, method] = value.split("/").slice(1);
        methods.set(call, { name: method, ...api.method(`${service.split(".").at(-1)}.${method}`) });
      } else if (kind === "message") {
        const { name, decodeRequest } = methods.get(call);
        onSent({ call, method: name, message: decodeRequest(value), length: payload.length, time: performance.now() });
      }
    });
    socket.on("framereceived", ({ payload }) => {
      const { call, response: { case: kind, value } } = api.decode(RESPONSE, payload);
      if (kind === "message") {
        const { name, decode } = methods.get(call);
        onReceived({ call, method: name, message: decode(value), length: payload.length, time: performance.now() });
      }
    });
  });
}
