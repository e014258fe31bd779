const GZIP_MAGIC = [0x1f, 0x8b];
/** Larger texts are compressed on the way: the server takes bodies of 20 MB. */
const PLAIN_BYTES_MAX = 2 << 20;

/** A CSV file, or one that is compressed already, as the server takes it; `type` says which. */
export async function readCsvFile(file: Blob): Promise<Blob> {
  const head = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  if (head[0] === GZIP_MAGIC[0] && head[1] === GZIP_MAGIC[1]) {
    return file.slice(0, file.size, "application/gzip");
  }
  if (file.size <= PLAIN_BYTES_MAX) return file.slice(0, file.size, "text/csv");
  const packed = file.stream().pipeThrough(new CompressionStream("gzip"));
  const bytes = await new Response(packed).blob();
  return bytes.slice(0, bytes.size, "application/gzip");
}
