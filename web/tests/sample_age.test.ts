import { expect, test } from "vitest";
import { SampleAge } from "../src/live/sample_age";

test("a silence grows while the page looks, and ends with a sample", () => {
  const age = new SampleAge(10);
  expect(age.at(10.2)).toBeCloseTo(0.2);
  expect(age.at(10.9)).toBeCloseTo(0.9);
  age.heard(11);
  expect(age.at(11)).toBe(0);
});

test("the sleep of the page is not the rig's silence; what was late before still is", () => {
  const age = new SampleAge(10);
  expect(age.at(10.6)).toBeCloseTo(0.6);
  expect(age.at(70.6)).toBeCloseTo(0.6);
  expect(age.at(71.2)).toBeCloseTo(1.2);
});
