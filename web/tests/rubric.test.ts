import { describe, expect, it } from "vitest";
import { rubricDraft, rubricOf } from "../src/course/rubric";

describe("a rubric as people write it", () => {
  it("comes back as it was", () => {
    const rubric = {
      detection: 1,
      isolation: 2,
      value: 3,
      confidence: 4,
      full_within: 0.07,
      late_h: 36,
      late_percent_a_day: 25,
      time_limit_min: 25,
      hint_percent: 15,
      counts: "last" as const,
      uploads_wait: true,
    };
    expect(rubricDraft(rubric)).toMatchObject({ within: 7, lateDays: 1.5, latePercent: 25 });
    expect(rubricOf(rubricDraft(rubric))).toEqual(rubric);
  });
  it("takes no late answers unless it says so", () => {
    const draft = rubricDraft({});
    expect(draft).toMatchObject({ isolation: 40, lateDays: 0, latePercent: 20 });
    expect(rubricOf(draft)).toMatchObject({ late_h: 0, late_percent_a_day: 0 });
    expect(rubricOf({ ...draft, lateDays: 2 })).toMatchObject({
      late_h: 48,
      late_percent_a_day: 20,
    });
  });
});
