import { call } from "../api/client";
import type { Job, MethodsCompared } from "../contract/types";
import { wordsOf } from "../i18n/words";

const LOOK_EVERY_MS = 500;
/** The newest job of each run that this page has opened: a tab that is opened again goes on. */
const begun = new Map<string, string>();

/**
 * The job that compares all methods on one run. What they have said so far is there while it goes
 * on.
 */
export class MethodComparison {
  failure = $state("");
  found = $state.raw<MethodsCompared | null>(null);
  private job = $state.raw<Job | null>(null);
  private timer: ReturnType<typeof setTimeout> | undefined;
  private left = false;

  constructor(private readonly run: string) {}

  get busy(): boolean {
    return this.job?.state === "waiting" || this.job?.state === "running";
  }

  get progress(): number {
    return this.job?.progress ?? 0;
  }

  /** Returns what ends it: the job itself goes on. */
  follow(): () => void {
    const id = begun.get(this.run);
    if (id) void this.look(id);
    return () => {
      this.left = true;
      clearTimeout(this.timer);
    };
  }

  async begin(): Promise<void> {
    this.failure = "";
    try {
      const runs = [{ methods: { recording: this.run } }];
      const { items } = await call("POST /jobs", {}, { body: { runs } });
      const job = items[0] as Job;
      begun.set(this.run, job.id);
      this.take(job);
    } catch (error) {
      this.failure = wordsOf(error);
    }
  }

  async cancel(): Promise<void> {
    if (!this.job) return;
    await call("DELETE /jobs/{id}", { id: this.job.id }).catch(() => {}); // it may have ended meanwhile
  }

  private take(job: Job): void {
    this.job = job;
    if (job.methods) this.found = job.methods;
    if (job.state === "failed") this.failure = job.error ?? "";
    if (this.busy && !this.left) {
      this.timer = setTimeout(() => void this.look(job.id), LOOK_EVERY_MS);
    }
  }

  private async look(id: string): Promise<void> {
    try {
      this.take(await call("GET /jobs/{id}", { id }));
    } catch (error) {
      this.failure = wordsOf(error);
      this.job = null;
    }
  }
}
