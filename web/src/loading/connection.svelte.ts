const FIRST_PAUSE_MS = 250;
const LAST_PAUSE_MS = 4000;
const ANSWER_MS = 5000;
/** A server that is behind a proxy and away. */
const AWAY = [502, 504];

/** Whether this answer comes from the server itself. */
export const answered = (response: Response) => !AWAY.includes(response.status);

/**
 * Whether the server answers. When a request has got no answer, one probe asks until the server
 * answers (after 0.25 s, doubling to 4 s, with jitter; at once when the network or the tab comes
 * back), and whoever waits for it goes on.
 */
export class Connection {
  /** The server has not answered the probe either: the page says so. */
  away = $state(false);
  /** How often the server was away. */
  outages = 0;
  private probe: Promise<void> | null = null;
  private hurry: () => void = () => {};

  constructor(private readonly ask: () => Promise<boolean> = asksHealth) {
    const wake = () => document.visibilityState === "visible" && this.hurry();
    globalThis.addEventListener?.("online", wake);
    globalThis.document?.addEventListener("visibilitychange", wake);
  }

  /** Resolves when the server answers; the caller's request had no answer. */
  again(): Promise<void> {
    this.probe ??= this.search().finally(() => {
      this.probe = null;
      this.away = false;
    });
    return this.probe;
  }

  /** Asks once; resolves when the server answers. */
  async check(): Promise<void> {
    if (!(await this.ask())) await this.again();
  }

  private async search(): Promise<void> {
    for (let pause = FIRST_PAUSE_MS; ; pause = Math.min(LAST_PAUSE_MS, 2 * pause)) {
      await new Promise<void>((resume) => {
        const timer = setTimeout(resume, pause * (0.5 + Math.random() / 2));
        this.hurry = () => {
          clearTimeout(timer);
          resume();
        };
      });
      if (await this.ask()) return;
      if (!this.away) this.outages++;
      this.away = true;
    }
  }
}

async function asksHealth(): Promise<boolean> {
  try {
    const signal = AbortSignal.timeout(ANSWER_MS);
    const response = await fetch("/healthz", { cache: "no-store", signal });
    await response.text();
    return answered(response);
  } catch {
    return false;
  }
}

export const connection = new Connection();
