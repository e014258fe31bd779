import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Announcer } from "../src/shell/announcer.svelte";

describe("Announcer", () => {
  beforeEach(() => {
    vi.useFakeTimers();
  });
  afterEach(() => {
    vi.useRealTimers();
  });

  it("says one message in 2 s, in order", () => {
    const announcer = new Announcer();
    announcer.say("start", "started");
    announcer.say("fault", "fault");
    announcer.say("detected", "detected");
    expect(announcer.message).toBe("started");
    vi.advanceTimersByTime(1999);
    expect(announcer.message).toBe("started");
    vi.advanceTimersByTime(1);
    expect(announcer.message).toBe("fault");
    vi.advanceTimersByTime(2000);
    expect(announcer.message).toBe("detected");
  });

  it("drops an older message of the same kind that still waits", () => {
    const announcer = new Announcer();
    announcer.say("start", "started");
    announcer.say("link", "lost");
    announcer.say("link", "back");
    vi.advanceTimersByTime(2000);
    expect(announcer.message).toBe("back");
    vi.advanceTimersByTime(60_000);
    announcer.say("end", "over");
    expect(announcer.message).toBe("over");
  });
});
