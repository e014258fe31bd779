import assert from "node:assert/strict";
import { createServer } from "node:http";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import { axe, becomes, confirmIn, launchBrowser, SUITE_MS, startServer, story } from "./support.js";

describe("webhooks", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let program;
  let url;
  const taken = [];

  before(async () => {
    program = createServer((request, response) => {
      let body = "";
      request.on("data", (part) => {
        body += part;
      });
      request.on("end", () => {
        taken.push({ path: request.url, body: JSON.parse(body) });
        response.writeHead(request.url === "/ready" ? 204 : 500).end();
      });
    });
    await new Promise((ready) => program.listen(0, "127.0.0.1", ready));
    url = `http://127.0.0.1:${program.address().port}`;
    server = await startServer({ settings: "[webhooks]\ninsecure_local = true\n" });
    browser = await launchBrowser();
    world = await makeWorld(server);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
    program?.close();
  });

  story("an admin adds a program, tests it, sees its attempts and removes it", async () => {
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    const card = page.getByRole("region", { name: "Webhooks" });
    await card.getByText("No program is told.").waitFor();
    for (const path of ["/ready", "/broken"]) {
      await card.getByLabel("Address").fill(url + path);
      await card.getByLabel("a rig is in quarantine").check();
      await card.getByRole("button", { name: "Add the webhook" }).click();
      await card
        .getByText(/^The secret of/)
        .filter({ hasText: url + path })
        .waitFor();
      assert.match(await card.locator("code").textContent(), /^whsec_/);
    }
    assert.deepEqual(await axe(page), []);
    await card.getByRole("button", { name: `Send a test ${url}/ready` }).click();
    await card.getByText(`${url}/ready has taken the test.`).waitFor();
    await card.getByText(/^last taken/).waitFor();
    await card.getByRole("button", { name: `Send a test ${url}/broken` }).click();
    await card.getByText(`${url}/broken has not taken the test:`).waitFor();
    await card.getByText(/^last failed/).waitFor();
    assert.deepEqual(
      taken.map((each) => each.path),
      ["/ready", "/broken"],
    );
    await card.getByRole("button", { name: `Remove ${url}/broken` }).click();
    await confirmIn(page);
    await card.getByText(`${url}/broken`, { exact: true }).waitFor({ state: "detached" });
    const { json } = await world.call(world.admin, "GET", "/webhooks");
    assert.deepEqual(
      json.items.map((each) => [each.url, each.kinds]),
      [[`${url}/ready`, ["rig_quarantined"]]],
    );
    await close();
  });

  story("whoever has a job is told when it has ended, by a webhook of their own", async () => {
    const ann = await world.user("ann", "Ann", "student");
    const { page, close } = await pageOf(browser, server, ann, "/account");
    const card = page.getByRole("region", { name: "Webhooks" });
    await card.getByLabel("Address").fill(`${url}/ready`);
    for (const what of ["a run of yours", "a job of yours", "the last job of a batch"]) {
      await card.getByLabel(`${what} has ended`).check();
    }
    assert.equal(await card.getByLabel("a rig is in quarantine").count(), 0);
    await card.getByRole("button", { name: "Add the webhook" }).click();
    await card.getByText(/^The secret of/).waitFor();
    assert.deepEqual(await axe(page), []);
    taken.length = 0;
    const before = await world.call(world.admin, "GET", "/webhooks");
    assert.deepEqual(
      before.json.items.map((each) => each.of),
      ["lab"],
      "hers is not shown",
    );
    const runs = [{ duration_s: 2 }, { duration_s: 3 }];
    const { json } = await world.call(ann, "POST", "/jobs", { name: "night", runs });
    const { batch } = json.items[0];
    const kinds = async () => taken.map(({ body }) => body.type).sort();
    await becomes(kinds, ["batch_ended", "job_ended", "job_ended", "run_ended", "run_ended"]);
    const last = taken.find(({ body }) => body.type === "batch_ended").body.data;
    assert.deepEqual(last, { batch, jobs: { finished: 2 } });
    await close();
  });
});
