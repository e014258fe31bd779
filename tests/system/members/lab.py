"""The lab as people see it through one server: rigs, sessions, runs, bookings."""

import time

from processes import await_true


def stamp(when):
    text = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(when))
    return f"{text}.{int(when % 1 * 1000):03d}Z"


def rigs(admin, server):
    """Of every class: id -> {status, reason, epoch}. Empty when the server has no answer."""
    answer = admin.get(server, "rig-classes")
    if not answer.ok:
        return {}
    return {m["id"]: m for group in answer.body["items"] for m in group["members"]}


def await_rigs(admin, server, ids, status, patience_s=60.0):
    """@returns how long it took"""
    began = time.monotonic()

    def there():
        known = rigs(admin, server)
        return all(known.get(i, {}).get("status") == status for i in ids)

    try:
        await_true(f"{ids} {status}", there, patience_s, 0.1)
    except TimeoutError:
        now = {i: (r["status"], r["reason"]) for i, r in rigs(admin, server).items() if i in ids}
        raise TimeoutError(f"{ids} are not {status} after {patience_s:.0f} s: {now}") from None
    return time.monotonic() - began


def session_on(person, server, rig_class, wanted=""):
    """A session on a rig whose id begins with `wanted`; others are declined."""

    def given():
        answer = person.post(server, "tickets", {"rig_class": rig_class, "min_s": 300, "want_s": 600})
        if not answer.ok:
            return None
        session = answer.body.get("session")
        if session is None or session["state"] != "active":
            ticket = answer.body["ticket"]["id"] if session is None else session["ticket"]
            accepted = person.post(server, f"tickets/{ticket}/accept")
            if not accepted.ok:
                return None
            session = accepted.body
        if session["rig"].startswith(wanted):
            return session
        person.post(server, f"sessions/{session['id']}/end")
        return None

    return await_true(f"a session on {rig_class} {wanted}", given, 90.0, 0.1)


def run_state(person, server, run):
    answer = person.get(server, f"runs/{run}")
    return answer.body.get("state", f"({answer.status})")


def all_runs(admin, server):
    out = []
    cursor = ""
    while True:
        page = admin.get(server, f"runs?limit=200{'&cursor=' + cursor if cursor else ''}").body
        out += page["items"]
        cursor = page["next_cursor"]
        if not cursor:
            return out


def await_no_run(admin, server):
    """Ends that could not be stored are made up for within two minutes."""

    def none():
        return not [run for run in all_runs(admin, server) if run["state"] == "running"]

    await_true("no run is stored as running", none, 160, 0.5)


def seconds_of(text):
    whole, _, rest = text.rstrip("Z").partition(".")
    return time.mktime(time.strptime(whole, "%Y-%m-%dT%H:%M:%S")) - time.timezone + float(f"0.{rest or 0}")


def double_allocations(runs, speed=None, slack_s=3.0):
    """Runs of different epochs that were on one rig at the same time. An end is stored after the
    rig was let go and the last diagnosis is made: `slack_s`, and with the rigs' `speed` no longer
    than the samples took. That of an interrupted run is when somebody noticed."""
    by_rig = {}
    for run in runs:
        by_rig.setdefault(run["rig"], []).append(run)
    found = []
    for rig, theirs in by_rig.items():
        theirs.sort(key=lambda run: run["epoch"])
        for older, newer in zip(theirs, theirs[1:]):
            if older["epoch"] == newer["epoch"] or older["state"] in ("running", "interrupted"):
                continue
            end = seconds_of(older["ended_at"])
            if speed:
                played = older["samples"] * older["period_s"] / speed
                end = min(end, seconds_of(older["created_at"]) + played)
            if end > seconds_of(newer["created_at"]) + slack_s:
                found.append(
                    f"{rig}: epoch {older['epoch']} {older['state']} until {older['ended_at']}, "
                    f"epoch {newer['epoch']} from {newer['created_at']}"
                )
    return found
