import { decodeFrame, type SampleBlock } from "./frame";
import type { ClientMessage, Hello, ServerMessage } from "./messages";

const FIRST_RETRY_MS = 250;
const LAST_RETRY_MS = 8000;
const PING_EVERY_MS = 2000;
/** Pings are answered at once: after this silence the link is dead, whatever the socket says. */
const SILENCE_MAX_MS = 8000;

export type LinkPhase = "connecting" | "open" | "waiting" | "closed";

export interface RunSocketEvents {
  /** The stream is open; `resumeFrom` was asked of the server. */
  hello(message: Hello): void;
  block(block: SampleBlock): void;
  message(message: Exclude<ServerMessage, Hello>): void;
  phase(phase: LinkPhase): void;
  roundTrip(seconds: number): void;
  /** The server refuses the stream for good (no such run, not allowed). */
  refused(error: unknown): void;
}

export interface RunSocketOptions {
  /** Fetches a one-time code and gives the address of the socket. */
  address: () => Promise<string>;
  /** Index of the first sample not yet here; asked for after every (re)connect. */
  nextIndex: () => number;
  isFatal: (error: unknown) => boolean;
  events: RunSocketEvents;
  open?: (url: string) => WebSocket;
  now?: () => number;
  random?: () => number;
}

/**
 * The live stream of one run: opens /ws with a fresh one-time code, asks for what it missed, and
 * comes back by itself after a cut (0.25 s, doubling to 8 s, with jitter) until `close` or the end.
 */
export class RunSocket {
  private socket: WebSocket | null = null;
  private attempts = 0;
  private heardAt = 0;
  private done = false;
  private retry: ReturnType<typeof setTimeout> | undefined;
  private pings: ReturnType<typeof setInterval> | undefined;
  private readonly open: (url: string) => WebSocket;
  private readonly now: () => number;
  private readonly random: () => number;

  constructor(private readonly options: RunSocketOptions) {
    this.open = options.open ?? ((url) => new WebSocket(url));
    this.now = options.now ?? (() => performance.now());
    this.random = options.random ?? Math.random;
  }

  async connect(): Promise<void> {
    if (this.done) return;
    this.options.events.phase("connecting");
    let url: string;
    try {
      url = await this.options.address();
    } catch (error) {
      if (this.options.isFatal(error)) {
        this.close();
        this.options.events.refused(error);
      } else {
        this.retryLater();
      }
      return;
    }
    if (this.done) return;
    const socket = this.open(url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onmessage = (event: MessageEvent) => this.receive(event.data);
    socket.onclose = () => {
      if (this.socket === socket) this.lost();
    };
  }

  /** The network or the tab is back: a pause before the next attempt ends now. */
  wake(): void {
    if (this.done || this.retry === undefined) return;
    clearTimeout(this.retry);
    this.retry = undefined;
    void this.connect();
  }

  send(message: ClientMessage): boolean {
    if (this.socket?.readyState !== 1) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  close(): void {
    this.done = true;
    clearTimeout(this.retry);
    clearInterval(this.pings);
    const socket = this.socket;
    this.socket = null;
    socket?.close();
    this.options.events.phase("closed");
  }

  private receive(data: ArrayBuffer | string): void {
    this.heardAt = this.now();
    if (typeof data !== "string") {
      this.options.events.block(decodeFrame(data));
      return;
    }
    const message = JSON.parse(data) as ServerMessage;
    if (message.type === "hello") {
      this.attempts = 0;
      this.options.events.phase("open");
      this.options.events.hello(message);
      this.send({ type: "resume", since: this.options.nextIndex() });
      clearInterval(this.pings);
      this.ping();
      this.pings = setInterval(() => this.ping(), PING_EVERY_MS);
    } else if (message.type === "pong") {
      this.options.events.roundTrip((this.now() - message.t) / 1000);
    } else {
      if (message.type === "end") this.done = true;
      this.options.events.message(message);
      if (message.type === "end") this.close();
    }
  }

  private ping(): void {
    if (this.now() - this.heardAt > SILENCE_MAX_MS) {
      const socket = this.socket;
      this.lost();
      socket?.close();
      return;
    }
    this.send({ type: "ping", t: this.now() });
  }

  private lost(): void {
    this.socket = null;
    clearInterval(this.pings);
    this.retryLater();
  }

  private retryLater(): void {
    if (this.done) return;
    this.options.events.phase("waiting");
    const pause = Math.min(LAST_RETRY_MS, FIRST_RETRY_MS * 2 ** this.attempts);
    this.attempts++;
    this.retry = setTimeout(
      () => {
        this.retry = undefined;
        void this.connect();
      },
      pause * (0.5 + this.random() / 2),
    );
  }
}
