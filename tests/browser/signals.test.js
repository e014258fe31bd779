// Reading the signals: zoom, cursors, statistics, lens and tabs, by mouse, keyboard and touch; and
// what arrow keys and "one fault at a time" do to the faults.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import {
  atRest,
  axe,
  finishedPaperRun,
  launchBrowser,
  openPage,
  SUITE_MS,
  startServer,
  story,
  until,
  waitForReview,
  waitForRunTime,
} from "./support.js";

const WINDOW = { width: 1280, height: 700 };
const PLOT = ".signals .chart:not(.glass) .plot";
const ROW = (name) => `section[aria-label="Measure"] tr:has(th:text-matches("^${name},"))`;

describe("signals", { timeout: SUITE_MS }, () => {
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

  async function openRun(options = {}) {
    const opened = await openPage(browser, `${server.url}/runs/${run}`, {
      storageState: guest,
      viewport: WINDOW,
      ...options,
    });
    await waitForReview(opened.page);
    const area = opened.page.locator(`${PLOT} .u-over`).first();
    await area.waitFor();
    // What wheel and fingers do is loaded after the charts.
    await opened.page.locator(`${PLOT}[style*="pan-y"]`).first().waitFor();
    return { ...opened, area };
  }
  const spanOf = async (page) => Number(await page.getByLabel("Time window").inputValue());
  const middleOf = async (page) =>
    Number.parseFloat(
      await page.getByRole("slider", { name: "Whole run" }).getAttribute("aria-valuetext"),
    );
  const spanBecomes = (page, test) =>
    page.waitForFunction(test, undefined, { polling: 50 }).catch(async () => {
      assert.fail(`the charts show ${await spanOf(page)} s`);
    });
  const timeOf = async (page, name) =>
    Number(await page.getByLabel(`Time of cursor ${name}`).inputValue());

  story("the wheel scrolls the page, with Ctrl it zooms, a double click shows all", async () => {
    const { page, area, close } = await openRun();
    await area.hover();
    await page.mouse.wheel(0, 120);
    await page.waitForFunction(() => scrollY > 50);
    await page.getByText(/Hold Ctrl/).waitFor();
    assert.equal(await spanOf(page), 20);
    await page.evaluate(() => scrollTo(0, 0));
    await page.keyboard.down("Control");
    for (let turn = 0; turn < 3; turn++) await page.mouse.wheel(0, -100);
    await page.keyboard.up("Control");
    await spanBecomes(page, () => {
      const span = Number(document.querySelector(".middle .bar select").value);
      return span > 1 && span < 10;
    });
    assert.equal(await page.evaluate(() => scrollY), 0, "the page stays");
    const zoomed = await middleOf(page);
    await page.keyboard.down("Shift");
    await page.mouse.wheel(0, 100);
    await page.keyboard.up("Shift");
    await page.waitForFunction(
      (before) =>
        Number.parseFloat(
          document.querySelector("canvas[role=slider]").getAttribute("aria-valuetext"),
        ) > before,
      zoomed,
    );
    await area.dblclick();
    await page.locator('button[aria-pressed="true"]', { hasText: "Whole run" }).waitFor();
    assert.equal(await spanOf(page), 20);
    await close();
  });

  story("cursors by mouse; statistics and fit are those of the recording", async () => {
    const { page, area, close } = await openRun();
    await page.keyboard.press("c");
    await page.getByLabel("Time of cursor A").waitFor();
    const places = () =>
      page
        .locator(".signals .plot")
        .evaluateAll((plots) =>
          plots.map((plot) => Object.values(plot.getBoundingClientRect().toJSON())),
        );
    await area.hover();
    await page.locator(".legend.under").first().waitFor();
    const pointed = await places();
    await page.mouse.move(0, 0);
    await page.locator(".legend.under").first().waitFor({ state: "detached" });
    assert.deepEqual(pointed, await places(), "pointing at a chart moves none");

    const at = async (share) => {
      const { width, height } = await area.boundingBox();
      return { position: { x: share * width, y: height / 2 } };
    };
    const near = (cursor, wanted) =>
      until(
        () => timeOf(page, cursor),
        (time) => Math.abs(time - wanted) < 0.6,
      );
    const drag = async (from, to) => {
      await area.hover(await at(from));
      await page.mouse.down();
      const { x, y, width, height } = await area.boundingBox();
      await page.mouse.move(x + to * width, y + height / 2, { steps: 5 });
      await page.mouse.up();
    };
    await area.click(await at(0.25));
    const a = await near("A", 5);
    await area.click(await at(0.75));
    const b = await near("B", 15);
    // a cursor is dragged
    await drag(0.25, 0.55);
    await until(
      () => timeOf(page, "A"),
      (time) => time > a + 2,
    );
    assert.equal(await timeOf(page, "B"), b);
    assert.equal(await spanOf(page), 20, "and nothing was zoomed");
    // dragging elsewhere selects
    await drag(0.35, 0.65);
    await near("A", 7);
    await near("B", 13);

    await page.getByLabel("Time of cursor A").fill("2");
    await page.getByLabel("Time of cursor B").fill("9.5");
    await page.getByText("n 751", { exact: false }).waitFor();
    const csv = await (
      await page.request.get(`${server.url}/api/v1/runs/${run}/export.csv`)
    ).text();
    const [head, ...lines] = csv.split(/\r?\n/).filter((line) => line && !line.startsWith("#"));
    const column = head.split(",").indexOf("um_v");
    const points = lines
      .map((line) => line.split(",").map(Number))
      .map((cells) => ({ t: cells[0], y: cells[column] }))
      .filter(({ t }) => t > 1.995 && t < 9.505);
    const mean = (of) => points.reduce((sum, p) => sum + of(p), 0) / points.length;
    const [mt, my] = [mean((p) => p.t), mean((p) => p.y)];
    const slope = mean((p) => (p.t - mt) * (p.y - my)) / mean((p) => (p.t - mt) ** 2);
    const deviation = Math.sqrt((751 / 750) * mean((p) => (p.y - my) ** 2));
    const cells = (await page.locator(`${ROW("Um")} td`).allInnerTexts()).map((text) =>
      Number.parseFloat(text.replace("−", "-")),
    );
    const ys = points.map((p) => p.y);
    const expected = [
      ys[0],
      ys.at(-1),
      ys.at(-1) - ys[0],
      my,
      deviation,
      Math.min(...ys),
      Math.max(...ys),
      slope,
    ];
    expected.forEach((value, i) => {
      assert.ok(
        Math.abs(cells[i] - value) <= 0.006 * Math.abs(value) + 1e-4,
        `${cells} is ${expected}`,
      );
    });
    assert.match(await page.locator(ROW("Um")).innerText(), /V\/s/);
    assert.deepEqual(await axe(page), []);
    await page.keyboard.press("Tab"); // out of the field: keys are shortcuts again
    await page.getByRole("button", { name: "Zoom to it" }).click();
    await spanBecomes(
      page,
      () => Number(document.querySelector(".middle .bar select").value) === 7.5,
    );
    await close();
  });

  story("cursors and the selection by keyboard alone", async () => {
    const { page, close } = await openRun();
    await page.keyboard.press("a");
    await page.getByLabel("Time of cursor A").waitFor();
    const first = await timeOf(page, "A");
    assert.ok(Math.abs(first - 10) < 0.02, `in the middle: ${first}`);
    await page.keyboard.press("Shift+ArrowLeft");
    assert.ok(Math.abs((await timeOf(page, "A")) - (first - 0.2)) < 0.011);
    await page.keyboard.press(".");
    assert.ok(Math.abs((await timeOf(page, "A")) - (first - 0.19)) < 0.001);
    await page.keyboard.press("b");
    await page.keyboard.press("Shift+ArrowRight");
    await page.getByText("n 40", { exact: false }).waitFor();
    await page.keyboard.press("s");
    await page.getByText("n 2000", { exact: false }).waitFor();
    await page.keyboard.press("c");
    await page.getByLabel("Time of cursor A").waitFor({ state: "detached" });
    await close();
  });

  story("the lens is there, and signals stay in sight under every tab", async () => {
    const { page, close } = await openRun();
    const lens = page.getByRole("img", { name: /^Lens/ });
    await lens.waitFor();
    await page.keyboard.press("z");
    await lens.waitFor({ state: "detached" });
    for (const tab of ["Model check", "Table", "SWA of Um: b0d, b1d, a1d"]) {
      await page.getByRole("button", { name: tab }).click();
      const below = page.locator(
        { "Model check": ".figure canvas", Table: "tbody" }[tab] ?? ".estimates canvas",
      );
      await below.first().waitFor();
      const boxes = await page.locator(PLOT).evaluateAll((plots) =>
        plots.map((plot) => {
          const { top, bottom, height } = plot.getBoundingClientRect();
          return { top, bottom, height };
        }),
      );
      assert.equal(boxes.length, 4, tab);
      if (tab === "Model check") {
        const orders = page.getByRole("region", { name: "Orders of the model" });
        await orders.getByRole("row", { name: /^SIA K, m = 100, 20, order 4/ }).waitFor();
        assert.equal(await orders.getByText("✓").count(), 4, "SWA and SIA, before and after");
      }
      for (const { top, bottom, height } of boxes) {
        assert.ok(top > 0 && bottom < WINDOW.height && height > 60, `${tab}: ${top} to ${bottom}`);
      }
    }
    await close();
  });

  story("fingers: one moves, two zoom, up and down scrolls, a double tap shows all", async () => {
    const { page, context, area, close } = await openRun({ hasTouch: true });
    const box = await atRest(area);
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const touch = await context.newCDPSession(page);
    const send = (type, ...points) =>
      touch.send("Input.dispatchTouchEvent", {
        type,
        touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })),
      });
    /** The same at a time of its own, seconds since 1970, however late the page gets it. */
    const sendAt = (timestamp, type, ...points) =>
      touch.send("Input.dispatchTouchEvent", {
        type,
        timestamp,
        touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })),
      });
    await send("touchStart", [x - 20, y], [x + 20, y]);
    for (let step = 1; step <= 8; step++) {
      await send("touchMove", [x - 20 - 5 * step, y], [x + 20 + 5 * step, y]);
    }
    await send("touchEnd");
    await spanBecomes(page, () => {
      const span = Number(document.querySelector(".middle .bar select").value);
      return span > 4 && span < 9;
    });
    const before = await middleOf(page);
    await send("touchStart", [x, y]);
    for (let step = 1; step <= 8; step++) await send("touchMove", [x + 8 * step, y]);
    await send("touchEnd");
    await page.waitForFunction(
      (was) =>
        Number.parseFloat(
          document.querySelector("canvas[role=slider]").getAttribute("aria-valuetext"),
        ) <
        was - 0.5,
      before,
    );
    const moved = await middleOf(page);
    await send("touchStart", [x, y + 40]);
    for (let step = 1; step <= 8; step++) await send("touchMove", [x, y + 40 - 12 * step]);
    await send("touchEnd");
    await page.waitForFunction(() => scrollY > 20);
    assert.equal(await middleOf(page), moved, "scrolling moves no time");
    await page.evaluate(() => scrollTo(0, 0));
    const now = Date.now() / 1000;
    await sendAt(now, "touchStart", [x, y]);
    await sendAt(now + 0.02, "touchEnd");
    await sendAt(now + 0.1, "touchStart", [x, y]);
    await sendAt(now + 0.12, "touchEnd");
    await page.locator('button[aria-pressed="true"]', { hasText: "Whole run" }).waitFor();
    await close();
  });

  story("arrow keys switch where they rest, or on Enter, and not on the way", async () => {
    const { page, close } = await openPage(browser, server.url);
    await page.addInitScript(() => {
      // keys rest longer than the test takes to press them, however busy the machine is
      const { setTimeout } = globalThis;
      globalThis.setTimeout = (run, ms) => setTimeout(run, ms === 800 ? 6000 : ms);
    });
    await page.reload();
    await page.getByLabel("Duration, s").fill("600");
    await page.locator("#set-R1").focus();
    await page.keyboard.press("1"); // healthy
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);
    const id = decodeURIComponent(new URL(page.url()).pathname.split("/")[2]);
    await page.locator("#set-R1:not([disabled])").waitFor();
    await waitForRunTime(page, 6);
    await page.locator("#set-R1").focus();
    for (let press = 0; press < 3; press++) await page.keyboard.press("ArrowRight");
    assert.match(
      await page.locator("#set-R1").getAttribute("aria-valuetext"),
      /^100 Ω, press Enter/,
    );
    await page.locator(".slider.confirmed #set-R1").waitFor();
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("Enter");
    await page
      .locator(".slider.confirmed", { has: page.locator("output", { hasText: /^56 Ω/ }) })
      .waitFor();
    const { items } = await (
      await page.request.get(`${server.url}/api/v1/runs/${id}/events`)
    ).json();
    const values = items
      .filter((event) => event.kind === "fault_commanded")
      .map((event) => event.value);
    assert.deepEqual(values, [100, 56]);
    await page.keyboard.press("Escape");
    await waitForReview(page);
    await close();
  });

  story("a fault beside a planned one is refused while there may be one only", async () => {
    const { page, close } = await openPage(browser, server.url);
    await page.getByLabel("Duration, s").fill("600");
    await page.getByLabel("Fault at, s").fill("500");
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);
    await page.locator("#set-R12:not([disabled])").waitFor();
    await waitForRunTime(page, 6);
    await page.locator("#set-R12").focus();
    await page.keyboard.press("4");
    await page.locator(".slider.refused #set-R12").waitFor();
    await page.locator(".detail", { hasText: "R1 → 100 Ω comes at 500.00 s" }).waitFor();
    await page.getByLabel("one fault at a time").uncheck();
    await page.locator("#set-R12").focus();
    await page.keyboard.press("4");
    await page.locator(".slider.confirmed #set-R12").waitFor();
    await page.keyboard.press("Escape");
    await waitForReview(page);
    await close();
  });
});
