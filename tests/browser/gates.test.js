// What every page must keep: nothing for axe to find in either theme, no text below 12 px, no page
// wider than its screen, at any zoom; sharp canvases; the system's own colours; focus that is seen.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import { coloursAt, contrast, differences, outside, smallTexts } from "./look.js";
import { axe, launchBrowser, openPage, SUITE_MS, settled, startServer, story } from "./support.js";

/** Width in CSS pixels: a zoom of 200 % and 400 % of 1280, and telephones. */
const WIDTHS = [640, 390, 360, 320];

describe("every page", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let people;
  let runs;
  let link;

  before(async () => {
    server = await startServer({ speed: 0, benches: 1 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    const [student, teacher] = await Promise.all([
      world.user("pera", "Pera", "student"),
      world.user("vera", "Vera", "instructor"),
    ]);
    people = { student, teacher, admin: world.admin };
    const course = await world.course(teacher, "Diagnosis", [student]);
    await world.join(student, course);
    const { json: eva } = await world.call(world.admin, "POST", "/users", {
      login: "eva",
      name: "Eva",
    });
    const made = await world.call(world.admin, "POST", `/users/${eva.id}/reset-link`, {});
    link = made.json.link;
    runs = [];
    for (const [component, value] of [
      ["R1", 100],
      ["R12", 5600],
    ]) {
      const faults = [{ component, value, at_s: 10 }];
      runs.push(await world.run(student, { duration_s: 20, faults }));
    }
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  async function open(who, path, options = {}) {
    const opened = who
      ? await pageOf(browser, server, people[who], path, options)
      : await openPage(browser, server.url + path, options);
    await settled(opened.page);
    return opened;
  }
  async function openRun(options) {
    const opened = await open("student", `/runs/${runs[0]}`, options);
    await opened.page.locator(".plot canvas").nth(6).waitFor();
    await opened.page.locator("#set-R9").waitFor();
    return opened;
  }
  /** A page takes its new size. */
  async function resize(page, width) {
    await page.setViewportSize({ width, height: 800 });
    await page.evaluate(
      () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))),
    );
  }

  for (const [who, path] of [
    [null, "/"],
    [null, "/signin"],
    [null, "LINK"],
    [null, "/api"],
    [null, "/help"],
    [null, "/status"],
    [null, "/nowhere"],
    [null, "/learn"],
    ["student", "/runs"],
    ["student", "/runs/RUN"],
    ["student", "/compare?runs=RUNS"],
    ["student", "/my"],
    ["student", "/sessions"],
    ["student", "/book"],
    ["student", "/jobs"],
    ["student", "/tasks"],
    ["student", "/account"],
    ["teacher", "/teach"],
    ["admin", "/admin"],
  ]) {
    story(`${path}: axe in both themes, size of texts, width`, async () => {
      const address = path
        .replace("RUNS", runs.join())
        .replace("RUN", runs[0])
        .replace("LINK", link);
      const { page, close } = await open(who, address, { viewport: { width: 1280, height: 800 } });
      for (const colorScheme of ["light", "dark"]) {
        await page.emulateMedia({ colorScheme });
        assert.deepEqual(await axe(page), [], colorScheme);
      }
      assert.deepEqual(await smallTexts(page), []);
      for (const width of WIDTHS) {
        await resize(page, width);
        assert.deepEqual(await outside(page), [], `${width} px`);
      }
      assert.deepEqual(await smallTexts(page), []);
      // letters of twice the size on a wide screen
      await resize(page, 1280);
      await page.evaluate(() => {
        document.documentElement.style.fontSize = "28px";
      });
      assert.deepEqual(await outside(page), [], "large letters");
      await close();
    });
  }

  story("canvases are as fine as the screen, and the layout does not depend on it", async () => {
    const layouts = [];
    for (const deviceScaleFactor of [1, 1.5, 2]) {
      const { page, close } = await openRun({ deviceScaleFactor });
      const charts = await page.locator("canvas").evaluateAll((canvases) =>
        canvases
          .filter((each) => each.checkVisibility())
          .map((each) => {
            const { left, top, width, height } = each.getBoundingClientRect();
            return { place: [left, top, width, height], pixels: [each.width, each.height] };
          }),
      );
      assert.ok(charts.length >= 9, `${charts.length} canvases`);
      for (const { place, pixels } of charts) {
        for (const side of [0, 1]) {
          const fine = place[2 + side] * deviceScaleFactor;
          assert.ok(Math.abs(pixels[side] - fine) <= 1.5, `${pixels} for ${place}`);
        }
      }
      layouts.push(charts.map(({ place }) => place.map(Math.round)));
      await close();
    }
    for (const layout of layouts.slice(1)) {
      layout.flat().forEach((side, at) => {
        assert.ok(Math.abs(side - layouts[0].flat()[at]) <= 1, JSON.stringify(layouts));
      });
    }
  });

  /** What stands around an element changes when it has the focus. */
  async function ringOf(page, element) {
    await element.scrollIntoViewIfNeeded();
    const box = await element.boundingBox();
    const clip = { x: box.x - 5, y: box.y - 5, width: box.width + 10, height: box.height + 10 };
    await page.evaluate(() => document.activeElement.blur());
    const before = await page.screenshot({ clip });
    await page.keyboard.press("Shift"); // the focus that follows is shown as one by keyboard
    await element.focus();
    const after = await page.screenshot({ clip });
    return differences(page, before, after);
  }

  for (const media of [
    { colorScheme: "light" },
    { colorScheme: "dark" },
    { forcedColors: "active" },
    { forcedColors: "active", colorScheme: "dark" },
  ]) {
    const name = Object.values(media).join(" ");
    story(`${name}: sliders, what is selected and the focus can be seen`, async () => {
      const { page, close } = await openRun(media);
      const slider = page.locator("#set-R9");
      const [track, thumb, ground] = await coloursAt(page, await slider.screenshot(), [
        [0.5, 0.5],
        [9 / 250, 0.5],
        [0.5, 0.1],
      ]);
      assert.ok(contrast(track, ground) > 1.3, `track ${track} on ${ground}`);
      assert.ok(contrast(thumb, ground) > 3, `thumb ${thumb} on ${ground}`);

      for (const [group, selected] of [
        ["[role=group] button", "[aria-pressed=true]"],
        ["nav a", "[aria-current]"],
      ]) {
        const corner = [[0.04, 0.5]];
        const both = [];
        for (const each of [`${group}${selected}`, `${group}:not(${selected})`]) {
          const picture = await page.locator(each).first().screenshot();
          both.push((await coloursAt(page, picture, corner))[0]);
        }
        assert.ok(contrast(...both) > (media.forcedColors ? 3 : 1.05), `${group}: ${both}`);
      }

      for (const each of [
        slider,
        page.getByRole("button", { name: "Model check" }),
        page.getByLabel("Time window"),
        page.getByRole("link", { name: "New run" }),
        page.getByRole("slider", { name: "Whole run" }),
      ]) {
        const seen = await ringOf(page, each);
        assert.ok(seen > 60, `${each}: ${seen} pixels differ`);
      }
      // and the ring of a slider leaves its labels alone
      for (const part of [".head", ".ticks"]) {
        const label = page.locator(`.slider:has(#set-R9) ${part}`);
        await slider.blur();
        const before = await label.screenshot();
        await page.keyboard.press("Shift");
        await slider.focus();
        assert.equal(await differences(page, before, await label.screenshot()), 0, part);
      }
      await close();
    });

    story(
      `${name}: free, taken and past differ in the calendar, and disabled looks it`,
      async () => {
        const { page, close } = await open("student", "/book", media);
        const sample = (state) => page.locator(`.sample.${state}`).screenshot();
        await page.locator(".sample.free").waitFor();
        const middle = async (state) =>
          (await coloursAt(page, await sample(state), [[0.5, 0.5]]))[0];
        if (!media.forcedColors) {
          const [free, past] = [await middle("free"), await middle("past")];
          assert.ok(contrast(free, past) >= 1.3, `free ${free}, past ${past}`);
        }
        const states = ["free", "taken", "mine", "outage", "past"];
        for (const one of states) {
          for (const other of states.slice(states.indexOf(one) + 1)) {
            const differ = await differences(page, await sample(one), await sample(other));
            assert.ok(differ > 20 || !media.forcedColors, `${one} and ${other}: ${differ} pixels`);
          }
        }
        const look = (words) =>
          page.getByRole("button", { name: words }).evaluate((button) => {
            const { color, backgroundColor, borderColor, borderStyle } = getComputedStyle(button);
            return [color, backgroundColor + borderStyle, borderColor];
          });
        const [disabled, enabled] = [await look("Week before"), await look("Week after")];
        disabled.forEach((each, at) => {
          assert.notEqual(each, enabled[at]);
        });
        await close();
      },
    );
  }
});
