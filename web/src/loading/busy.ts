/**
 * How many parts and answers of the page are on their way, as `data-busy` of the document: whoever
 * reads the page by a program knows by it when all is there.
 */
let waiting = 0;
let patient: (() => void)[] = [];

function tell(change: number): void {
  waiting += change;
  if (waiting === 0) {
    for (const resolve of patient) resolve();
    patient = [];
  }
  if (typeof document !== "undefined") document.documentElement.dataset.busy = String(waiting);
}

export async function busyDuring<T>(work: Promise<T>): Promise<T> {
  tell(1);
  try {
    return await work;
  } finally {
    // What has come is drawn before the page says that all is there.
    setTimeout(() => tell(-1));
  }
}

/** Resolves when nothing is on its way, and after `mostMs` at the latest. */
export function quiet(mostMs: number): Promise<void> {
  if (waiting === 0) return Promise.resolve();
  return new Promise((resolve) => {
    patient.push(resolve);
    setTimeout(resolve, mostMs);
  });
}
