/**
 * The text of a class list that a spreadsheet has saved: UTF-8, what Excel calls Unicode text (UTF-16
 * with a byte order mark), or, as it saves CSV in our languages, Windows-1250.
 */
export function listText(bytes: ArrayBuffer): string {
  const [first, second] = new Uint8Array(bytes);
  if (first === 0xff && second === 0xfe) return new TextDecoder("utf-16le").decode(bytes);
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1250").decode(bytes);
  }
}
