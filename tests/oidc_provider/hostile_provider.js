// A provider that violates the protocol in one way, on request. Everything else is right, so that a
// refusal concerns only that one error.
import { createHmac, randomUUID } from "node:crypto";
import { calculateJwkThumbprint, exportJWK, exportSPKI, generateKeyPair, SignJWT } from "jose";
import { bodyOf } from "./listener.js";

const encode = (value) => Buffer.from(JSON.stringify(value)).toString("base64url");

export async function hostileProvider(issuer) {
  const right = await generateKeyPair("RS256", { extractable: true });
  const wrong = await generateKeyPair("RS256", { extractable: true });
  const publicJwk = await exportJWK(right.publicKey);
  const kid = await calculateJwkThumbprint(publicJwk);
  const publicPem = await exportSPKI(right.publicKey);
  const asked = new Map();
  const provider = {
    /** The error to make: the names below. */
    mode: "",
    subject: "hostile-ann",
    login: "hostile.ann",
    tokensGiven: 0,
    handler,
  };

  const say = (response, value, status = 200) => {
    response.writeHead(status, { "Content-Type": "application/json" });
    response.end(JSON.stringify(value));
  };

  async function idToken(question) {
    const now = Math.floor(Date.now() / 1000);
    const claims = {
      iss: provider.mode === "issuer" ? `${issuer}/other` : issuer,
      sub: provider.subject,
      aud: provider.mode === "audience" ? "another-client" : question.get("client_id"),
      nonce: provider.mode === "nonce" ? "another-nonce" : question.get("nonce"),
      iat: provider.mode === "expired" ? now - 1000 : now,
      exp: provider.mode === "expired" ? now - 500 : now + 300,
      preferred_username: provider.login,
    };
    if (provider.mode === "azp") claims.aud = [claims.aud, "another-client"];
    const header = { alg: "RS256", kid };
    if (provider.mode === "none") return `${encode({ ...header, alg: "none" })}.${encode(claims)}.`;
    if (provider.mode === "confused key") {
      const text = `${encode({ ...header, alg: "HS256" })}.${encode(claims)}`;
      return `${text}.${createHmac("sha256", publicPem).update(text).digest("base64url")}`;
    }
    if (provider.mode === "crit") {
      header.crit = ["exp"];
      const text = `${encode(header)}.${encode(claims)}`;
      return `${text}.${encode("x")}`;
    }
    const key = provider.mode === "another key" ? wrong.privateKey : right.privateKey;
    if (provider.mode === "unknown kid") header.kid = "nobody-knows";
    const token = await new SignJWT(claims).setProtectedHeader(header).sign(key);
    if (provider.mode === "last character") {
      return token.slice(0, -1) + (token.endsWith("A") ? "B" : "A");
    }
    return token;
  }

  async function handler(request, response) {
    const url = new URL(request.url, issuer);
    switch (url.pathname) {
      case "/.well-known/openid-configuration":
        return say(response, {
          issuer,
          authorization_endpoint: `${issuer}/auth`,
          token_endpoint: `${issuer}/token`,
          userinfo_endpoint: `${issuer}/me`,
          jwks_uri: `${issuer}/jwks`,
          authorization_response_iss_parameter_supported: true,
        });
      case "/jwks":
        return say(response, { keys: [{ ...publicJwk, kid, alg: "RS256", use: "sig" }] });
      case "/auth": {
        const code = randomUUID();
        asked.set(code, url.searchParams);
        const back = new URL(url.searchParams.get("redirect_uri"));
        back.searchParams.set("code", code);
        back.searchParams.set("state", url.searchParams.get("state"));
        if (provider.mode !== "silent issuer") {
          back.searchParams.set(
            "iss",
            provider.mode === "mixed up" ? "https://honest.example" : issuer,
          );
        }
        response.writeHead(303, { Location: back.href });
        return response.end();
      }
      case "/token": {
        // A code is accepted any number of times, so that only the server under test can refuse the
        // second.
        const question = asked.get((await bodyOf(request)).get("code"));
        if (!question) return say(response, { error: "invalid_grant" }, 400);
        provider.tokensGiven++;
        if (provider.mode === "redirect") {
          response.writeHead(302, { Location: `${issuer}/elsewhere` });
          return response.end();
        }
        if (provider.mode === "flood") return response.end("x".repeat(1 << 20));
        const token = await idToken(question);
        return say(response, { access_token: "access", token_type: "Bearer", id_token: token });
      }
      case "/me":
        return say(response, {
          sub: provider.mode === "userinfo" ? "somebody-else" : provider.subject,
        });
      default:
        return say(response, {}, 404);
    }
  }
  return provider;
}
