// Verdict, path, table and events of one run tell the same story.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { launchBrowser, openPage, SUITE_MS, startServer, story } from "./support.js";

describe("the parts of the run page", { timeout: SUITE_MS }, () => {
  let server;
  let browser;

  before(async () => {
    server = await startServer({ speed: 0 });
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  /** Opens a run with these faults when it is over. */
  async function reviewOf(page, faults, duration_s = 30) {
    const answer = await page.request.post(`${server.url}/api/v1/runs`, {
      data: { bench: "paper", duration_s, faults },
    });
    const { id } = await answer.json();
    const of = async () => (await page.request.get(`${server.url}/api/v1/runs/${id}`)).json();
    for (let run = await of(); run.state === "running"; run = await of());
    await page.goto(`${server.url}/runs/${id}`);
    await page.locator(".verdict .heading").waitFor();
    return id;
  }

  story("the paper's path says that it disagrees, and why", async () => {
    const { page, close } = await openPage(browser, server.url);
    await reviewOf(page, [{ component: "R12", value: 5600, at_s: 10 }], 20);
    assert.match(await page.locator(".verdict .heading").innerText(), /Fault: R9 or R12/);
    const path = page.locator(".card", { hasText: "Decision path of the paper" });
    await path.locator(".differs").waitFor();
    assert.match(
      await path.locator(".differs").innerText(),
      /Disagrees with the verdict.*ends at B, but the verdict is R9 or R12.*was close: −0\.007\d*, limit 0\.005\d*/s,
    );
    await close();
  });

  story("a part that was switched twice is told by its last change", async () => {
    const { page, close } = await openPage(browser, server.url);
    await reviewOf(page, [
      { component: "R1", value: 10, at_s: 10 },
      { component: "R1", value: 56, at_s: 18 },
    ]);
    assert.match(
      await page.locator(".verdict").innerText(),
      /R1 ↑[\s\S]*56\.\d[\s\S]*R1 → 56 Ω, 18\.00 s/,
    );
    const table = page.locator(".card", { hasText: "Before / after" });
    await table.getByText(/calculated from the data sheet for R1 = 56 Ω/).waitFor();
    const which = table.getByLabel("Change that is shown");
    assert.equal(await which.locator("option:checked").innerText(), "R1: 10 Ω → 56 Ω, 18.00 s");
    await which.selectOption({ index: 0 });
    await table.getByText(/calculated from the data sheet for R1 = 10 Ω/).waitFor();
    const events = await page.getByRole("region", { name: "Events" }).locator("li").allInnerTexts();
    const detected = events.filter((each) => each.includes("detected"));
    assert.equal(detected.length, 2, detected.join());
    assert.match(detected[0], /^18\.0/);
    await close();
  });

  story("a fault that was set back is told beside the one that came after it", async () => {
    const { page, close } = await openPage(browser, server.url);
    await reviewOf(page, [
      { component: "R1", value: 100, at_s: 8 },
      { component: "R1", value: 1, at_s: 14 },
      { component: "R12", value: 5600, at_s: 20 },
    ]);
    const card = await page.locator(".verdict").innerText();
    assert.match(card, /Fault: R9 or R12/);
    assert.match(
      card,
      /Earlier in this run\s+8\.00–14\.00 s: R1 → 100 Ω; Fault: R1 = (99|100|101)\b/,
    );
    await close();
  });
});
