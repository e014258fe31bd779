/** Groups of Rolldown's code splitting. */
interface Group {
  name: string;
  priority?: number;
  test: (id: string) => boolean;
}
export function runChunk(): Group;
export function baseChunk(): Group;
