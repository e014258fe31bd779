import { expect, it } from "vitest";
import { t } from "../src/i18n/i18n.svelte";
import { typedNumber } from "../src/i18n/numbers";
import { numberComplaint } from "../src/shell/number_complaint";

it("a number that is needed and left empty is asked for", () => {
  const wanted = t("number_wanted");
  expect(wanted).not.toBe("");
  expect(numberComplaint("", { min: 10, max: 300, whole: true })).toBe(wanted);
  expect(numberComplaint(" ", {})).toBe(wanted);
  expect(numberComplaint("", { optional: true })).toBe("");
  expect(numberComplaint("two", { optional: true })).toBe(wanted);
  expect(numberComplaint("20.5", { whole: true })).toBe(wanted);
});

it("a value is understood as people write those of parts", () => {
  for (const [text, value] of [
    ["33k", 33e3],
    ["4k7", 4700],
    ["10u", 10e-6],
    ["47 pF", 47e-12],
    ["4R7", 4.7],
    ["5,6 kΩ", 5600],
    ["0.1µ", 1e-7],
  ] as const)
    expect(typedNumber(text)).toBe(value);
  for (const text of ["k", "k7", "4.7k7", "3x", "1e", "4k7k"]) expect(typedNumber(text)).toBeNaN();
});

it("a number outside its limits is told them", () => {
  expect(numberComplaint("5", { min: 10, max: 300 })).toBe(
    t("number_between", { least: 10, most: 300 }),
  );
  expect(numberComplaint("-1", { min: 0 })).toBe(t("number_from", { least: 0 }));
  expect(numberComplaint("2,5", { min: 0 })).toBe("");
  expect(numberComplaint("1", { max: undefined, min: undefined })).toBe("");
});
