/** What this browser keeps under a name, or `empty`; where it keeps nothing, the page still has it. */
export function stored<T extends object>(key: string, empty: T) {
  const tried = <R>(action: () => R, otherwise: R): R => {
    try {
      return action();
    } catch {
      return otherwise;
    }
  };
  return {
    read: (): T =>
      tried(() => ({ ...empty, ...JSON.parse(localStorage.getItem(key) ?? "{}") }), empty),
    write: (value: T) => tried(() => localStorage.setItem(key, JSON.stringify(value)), undefined),
    clear: () => tried(() => localStorage.removeItem(key), undefined),
  };
}
