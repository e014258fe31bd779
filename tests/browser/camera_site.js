// A small HTTP server that gives pictures as ustreamer does. Chromium draws them, so that each is a
// real JPEG with another number.
import { createServer } from "node:http";

const SIZE = { width: 320, height: 240 };

/** `count` JPEG files with a number and a colour of their own. */
async function drawPictures(browser, count) {
  const page = await browser.newPage({ viewport: SIZE });
  const pictures = [];
  for (let at = 0; at < count; at++) {
    await page.setContent(
      `<body style="margin:0;background:hsl(${(at * 360) / count} 70% 45%);color:#fff;font:120px sans-serif">${at}`,
    );
    pictures.push(await page.screenshot({ type: "jpeg", quality: 80 }));
  }
  await page.close();
  return pictures;
}

export async function startCamera(browser) {
  const pictures = await drawPictures(browser, 8);
  const camera = { asked: 0, works: true };
  const server = createServer((request, response) => {
    if (request.url !== "/snapshot" || !camera.works) {
      response.writeHead(503).end();
      return;
    }
    response.writeHead(200, { "Content-Type": "image/jpeg" });
    response.end(pictures[camera.asked++ % pictures.length]);
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  server.unref(); // a story that fails leaves it open, and its file must end
  camera.url = `http://127.0.0.1:${server.address().port}/snapshot`;
  camera.close = () => {
    server.closeAllConnections();
    server.close();
  };
  return camera;
}
