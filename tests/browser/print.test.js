// The browser's print: every chart is complete on the paper, whatever the size of the window was.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import {
  finishedPaperRun,
  launchBrowser,
  openPage,
  SUITE_MS,
  startServer,
  story,
  waitForReview,
} from "./support.js";

const WIDE = { width: 1440, height: 900 };
const PHONE = { width: 390, height: 844 };
const A4_WIDTH_PX = 794;
const CHARTS = 9; // seven charts, the lens and the overview

/** Waits for the last chart: some of them are loaded after the others. */
const allDrawn = (page) =>
  page.waitForFunction((count) => document.querySelectorAll("canvas").length >= count, CHARTS);

/** Measures the printed layout, after the page's own listeners have drawn. */
function measureOnPaper() {
  const listen = MediaQueryList.prototype.addEventListener;
  globalThis.paper = [];
  const media = matchMedia("print");
  (globalThis.listenToMedia ?? listen).call(media, "change", () => {
    if (!media.matches) return;
    const box = (element) => {
      const { left, top, right, bottom } = element.getBoundingClientRect();
      return { left, top, right, bottom };
    };
    globalThis.paper = [...document.querySelectorAll("canvas")].map((canvas) => {
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      let coloured = 0;
      for (let at = 0; at < data.length; at += 4) {
        const [r, g, b, a] = data.subarray(at, at + 4);
        if (a > 100 && Math.max(r, g, b) - Math.min(r, g, b) > 80) coloured++;
      }
      const bounds = [];
      for (let each = canvas.parentElement; each; each = each.parentElement) {
        if (each.matches(".plot, .strip, figure, .card, body")) bounds.push(box(each));
      }
      return {
        canvas: box(canvas),
        bounds,
        pixels: canvas.width / devicePixelRatio,
        coloured: coloured / (canvas.width * canvas.height),
      };
    });
  });
}

function assertInside(inner, outer, words) {
  const inside =
    inner.left >= outer.left - 1 &&
    inner.top >= outer.top - 1 &&
    inner.right <= outer.right + 1 &&
    inner.bottom <= outer.bottom + 1;
  assert.ok(inside, `${words}: ${JSON.stringify(inner)} in ${JSON.stringify(outer)}`);
}

/** Prints, and returns what is on the paper; every chart must be complete. */
async function printWhole(page) {
  const pdf = await page.pdf({ format: "A4" });
  assert.equal(pdf.subarray(0, 5).toString(), "%PDF-");
  const charts = await page.evaluate(() => globalThis.paper);
  charts.forEach((chart, at) => {
    let inner = chart.canvas;
    assert.ok(inner.right - inner.left > 100, `chart ${at} is there`);
    for (const outer of chart.bounds) {
      assertInside(inner, outer, `chart ${at}`);
      inner = outer;
    }
    assert.ok(inner.right <= A4_WIDTH_PX, "the page is as wide as the paper");
  });
  return charts;
}

describe("print", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let run;
  let guest;

  before(async () => {
    server = await startServer({ speed: 4 });
    browser = await launchBrowser();
    ({ run, guest } = await finishedPaperRun(browser, server));
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  async function openRun(options) {
    const opened = await openPage(browser, `${server.url}/runs/${run}`, {
      storageState: guest,
      ...options,
    });
    await waitForReview(opened.page);
    await allDrawn(opened.page);
    await opened.page.evaluate(measureOnPaper);
    return opened;
  }

  for (const [name, viewport] of [
    ["a wide window", WIDE],
    ["a phone", PHONE],
  ]) {
    for (const deviceScaleFactor of [1, 2]) {
      story(`from ${name}, ${deviceScaleFactor} pixels to the point`, async () => {
        const { page, close } = await openRun({ viewport, deviceScaleFactor });
        const charts = await printWhole(page);
        assert.equal(charts.length, CHARTS);
        for (const { canvas, pixels, coloured } of charts) {
          assert.ok(Math.abs(canvas.right - canvas.left - pixels) <= 1, "drawn for the paper");
          assert.ok(coloured > 0.002, `the traces are drawn: ${coloured}`);
        }
        await page.locator(".plot canvas:visible").first().waitFor();
        await page.waitForFunction(() => {
          const hosts = [...document.querySelectorAll(".chart .plot")];
          const host = hosts.find((each) => each.checkVisibility());
          return host.querySelector("canvas").clientWidth === host.clientWidth;
        });
        await close();
      });
    }
  }

  story("Ctrl+P and the printed page lead to the report", async () => {
    const { page, context, close } = await openRun({ viewport: WIDE });
    const report = `/api/v1/runs/${run}/report.pdf?language=en`;
    const answer = await page.request.get(`${server.url}${report}`);
    assert.equal(answer.headers()["content-type"], "application/pdf");
    assert.equal((await answer.body()).subarray(0, 5).toString(), "%PDF-");
    await page.emulateMedia({ media: "print" });
    await page.getByText(`Report to print: ${server.url}${report}`).waitFor();
    await page.emulateMedia({ media: null });
    const asked = context.waitForEvent("request", (request) => request.url().endsWith(report));
    await page.keyboard.press("Control+p");
    await asked;
    await close();
  });

  story("in the dark theme, with the model check", async () => {
    const { page, close } = await openRun({ viewport: WIDE, colorScheme: "dark" });
    await page.getByRole("button", { name: "Model check" }).click();
    await page.locator(".figure canvas").first().waitFor();
    const charts = await printWhole(page);
    assert.ok(charts.length >= 3, `${charts.length} charts`);
    assert.ok(charts.every(({ coloured }) => coloured > 0.002));
    await close();
  });

  story("in a browser that does not tell when it prints", async () => {
    const { page, close } = await openPage(browser, server.url, {
      storageState: guest,
      viewport: WIDE,
    });
    await page.addInitScript(() => {
      const ofMedia = MediaQueryList.prototype.addEventListener;
      globalThis.listenToMedia = ofMedia;
      MediaQueryList.prototype.addEventListener = function (kind, listener) {
        if (this.media !== "print") ofMedia.call(this, kind, listener);
      };
      addEventListener("beforeprint", (event) => event.stopImmediatePropagation());
    });
    await page.goto(`${server.url}/runs/${run}`);
    await waitForReview(page);
    await allDrawn(page);
    await page.evaluate(measureOnPaper);
    assert.equal((await printWhole(page)).length, CHARTS);
    await close();
  });
});
