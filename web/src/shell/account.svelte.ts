import { tick } from "svelte";
import { call, onUnauthorized, useCsrfToken } from "../api/client";
import type { Me, Role } from "../contract/types";
import { quiet } from "../loading/busy";

const RANK: Record<Role, number> = {
  guest: 0,
  student: 1,
  service: 1,
  instructor: 2,
  operator: 3,
  admin: 4,
};

/** Nobody waits longer for a sign-out. */
const QUIET_MS = 10_000;

/**
 * The user of the page. The server decides what the user may do; this only hides what is not
 * allowed.
 */
class Account {
  me = $state.raw<Me>({ role: "guest", name: "guest" });
  loaded = $state(false);
  /** The sign-in ended while the page was open: by a time limit, or from elsewhere. */
  expired = $state(false);
  /** The person is signing out. */
  leaving = $state(false);

  constructor() {
    onUnauthorized(() => {
      if (!this.signedIn) return;
      this.take({ role: "guest", name: "guest" });
      this.expired = true;
    });
  }

  get signedIn(): boolean {
    return this.me.role !== "guest";
  }

  atLeast(role: Role): boolean {
    return RANK[this.me.role] >= RANK[role];
  }

  /** The address of the sign-in page, with the page to return to. */
  signInPath(from: string): string {
    return `/signin?next=${encodeURIComponent(from)}`;
  }

  async load(): Promise<void> {
    try {
      this.take(await call("GET /auth/me"));
    } catch {
      this.take({ role: "guest", name: "guest" }); // a guest, who may sign in again
    }
    this.loaded = true;
  }

  async signIn(login: string, password: string): Promise<void> {
    this.take(await call("POST /auth/login", {}, { body: { login, password } }));
    this.expired = false;
    if (!this.me.csrf_token) await this.load();
  }

  /**
   * The lab's feed ends first: the server ends it with the sign-in, and a feed that was still there
   * would connect again, without one. What the page is loading comes before that, too: afterwards
   * it would be refused.
   */
  async signOut(): Promise<void> {
    this.leaving = true;
    await tick();
    await quiet(QUIET_MS);
    try {
      await call("POST /auth/logout");
      this.take({ role: "guest", name: "guest" });
    } finally {
      this.leaving = false;
    }
  }

  private take(me: Me): void {
    this.me = me;
    useCsrfToken(me.csrf_token ?? "");
  }
}

export const account = new Account();
