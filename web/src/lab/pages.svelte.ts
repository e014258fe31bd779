import type { Page } from "../contract/types";

/** A list that the server sends page by page. */
export class Pages<T> {
  items = $state.raw<T[]>([]);
  /** More than the first page is shown: loading anew would take it away. */
  turned = $state(false);
  private cursor = $state<string | null>(null);

  constructor(private readonly fetch: (cursor?: string) => Promise<Page<T>>) {}

  get more(): boolean {
    return this.cursor !== null;
  }

  async load(): Promise<void> {
    const page = await this.fetch();
    this.items = page.items;
    this.turned = false;
    this.cursor = page.next_cursor;
  }

  async next(): Promise<void> {
    const page = await this.fetch(this.cursor ?? undefined);
    this.items = [...this.items, ...page.items];
    this.turned = true;
    this.cursor = page.next_cursor;
  }
}
