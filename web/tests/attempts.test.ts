import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { Attempts } from "../src/lab/attempts.svelte";

const EVERY_MS = 5000;
let answers: (Error | null)[] = [];
const asked = vi.fn(async () => {
  const answer = answers.shift();
  if (answer) throw answer;
});

beforeEach(() => {
  vi.useFakeTimers();
  asked.mockClear();
});
afterEach(() => {
  vi.useRealTimers();
});

it("fetches again when an answer has failed to come", async () => {
  answers = [new Error("no answer")];
  const attempts = new Attempts(asked);
  expect(attempts.awaited).toBe(true);
  const end = attempts.keepFresh(EVERY_MS);
  await vi.advanceTimersByTimeAsync(0);
  expect([attempts.failure !== "", attempts.loaded]).toEqual([true, false]);
  expect(attempts.awaited, "the failure is shown").toBe(false);
  await vi.advanceTimersByTimeAsync(EVERY_MS);
  expect([attempts.failure, attempts.loaded]).toEqual(["", true]);
  answers = [new Error("no answer")];
  await vi.advanceTimersByTimeAsync(EVERY_MS);
  expect([attempts.failure !== "", attempts.loaded], "what was loaded stays").toEqual([true, true]);
  end();
  await vi.advanceTimersByTimeAsync(EVERY_MS);
  expect(asked).toHaveBeenCalledTimes(3);
});

it("says a refusal until the next action, however often it fetches", async () => {
  answers = [];
  const attempts = new Attempts(asked);
  const end = attempts.keepFresh(EVERY_MS);
  await vi.advanceTimersByTimeAsync(0);
  expect(await attempts.act(() => Promise.reject(new Error("refused")))).toBe(false);
  const said = attempts.failure;
  expect(said).not.toBe("");
  await vi.advanceTimersByTimeAsync(3 * EVERY_MS);
  expect(asked).toHaveBeenCalledTimes(5);
  expect(attempts.failure).toBe(said);
  expect(await attempts.act(async () => {})).toBe(true);
  expect(attempts.failure).toBe("");
  end();
});

it("holds back what stands below it until the first answer, but not for ever", async () => {
  const attempts = new Attempts(() => new Promise(() => {}));
  void attempts.start();
  await vi.advanceTimersByTimeAsync(9_999);
  expect(attempts.awaited).toBe(true);
  await vi.advanceTimersByTimeAsync(1);
  expect([attempts.awaited, attempts.loaded]).toEqual([false, false]);
});

it("waits while it may not", async () => {
  answers = [];
  let turned = true;
  const attempts = new Attempts(asked);
  const end = attempts.keepFresh(EVERY_MS, () => !turned);
  await vi.advanceTimersByTimeAsync(2 * EVERY_MS);
  expect(asked).toHaveBeenCalledTimes(1);
  turned = false;
  await vi.advanceTimersByTimeAsync(EVERY_MS);
  expect(asked).toHaveBeenCalledTimes(2);
  end();
});
