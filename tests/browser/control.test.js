// The speed of a rig is kept although a part fails: planned on the page, watched, and read.
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
} from "./support.js";

describe("speed control", { timeout: SUITE_MS }, () => {
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

  story("is planned, watched, and compared with the run without a diagnosis", async () => {
    const { page, close } = await openPage(browser, server.url);
    const form = page.locator("form", { hasText: "Your own experiment" });
    await form.getByLabel("Speed control").selectOption("steps");
    assert.equal(await form.getByLabel("Low speed, rpm").inputValue(), "376.9");
    await form.getByLabel("High speed, rpm").fill("12000");
    await form.locator("input:invalid").waitFor();
    await form.getByLabel("High speed, rpm").fill("440");
    await page.locator("#set-R1").focus();
    await page.keyboard.press("3"); // 56 ohm
    assert.deepEqual(await axe(page), []);
    await form.getByRole("button", { name: "Run this experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);

    const card = page.locator(".right .card", { hasText: "Speed control" });
    await card.getByText(/it keeps its speed|has kept its speed/).waitFor();
    await waitForReview(page);
    await card.getByText(/The rig has kept its speed since 5\.5\d s\./).waitFor();
    await card.getByText(/it makes up for R1 → 56/).waitFor();
    await card.getByRole("columnheader", { name: "without compensation" }).waitFor();
    const numbers = await card
      .getByRole("row", { name: /deviation/ })
      .getByRole("cell")
      .allInnerTexts();
    const [made, without] = numbers.map(Number.parseFloat);
    assert.ok(made < without, `${made} ${without}`);
    await page.locator(".list li", { hasText: "speed control begins" }).waitFor();
    const chart = page.locator(".chart", { has: page.locator(".title", { hasText: /^n,/ }) });
    await chart.getByText("reference", { exact: true }).waitFor();
    assert.deepEqual(await axe(page), []);
    await close();
  });
});
