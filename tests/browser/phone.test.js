// A telephone: what is in sight, what a finger can hit, and nothing wider than the screen.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import {
  axe,
  launchBrowser,
  openPage,
  SUITE_MS,
  startServer,
  story,
  waitForReview,
  waitForRunTime,
} from "./support.js";

const FINGER = 44;

/** Rectangles of what is shown, in CSS pixels. */
const boxesOf = (page, selector) =>
  page.locator(selector).evaluateAll((elements) =>
    elements
      .filter((element) => element.checkVisibility())
      .map((element) => {
        const { top, bottom, left, right } = element.getBoundingClientRect();
        return { top, bottom, left, right };
      }),
  );

/** Controls that are too small for a finger; a check box is hit by its label. */
const tooSmall = (page) =>
  page.evaluate(
    (least) =>
      [...document.querySelectorAll("button, select, summary, input, a.button, nav a, label")]
        .filter((each) => each.checkVisibility() && !["checkbox", "radio"].includes(each.type))
        .filter((each) => each.tagName !== "LABEL" || each.querySelector("input[type=checkbox]"))
        .filter((each) => each.getBoundingClientRect().height < least)
        .map((each) => each.outerHTML.slice(0, 80)),
    FINGER - 0.5,
  );

describe("phone", { timeout: SUITE_MS }, () => {
  let server;
  let browser;

  before(async () => {
    server = await startServer({ speed: 4 });
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  async function openLive(viewport) {
    const opened = await openPage(browser, server.url, {
      viewport,
      hasTouch: true,
      isMobile: true,
    });
    const { page } = opened;
    await page.getByLabel("Duration, s").fill("600");
    await page.getByLabel("Fault at, s").fill("10");
    await page.getByRole("button", { name: "Run this experiment" }).tap();
    await page.waitForURL(/\/lab\/.+/);
    await waitForRunTime(page, 12);
    await page.evaluate(() => scrollTo(0, 0));
    return opened;
  }
  async function end(page, close) {
    await page.getByRole("button", { name: /^Stop/ }).tap();
    await waitForReview(page);
    await close();
  }
  const wider = (page) =>
    page.evaluate(
      () => document.documentElement.scrollWidth - document.documentElement.clientWidth,
    );

  for (const [width, height] of [
    [390, 844],
    [360, 640],
    [320, 568],
  ]) {
    story(`${width} × ${height}: verdict, Stop and two charts without scrolling`, async () => {
      const { page, close } = await openLive({ width, height });
      const verdict = page.locator(".verdict-line", { hasText: "Fault: R1 ↑" });
      await verdict.waitFor();
      const [line] = await boxesOf(page, ".verdict-line");
      const charts = await boxesOf(page, ".chart");
      assert.equal(charts.length, 2, "the two that are chosen");
      for (const chart of charts) {
        assert.ok(chart.top >= 0 && chart.bottom <= line.top, JSON.stringify({ chart, line }));
      }
      assert.equal(await wider(page), 0);
      assert.deepEqual(await tooSmall(page), []);
      // at the end of the page verdict and Stop are still there
      await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
      for (const each of [".verdict-line", "button.danger"]) {
        const [box] = await boxesOf(page, each);
        assert.ok(box.top >= 0 && box.bottom <= height, `${each} ${JSON.stringify(box)}`);
      }
      await end(page, close);
    });
  }

  story("faults are in a sheet, below a chart that stays in sight", async () => {
    const { page, close } = await openLive({ width: 390, height: 844 });
    assert.equal(await page.locator("#set-R12").isVisible(), false);
    await page.getByRole("button", { name: "Faults" }).tap();
    await page.locator("#set-R12").waitFor();
    const [sheet] = await boxesOf(page, "#faults");
    const [first] = await boxesOf(page, ".chart");
    assert.ok(first.top >= 0 && first.bottom <= sheet.top, JSON.stringify({ first, sheet }));
    assert.deepEqual(await tooSmall(page), []);
    assert.deepEqual(await axe(page), []);
    assert.equal(await wider(page), 0);
    await page.getByRole("button", { name: /^All nominal/ }).tap();
    await page.locator(".slider.nominal #set-R1").waitFor();
    await page.getByRole("button", { name: "Close" }).tap();
    await page.locator("#set-R12").waitFor({ state: "hidden" });
    await page.getByRole("button", { name: "Faults" }).press("Enter");
    await page.locator("#set-R12").waitFor();
    await page.keyboard.press("Escape");
    await page.locator("#set-R12").waitFor({ state: "hidden" });
    await page.keyboard.press("Escape");
    await page.locator("#set-R12").waitFor({ state: "hidden" });
    assert.ok(await page.getByRole("button", { name: /^Stop/ }).isVisible(), "the run goes on");
    await end(page, close);
  });

  story("other charts are chosen, and the menu is folded until it is pressed", async () => {
    const { page, close } = await openLive({ width: 360, height: 640 });
    await page.getByLabel("Chart 2").selectOption({ label: "Ia, A" });
    await page.getByRole("img", { name: /^Ia\./ }).waitFor();
    await page.getByLabel("Chart 2").selectOption({ label: "Uc, Um, V" });
    await page.waitForFunction(
      () => document.querySelector('select[aria-label="Chart 1"]').value === "ia",
    );
    assert.equal((await boxesOf(page, ".chart")).length, 2, "they have changed places");
    assert.equal(await page.getByRole("link", { name: "Runs" }).isVisible(), false);
    await page.getByRole("button", { name: "Menu" }).tap();
    assert.deepEqual(await tooSmall(page), []);
    assert.equal(await wider(page), 0);
    await page.getByRole("link", { name: "Help" }).tap();
    await page.waitForURL(/\/help/);
    await page.getByRole("link", { name: "Runs" }).waitFor({ state: "hidden" });
    await page.goBack();
    await end(page, close);
  });

  story("lying, one chart fills the screen above the verdict", async () => {
    const { page, close } = await openLive({ width: 844, height: 390 });
    const charts = await boxesOf(page, ".chart");
    assert.equal(charts.length, 1);
    const [line] = await boxesOf(page, ".verdict-line");
    assert.ok(charts[0].bottom <= line.top, JSON.stringify({ charts, line }));
    assert.ok(charts[0].right - charts[0].left > 800);
    assert.equal(await wider(page), 0);
    await end(page, close);
  });

  story("a tablet shows all charts, the verdict, and the faults in the sheet", async () => {
    const { page, close } = await openLive({ width: 820, height: 1180 });
    assert.equal((await boxesOf(page, ".signals .chart:not(.glass)")).length, 4);
    await page.locator(".verdict-line").waitFor();
    await page.getByRole("button", { name: "Faults" }).tap();
    await page.locator("#set-R1").waitFor();
    assert.deepEqual(await tooSmall(page), []);
    assert.equal(await wider(page), 0);
    await end(page, close);
  });
});
