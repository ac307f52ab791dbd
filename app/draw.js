// Draws one frame of a recording and what lies over it. Lengths in the data are shares of the
// picture's width and height, so that a picture of any size shows them in their place.

const DIFFERENCE_GAIN = 4; // grey levels drawn per grey level of change, as in saved pictures
const LOOK_AHEAD_S = 0.25; // arrows of a recording reach to where the contact is then
const AT_ONCE = 12; // pictures that are begun to be read without a pause
const ARROWS_ACROSS = 9; // arrows over the longer side of a contact
const LEAST_ARROW = 3; // pixels; a shorter one is left out

function loadImage(address) {
  return new Promise((resolve) => {
    const image = new Image();
    image.onload = () => resolve(image);
    image.onerror = () => resolve(null);
    image.src = address;
  });
}

// The pictures of a pack, as of `stage.py`, which load by themselves.
async function imagesOf(address) {
  const answer = await fetch(new URL(address, document.baseURI));
  if (!answer.ok) return null;
  const content = await answer.arrayBuffer(), view = new DataView(content);
  const count = view.getUint32(0, true);
  const images = [];
  let place = 4 * (count + 1);
  for (let k = 0; k < count; k++) {
    const length = view.getUint32(4 * (k + 1), true), image = new Image();
    image.src = URL.createObjectURL(new Blob([new Uint8Array(content, place, length)], { type: "image/jpeg" }));
    image.onload = () => URL.revokeObjectURL(image.src);
    place += length;
    images.push(image);
    if (k % AT_ONCE === AT_ONCE - 1) await new Promise((go) => setTimeout(go)); // the page stays awake
  }
  return images;
}

function canvasOf(image) {
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth;
  canvas.height = image.naturalHeight;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  return { canvas, context, pixels: context.getImageData(0, 0, canvas.width, canvas.height) };
}

// A frame against the idle gel: neutral grey where nothing changed.
function differenceOf(image, idle) {
  const { canvas, context, pixels } = canvasOf(image), seen = pixels.data;
  for (let k = 0; k < seen.length; k++) {
    if (k % 4 < 3) seen[k] = 128 + DIFFERENCE_GAIN * (seen[k] - idle[k]);
  }
  context.putImageData(pixels, 0, 0);
  return canvas;
}

function pathOf(polygons, size) {
  const path = new Path2D();
  for (const polygon of polygons) {
    polygon.forEach(([x, y], k) => path[k ? "lineTo" : "moveTo"](x * size[0], y * size[1]));
    path.closePath();
  }
  return path;
}

// A dark edge lets it be seen on any picture.
function strokeOver(context, path, width, colour) {
  context.lineCap = context.lineJoin = "round";
  for (const [wide, shade] of [[width + 2.2, "rgba(0,0,0,0.5)"], [width, colour]]) {
    context.lineWidth = wide;
    context.strokeStyle = shade;
    context.stroke(path);
  }
}

// Tells whether any arrow was long enough to be drawn.
function drawField(context, size, ends, colour) {
  const path = new Path2D();
  let isDrawn = false;
  for (const pair of ends || []) {
    const [tail, tip] = pair.map((point) => [point[0] * size[0], point[1] * size[1]]);
    const across = tip[0] - tail[0], down = tip[1] - tail[1], length = Math.hypot(across, down);
    if (length < LEAST_ARROW) continue;
    isDrawn = true;
    const angle = Math.atan2(down, across), head = Math.min(Math.max(0.35 * length, 4), 12);
    path.moveTo(...tail);
    for (const side of [-0.5, 0.5]) {
      path.lineTo(...tip);
      path.lineTo(tip[0] - head * Math.cos(angle + side), tip[1] - head * Math.sin(angle + side));
    }
  }
  strokeOver(context, path, 2, colour);
  return isDrawn;
}

// Where points of the contact go: turned about its middle and carried along, shares of the picture.
function rigidArrows(size, polygons, turn, travel) {
  const points = polygons.flat(), path = pathOf(polygons, size);
  const plain = document.createElement("canvas").getContext("2d"); // which nothing has moved or turned
  const across = points.map((point) => point[0] * size[0]), down = points.map((point) => point[1] * size[1]);
  const [left, right, top, bottom] = [Math.min(...across), Math.max(...across), Math.min(...down), Math.max(...down)];
  const middle = [(left + right) / 2, (top + bottom) / 2];
  const step = Math.max(right - left, bottom - top) / ARROWS_ACROSS, ends = [];
  const cos = Math.cos(turn), sin = Math.sin(turn);
  for (let x = left + step / 2; x < right; x += step) {
    for (let y = top + step / 2; y < bottom; y += step) {
      if (!plain.isPointInPath(path, x, y)) continue;
      const [a, b] = [x - middle[0], y - middle[1]];
      const tip = [middle[0] + cos * a - sin * b, middle[1] + sin * a + cos * b];
      ends.push([[x / size[0], y / size[1]], [tip[0] / size[0] + travel[0], tip[1] / size[1] + travel[1]]]);
    }
  }
  return ends;
}

// What lies over the picture, in its lower left corner.
function drawLegend(context, size, lines) {
  context.font = "12px system-ui, sans-serif";
  const widest = Math.max(...lines.map((line) => context.measureText(line.text).width));
  if (widest > size[0] - 32) context.font = `${(12 * (size[0] - 32)) / widest}px system-ui, sans-serif`;
  context.textBaseline = "middle";
  lines.forEach((line, k) => {
    const middle = size[1] - 10 - 16 * (lines.length - 1 - k);
    context.fillStyle = "rgba(12,16,22,0.66)";
    context.fillRect(0, middle - 8, context.measureText(line.text).width + 32, 16);
    context.fillStyle = line.colour || "#fff";
    context.fillRect(8, middle - 1.5, 10, 3);
    context.fillStyle = "#fff";
    context.fillText(line.text, 24, middle);
  });
}
