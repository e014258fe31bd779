// A mail server, `smtp-server` (npm): STARTTLS with a certificate of its own, a password, and the moods of real ones.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

// The packages of the sign-in provider's tests.
const require = createRequire(new URL("../oidc_provider/package.json", import.meta.url));
const { SMTPServer } = require("smtp-server");

const USER = "lab";
export const PASSWORD = "a password of mail";

/** @param folder  where its certificate is made */
export async function startMailServer(folder) {
  const key = join(folder, "key.pem");
  const certificate = join(folder, "certificate.pem");
  execFileSync(
    "openssl",
    [
      "req",
      "-x509",
      "-newkey",
      "rsa:2048",
      "-nodes",
      "-days",
      "2",
      "-subj",
      "/CN=localhost",
    ].concat(["-addext", "subjectAltName=DNS:localhost", "-keyout", key, "-out", certificate]),
    { stdio: "ignore" },
  );
  const mails = [];
  const busy = new Set();
  const mood = { password: PASSWORD, away: false, takes: () => {} };
  const refusal = (code, words) => Object.assign(new Error(words), { responseCode: code });
  const server = new SMTPServer({
    key: readFileSync(key),
    cert: readFileSync(certificate),
    authMethods: ["PLAIN", "LOGIN"],
    onAuth({ username, password }, _session, done) {
      if (username === USER && password === mood.password) done(null, { user: username });
      else done(refusal(535, "who are you"));
    },
    onMailFrom(_address, _session, done) {
      done(mood.away ? refusal(421, "too many mails, later") : undefined);
    },
    onRcptTo({ address }, _session, done) {
      if (address.startsWith("nobody")) return done(refusal(550, "no such student"));
      if (address.startsWith("busy") && !busy.has(address)) {
        busy.add(address);
        return done(refusal(451, "greylisted"));
      }
      return done();
    },
    onData(stream, session, done) {
      let text = "";
      stream.setEncoding("utf8");
      stream.on("data", (chunk) => {
        text += chunk;
      });
      stream.on("end", () => {
        mails.push({
          ...read(text),
          to: session.envelope.rcptTo[0].address,
          secure: session.secure,
        });
        mood.takes();
        done();
      });
    },
  });
  server.on("error", () => {}); // whoever is killed says no goodbye
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const { port } = server.server.address();
  return {
    mails,
    mood,
    settings: `[mail]
smtp = "smtp://localhost:${port}"
user = "${USER}"
password_env = "FAULTLAB_TEST_MAIL_PASSWORD"
from = "lab@example.org"
per_minute = 6000
ca_file = "${certificate}"
`,
    stop: () => new Promise((resolve) => server.close(resolve)),
  };
}

function read(text) {
  const end = text.indexOf("\r\n\r\n");
  const head = text.slice(0, end).replaceAll(/\r\n[ \t]/g, " ");
  const headers = Object.fromEntries(
    head
      .split("\r\n")
      .map((line) => [line.slice(0, line.indexOf(":")), line.slice(line.indexOf(":") + 2)]),
  );
  const words = /=\?UTF-8\?B\?([^?]*)\?=\s*/g;
  const decoded = (value) =>
    value.replace(words, (_all, word) => Buffer.from(word, "base64").toString("latin1"));
  return {
    headers,
    subject: words.test(headers.Subject)
      ? Buffer.from(decoded(headers.Subject), "latin1").toString("utf8")
      : headers.Subject,
    body: Buffer.from(/base64\r\n\r\n([^-]*)\r\n--/.exec(text)[1], "base64").toString("utf8"),
  };
}
