import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import {
  axe,
  launchBrowser,
  openPage,
  START,
  SUITE_MS,
  startPaperRun,
  startServer,
  story,
  waitForReview,
} from "./support.js";

const SPEED = 2;

describe("access", { timeout: SUITE_MS }, () => {
  let server;
  let browser;

  before(async () => {
    server = await startServer({ speed: SPEED });
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  story("axe finds nothing while a run is live, with menu, table and key list open", async () => {
    const { page, close } = await openPage(browser, server.url);
    await page.getByLabel("Duration, s").fill("200");
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);
    await page.locator("#set-R1:not([disabled])").waitFor();
    await page.keyboard.press("t");
    await page.getByRole("region", { name: "Samples as a table" }).waitFor();
    await page.locator("summary", { hasText: "Download" }).click();
    assert.deepEqual(await axe(page), []);
    await page.keyboard.press("Escape");
    await page.getByRole("button", { name: "Keys" }).click();
    await page.getByRole("dialog").waitFor();
    assert.deepEqual(await axe(page), []);
    await page.keyboard.press("Escape");
    await page.getByRole("button", { name: /^Stop/ }).click();
    await waitForReview(page);
    await close();
  });

  story("the whole way by keyboard: start, fault, read, stop, report, download", async () => {
    const { page, context, close } = await openPage(browser, server.url);
    await page.getByRole("button", { name: START }).waitFor();
    /** What has the focus; it must show that it has, a slider by its thumb (gates.test.js). */
    const focused = () =>
      page.evaluate(() => {
        const element = document.activeElement;
        const { outlineStyle, outlineWidth } = getComputedStyle(element);
        const ringed = outlineStyle !== "none" && Number.parseFloat(outlineWidth) >= 1;
        return {
          name: `${element.tagName} ${element.id} ${element.textContent.trim().slice(0, 60)}`,
          seen: ringed || element.type === "range" || element === document.body,
          lost: element === document.body,
        };
      });
    const notLost = async (after) => {
      await page.waitForFunction(() => document.activeElement !== document.body);
      assert.equal((await focused()).lost, false, `after ${after}`);
    };
    const focusOn = async (matches) => {
      let lost = 0;
      for (let press = 0; press < 80; press++) {
        await page.keyboard.press("Tab");
        const here = await focused();
        assert.ok(here.seen, `nobody sees that ${here.name} has the focus`);
        if (matches.test(here.name)) return;
        if (here.lost) lost++; // once round, the focus leaves the page
        assert.ok(lost < 2, `never reached ${matches}`);
      }
      assert.fail(`never reached ${matches}`);
    };
    await focusOn(/BUTTON {2}Run the paper/);
    await page.keyboard.press("Enter");
    await page.waitForURL(/\/lab\/.+/);
    await page.locator("#set-R12:not([disabled])").waitFor();
    await notLost("the start");
    await page.keyboard.press("Space");
    await page.getByRole("button", { name: /Resume/ }).waitFor();
    const live = page.getByRole("button", { name: /^Live/ });
    assert.equal(await live.getAttribute("aria-pressed"), "false", "paused is not live");
    await page.keyboard.press("l");
    await page.getByRole("button", { name: /Pause/ }).waitFor();
    assert.equal(await live.getAttribute("aria-pressed"), "true");
    await focusOn(/INPUT set-R12/);
    await page.keyboard.press("ArrowRight");
    await page.locator(".slider:not(.nominal) #set-R12").waitFor();
    await page.keyboard.press("Escape");
    await waitForReview(page);
    await notLost("Stop");
    await focusOn(/SUMMARY .*Download/);
    await page.keyboard.press("Enter");
    await focusOn(/A {2}Report/);
    const asked = context.waitForEvent("request", (request) => /report\.pdf/.test(request.url()));
    await page.keyboard.press("Enter");
    await asked;
    await page.bringToFront();
    await focusOn(/A {2}CSV/);
    const waiting = page.waitForEvent("download");
    await page.keyboard.press("Enter");
    assert.match((await waiting).suggestedFilename(), /\.csv$/);
    await close();
  });

  story("a screen reader hears the fault, its detection and the end", async () => {
    const { page, close } = await openPage(browser, server.url);
    await page.evaluate(() => {
      const region = document.querySelector('[role="status"]');
      globalThis.heard = [];
      new MutationObserver(() => {
        globalThis.heard.push({ text: region.textContent });
      }).observe(region, { childList: true, characterData: true, subtree: true });
    });
    await startPaperRun(page);
    await waitForReview(page);
    await page.waitForFunction(() =>
      globalThis.heard.some((entry) => /The run has ended/.test(entry.text)),
    );
    const heard = await page.evaluate(() => globalThis.heard);
    assert.ok(
      heard.some((entry) => /R1 is now 100 Ω/.test(entry.text)),
      JSON.stringify(heard),
    );
    assert.ok(
      heard.some((entry) => /Fault detected/.test(entry.text)),
      JSON.stringify(heard),
    );
    await close();
  });

  story(
    "Serbian in both scripts is chosen, kept over a reload, and the page says its language",
    async () => {
      const { page, close } = await openPage(browser, server.url);
      const choose = (name) => page.locator("header select").first().selectOption({ label: name });
      await choose("Srpski");
      await page.getByRole("button", { name: "Pokreni ogled iz rada" }).waitFor();
      await choose("Српски");
      await page.getByRole("button", { name: "Покрени оглед из рада" }).waitFor();
      await page.reload();
      await page.getByRole("button", { name: "Покрени оглед из рада" }).waitFor();
      assert.equal(await page.evaluate(() => document.documentElement.lang), "sr-Cyrl");
      assert.deepEqual(await axe(page), []);
      await close();
    },
  );

  story("the policy is sealed: nothing inline, nothing from elsewhere", async () => {
    const { page, close } = await openPage(browser, server.url);
    const answer = await page.request.get(server.url);
    const policy = answer.headers()["content-security-policy"];
    assert.match(policy, /default-src 'self'/);
    assert.doesNotMatch(policy, /unsafe|\*|data:/);
    const ran = await page.evaluate(() => {
      const script = document.createElement("script");
      script.textContent = "globalThis.inlineRan = true";
      const blocked = new Promise((resolve) => {
        document.addEventListener("securitypolicyviolation", (event) =>
          resolve(event.effectiveDirective),
        );
      });
      document.head.append(script);
      return blocked.then((directive) => ({ directive, ran: globalThis.inlineRan === true }));
    });
    assert.deepEqual(ran, { directive: "script-src-elem", ran: false });
    await page.context().close();
    void close;
  });
});
