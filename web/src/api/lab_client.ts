import type {
  ApiKey,
  Availability,
  Booking,
  Course,
  Enrolled,
  FaultSet,
  Identity,
  Invitation,
  Isolability,
  Job,
  LabEvent,
  NewApiKey,
  Policy,
  Provider,
  RigHealth,
  Session,
  SetFile,
  Span,
  StoredCalibration,
  Ticket,
  User,
} from "../contract/lab_types";
import type { Page, RunRequest, Schemas } from "../contract/types";
import { api, get, getAll, send, sendText } from "./client";

type Id = string | number;
const at = (id: Id) => encodeURIComponent(String(id));
const items = async <T>(path: string) => (await get<Page<T>>(path)).items;
const page = <T>(path: string, cursor?: string) =>
  get<Page<T>>(`${path}?limit=50${cursor ? `&cursor=${at(cursor)}` : ""}`);
/** The conditions under which a fault set is judged. */
export interface IsolabilityView {
  channels: "um" | "all";
  window_samples: number;
}
const isolability = (set: Id, view: IsolabilityView, suffix = "") =>
  `/fault-sets/${at(set)}/isolability${suffix}?channels=${view.channels}&window_samples=${view.window_samples}`;
export const isolabilityPng = (set: Id, view: IsolabilityView) =>
  `/api/v1${isolability(set, view, ".png")}`;
const ifMatch = (version: number) => ({ "If-Match": `"${version}"` });

export const lab = {
  changePassword: (old: string, fresh: string, endKeys: boolean) =>
    send<unknown>("POST", "/auth/password", { old, new: fresh, end_keys: endKeys }),
  providers: () => items<Provider>("/auth/providers"),
  /** The address at which a browser signs in at a provider and then goes on to `next`. */
  signInAddress: (provider: string, next: string) =>
    `/api/v1/auth/oidc/${at(provider)}/start?next=${at(next)}`,
  identities: () => items<Identity>("/auth/identities"),
  addIdentity: async (provider: string) =>
    (await send<Schemas["ProviderLocation"]>("POST", `/auth/oidc/${at(provider)}/link`, {}))
      .location,
  removeIdentity: (provider: string) => send<unknown>("DELETE", `/auth/identities/${at(provider)}`),
  resetPassword: (token: string, password: string) =>
    send<unknown>("POST", "/auth/reset", { token, password }),

  rigClasses: api.rigClasses,
  /**
   * On how many rigs a session of `minutes` can start every `step` minutes, and some of the times
   * at which it can.
   */
  availability: (rigClass: string, span: Span, minutes: number, step: number) =>
    get<Availability>(
      `/rig-classes/${at(rigClass)}/availability?from=${at(span.start)}&to=${at(span.end)}&minutes=${minutes}&step=${step}`,
    ),

  policy: () => get<Policy>("/policy"),
  /** `version` as last read; refused when somebody else has changed it since. */
  changePolicy: ({ version, ...settings }: Policy) =>
    send<Policy>("PUT", "/policy", settings, ifMatch(version)),

  tickets: () => items<Ticket>("/tickets"),
  askForRig: (rigClass: string, minS: number, wantS: number) =>
    send<{ ticket?: Ticket; session?: Session }>("POST", "/tickets", {
      rig_class: rigClass,
      min_s: minS,
      want_s: wantS,
    }),
  acceptTicket: (id: Id) => send<Session>("POST", `/tickets/${at(id)}/accept`, {}),
  leaveTicket: (id: Id) => send<unknown>("POST", `/tickets/${at(id)}/leave`, {}),

  bookings: () => items<Booking>("/bookings"),
  book: (rigClass: string, span: Span) =>
    send<Booking>("POST", "/bookings", { rig_class: rigClass, ...span }),
  cancelBooking: (booking: Booking) =>
    send<unknown>("DELETE", `/bookings/${at(booking.id)}`, undefined, ifMatch(booking.version)),
  claimBooking: (id: Id) => send<Session>("POST", `/bookings/${at(id)}/claim`, {}),

  sessions: () => items<Session>("/sessions"),
  pastSessions: (cursor?: string) => page<Schemas["PastSession"]>("/sessions/past", cursor),
  endSession: (id: Id) => send<unknown>("POST", `/sessions/${at(id)}/end`, {}),
  stillThere: (id: Id) => send<unknown>("POST", `/sessions/${at(id)}/still-there`, {}),
  handOver: (id: Id, to: string) => send<unknown>("POST", `/sessions/${at(id)}/handover`, { to }),
  acceptHandOver: (id: Id) => send<Session>("POST", `/sessions/${at(id)}/handover/accept`, {}),

  events: (since: number) =>
    get<{ items: LabEvent[]; next: number }>(`/events?since=${since}&limit=100`),

  faultSets: () => getAll<FaultSet>("/fault-sets"),
  saveFaultSet: (set: Pick<FaultSet, "name" | "visible" | "faults"> & Partial<FaultSet>) =>
    set.id === undefined
      ? send<FaultSet>("POST", "/fault-sets", set)
      : send<FaultSet>(
          "PUT",
          `/fault-sets/${at(set.id)}`,
          { name: set.name, visible: set.visible, faults: set.faults },
          ifMatch(set.version ?? 1),
        ),
  makeFaultSet: (set: SetFile & { course?: number }) => send<FaultSet>("POST", "/fault-sets", set),
  deleteFaultSet: (set: FaultSet) =>
    send<unknown>("DELETE", `/fault-sets/${at(set.id)}`, undefined, ifMatch(set.version)),

  isolability: (set: Id, view: IsolabilityView) => get<Isolability>(isolability(set, view)),

  createUser: (user: Pick<User, "login" | "name" | "role">) => send<User>("POST", "/users", user),
  changeUser: (user: User, change: Partial<Pick<User, "role" | "disabled">>) =>
    send<User>("PATCH", `/users/${at(user.id)}`, change, ifMatch(user.version)),
  resetLink: (id: Id) => send<{ link: string }>("POST", `/users/${at(id)}/reset-link`, {}),
  quarantine: (rig: string, reason: string) =>
    send<unknown>("POST", `/rigs/${at(rig)}/quarantine`, { reason }),
  release: (rig: string) => send<unknown>("POST", `/rigs/${at(rig)}/release`, {}),
  outage: (rig: string, span: Span, reason: string) =>
    send<unknown>("POST", `/rigs/${at(rig)}/outages`, { ...span, reason }),
  selfTest: (rig: string) => send<unknown>("POST", `/rigs/${at(rig)}/self-test`, {}),
  removeOutage: (rig: string, id: number) =>
    send<unknown>("DELETE", `/rigs/${at(rig)}/outages/${at(id)}`),
  commission: (rig: string, reason: string) =>
    send<unknown>("POST", `/rigs/${at(rig)}/commission`, { reason }),
  adopt: (rig: string) => send<unknown>("POST", `/rigs/${at(rig)}/adopt`, {}),
  clearTrip: (rig: string) => send<unknown>("POST", `/rigs/${at(rig)}/clear-trip`, {}),
  newestCalibration: async (rig: string) =>
    (await items<StoredCalibration>(`/rigs/${at(rig)}/calibrations?limit=1`))[0] ?? null,
  health: (rig: string) => get<RigHealth>(`/rigs/${at(rig)}/health`),
  allSessions: () => items<Session>("/sessions?all=1"),
  takeOver: (id: Id, reason: string) =>
    send<Session>("POST", `/sessions/${at(id)}/take-over`, { reason }),

  courses: () => getAll<Course>("/courses"),
  createCourse: (name: string) => send<Course>("POST", "/courses", { name }),
  /** `ends` in ISO 8601; empty: open end. */
  setCourseEnd: (course: number, ends: string) =>
    send<unknown>("PUT", `/courses/${at(course)}/end`, ends ? { ends } : {}),
  members: (course: number) => items<User>(`/courses/${at(course)}/members`),
  endEnrolment: (course: number, user: number) =>
    send<unknown>("DELETE", `/courses/${at(course)}/members/${at(user)}`),
  enrol: (course: number, csv: string) =>
    sendText<Enrolled>("POST", `/courses/${at(course)}/members`, csv, "text/csv"),
  /** Accounts invited to a course that the user teaches. */
  courseInvitations: (course: number) => items<Invitation>(`/courses/${at(course)}/invitations`),
  /** Courses to which the user is invited. */
  invitations: () => items<Invitation>("/invitations"),
  answerInvitation: (course: number, answer: "accept" | "decline") =>
    send<unknown>("POST", `/invitations/${at(course)}/${answer}`, {}),

  calendarLink: () => get<{ created_at: string | null }>("/calendar-link"),
  makeCalendarLink: () => send<{ link: string }>("POST", "/calendar-link", {}),
  endCalendarLink: () => send<unknown>("DELETE", "/calendar-link"),

  keys: () => items<ApiKey>("/api-keys"),
  createKey: (key: Pick<ApiKey, "name" | "scopes" | "expires_at">) =>
    send<NewApiKey>("POST", "/api-keys", key),
  revokeKey: (id: number) => send<unknown>("DELETE", `/api-keys/${at(id)}`),

  jobs: (cursor?: string) => page<Job>("/jobs", cursor),
  submitJobs: (name: string, runs: RunRequest[]) =>
    send<{ batch: string; count: number; items: Job[] }>("POST", "/jobs", { name, runs }),
  job: (id: string) => get<Job>(`/jobs/${at(id)}`),
  /** All methods on one recording: a job of its own. */
  compareMethods: (recording: string) =>
    send<{ items: Job[] }>("POST", "/jobs", { runs: [{ methods: { recording } }] }),
  cancelJob: (id: string) => send<unknown>("DELETE", `/jobs/${at(id)}`),
};
