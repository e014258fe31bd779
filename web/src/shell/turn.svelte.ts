import { ApiError } from "../api/client";

const SECOND_MS = 1000;

/**
 * Asks for a run until it is one's turn: where all simulators are in use, the server says which
 * place in line one has, and keeps it for whoever asks again in time.
 */
export class Turn {
  /** 1: the next; null: not in line. */
  place = $state<number | null>(null);
  seconds = $state(0);
  private left = false;
  private wake: () => void = () => {};

  /** @returns null when the line was left */
  async await<T>(ask: () => Promise<T>): Promise<T | null> {
    this.left = false;
    try {
      while (!this.left) {
        try {
          return await ask();
        } catch (error) {
          await this.stand(error);
        }
      }
      return null;
    } finally {
      this.place = null;
    }
  }

  leave(): void {
    this.left = true;
    this.wake();
  }

  /** Waits to ask again; what is no place in line is thrown. */
  private async stand(error: unknown): Promise<void> {
    const told = error instanceof ApiError && error.problem.reason === "in_line";
    if (!told) throw error;
    const { place, seconds, again_s } = error.problem.parameters ?? {};
    this.place = Number(place);
    this.seconds = Number(seconds);
    if (this.left) return;
    await new Promise<void>((resolve) => {
      this.wake = resolve;
      setTimeout(resolve, Number(again_s) * SECOND_MS);
    });
  }
}
