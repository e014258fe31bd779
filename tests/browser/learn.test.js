// Learn: the guided exercise from the start page to the truth, and the theory with its widgets.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import {
  axe,
  launchBrowser,
  openPage,
  SUITE_MS,
  settled,
  startServer,
  story,
  until,
} from "./support.js";

const TOPICS = ["swa", "sia", "windows", "ambiguity", "detection", "methods"];
const FIRST_VERDICT_MS = 60_000;

describe("learn", { timeout: SUITE_MS }, () => {
  let server;
  let browser;

  before(async () => {
    server = await startServer(); // in real time, as for a student
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  const heading = (page, name) => page.getByRole("heading", { level: 2, name }).waitFor();
  const noOverflow = async (page) =>
    assert.ok(
      (await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)) <= 0,
      `${page.url()} is too wide`,
    );
  /** A number of a widget, by the words before it. */
  async function result(page, name) {
    const shown = page.locator(".results div", { hasText: name }).locator("dd");
    const said = (await shown.innerText()).replace("−", "-");
    const [, number, unit] = /^(-?[\d.]+)\s*(\D*)/.exec(said) ?? [];
    return Number(number) * (unit?.startsWith("m") ? 1e-3 : unit?.startsWith("µ") ? 1e-6 : 1);
  }
  /** Waits until a number of a widget is as wanted; keys take time to act. */
  async function becomes(page, name, wanted) {
    return until(() => result(page, name), wanted);
  }

  story("somebody new names a first fault within a minute, and then a hidden one", async () => {
    const { page, close } = await openPage(browser, server.url);
    const opened = Date.now();
    await page.locator('a[href="/learn/exercise"]').first().click();
    const press = (name) => page.getByRole("button", { name }).press("Enter");
    await press("Start the motor");
    await heading(page, "Watch a healthy rig");
    await page.getByRole("progressbar").waitFor();
    await heading(page, "Change one part");
    await press(/^Set .* to /);
    await heading(page, "The fault has a name");
    assert.ok(Date.now() - opened < FIRST_VERDICT_MS, "the first verdict within a minute");
    assert.match(await page.locator(".verdict").innerText(), /Fault: R1 ↑.*R1 = (99|100|101)\b/s);
    // the focus has followed the step
    await page.waitForFunction(() => document.activeElement?.tagName === "H2");
    await press(/^Set .* back to /);
    await heading(page, "Now find one yourself");
    await page.evaluate(() => {
      const region = document.querySelector('[role="status"]');
      globalThis.announced = [];
      new MutationObserver(() => globalThis.announced.push(region.textContent)).observe(region, {
        subtree: true,
        childList: true,
        characterData: true,
      });
    });
    await press("Switch on a hidden fault");
    await heading(page, "Which part, and by how much?");

    // nothing on the page tells the fault, also when it is opened again
    const { run } = await page.evaluate(() => JSON.parse(localStorage["faultlab.exercise"]));
    const events = (
      await (await page.request.get(`${server.url}/api/v1/runs/${run}/events`)).json()
    ).items;
    const truth = events.filter((event) => event.kind === "relay_confirmed").at(-1);
    const said = () => page.evaluate(() => globalThis.announced.join("\n"));
    await until(said, (text) => text.includes("Fault detected"));
    assert.doesNotMatch(await said(), /is now (?!1 Ω)/, "only the return to nominal is told");
    await page.reload();
    await heading(page, "Which part, and by how much?");
    const verdict = page.locator(".step .verdict");
    assert.match(await verdict.innerText(), /hidden until you answer/);
    await page.getByRole("radio").first().waitFor();
    assert.deepEqual(await axe(page), []);

    // the row that fits best
    const numbers = (cells) => cells.map((cell) => Number(cell.replace("−", "-")));
    const measured = numbers(await page.locator(".measured td").allInnerTexts());
    const rows = await page
      .locator("tbody tr")
      .evaluateAll((all) =>
        all.map((row) => [...row.querySelectorAll("td")].map((cell) => cell.innerText)),
      );
    const distance = (row) =>
      numbers(row).reduce((sum, value, at) => {
        const scale = [0.01, 0.2, 0.2][at]; // b0 is the most certain one
        return sum + ((value - measured[at]) / (scale * Math.max(Math.abs(value), 0.05))) ** 2;
      }, 0);
    const best = rows
      .map(distance)
      .reduce((least, each, at, all) => (each < all[least] ? at : least), 0);
    await page.getByRole("radio").nth(best).press("Space");
    await press("Compare with the truth");
    await heading(page, "The truth");
    const judged = await page.locator(".result").innerText();
    assert.ok(judged.includes(`${truth.component} = `), judged);
    assert.match(judged, /^Right: |No measured signal/);
    assert.deepEqual(await axe(page), []);

    await page.getByRole("button", { name: "Once more" }).click();
    await heading(page, "Start the motor");
    await close();
  });

  story("a wrong answer stays beside the truth and what was measured", async () => {
    const { page, close } = await openPage(browser, `${server.url}/learn/exercise`);
    const press = (name) => page.getByRole("button", { name }).press("Enter");
    await press("Start the motor");
    await press(/^Set .* to /);
    await press(/^Set .* back to /);
    await press("Switch on a hidden fault");
    await page.getByRole("radio").first().waitFor();
    const run = await page.evaluate(() => JSON.parse(localStorage["faultlab.exercise"]).run);
    const { items } = await (
      await page.request.get(`${server.url}/api/v1/runs/${run}/events`)
    ).json();
    const truth = items.filter((event) => event.kind === "relay_confirmed").at(-1).component;
    // of a part that no verdict takes for the hidden one
    const wrong = truth === "R1" ? "C8" : "R1";
    await page
      .getByRole("radio", { name: new RegExp(`^${wrong} `) })
      .first()
      .press("Space");
    await press("Compare with the truth");
    const rows = page.locator(".step tbody tr");
    await rows.nth(2).waitFor();
    const named = await rows.locator("th").allInnerTexts();
    assert.equal(named[0], "measured");
    assert.ok(named[1].startsWith(`${truth} = `), named[1]);
    assert.ok(named[2].startsWith(`${wrong} = `), named[2]);
    assert.deepEqual(await axe(page), []);
    await close();
  });

  story("an exercise that is left ends its run, and fits a phone in the dark", async () => {
    const { page, close } = await openPage(browser, `${server.url}/learn`, {
      viewport: { width: 390, height: 844 },
      colorScheme: "dark",
    });
    await page.getByRole("link", { name: "Begin the exercise" }).click();
    await page.getByRole("button", { name: "Start the motor" }).click();
    await heading(page, "Watch a healthy rig");
    await noOverflow(page);
    const runOf = () => page.evaluate(() => JSON.parse(localStorage["faultlab.exercise"]).run);
    const ended = (run) => page.request.get(`${server.url}/api/v1/runs/${run}?wait=60`);
    const first = await runOf();
    await page.goto(`${server.url}/learn`); // as closing the tab
    await ended(first);
    await page.getByRole("link", { name: "Begin the exercise" }).click();
    await page.getByRole("button", { name: "Start the motor" }).click();
    await heading(page, "Change one part");
    await noOverflow(page);
    assert.deepEqual(await axe(page), []);
    const second = await runOf();
    await page.getByRole("link", { name: "← Learn" }).click();
    await ended(second);
    await page.goto(`${server.url}/learn/exercise`);
    await page.getByRole("button", { name: "Start the motor" }).click();
    await heading(page, "Watch a healthy rig");
    await page.request.post(`${server.url}/api/v1/runs/${await runOf()}/stop`);
    await heading(page, "The run has ended");
    await close();
  });

  story("a larger window has less spread and more delay, by keyboard", async () => {
    const { page, close } = await openPage(browser, `${server.url}/learn/windows`);
    await page.getByText("Spread while healthy").waitFor();
    const spread = await result(page, "Spread while healthy");
    const delay = await result(page, "Delay:");
    await page.getByRole("slider", { name: "Window K" }).focus();
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("ArrowRight");
    await becomes(page, "Spread while healthy", (now) => now < spread);
    const later = await result(page, "Delay:");
    assert.ok(later > delay, `${delay} s, then ${later} s`);
    const calm = await result(page, "Spread while healthy");
    await page.getByRole("slider", { name: "Added noise" }).press("End");
    await becomes(page, "Spread while healthy", (now) => now > calm);
    await close();
  });

  story("the published rule of integration reads a1 higher than the exact one", async () => {
    const { page, close } = await openPage(browser, `${server.url}/learn/sia`);
    await page.getByText("Mean while healthy").waitFor();
    const exact = await result(page, "Mean while healthy");
    await page.getByLabel("Rule of integration").selectOption("published");
    await becomes(page, "Mean while healthy", (now) => now > 1.2 * exact);
    await close();
  });

  story("a window says what it holds", async () => {
    const { page, close } = await openPage(browser, `${server.url}/learn/swa`);
    const holds = page.locator(".results div", { hasText: "The window holds" }).locator("dd");
    await holds.filter({ hasText: "only samples before" }).waitFor();
    const slider = page.getByRole("slider", { name: "End of the window" });
    await slider.press("End");
    await holds.filter({ hasText: "only samples after" }).waitFor();
    for (let step = 0; step < 17; step++) await slider.press("ArrowLeft");
    await holds.filter({ hasText: "describes neither" }).waitFor();
    await close();
  });

  story("two parts that cancel leave no trace in what is measured", async () => {
    const { page, close } = await openPage(browser, `${server.url}/learn/ambiguity`);
    await page.getByText("Gain k", { exact: true }).waitFor();
    assert.equal(await result(page, "Um: largest"), 0);
    const tap = await result(page, "Voltage across");
    for (let step = 0; step < 8; step++) {
      await page.getByRole("slider", { name: "R9" }).press("ArrowRight");
    }
    await becomes(page, "Um: largest", (now) => now > 0.5);
    await page.getByRole("button", { name: "Let R12 restore the gain" }).press("Enter");
    await becomes(page, "Um: largest", (now) => now < 2e-3);
    assert.ok((await result(page, "Ia: largest")) < 2e-3);
    assert.notEqual(await result(page, "Voltage across"), tap, "a measured node would tell");
    await close();
  });

  story("more false alarms buy little time", async () => {
    const { page, close } = await openPage(browser, `${server.url}/learn/detection`);
    await page.getByText("Fault detected after").waitFor();
    assert.equal(await result(page, "False alarms in"), 0);
    const delay = await result(page, "Fault detected after");
    await page.getByRole("slider", { name: "False alarms allowed" }).press("End");
    await becomes(page, "False alarms in", (now) => now >= 1);
    await becomes(page, "Fault detected after", (now) => now <= delay);
    await close();
  });

  for (const colorScheme of ["light", "dark"]) {
    story(`every page passes axe and fits 390 px, ${colorScheme}`, async () => {
      const { page, close } = await openPage(browser, `${server.url}/learn`, {
        viewport: { width: 390, height: 844 },
        colorScheme,
      });
      for (const path of ["/learn", ...TOPICS.map((topic) => `/learn/${topic}`)]) {
        await page.goto(server.url + path);
        await settled(page);
        if (path !== "/learn") await page.locator(".prose p").first().waitFor();
        if (!["/learn", "/learn/methods"].includes(path)) await page.locator(".results").waitFor();
        assert.deepEqual(await axe(page), [], path);
        await noOverflow(page);
      }
      await close();
    });
  }

  story("the theory is one link away from where one wonders", async () => {
    const { page, close } = await openPage(browser, server.url);
    const started = await page.request.post(`${server.url}/api/v1/runs`, {
      data: {
        bench: "paper",
        duration_s: 8,
        faults: [{ component: "R12", value: 5600, at_s: 6 }],
      },
    });
    assert.equal(started.status(), 201, await started.text());
    const { id } = await started.json();
    await page.goto(`${server.url}/lab/${id}`);
    for (const topic of ["ambiguity", "windows", "sia"]) {
      await page.locator(`main a[href="/learn/${topic}"]`).waitFor();
    }
    await page.goto(`${server.url}/help`);
    await page.getByRole("link", { name: "Learn how it works" }).click();
    await page.getByRole("heading", { level: 1, name: "Learn" }).waitFor();
    await close();
  });
});
