import type { ClientMessage } from "./messages";

const FIRST_RETRY_MS = 250;
const LAST_RETRY_MS = 8000;
const PING_EVERY_MS = 2000;
/**
 * Pings are answered at once: after this silence the link is dead, even if the socket is still
 * open.
 */
const SILENCE_MAX_MS = 8000;
/** The timers of this tab slept: what came meanwhile has not been read, so the silence is judged
 * anew, and sooner. */
const SLEPT_MS = 3 * PING_EVERY_MS;
const SILENCE_AWAKE_MS = 3000;

export type LinkPhase = "connecting" | "open" | "waiting" | "closed";

export interface LinkEvents {
  phase(phase: LinkPhase): void;
  roundTrip(seconds: number): void;
  /** Everything but pongs. */
  text(message: { type: string }): void;
  binary(data: ArrayBuffer): void;
  /** The server refuses permanently. */
  refused(error: unknown): void;
}

export interface LinkOptions {
  /** Requests a one-time code and returns the address of the socket. */
  address: () => Promise<string>;
  isFatal: (error: unknown) => boolean;
  open?: (url: string) => WebSocket;
  now?: () => number;
  random?: () => number;
}

/** The address of /ws for a one-time code. */
export function socketAddress(code: string): string {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  return `${scheme}://${location.host}/ws?code=${encodeURIComponent(code)}`;
}

/**
 * A WebSocket that reconnects automatically: opens /ws with a new one-time code, and again after
 * a cut (after 0.25 s, doubling to 8 s, with jitter) until `close`. Its user calls `ready` when
 * the connection works.
 */
export class Link {
  private socket: WebSocket | null = null;
  private attempts = 0;
  private heardAt = 0;
  private pingedAt = 0;
  private done = false;
  private retry: ReturnType<typeof setTimeout> | undefined;
  private pings: ReturnType<typeof setInterval> | undefined;
  private readonly open: (url: string) => WebSocket;
  private readonly now: () => number;
  private readonly random: () => number;

  constructor(
    private readonly options: LinkOptions,
    private readonly events: LinkEvents,
  ) {
    this.open = options.open ?? ((url) => new WebSocket(url));
    this.now = options.now ?? (() => performance.now());
    this.random = options.random ?? Math.random;
    globalThis.addEventListener?.("online", this.back);
    globalThis.document?.addEventListener("visibilitychange", this.back);
  }

  async connect(): Promise<void> {
    if (this.done) return;
    this.events.phase("connecting");
    let url: string;
    try {
      url = await this.options.address();
    } catch (error) {
      if (this.options.isFatal(error)) {
        this.close();
        this.events.refused(error);
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

  /** The server has answered with a message of the protocol: the link works. */
  ready(): void {
    this.attempts = 0;
    this.events.phase("open");
    clearInterval(this.pings);
    this.pings = setInterval(() => this.ping(), PING_EVERY_MS);
    this.pingedAt = this.now();
    this.ping();
  }

  /** The network or the tab is available again: the pause before the next attempt ends now. */
  wake(): void {
    if (this.done) return;
    if (this.retry === undefined) {
      if (this.socket) this.ping();
      return;
    }
    clearTimeout(this.retry);
    this.retry = undefined;
    void this.connect();
  }

  private readonly back = () => document.visibilityState === "visible" && this.wake();

  send(message: ClientMessage): boolean {
    if (this.socket?.readyState !== 1) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  close(): void {
    this.done = true;
    globalThis.removeEventListener?.("online", this.back);
    globalThis.document?.removeEventListener("visibilitychange", this.back);
    clearTimeout(this.retry);
    clearInterval(this.pings);
    const socket = this.socket;
    this.socket = null;
    socket?.close();
    this.events.phase("closed");
  }

  private receive(data: ArrayBuffer | string): void {
    this.heardAt = this.now();
    if (typeof data !== "string") {
      this.events.binary(data);
      return;
    }
    const message = JSON.parse(data) as { type: string; t?: number };
    if (message.type === "pong") {
      this.events.roundTrip((this.now() - (message.t ?? 0)) / 1000);
    } else {
      this.events.text(message);
    }
  }

  private ping(): void {
    const now = this.now();
    if (now - this.pingedAt > SLEPT_MS) {
      this.heardAt = Math.max(this.heardAt, now - SILENCE_MAX_MS + SILENCE_AWAKE_MS);
    }
    this.pingedAt = now;
    if (now - this.heardAt > SILENCE_MAX_MS) {
      const socket = this.socket;
      this.lost();
      socket?.close();
      return;
    }
    this.send({ type: "ping", t: now });
  }

  private lost(): void {
    this.socket = null;
    clearInterval(this.pings);
    this.retryLater();
  }

  private retryLater(): void {
    if (this.done) return;
    this.events.phase("waiting");
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
