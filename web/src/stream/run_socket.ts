import { decodeFrame, type SampleBlock } from "./frame";
import { Link, type LinkEvents, type LinkOptions } from "./link";

export { socketAddress } from "./link";

import type { Hello, ServerMessage } from "./messages";

export interface RunSocketEvents extends Pick<LinkEvents, "phase" | "roundTrip" | "refused"> {
  /** The stream is open; missing samples have been requested from the server. */
  hello(message: Hello): void;
  block(block: SampleBlock): void;
  message(message: Exclude<ServerMessage, Hello>): void;
}

export interface RunSocketOptions extends LinkOptions {
  /** Index of the first missing sample; it is requested after every (re)connection. */
  nextIndex: () => number;
  events: RunSocketEvents;
}

/**
 * The live stream of one run over a link: requests missing samples, and closes at the end of the
 * run.
 */
export function runSocket({ events, nextIndex, ...options }: RunSocketOptions): Link {
  const link: Link = new Link(options, {
    ...events,
    binary: (data) => events.block(decodeFrame(data)),
    text: (text) => {
      const message = text as ServerMessage;
      if (message.type === "hello") {
        link.ready();
        events.hello(message);
        link.send({ type: "resume", since: nextIndex() });
      } else events.message(message);
      if (message.type === "end") link.close();
    },
  });
  return link;
}
