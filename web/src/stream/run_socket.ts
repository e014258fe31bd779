import { decodeFrame, type SampleBlock } from "./frame";
import { Link, type LinkEvents, type LinkOptions } from "./link";

export { socketAddress } from "./link";

import type { ClientMessage, Hello, ServerMessage } from "./messages";

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
export class RunSocket {
  private readonly link: Link;

  constructor(private readonly options: RunSocketOptions) {
    const { events } = options;
    this.link = new Link(options, {
      phase: (phase) => events.phase(phase),
      roundTrip: (seconds) => events.roundTrip(seconds),
      refused: (error) => events.refused(error),
      binary: (data) => events.block(decodeFrame(data)),
      text: (message) => this.receive(message as ServerMessage),
    });
  }

  connect(): Promise<void> {
    return this.link.connect();
  }

  wake(): void {
    this.link.wake();
  }

  send(message: ClientMessage): boolean {
    return this.link.send(message);
  }

  close(): void {
    this.link.close();
  }

  private receive(message: ServerMessage): void {
    if (message.type === "hello") {
      this.link.ready();
      this.options.events.hello(message);
      this.send({ type: "resume", since: this.options.nextIndex() });
      return;
    }
    this.options.events.message(message);
    if (message.type === "end") this.close();
  }
}
