// What stands in the page: numbers, the image, and where in space a pixel lies.

const element = (id) => document.getElementById(id);
const facts = JSON.parse(element("facts").textContent);
const { columns, rows, camera } = facts;

// The bytes of an element, which is the base64 of a zlib stream; null where there is no such element.
async function bytesOf(id) {
  const text = element(id)?.textContent;
  if (text === undefined) return null;
  element(id).remove();
  if (!globalThis.DecompressionStream) {
    throw new Error("this browser has no DecompressionStream, which browsers have since 2023");
  }
  const letters = atob(text);
  const packed = new Uint8Array(letters.length);
  for (let at = 0; at < letters.length; at += 1) packed[at] = letters.charCodeAt(at);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

async function numbersOf(id) {
  const bytes = await bytesOf(id);
  return bytes && new Float32Array(bytes);
}

async function placesOf(id) {
  const bytes = await bytesOf(id);
  return bytes && new Uint8Array(bytes);
}

// Red, green, blue and 255 of each pixel of the left image; null where there is none.
async function pixelsOfImage() {
  const image = element("image");
  if (!image) return null;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [columns, rows];
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  image.remove();
  return context.getImageData(0, 0, columns, rows).data;
}

// Depth in metres of a disparity in pixels, f B / (d + doffs); NaN where nothing in front of the cameras
// has it. A depth has 32 bits, as where it was computed first.
function depthOf(disparity) {
  const shifted = disparity + camera.doffs;
  const depth = Math.fround((camera.focal_px * camera.baseline_m) / shifted);
  return shifted > 0 && Number.isFinite(depth) ? depth : NaN;
}

// The disparity of a depth.
const disparityOf = (depth) => (camera.focal_px * camera.baseline_m) / depth - camera.doffs;

// Where pixels lie: X to the right, Y down, Z forward, in metres. Without a camera X and Y are pixels
// from the middle, and Z is how much less the disparity is than the largest one, in pixels as well.
class Space {
  constructor(disparities) {
    this.centre = [(columns - 1) / 2, (rows - 1) / 2];
    const principal = camera ? [camera.cx, camera.cy] : this.centre;
    [this.cx, this.cy] = principal;
    this.focal = camera ? camera.focal_px : Math.max(columns, rows);
    // In a relief nothing may have the depth 0, which is that of no point.
    const most = disparities.reduce((most, d) => (d > most ? d : most), -Infinity);
    this.z = disparities.map(camera ? depthOf : (disparity) => 1 + most - disparity);
  }

  // How wide a pixel is where it lies.
  widthOf(pixel) {
    return camera ? this.z[pixel] / this.focal : 1;
  }

  // Z is NaN where the pixel has no point.
  pointOf(pixel) {
    const [x, y] = [pixel % columns, Math.floor(pixel / columns)];
    const width = this.widthOf(pixel);
    return [(x - this.cx) * width, (y - this.cy) * width, this.z[pixel]];
  }

  // The depth that as many points are nearer than farther; some are asked where there are many.
  median() {
    const step = Math.ceil(this.z.length / 100000);
    const some = this.z.filter((z, at) => at % step === 0 && z > 0).sort();
    return some.length > 0 ? some[some.length >> 1] : 1;
  }
}
