// Verdict, path, table and events of one run tell the same story.
import assert from "node:assert/strict";
import { readdirSync, statSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe } from "node:test";
import {
  launchBrowser,
  openPage,
  SUITE_MS,
  startServer,
  story,
  temporaryDirectory,
} from "./support.js";

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

  /** Each place of the page that tells what happened, as text. */
  async function placesOf(page, id, other) {
    await page.goto(`${server.url}/runs/${id}`);
    await page.locator(".verdict .heading").waitFor();
    const card = await page.locator(".verdict").innerText();
    const events = await page.getByRole("region", { name: "Events" }).innerText();
    const band = await page.locator(".card", { hasText: "Before / after" }).innerText();
    await page.goto(`${server.url}/runs`);
    const row = page.getByRole("row").filter({ has: page.locator(`a[href="/runs/${id}"]`) });
    const list = await row.innerText();
    await page.goto(`${server.url}/compare?runs=${id},${other}`);
    const compared = page.locator("table").first().locator("tbody tr").first();
    await compared.waitFor();
    return { card, events, band, list, compare: await compared.innerText() };
  }

  story("no place of the page tells another story than the server does", async () => {
    const { page, close } = await openPage(browser, server.url);
    const id = await reviewOf(page, [
      { component: "R12", value: 5600, at_s: 8 },
      { component: "R12", value: 10000, at_s: 14 },
    ]);
    const healthy = await reviewOf(page, [], 5);
    const told = await placesOf(page, id, healthy);
    assert.match(told.card, /^Fault: R9 or R12; set back$/m);
    assert.match(told.card, /8\.00–14\.00 s: R12 → 5\.6 kΩ; Fault: R9 = .* or R12 = 5\.6/);
    assert.match(told.events, /8\.00 s[\s\S]*R12 → 5\.6 kΩ/);
    assert.match(told.events, /R9 or R12/);
    assert.match(told.band, /R12 → 5\.6 kΩ|R12: /);
    for (const place of [told.list, told.compare]) {
      assert.match(place, /R12 → 5\.6 kΩ @ 8 s/);
      assert.match(place, /Fault: R9 or R12/);
    }

    // As if the server told another one: each place follows, and nothing of the first is left.
    const another = (json) =>
      JSON.parse(JSON.stringify(json).replaceAll('"R9"', '"R1"').replaceAll('"R12"', '"Ra"'));
    const retold = (run) => ({ ...run, story: another(run.story) });
    await page.route(/\/api\/v1\/runs(\/[^/]+)?(\?.*)?$/, async (route) => {
      const answer = await route.fetch();
      const json = await answer.json();
      const other = json.items ? { ...json, items: json.items.map(retold) } : retold(json);
      await route.fulfill({ response: answer, json: other });
    });
    const other = await placesOf(page, id, healthy);
    assert.match(other.card, /^Fault: R1 or Ra; set back$/m);
    assert.match(other.events, /R1 or Ra/);
    for (const [place, text] of Object.entries(other)) {
      assert.match(text, /\bRa\b/, place);
      // what the rig did is an event as it came
      const rest = place === "events" ? text.replace(/R12 → .*/g, "") : text;
      assert.doesNotMatch(rest, /\bR9\b|\bR12\b/, place);
    }
    await close();
  });

  story("a run that its server did not see the end of is told as far as it came", async () => {
    const folder = temporaryDirectory();
    let own = await startServer({ data: folder.path });
    let { page, close } = await openPage(browser, own.url);
    const start = (faults) =>
      page.request
        .post(`${own.url}/api/v1/runs`, { data: { bench: "paper", duration_s: 600, faults } })
        .then((answer) => answer.json());
    const of = async (id) => (await page.request.get(`${own.url}/api/v1/runs/${id}`)).json();
    const { id } = await start([{ component: "R1", value: 100, at_s: 3 }]);
    // a second of samples is written at once
    for (let run = await of(id); !(run.samples >= 600); run = await of(id));
    const { id: empty } = await start([{ component: "R1", value: 100, at_s: 3 }]);
    await close();
    await own.stop("SIGKILL");
    const files = readdirSync(folder.path, { recursive: true });
    assert.ok(files.length > 0);
    for (const file of files)
      assert.equal(statSync(join(folder.path, file)).mode & 0o077, 0, `${file} is read by others`);

    own = await startServer({ data: folder.path });
    ({ page, close } = await openPage(browser, own.url));
    const ended = await of(id);
    assert.notEqual(ended.state, "running");
    assert.equal(ended.story.changes.length, 1, JSON.stringify(ended.story));
    await page.goto(`${own.url}/runs`);
    for (const [run, words] of [
      [id, /R1 → 100 Ω @ 3 s/],
      [empty, /ended at|no fault/i],
    ]) {
      const row = page.getByRole("row").filter({ has: page.locator(`a[href="/runs/${run}"]`) });
      assert.match(await row.innerText(), words);
    }
    for (const run of [id, empty]) {
      await page.goto(`${own.url}/runs/${run}`);
      await page.locator(".verdict .heading").waitFor();
      assert.match(await page.locator(".verdict").innerText(), /no verdict/i);
      for (const file of ["report.pdf", "export.csv", "export.json", "export.mat"]) {
        const answer = await page.request.get(`${own.url}/api/v1/runs/${run}/${file}`);
        assert.equal(answer.status(), 200, `${file}: ${await answer.text()}`);
      }
    }
    await close();
    await own.stop();
    folder.remove();
  });
});
