// A PDF as it comes out of a printer: its pages as grey pixels, and its words.
import { execFileSync } from "node:child_process";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { temporaryDirectory } from "./support.js";

const DOTS_PER_INCH = 50;
const WHITE = 250;

/** {width, height, data} of a binary PGM. */
function readGrey(file) {
  const bytes = readFileSync(file);
  const [header, width, height] = /^P5\s+(\d+)\s+(\d+)\s+255\s/.exec(
    bytes.subarray(0, 40).toString("latin1"),
  );
  return {
    width: Number(width),
    height: Number(height),
    data: bytes.subarray(header.length),
  };
}

/** The pages of a PDF, by pdftoppm. */
export function pagesOf(pdf) {
  const { path, remove } = temporaryDirectory();
  try {
    writeFileSync(join(path, "in.pdf"), pdf);
    const options = ["-gray", "-r", String(DOTS_PER_INCH)];
    execFileSync("pdftoppm", [...options, join(path, "in.pdf"), join(path, "page")]);
    return readdirSync(path)
      .filter((name) => name.endsWith(".pgm"))
      .sort()
      .map((name) => readGrey(join(path, name)));
  } finally {
    remove();
  }
}

export function wordsOf(pdf) {
  return execFileSync("pdftotext", ["-layout", "-", "-"], { input: pdf }).toString();
}

/** Number of pixels with ink, within `marginMm` of the edges or, if it is 0, on the whole page. */
export function inkOf({ width, height, data }, marginMm = 0) {
  const margin = (marginMm / 25.4) * DOTS_PER_INCH;
  let count = 0;
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const inside = x >= margin && y >= margin && x < width - margin && y < height - margin;
      if (marginMm > 0 && inside) continue;
      if (data[y * width + x] < WHITE) count++;
    }
  }
  return count;
}

/** Share of pixels that differ between two pages. */
export function difference(one, other) {
  if (one.width !== other.width || one.height !== other.height) return 1;
  let count = 0;
  for (let at = 0; at < one.data.length; at++) {
    if (Math.abs(one.data[at] - other.data[at]) > 32) count++;
  }
  return count / one.data.length;
}
