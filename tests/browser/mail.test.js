// A class gets the links that open its accounts by mail.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { PASSWORD as MAIL_PASSWORD, startMailServer } from "../mail_server/mail_server.js";
import { makeWorld, PASSWORD, pageOf } from "./lab_world.js";
import {
  axe,
  confirmIn,
  freePort,
  launchBrowser,
  openPage,
  SUITE_MS,
  startServer,
  story,
  temporaryDirectory,
  until,
} from "./support.js";

describe("mail", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let teacher;
  let mail;
  let data;
  let listen;
  const start = async () => {
    server = await startServer({
      data: data.path,
      listen,
      top: `public_url = "http://${listen}"\n`,
      settings: mail.settings,
    });
  };

  before(async () => {
    process.env.FAULTLAB_TEST_MAIL_PASSWORD = MAIL_PASSWORD;
    data = temporaryDirectory();
    mail = await startMailServer(data.path);
    listen = `127.0.0.1:${await freePort()}`;
    await start();
    world = await makeWorld(server);
    teacher = await world.user("teacher", "Žarko Učitelj", "instructor");
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
    await mail?.stop();
    data?.remove();
  });

  const to = (address) => mail.mails.filter((each) => each.to === address);
  const linkIn = ({ body }) => /http:\/\/\S+/.exec(body)[0];

  story("a teacher mails the links, and whom no mail reaches is told", async () => {
    await world.call(teacher, "POST", "/courses", { name: "Pogoni „A“" });
    const desk = await pageOf(browser, server, teacher, "/teach");
    const { page } = desk;
    await page.getByRole("button", { name: "Add members, Pogoni „A“" }).click();
    const list =
      "Matrikelnummer;Name;E-Mail\n1001;Jörg Groß;jorg@example.org\n1002;Anna Kiss;nobody@example.org\n" +
      "1003;Ben Ohne;\n1004;Eva Spät;busy@example.org\n1005;Ivo Inject;ivo@example.org>RCPT\n";
    await page.getByRole("textbox", { name: /^Students, one per line/ }).fill(list);
    await page.getByRole("button", { name: "Look at the list first" }).click();
    await page.getByText("Addresses are taken from “E-Mail”.").waitFor();
    await page.getByRole("button", { name: "Add all 5" }).click();
    await page.getByText("5 of this course have no password yet.").waitFor();
    await page.getByRole("button", { name: "Mail them their links" }).click();
    await page.getByText(/Each student gets a mail from lab@example\.org/).waitFor();
    await confirmIn(page);
    await page
      .getByText("No address is known of 2 students: 1003, 1005.", { exact: false })
      .waitFor();
    await page.getByText("Mails: 2 taken by the mail server, 0 waiting, 1 refused.").waitFor();
    await page.getByText(/1002: .*550 .*no such student/).waitFor();
    assert.deepEqual(await axe(page), []);
    await desk.close();

    const [mine] = to("jorg@example.org");
    assert.equal(mine.secure, true, "by STARTTLS");
    assert.equal(mine.subject, "Your account in the laboratory: Pogoni „A“");
    assert.match(mine.headers["Message-ID"], /^<[\w-]+@example\.org>$/);
    assert.match(mine.headers.Date, /^\w{3}, \d{2} \w{3} \d{4} [\d:]{8} \+0000$/);
    assert.match(mine.body, /Hello Jörg Groß,.*Žarko Učitelj.*login is 1001/s);
    await fetch(linkIn(mine)); // a scanner of mail follows it
    const jorg = await openPage(browser, linkIn(mine));
    await jorg.page.getByText("For the account of Jörg Groß, login 1001.").waitFor();
    await jorg.page.getByLabel("New password").fill(PASSWORD);
    await jorg.page.getByLabel("Repeat the password").fill(PASSWORD);
    await jorg.page.getByRole("button", { name: "Save and sign in" }).click();
    await jorg.page.getByRole("heading", { name: "My lab" }).waitFor();
    await jorg.close();
    assert.equal(to("busy@example.org").length, 1, "tried again");
  });

  story("none is lost though the mail server is away and the lab is killed", async () => {
    const { json: course } = await world.call(teacher, "POST", "/courses", { name: "Second" });
    const people = Array.from({ length: 40 }, (_, i) => `p${i}@example.org,Person ${i}`);
    const members = `/courses/${course.id}/members`;
    const kill = async () => {
      await server.stop("SIGKILL");
      await start();
    };
    await world.call(teacher, "POST", members, people.join("\n"), "text/csv");
    mail.mood.away = true;
    const { json: queued } = await world.call(
      teacher,
      "POST",
      `/courses/${course.id}/mails?language=sr`,
      {},
    );
    assert.deepEqual(queued, { queued: 40, without: [] });
    const state = async () =>
      (await world.call(teacher, "GET", `/courses/${course.id}/mails`)).json.items;
    await until(state, (items) => items.some((each) => /421/.test(each.error)));
    const { json: again } = await world.call(teacher, "POST", `/courses/${course.id}/mails`, {});
    assert.equal(again.queued, 0, "each has one waiting");
    mail.mood.away = false;
    const killAt = 5 + mail.mails.length;
    await new Promise((resolve) => {
      mail.mood.takes = () => mail.mails.length >= killAt && resolve();
    });
    await kill();
    await until(
      async () => people.filter((_, i) => to(`p${i}@example.org`).length > 0).length,
      (count) => count === people.length,
    );
    await until(state, (items) => items.every((each) => each.state === "delivered"));
    const twice = people.filter((_, i) => to(`p${i}@example.org`).length > 1);
    assert.ok(twice.length <= 1, `${twice} got two`); // what was on its way when the lab was killed
    for (const [sent] of people.map((_, i) => to(`p${i}@example.org`))) {
      assert.match(sent.subject, /^Vaš nalog u laboratoriji: Second$/);
    }
  });

  story("a wrong password stops all mail and refuses nobody", async () => {
    const { json: course } = await world.call(teacher, "POST", "/courses", { name: "Third" });
    mail.mood.password = "another";
    await world.call(
      teacher,
      "POST",
      `/courses/${course.id}/members`,
      "q@example.org,Quinn",
      "text/csv",
    );
    await world.call(teacher, "POST", `/courses/${course.id}/mails`, {});
    const state = async () =>
      (await world.call(teacher, "GET", `/courses/${course.id}/mails`)).json.items[0];
    await until(state, (item) => item.error !== "");
    assert.equal((await state()).state, "waiting");
    mail.mood.password = MAIL_PASSWORD;
    await until(state, (item) => item.state === "delivered");
  });
});
