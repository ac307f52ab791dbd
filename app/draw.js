// Draws one frame of a recording and what lies over it. Lengths in the data are shares of the
// picture's width and height, so that a picture of any size shows them in their place.

const DIFFERENCE_GAIN = 4; // grey levels drawn per grey level of change, as in saved pictures
const CONTACT_RGB = [255, 70, 40];
const DIAL_PX = 26;

function loadImage(address) {
  return new Promise((resolve) => {
    const image = new Image();
    image.onload = () => resolve(image);
    image.onerror = () => resolve(null);
    image.src = address;
  });
}

function pixelsOf(image) {
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth;
  canvas.height = image.naturalHeight;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

// A frame against the idle gel: neutral grey where nothing changed.
function differenceOf(image, idlePixels) {
  const pixels = pixelsOf(image);
  const seen = pixels.data, idle = idlePixels.data;
  for (let k = 0; k < seen.length; k += 4) {
    for (let c = 0; c < 3; c++) seen[k + c] = 128 + DIFFERENCE_GAIN * (seen[k + c] - idle[k + c]);
  }
  const canvas = document.createElement("canvas");
  canvas.width = pixels.width;
  canvas.height = pixels.height;
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  return canvas;
}

function maskCanvas(mask) {
  const canvas = document.createElement("canvas");
  canvas.height = mask.length;
  canvas.width = mask[0].length;
  const context = canvas.getContext("2d");
  const image = context.createImageData(canvas.width, canvas.height);
  mask.flat().forEach((share, k) => {
    image.data.set([...CONTACT_RGB, Math.round(255 * 0.6 * Math.min(Math.max(share, 0), 1))], 4 * k);
  });
  context.putImageData(image, 0, 0);
  return canvas;
}

function drawContact(context, size, contact, mask, strength) {
  const [[left, top], [right, bottom]] = contact.corners;
  const box = [left * size[0], top * size[1], (right - left) * size[0], (bottom - top) * size[1]];
  context.save();
  context.globalAlpha = strength;
  context.imageSmoothingEnabled = true;
  context.drawImage(mask, ...box);
  context.restore();
  context.strokeStyle = "rgba(235,235,235,0.8)";
  context.lineWidth = 1;
  context.strokeRect(...box);
}

function drawArrow(context, from, to, colour, thickness) {
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  if (length < thickness) return;
  const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
  const head = Math.min(Math.max(0.35 * length, 5), 14);
  context.strokeStyle = colour;
  context.lineWidth = thickness;
  context.lineCap = "round";
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  for (const side of [-0.5, 0.5]) {
    context.moveTo(...to);
    context.lineTo(to[0] - head * Math.cos(angle + side), to[1] - head * Math.sin(angle + side));
  }
  context.stroke();
}

function drawField(context, size, field) {
  for (const [tail, tip] of field.ends) {
    const ends = [tail, tip].map((one) => [one[0] * size[0], one[1] * size[1]]);
    drawArrow(context, ...ends, "rgba(0,0,0,0.55)", 4);
    drawArrow(context, ...ends, field.colour, 2);
  }
}

// What lies over the picture and how long its arrows are, in the lower left corner.
function drawLegend(context, size, lines) {
  context.font = "12px system-ui, sans-serif";
  context.textBaseline = "middle";
  lines.forEach((line, k) => {
    const middle = size[1] - 14 - 20 * (lines.length - 1 - k);
    const long = (line.length || 0) * size[0];
    const width = context.measureText(line.text).width + long + (long ? 26 : 16);
    context.fillStyle = "rgba(20,20,20,0.72)";
    context.fillRect(0, middle - 10, width, 20);
    if (long) drawArrow(context, [8, middle], [8 + long, middle], line.colour, 2);
    context.fillStyle = "#fff";
    context.fillText(line.text, long ? 16 + long : 8, middle);
  });
}

// The way since the first frame: a hand that has turned as the object, an arrow as long as its way.
function drawWay(context, size, way) {
  const middle = [way.middle[0] * size[0], way.middle[1] * size[1]];
  const tip = [middle[0] + way.travel[0] * size[0], middle[1] + way.travel[1] * size[1]];
  drawArrow(context, middle, tip, "rgba(0,0,0,0.55)", 5);
  drawArrow(context, middle, tip, "#ffdc00", 2.5);
  const centre = [DIAL_PX + 12, DIAL_PX + 12], angle = (way.turn * Math.PI) / 180;
  context.fillStyle = "rgba(20,20,20,0.6)";
  context.beginPath();
  context.arc(...centre, DIAL_PX, 0, 2 * Math.PI);
  context.fill();
  context.strokeStyle = "rgba(255,255,255,0.6)";
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(...centre);
  context.lineTo(centre[0], centre[1] - DIAL_PX);
  context.stroke();
  const hand = [centre[0] + DIAL_PX * Math.sin(angle), centre[1] - DIAL_PX * Math.cos(angle)];
  drawArrow(context, centre, hand, "#ffdc00", 2.5);
}
