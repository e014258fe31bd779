// Frames per second while a run is live, compared with an empty page in the same browser, and how
// the heap grows in a minute of it; exits with 1 when the display is too slow:
//   FAULTLAB_BIN=.. node tests/browser/display.bench.js
import { loadavg } from "node:os";
import { launchBrowser, openPage, startServer, waitForRunTime } from "./support.js";

const MEASURE_MS = 8000;
const HEAP_MS = 60_000;
const FRAME_P95_MAX_MS = 17;
const HEAP_GROWTH_MAX_MB = 1;

function measure(page) {
  return page.evaluate(
    (forMs) =>
      new Promise((resolve) => {
        const intervals = [];
        const start = performance.now();
        let last = start;
        const step = (now) => {
          intervals.push(now - last);
          last = now;
          if (now - start < forMs) return requestAnimationFrame(step);
          intervals.sort((a, b) => a - b);
          resolve({
            fps: (1000 * intervals.length) / (now - start),
            p95: intervals[Math.floor(0.95 * intervals.length)],
          });
        };
        requestAnimationFrame(step);
      }),
    MEASURE_MS,
  );
}

/** A page with a run of ten minutes, after its first seconds. */
async function openLive(options = {}) {
  const opened = await openPage(browser, server.url, options);
  await opened.page.getByLabel("Duration, s").fill("600");
  await opened.page.getByRole("button", { name: "Run this experiment" }).click();
  await opened.page.waitForURL(/\/lab\/.+/);
  await waitForRunTime(opened.page, 25); // the charts are full
  return opened;
}
async function close({ page, context }) {
  await page.getByRole("button", { name: /^Stop/ }).click();
  await page.getByText("REVIEW", { exact: true }).waitFor();
  await context.close();
}

/** Megabytes in use after a collection of garbage. */
async function heapOf(session) {
  await session.send("HeapProfiler.collectGarbage");
  const { usedSize } = await session.send("Runtime.getHeapUsage");
  return usedSize / 1e6;
}

const server = await startServer();
const browser = await launchBrowser();
let slowest = 0;
for (const deviceScaleFactor of [1, 1.5, 2]) {
  const none = await openPage(browser, `${server.url}/help`, { deviceScaleFactor });
  const baseline = await measure(none.page);
  await none.context.close();
  const opened = await openLive({ deviceScaleFactor });
  const live = await measure(opened.page);
  await close(opened);
  slowest = Math.max(slowest, live.p95);
  console.log(
    `scale ${deviceScaleFactor}: none ${baseline.fps.toFixed(1)} fps (p95 ${baseline.p95.toFixed(1)} ms), live ${live.fps.toFixed(1)} fps ` +
      `(${(live.fps / baseline.fps).toFixed(2)}), frame p95 ${live.p95.toFixed(1)} ms`,
  );
}
const opened = await openLive();
const session = await opened.context.newCDPSession(opened.page);
const before = await heapOf(session);
await opened.page.waitForTimeout(HEAP_MS);
const after = await heapOf(session);
await close(opened);
console.log(
  `heap ${before.toFixed(2)} MB, ${HEAP_MS / 1000} s later ${after.toFixed(2)} MB; ` +
    `load of the machine ${loadavg().map((each) => each.toFixed(1))}`,
);
await browser.close();
await server.stop();
if (slowest > FRAME_P95_MAX_MS || after - before > HEAP_GROWTH_MAX_MB) process.exitCode = 1;
