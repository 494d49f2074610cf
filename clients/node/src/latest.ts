// What a call tells again and again, each time anew and whole.

import type { ClientReadableStream } from "@grpc/grpc-js";

// Gives a call's messages as they come. Who takes long between two of them gets the latest of those that came meanwhile and
// misses the others, for which there would be room in buffers of megabytes. Ends as the call does.
export async function* latestOf<Message>(call: ClientReadableStream<Message>): AsyncGenerator<Message, void, void> {
  const told: { latest?: Message; failure?: Error; isOver: boolean } = { isOver: false };
  let wake = () => {};
  call.on("data", (message: Message) => {
    told.latest = message;
    wake();
  });
  call.on("error", (error: Error) => {
    told.failure = error;
  });
  call.on("end", () => { // After an error, too.
    told.isOver = true;
    wake();
  });
  for (;;) {
    const { latest } = told;
    if (latest !== undefined) {
      told.latest = undefined;
      yield latest;
    } else if (told.isOver) {
      break;
    } else {
      await new Promise<void>((resolve) => (wake = resolve));
    }
  }
  if (told.failure !== undefined) {
    throw told.failure;
  }
}
