// Keeps what arrives of a stream that is watched: each value brings one picture more, and the whole
// timeline as far as it is shown.

const MOST_PICTURES = 320; // of more every second one is let go of
const STALE_MS = 3000; // without a picture it is not live any more
const SILENT = "No picture has come for 3 s: the camera was stopped, or has stalled.";

class Received {
  begin(stream) {
    this.stream = stream;
    this.images = [];
    this.touched = [];
    this.x = [];
    this.numbers = [];
    this.idle = null;
  }

  // What the stage shows once a value has come; null where another stream has begun meanwhile.
  async with(value) {
    if (this.stream !== value.stream) this.begin(value.stream);
    const given = value.picture;
    const [image, idle] = await Promise.all(
      [given && given.image, value.idle].map((one) => (one ? loadImage(one) : null)));
    if (this.stream !== value.stream) return null;
    if (idle) this.idle = pixelsOf(idle);
    if (image && !(given.at <= this.x[this.x.length - 1])) this.add(given, image);
    return { ...value, frames: this.images, x: this.x, numbers: this.numbers, rate: this.rate };
  }

  add(given, image) {
    this.images.push(image);
    this.touched.push(given.touched ? maskCanvas(given.touched) : null);
    this.x.push(given.at);
    this.numbers.push(given.number);
    if (this.images.length <= MOST_PICTURES) return;
    for (const name of ["images", "touched", "x", "numbers"]) {
      const last = this[name].length - 1;
      this[name] = this[name].filter((_, k) => (last - k) % 2 === 0);
    }
  }

  get rate() {
    const last = this.x.length - 1;
    return last > 0 ? last / (this.x[last] - this.x[0]) : 10;
  }
}
// Plays a recording, and keeps picture, slider and timeline at the same frame.

const part = (name) => element.querySelector(`[data-part="${name}"]`);
const picture = part("picture"), scrub = part("scrub"), playButton = part("play");
const timeline = new Timeline(part("time"));
const wantsRest = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
const layers = { arrows: true, contact: false, difference: false, depth: false, truth: true };
const LAYER_NAMES = {
  arrows: "Arrows", truth: "True motion", contact: "Contact", difference: "Difference", depth: "Depth",
};
let data = null, images = [], idle = null, masks = [], depths = [];
let frame = 0, isPlaying = false, isFollowing = false, began = 0, beganAt = 0;
let wanted = null, stale = null;
const received = new Received();

async function show(value) {
  const isOpen = Boolean(value && (value.frames || value.stream));
  wanted = isOpen ? value.stream || value.key : null;
  if (!isOpen) showNothing();
  else if (value.stream) await showStream(value);
  else await showRecording(value);
}

function showNothing() {
  data = null;
  images = [];
  received.begin(null);
  pause();
  title();
  picture.setAttribute("aria-label", "No recording is open");
  part("layers").replaceChildren();
  part("clock").textContent = "";
  timeline.place = undefined;
  timeline.show(null);
  draw();
}

async function showRecording(value) {
  const isSame = data && data.frames && data.frames.length === value.frames.length
    && data.frames[0] === value.frames[0] && data.name === value.name;
  data = value;
  received.begin(null);
  if (!isSame) images = [];
  title();
  scrub.min = 0;
  timeline.show(data);
  const overlays = data.overlays || {};
  const load = async (list) => Promise.all((list || []).map(loadImage));
  const loaded = isSame ? images : await load(data.frames);
  const idleImage = data.idle ? await loadImage(data.idle) : null;
  const depthImages = await load(overlays.depth);
  if (wanted !== value.key) return; // another one was opened meanwhile
  images = loaded;
  depths = depthImages;
  idle = idleImage ? pixelsOf(idleImage) : null;
  masks = overlays.contact ? [maskCanvas(overlays.contact.mask)] : [];
  showLayers();
  if (!isSame) {
    go(0);
    if (!wantsRest) play();
  }
  draw();
  element.querySelector(".stage").dataset.shown = data.pending ? "frames" : "all";
}

// While it is live the newest picture is shown, unless another one was looked for.
async function showStream(value) {
  const isNew = !data || data.stream !== value.stream, place = isNew ? 0 : data.x[frame];
  const told = await received.with(value);
  if (!told || wanted !== value.stream) return;
  data = told;
  ({ images, idle } = received);
  masks = received.touched;
  depths = [];
  if (isNew) {
    isPlaying = false;
    isFollowing = true;
    timeline.rows = 2;
  }
  title();
  const oldest = data.x.findIndex((one) => one >= data.window[0]);
  scrub.min = Math.max(oldest, 0);
  timeline.show(data);
  showLayers();
  go(isFollowing ? images.length - 1 : nearest(data.x, place));
  shownAsPlaying();
  element.querySelector(".stage").dataset.shown = "all";
  clearTimeout(stale);
  if (data.live) stale = setTimeout(() => endLive(value.stream), STALE_MS);
  else isFollowing = false;
}

function endLive(stream) {
  if (!data || data.stream !== stream) return;
  data = { ...data, live: false, notes: [SILENT, ...data.notes] };
  title();
  shownAsPlaying();
}

function title() {
  element.querySelector(".stage").dataset.shown = data ? "" : "nothing";
  part("empty").hidden = Boolean(data);
  part("name").textContent = data ? data.name : "";
  part("about").textContent = data ? data.about : "";
  part("live").hidden = !(data && data.live);
  part("notes").textContent = ((data && data.notes) || []).join(" ");
  playButton.disabled = scrub.disabled = !data;
  if (!data) return;
  scrub.max = data.frames.length - 1;
  const how = data.stream ? "watched" : "playing";
  picture.setAttribute("aria-label", `${data.name}, ${how}: its frames with what the model reads`);
  part("time").setAttribute("aria-label", timelineLabel());
}

function timelineLabel() {
  if (data.timeline) {
    const told = data.timeline.events.map((one) => `${one.name} ${one.far}`.trim());
    return `Timeline: ${told.join("; ") || "nothing moves"}`;
  }
  const rows = data.step ? data.step.rows.map((one) => `${one.name}: ${one.text}`) : [];
  return `Timeline: ${(data.step && data.step.told) || rows.join("; ") || "being read"}`;
}

function showLayers() {
  const has = {
    arrows: data.overlays, contact: data.overlays, difference: idle,
    depth: depths.length, truth: data.overlays && data.overlays.fields.some((one) => one.key === "truth"),
  };
  const names = Object.keys(LAYER_NAMES).filter((name) => has[name]);
  const shown = [...part("layers").children].map((one) => one.dataset.layer);
  if (shown.join() === names.join()) return; // a button that is being used stays
  const buttons = names.map((name) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = LAYER_NAMES[name];
    button.dataset.layer = name;
    button.setAttribute("aria-pressed", layers[name]);
    button.onclick = () => {
      layers[name] = !layers[name];
      button.setAttribute("aria-pressed", layers[name]);
      draw();
    };
    return button;
  });
  part("layers").replaceChildren(...buttons);
}

function draw() {
  const ratio = window.devicePixelRatio || 1;
  if (data) picture.parentElement.style.aspectRatio = `${data.aspect}`;
  const box = picture.getBoundingClientRect();
  const size = [Math.max(box.width, 1), Math.max(box.height, 1)];
  picture.width = Math.round(size[0] * ratio);
  picture.height = Math.round(size[1] * ratio);
  const context = picture.getContext("2d");
  context.scale(ratio, ratio);
  const image = images[frame];
  if (!data || !image) return;
  let seen = image;
  if (layers.difference && idle) seen = differenceOf(image, idle);
  if (layers.depth && depths[frame]) seen = depths[frame];
  context.imageSmoothingQuality = "high";
  context.drawImage(seen, 0, 0, ...size);
  drawLayers(context, size);
}

function drawLayers(context, size) {
  const overlays = data.overlays, lines = [];
  if (!overlays) return;
  const k = data.timeline ? nearest(data.timeline.x, data.x[frame]) : 0;
  const mask = data.stream ? masks[frame] : masks[0];
  if (layers.contact && mask) {
    const touch = data.timeline && !data.stream ? data.timeline.panels[2].curves[0].mean[k] : 1;
    if (touch >= 0.5) drawContact(context, size, overlays.contact, mask, touch);
    lines.push({ text: overlays.contact.told });
  }
  if (layers.depth && depths[frame]) lines.push({ text: `bright: ${overlays.deepest_mm} mm deep` });
  if (layers.difference && idle) lines.push({ text: "change against the idle gel, four times" });
  for (const field of overlays.fields) {
    const isTruth = field.key === "truth";
    if (isTruth ? !layers.truth : !layers.arrows || data.timeline) continue;
    drawField(context, size, field);
    const named = overlays.fields.length > 1 ? `${field.label}: ` : "";
    if (field.ends.length) lines.push({ ...field.legend, colour: field.colour, text: `${named}${field.legend.text}` });
  }
  if (layers.arrows && data.timeline) {
    const panels = data.timeline.panels, corners = overlays.contact.corners;
    const middle = [0, 1].map((axis) => (corners[0][axis] + corners[1][axis]) / 2);
    const turn = panels[0].curves[0].mean[k];
    drawWay(context, size, { middle, travel: data.timeline.way[k], turn });
    // No "-0.0" of what rounds to nothing.
    const rounded = (value, digits) => (Number(value.toFixed(digits)) + 0).toFixed(digits);
    const far = panels[1].curves.map((one) => rounded(one.mean[k], 1));
    lines.push({ text: `since the start: ${rounded(turn, 0)}°, ${far[0]} ${panels[1].unit} right, ${far[1]} down` });
  }
  drawLegend(context, size, lines);
}

function go(place) {
  if (!data || !data.frames.length) return;
  frame = Math.min(Math.max(Math.round(place), Number(scrub.min)), data.frames.length - 1);
  scrub.value = frame;
  const when = data.x[frame], number = data.numbers[frame];
  part("clock").textContent = data.unit === "s" ? `${when.toFixed(2)} s` : `frame ${number}`;
  scrub.setAttribute("aria-valuetext", data.unit === "s" ? `${when.toFixed(2)} seconds` : `frame ${number}`);
  timeline.at(when);
  draw();
}

function play() {
  if (!data || isPlaying) return;
  if (data.live) {
    isFollowing = true;
    go(images.length - 1);
    shownAsPlaying();
    return;
  }
  if (frame >= data.frames.length - 1) go(Number(scrub.min));
  isPlaying = true;
  began = performance.now();
  beganAt = frame;
  shownAsPlaying();
  requestAnimationFrame(advance);
}

function pause() {
  isPlaying = isFollowing = false;
  shownAsPlaying();
}

const runs = () => isPlaying || Boolean(data && data.live && isFollowing);

function shownAsPlaying() {
  playButton.textContent = runs() ? "❚❚" : "▶";
  playButton.setAttribute("aria-label", runs() ? "Pause" : data && data.live ? "Show the newest" : "Play");
}

function advance(now) {
  if (!isPlaying || !data || !element.isConnected) return;
  const count = data.frames.length;
  let wanted = placeAfter((now - began) / 1000);
  if (wanted >= count && !data.loops) {
    go(count - 1);
    pause();
    return;
  }
  wanted = Math.floor(wanted) % count;
  if (wanted !== frame && element.offsetParent !== null) go(wanted);
  requestAnimationFrame(advance);
}

// Frames are not always as far apart: where times are known, they are shown by them.
function placeAfter(seconds) {
  if (data.unit !== "s") return beganAt + seconds * data.rate;
  const when = data.x[beganAt] + seconds, last = data.x.length - 1;
  if (when > data.x[last]) return last + (when - data.x[last]) * data.rate;
  let place = beganAt;
  while (place < last && data.x[place + 1] <= when) place++;
  return place;
}

function seek(place) {
  pause();
  go(place);
}
// Mouse, finger and keys on the stage; comes last, and shows the first value.

playButton.onclick = () => (runs() ? pause() : play());
scrub.oninput = () => seek(Number(scrub.value));
picture.onclick = playButton.onclick;
element.addEventListener("keydown", (event) => {
  const steps = { ArrowLeft: frame - 1, ArrowRight: frame + 1, Home: 0, End: 1e9 };
  if (event.key === " " && event.target.tagName !== "BUTTON") playButton.click();
  else if (event.key in steps) seek(steps[event.key]);
  else return;
  event.preventDefault();
});

const tip = part("tip");
let isDragging = false;
const toPlace = (event) => {
  const box = part("time").getBoundingClientRect();
  return timeline.valueAt(event.clientX - box.left);
};
part("time").addEventListener("pointerdown", (event) => {
  if (!data) return;
  isDragging = true;
  part("time").setPointerCapture(event.pointerId);
  seek(nearest(data.x, toPlace(event)));
});
part("time").addEventListener("pointermove", (event) => {
  if (!data) return;
  const value = toPlace(event);
  if (isDragging) seek(nearest(data.x, value));
  if (!data.timeline) return;
  tip.textContent = timeline.toldAt(value);
  tip.hidden = false;
  const box = element.getBoundingClientRect();
  const left = Math.min(event.clientX - box.left + 14, box.width - tip.offsetWidth - 4);
  tip.style.left = `${left}px`;
  tip.style.top = `${part("time").getBoundingClientRect().top - box.top - tip.offsetHeight - 4}px`;
});
for (const ending of ["pointerup", "pointercancel", "pointerleave"]) {
  part("time").addEventListener(ending, () => {
    isDragging = false;
    if (ending !== "pointerup") tip.hidden = true;
  });
}
new ResizeObserver(() => {
  timeline.draw();
  draw();
}).observe(element);
watch("value", () => show(props.value));
show(props.value);
