// Frames per second while a run is live, compared with an empty page in the same browser:
//   FAULTLAB_BIN=.. node tests/browser/display.bench.js
import { launchBrowser, openPage, startPaperRun, startServer } from "./support.js";

const MEASURE_MS = 8000;

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

const server = await startServer();
const browser = await launchBrowser();
for (const deviceScaleFactor of [1, 1.5, 2]) {
  const none = await openPage(browser, `${server.url}/help`, { deviceScaleFactor });
  const baseline = await measure(none.page);
  await none.context.close();
  const { page, context } = await openPage(browser, server.url, { deviceScaleFactor });
  await startPaperRun(page);
  await page.waitForTimeout(8000);
  const live = await measure(page);
  const heap = await page.evaluate(() => performance.memory?.usedJSHeapSize ?? 0);
  await context.close();
  console.log(
    `scale ${deviceScaleFactor}: none ${baseline.fps.toFixed(1)} fps, live ${live.fps.toFixed(1)} fps ` +
      `(${(live.fps / baseline.fps).toFixed(2)}), frame p95 ${live.p95.toFixed(1)} ms, heap ${(heap / 1e6).toFixed(1)} MB`,
  );
}
await browser.close();
await server.stop();
