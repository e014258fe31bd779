import { ApiError, request } from "../../api/client";

/** About two pictures a second, and never two requests at a time. */
const EVERY_MS = 500;
const PATIENCE_MS = 5000;
/** An older picture does not show the present state of the bench. */
export const STALE_MS = 2000;

/** Time at which the camera was asked for the picture of this answer, at the earliest. */
export function takenAt(answer: Response, nowMs: number): number {
  const age = Number(answer.headers.get("X-Picture-Age-Ms") ?? Number.NaN);
  return nowMs - (Number.isFinite(age) ? age : 0);
}

/** The pictures of a run's camera, while the tab is visible. */
export class CameraFeed {
  /** Age of the picture that is shown; null before the first. */
  ageMs = $state<number | null>(null);
  /** The newest request brought no picture. */
  failing = $state(false);

  private taken = Number.NaN;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private asking = false;
  private ended = true;
  private lastAsked = Number.NEGATIVE_INFINITY;
  private abort = new AbortController();

  constructor(
    private readonly run: string,
    private readonly show: (picture: ImageBitmap) => void,
  ) {}

  readonly start = (): void => {
    this.ended = false;
    document.addEventListener("visibilitychange", this.step);
    void this.step();
  };

  readonly stop = (): void => {
    this.ended = true;
    document.removeEventListener("visibilitychange", this.step);
    clearTimeout(this.timer);
    this.abort.abort();
  };

  private readonly step = async (): Promise<void> => {
    clearTimeout(this.timer);
    if (this.ended || this.asking || document.visibilityState !== "visible") return;
    const wait = this.lastAsked + EVERY_MS - performance.now();
    if (wait <= 0) await this.ask();
    this.updateAge();
    if (!this.ended) this.timer = setTimeout(this.step, Math.max(wait, EVERY_MS / 5));
  };

  private async ask(): Promise<void> {
    this.asking = true;
    this.lastAsked = performance.now();
    this.abort = new AbortController();
    const timeout = setTimeout(() => this.abort.abort(), PATIENCE_MS);
    try {
      const answer = await request(`/runs/${encodeURIComponent(this.run)}/camera`, {
        signal: this.abort.signal,
      });
      const taken = takenAt(answer, performance.now());
      const picture = await createImageBitmap(await answer.blob());
      if (!this.ended) {
        this.show(picture);
        this.taken = taken;
        this.failing = false;
      }
      picture.close();
    } catch (error) {
      this.failing = true;
      // The run has ended, or it may not be looked at any more.
      if (error instanceof ApiError && error.status < 500 && error.status !== 429) this.stop();
    } finally {
      clearTimeout(timeout);
      this.asking = false;
    }
  }

  private updateAge(): void {
    this.ageMs = Number.isNaN(this.taken) ? null : performance.now() - this.taken;
  }
}
