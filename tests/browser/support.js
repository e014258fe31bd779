// Shared by the browser tests: the real server in a directory of its own, Chromium, axe, and a page
// that records every console error, failed request and request to another host.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createSocket } from "node:dgram";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { connect, createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { it } from "node:test";
import { isDeepStrictEqual } from "node:util";
import { giveBack, takeContext } from "./contexts.js";

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
  // A third of a page's processor time: helper threads of its scripts, and a process for each page.
  "--js-flags=--single-threaded",
  "--renderer-process-limit=1",
];
// Guards against hanging, not expectations: the same tests run on an old laptop during a build.
export const PATIENCE_MS = 120_000;
export const SUITE_MS = 1_500_000;

export function temporaryDirectory() {
  const path = mkdtempSync(join(tmpdir(), "faultlab-browser-"));
  return { path, remove: () => rmSync(path, { recursive: true, force: true }) };
}

function binary() {
  const path = process.env.FAULTLAB_BIN;
  assert.ok(path, "set FAULTLAB_BIN to the faultlab program");
  return path;
}

const servers = new Set();
/** Servers and agents that run. */
const running = new Set();
const browsers = new Set();
const pages = new Set();

/**
 * A test that, on failure, also prints what its pages showed and what the server logged, and ends the
 * servers and agents that it has started, or its file would not end.
 */
export function story(name, body) {
  it(name, async (context) => {
    const before = new Set(running);
    try {
      await body(context);
    } catch (error) {
      const contexts = [...browsers].flatMap((browser) => browser.contexts());
      for (const page of contexts.flatMap((each) => each.pages())) {
        const text = await page.innerText("body", { timeout: 2000 }).catch(() => "(no answer)");
        error.message += `\n--- ${page.url()}\n${text.slice(0, 1500)}`;
      }
      for (const server of servers)
        error.message += `\n--- server\n${server.output().slice(-1500)}`;
      for (const each of running) if (!before.has(each)) await each.stop("SIGKILL");
      throw error;
    } finally {
      for (const page of pages) await page.context().close();
      pages.clear();
    }
  });
}

export async function freePort() {
  const server = createServer();
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const { port } = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}

/**
 * Starts `faultlab serve` on a free port. `speed` is simulated seconds per second, `benches` the
 * number of simulated benches that need a session, `bench` the descriptions to start with, `bus` the
 * LCM address where remote rigs are searched for, `top` and `settings` the rest of its configuration.
 */
export async function startServer({
  speed = 1,
  benches = 0,
  bench = [],
  bus,
  data,
  top = "",
  settings = "",
  listen = "127.0.0.1:0",
} = {}) {
  const own = temporaryDirectory();
  const config = join(own.path, "faultlab.toml");
  const lcm = bus ? `[lcm]\nurl = "${bus.url}"\nkeys = "${bus.keys}"\n` : "";
  const noise = "[simulators]\nseed = 1\n"; // the same in each run
  writeFileSync(config, `${top}${noise}[lab]\nbenches = ${benches}\n${lcm}${settings}`);
  const child = spawn(
    binary(),
    [
      "serve",
      "--config",
      config,
      "--listen",
      listen,
      "--data",
      data ?? join(own.path, "data"),
      "--sim-speed",
      String(speed),
      ...bench.flatMap((each) => ["--bench", each]),
    ],
    { stdio: ["ignore", "pipe", "pipe"] },
  );
  let output = "";
  const url = await new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`no answer:\n${output}`)), PATIENCE_MS);
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
  const server = {
    url,
    output: () => output,
    async stop(signal = "SIGTERM") {
      servers.delete(server);
      running.delete(server);
      child.kill(signal);
      await ended;
      own.remove();
    },
  };
  servers.add(server);
  running.add(server);
  return server;
}

/** Whether a datagram to the group reaches its own machine. */
function hearsItself(group, port) {
  const socket = createSocket({ type: "udp4", reuseAddr: true });
  return new Promise((resolve) => {
    const timer = setTimeout(() => resolve(false), 2000);
    const answer = (heard) => {
      clearTimeout(timer);
      resolve(heard);
    };
    socket.on("error", () => answer(false));
    socket.on("message", () => answer(true));
    socket.bind(port, () => {
      try {
        socket.addMembership(group);
        socket.setMulticastTTL(0);
        socket.send("here", port, group);
      } catch {
        answer(false); // no route for multicast
      }
    });
  }).finally(() => socket.close());
}

/**
 * The agent of a simulated remote rig on a bus of its own that stays on this machine. It has
 * seen `epoch` from another lab. Null if the machine has no multicast.
 */
export async function startAgent({ id, epoch }) {
  const group = "239.255.76.67";
  const port = 20_000 + (process.pid % 20_000);
  if (!(await hearsItself(group, port))) return null;
  const own = temporaryDirectory();
  const bus = { url: `udpm://${group}:${port}?ttl=0`, keys: join(own.path, "keys") };
  const state = join(own.path, "state");
  mkdirSync(state);
  writeFileSync(join(state, `${id}.epoch`), `${epoch} other-lab/1\n`);
  const child = spawn(
    binary(),
    ["rig", "--id", id, "--lcm", bus.url, "--keys", bus.keys, "--state", state],
    { stdio: ["ignore", "pipe", "pipe"] },
  );
  let output = "";
  const ended = new Promise((resolve) => child.on("exit", resolve));
  await new Promise((resolve, reject) => {
    const read = (data) => {
      output += data;
      if (output.includes(`${id} is on`)) resolve();
    };
    child.stdout.on("data", read);
    child.stderr.on("data", read);
    child.on("exit", (code) => reject(new Error(`agent ended with ${code}:\n${output}`)));
  });
  const agent = {
    bus,
    async stop(signal = "SIGTERM") {
      running.delete(agent);
      child.kill(signal);
      await ended;
      own.remove();
    },
  };
  running.add(agent);
  return agent;
}

/** A connection to the server that can be cut: all open connections break, new ones are refused. */
export async function startWire(url) {
  const target = new URL(url);
  const sockets = new Set();
  let open = true;
  let refused = 0;
  const waiting = [];
  const server = createServer((near) => {
    if (!open) {
      near.destroy();
      refused++;
      for (const each of waiting) if (refused >= each.count) each.resolve();
      return;
    }
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
  server.unref(); // a story that fails leaves it open, and its file must end
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    cut() {
      open = false;
      for (const socket of sockets) socket.destroy();
    },
    /** Resolves when `count` more connections have been refused. */
    refusals(count) {
      return new Promise((resolve) => waiting.push({ count: refused + count, resolve }));
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

export async function launchBrowser() {
  const browser = await chromium.launch({
    executablePath: "/usr/bin/chromium-headless-shell",
    headless: true,
    args: FLAGS,
    timeout: PATIENCE_MS,
  });
  browsers.add(browser);
  browser.on("disconnected", () => browsers.delete(browser));
  return browser;
}

/**
 * A new page. `allow` matches console errors that the test causes on purpose, `storageState` is that
 * of another context, `stored` what the page finds in its localStorage.
 */
export async function openPage(
  browser,
  url,
  {
    allow = /^$/,
    viewport = { width: 1440, height: 900 },
    colorScheme = "light",
    reducedMotion = "reduce",
    storageState = {},
    stored,
    ...kind
  } = {},
) {
  const { origin } = new URL(url);
  const context = await takeContext(browser, { acceptDownloads: true, ...kind });
  const page = await context.newPage();
  await page.setViewportSize(viewport);
  await page.emulateMedia({ colorScheme, reducedMotion });
  await context.addCookies(storageState.cookies ?? []);
  const items = storageState.origins?.find((each) => each.origin === origin)?.localStorage ?? [];
  for (const [name, value] of Object.entries(stored ?? {})) items.push({ name, value });
  if (items.length > 0) {
    await page.addInitScript((each) => {
      if (localStorage.length > 0) return;
      for (const { name, value } of each) localStorage.setItem(name, value);
    }, items);
  }
  context.setDefaultTimeout(PATIENCE_MS); // of requests by context.request too
  context.setDefaultNavigationTimeout(PATIENCE_MS);
  pages.add(page);
  const complaints = [];
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
      pages.delete(page);
      await giveBack(context, origin);
      assert.deepEqual(complaints, []);
    },
  };
}

/** Waits until the page has its heading and nothing on it is still loading. */
export async function settled(page) {
  await page.locator("main h1").first().waitFor({ state: "attached" });
  await page.waitForFunction(
    () =>
      document.documentElement.dataset.busy === "0" &&
      !/^(Loading|Loading the run)$/m.test(document.querySelector("main").innerText),
  );
}

/** Waits until `read()` gives something of which `ok` is true; returns it. */
export async function until(read, ok) {
  const end = Date.now() + PATIENCE_MS;
  for (;;) {
    const found = await read();
    if (ok(found)) return found;
    assert.ok(Date.now() < end, `stays ${found}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/**
 * The box of an element that has stopped moving: parts above it may be loaded late. What is there has been painted:
 * before that a finger meets the page of the frame before, which may let it zoom or scroll.
 */
export async function atRest(locator) {
  let last = "";
  const box = await until(
    () => locator.boundingBox(),
    (box) => {
      const same = JSON.stringify(box) === last;
      last = JSON.stringify(box);
      return same;
    },
  );
  await locator.evaluate(
    () => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))),
  );
  return box;
}

/** Waits until `read()` gives what is expected; says how they differ if that never comes. */
export async function becomes(read, expected, words) {
  const end = Date.now() + PATIENCE_MS;
  for (;;) {
    const found = await read();
    if (isDeepStrictEqual(found, expected)) return;
    if (Date.now() > end) assert.deepEqual(found, expected, words);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/** Violations that axe finds on a page that has its heading, as short lines. */
export async function axe(page) {
  await page.locator("h1").first().waitFor({ state: "attached" });
  await page.evaluate(axeSource);
  // Only what is wrong is written out node by node: half of its time went into the rest.
  const result = await page.evaluate(() =>
    globalThis.axe.run(document, { resultTypes: ["violations"] }),
  );
  assert.ok(result.passes.length > 10, "axe must have looked at a real page");
  return result.violations.map(
    (violation) =>
      `${violation.id}: ${violation.nodes.map((node) => node.target.join(" ")).join(", ")}`,
  );
}

export const START = "Run the paper's experiment";

/** Answers the question whether one is sure with the button that does it. */
export async function confirmIn(page) {
  const dialog = page.getByRole("dialog");
  await dialog.locator("button.primary").click();
  await dialog.waitFor({ state: "detached" });
}

/** Presses the button; returns the run's id. */
export async function startPaperRun(page) {
  await page.getByRole("button", { name: START }).click();
  await page.waitForURL(/\/lab\/.+/);
  return decodeURIComponent(new URL(page.url()).pathname.split("/")[2]);
}

/** A guest's run of the paper's experiment that is over: its id, and the storage that owns it. */
export async function finishedPaperRun(browser, server) {
  const { page, context, close } = await openPage(browser, server.url);
  const run = await startPaperRun(page);
  await waitForReview(page);
  const guest = await context.storageState();
  await close();
  return { run, guest };
}

export async function waitForReview(page) {
  await page.getByText("REVIEW", { exact: true }).waitFor();
}

/** Waits until the page shows at least `seconds` of run time. */
export async function waitForRunTime(page, seconds) {
  await page.waitForFunction((least) => {
    const [, minutes, rest] =
      /(\d+):([\d.]+)/.exec(document.querySelector(".state")?.textContent) ?? [];
    return Number(minutes) * 60 + Number(rest) >= least;
  }, seconds);
}

/** Waits until a canvas has been drawn in `count` different ways. */
export async function waitForDrawings(page, selector, count) {
  await page.waitForFunction(
    ([selector, count]) => {
      const canvas = document.querySelector(selector);
      if (!canvas?.width) return false;
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      let sum = 0;
      for (let at = 0; at < data.length; at += 16) sum = (sum * 31 + data[at]) >>> 0;
      globalThis.drawings ??= new Set();
      globalThis.drawings.add(sum);
      return globalThis.drawings.size >= count;
    },
    [selector, count],
    { polling: "raf" },
  );
}

export async function readDownload(download) {
  return readFileSync(await download.path());
}

/**
 * Requests that wait on their way to the server, until they are let go; `arrived` comes with the
 * first.
 */
export async function holdRequests(page, url) {
  const held = [];
  let open = false;
  let arrive;
  const arrived = new Promise((resolve) => {
    arrive = resolve;
  });
  await page.route(url, (route) => {
    if (open) return route.continue();
    held.push(route);
    arrive();
  });
  return {
    arrived,
    async letGo() {
      await arrived;
      open = true;
      await Promise.all(held.map((route) => route.continue()));
    },
  };
}
