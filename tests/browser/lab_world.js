// The people of a lab and their pages, made over the REST interface, so that a test of the page can
// start with data.
import assert from "node:assert/strict";
import { openPage, until } from "./support.js";

export const PASSWORD = "correct horse battery";

/** Accounts, courses and sign-ins on `server`; the first-start link makes the admin. */
export async function makeWorld(server) {
  const token = /reset\?token=([\w-]+)/.exec(server.output())?.[1];
  assert.ok(token, `the first start prints a link:\n${server.output()}`);

  async function call(who, method, path, body, type = "application/json", more = {}) {
    const headers = { ...(who ? { Cookie: who.cookie, "X-CSRF-Token": who.csrf } : {}), ...more };
    if (body !== undefined) headers["Content-Type"] = type;
    const answer = await fetch(`${server.url}/api/v1${path}`, {
      method,
      headers,
      body: typeof body === "object" ? JSON.stringify(body) : body,
    });
    const text = await answer.text();
    assert.ok(answer.ok, `${method} ${path}: ${answer.status} ${text}`);
    return { answer, json: text ? JSON.parse(text) : {} };
  }
  async function signIn(login) {
    const { answer, json } = await call(null, "POST", "/auth/login", { login, password: PASSWORD });
    return { login, cookie: answer.headers.get("set-cookie").split(";")[0], csrf: json.csrf_token };
  }
  const reset = (secret) =>
    call(null, "POST", "/auth/reset", { token: secret, password: PASSWORD });

  await reset(token);
  const admin = await signIn("admin");
  return {
    admin,
    call,
    /** Changes settings of the lab's policy. */
    async policy(settings) {
      const { json } = await call(admin, "GET", "/policy");
      const { version, ...now } = json;
      await call(admin, "PUT", "/policy", { ...now, ...settings }, undefined, {
        "If-Match": `"${version}"`,
      });
    },
    async user(login, name, role) {
      const { json: user } = await call(admin, "POST", "/users", { login, name, role });
      const { json } = await call(admin, "POST", `/users/${user.id}/reset-link`, {});
      await reset(json.link.split("token=")[1]);
      return signIn(login);
    },
    /** Invites `students`, who have accounts; each joins by accepting. */
    async course(teacher, name, students) {
      const { json: course } = await call(teacher, "POST", "/courses", { name });
      const lines = students.map((who) => `${who.login},${who.login}`).join("\n");
      await call(
        teacher,
        "POST",
        `/courses/${course.id}/members`,
        `login,name\n${lines}\n`,
        "text/csv",
      );
      return course;
    },
    async join(student, course) {
      await call(student, "POST", `/invitations/${course.id}/accept`, {});
    },
    /** A run of `who` on the paper's bench that is over; its id. */
    async run(who, plan) {
      const { json: run } = await call(who, "POST", "/runs", { bench: "paper", ...plan });
      const state = async () => (await call(who, "GET", `/runs/${run.id}`)).json.state;
      await until(state, (now) => now !== "running");
      return run.id;
    },
    /** Waits until `count` benches have passed their first check. */
    async benchesReady(count) {
      const classes = async () => (await call(admin, "GET", "/rig-classes")).json.items;
      await until(
        classes,
        (now) => now.reduce((sum, each) => sum + (each.elastic ? 0 : each.ready), 0) >= count,
      );
    },
  };
}

/** A page on which `who` is signed in. */
export async function pageOf(browser, server, who, path, options = {}) {
  const [name, value] = who.cookie.split("=");
  const storageState = { cookies: [{ name, value, url: server.url }] };
  return openPage(browser, server.url + path, { ...options, storageState });
}
