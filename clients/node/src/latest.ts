// Conflates a server stream: a slow reader gets the latest message.

import type { ClientReadableStream } from "@grpc/grpc-js";

// Yields a call's messages. A reader that is slower than the call gets the latest message and skips
// those before, which gRPC would otherwise buffer. Ends, or throws, as the call does.
export async function* latestOf<Message>(call: ClientReadableStream<Message>): AsyncGenerator<Message, void, void> {
  const state: { latest?: Message; failure?: Error; isOver: boolean } = { isOver: false };
  let wake = () => {};
  call.on("data", (message: Message) => {
    state.latest = message;
    wake();
  });
  call.on("error", (error: Error) => {
    state.failure = error;
  });
  call.on("end", () => { // Also after an error.
    state.isOver = true;
    wake();
  });
  for (;;) {
    const { latest } = state;
    if (latest !== undefined) {
      state.latest = undefined;
      yield latest;
    } else if (state.isOver) {
      break;
    } else {
      await new Promise<void>((resolve) => (wake = resolve));
    }
  }
  if (state.failure !== undefined) {
    throw state.failure;
  }
}
