// Takes the picture of the README from the real page: FAULTLAB_BIN=.. npm run screenshot [file]
import { mkdirSync } from "node:fs";
import { dirname, resolve } from "node:path";
import { launchBrowser, openPage, startPaperRun, startServer, waitForReview } from "./support.js";

const file = resolve(
  process.argv[2] ?? new URL("../../web/live-page.png", import.meta.url).pathname,
);
const server = await startServer();
const browser = await launchBrowser();
try {
  const { page, close } = await openPage(browser, server.url, { colorScheme: "light" });
  await startPaperRun(page);
  await waitForReview(page);
  await page.keyboard.press("f");
  await page.mouse.move(0, 0);
  await page.waitForTimeout(1500);
  mkdirSync(dirname(file), { recursive: true });
  await page.screenshot({ path: file });
  await close();
} finally {
  await browser.close();
  await server.stop();
}
console.log(file);
