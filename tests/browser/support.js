// What the browser tests share: the real server in a directory of its own, Chromium, axe, and a page
// whose every console error, failed request and word to another host is kept for the test to judge.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { connect, createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";

const require = createRequire(new URL("../../web/package.json", import.meta.url));
const { chromium } = require("playwright-core");
const axeSource = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

const FLAGS = [
  "--no-sandbox",
  "--disable-gpu",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];
const START_MS = 20_000;

export function temporaryDirectory() {
  const path = mkdtempSync(join(tmpdir(), "faultlab-browser-"));
  return { path, remove: () => rmSync(path, { recursive: true, force: true }) };
}

/** Starts `faultlab serve` on a free port. `speed` is simulated seconds per second. */
export async function startServer({ speed = 1, data, args = [] } = {}) {
  const binary = process.env.FAULTLAB_BIN;
  assert.ok(binary, "set FAULTLAB_BIN to the faultlab program");
  const own = data ? null : temporaryDirectory();
  const child = spawn(
    binary,
    [
      "serve",
      "--listen",
      "127.0.0.1:0",
      "--data",
      data ?? own.path,
      "--sim-speed",
      String(speed),
      ...args,
    ],
    { stdio: ["ignore", "pipe", "pipe"] },
  );
  let output = "";
  const url = await new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`no answer:\n${output}`)), START_MS);
    const read = (data) => {
      output += data;
      const found = /listening on (http:\/\/[\d.]+:\d+)/.exec(output);
      if (!found) return;
      clearTimeout(timer);
      resolve(found[1]);
    };
    child.stdout.on("data", read);
    child.stderr.on("data", read);
    child.on("exit", (code) => reject(new Error(`server ended with ${code}:\n${output}`)));
  });
  const ended = new Promise((resolve) => child.on("exit", resolve));
  return {
    url,
    output: () => output,
    async stop() {
      child.kill("SIGTERM");
      await ended;
      own?.remove();
    },
  };
}

/** A wire to the server that can be cut: everything through it breaks off, new calls are refused. */
export async function startWire(url) {
  const target = new URL(url);
  const sockets = new Set();
  let open = true;
  const server = createServer((near) => {
    if (!open) return near.destroy();
    const far = connect(Number(target.port), target.hostname);
    for (const [a, b] of [
      [near, far],
      [far, near],
    ]) {
      sockets.add(a);
      a.on("error", () => b.destroy());
      a.on("close", () => {
        sockets.delete(a);
        b.destroy();
      });
      a.pipe(b);
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    cut() {
      open = false;
      for (const socket of sockets) socket.destroy();
    },
    mend() {
      open = true;
    },
    close() {
      for (const socket of sockets) socket.destroy();
      server.close();
    },
  };
}

export function launchBrowser() {
  return chromium.launch({ executablePath: "/usr/bin/chromium", headless: true, args: FLAGS });
}

/** A fresh page. `allow` matches console errors that the test provokes on purpose. */
export async function openPage(browser, url, { allow = /^$/, ...options } = {}) {
  const context = await browser.newContext({
    viewport: { width: 1440, height: 900 },
    reducedMotion: "reduce",
    acceptDownloads: true,
    ...options,
  });
  const page = await context.newPage();
  const complaints = [];
  const origin = new URL(url).origin;
  page.on("console", (message) => {
    if (message.type() === "error" && !allow.test(message.text())) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(`${error.message}\n${error.stack}`));
  page.on("request", (request) => {
    const to = new URL(request.url());
    if (!["data:", "blob:"].includes(to.protocol) && to.host !== new URL(origin).host) {
      complaints.push(`request to another host: ${request.url()}`);
    }
  });
  await page.goto(url);
  return {
    page,
    context,
    complaints,
    async close() {
      await context.close();
      assert.deepEqual(complaints, []);
    },
  };
}

/** Waits until the page has its heading and nothing on it is still loading. */
export async function settled(page) {
  await page.locator("main h1").first().waitFor({ state: "attached" });
  await page.waitForFunction(
    () => !/^(Loading|Loading the run)$/m.test(document.querySelector("main").innerText),
  );
}

/** Violations that axe finds, as short lines. */
export async function axe(page) {
  await page.evaluate(axeSource);
  const result = await page.evaluate(() => globalThis.axe.run(document));
  assert.ok(result.passes.length > 10, "axe must have looked at a real page");
  return result.violations.map(
    (violation) =>
      `${violation.id}: ${violation.nodes.map((node) => node.target.join(" ")).join(", ")}`,
  );
}

/** Sum over the pixels of a canvas; changes when anything is drawn. */
export function inkOf(page, selector) {
  return page.$eval(selector, (canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let sum = 0;
    for (let at = 0; at < data.length; at += 16) sum = (sum * 31 + data[at]) >>> 0;
    return sum;
  });
}

export const START = "Run the paper's experiment";

/** Presses the button; the run's id. */
export async function startPaperRun(page) {
  await page.getByRole("button", { name: START }).click();
  await page.waitForURL(/\/lab\/.+/);
  return decodeURIComponent(new URL(page.url()).pathname.split("/")[2]);
}

export async function waitForReview(page, timeout = 60_000) {
  await page.getByText("REVIEW", { exact: true }).waitFor({ timeout });
}

export async function readDownload(download) {
  return readFileSync(await download.path());
}
