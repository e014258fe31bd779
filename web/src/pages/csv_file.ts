const GZIP_MAGIC = [0x1f, 0x8b];

/** The text of a CSV file; a gzipped one is unpacked here, for the server takes plain text. */
export async function readCsvFile(file: Blob): Promise<Blob> {
  const head = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  if (head[0] !== GZIP_MAGIC[0] || head[1] !== GZIP_MAGIC[1]) return file;
  const plain = file.stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(plain).blob();
}
