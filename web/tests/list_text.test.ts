import { describe, expect, it } from "vitest";
import { listText } from "../src/lab/list_text";

const bytes = (...list: number[]) => new Uint8Array(list).buffer;

describe("a class list from a file", () => {
  it("is read in the encodings that spreadsheets write", () => {
    expect(listText(new TextEncoder().encode("ana;Đorđević").buffer as ArrayBuffer)).toBe(
      "ana;Đorđević",
    );
    // "Đić;ž" in Windows-1250, "a;Đž" in UTF-16
    expect(listText(bytes(0xd0, 0x69, 0xe6, 0x3b, 0x9e))).toBe("Đić;ž");
    expect(listText(bytes(0xff, 0xfe, 0x61, 0, 0x3b, 0, 0x10, 0x01, 0x7e, 0x01))).toBe("a;Đž");
  });
});
