// Plays a recording, and keeps picture, slider and timeline at the same frame.

const part = (name) => element.querySelector(`[data-part="${name}"]`);
const picture = part("picture"), scrub = part("scrub"), playButton = part("play");
const timeline = new Timeline(part("time"));
const wantsRest = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
const layers = { arrows: true, contact: false, difference: false, depth: false, truth: true };
const LAYER_NAMES = {
  arrows: "Arrows", truth: "True motion", contact: "Contact", difference: "Difference", depth: "Depth",
};
let data = null, images = [], idle = null, mask = null, depths = [];
let frame = 0, isPlaying = false, began = 0, beganAt = 0;

async function show(value) {
  const isSame = data && value && data.frames && value.frames && data.frames.length === value.frames.length
    && data.frames[0] === value.frames[0] && data.name === value.name;
  data = value && value.frames ? value : null;
  element.querySelector(".stage").dataset.shown = data ? "" : "nothing";
  part("empty").hidden = Boolean(data);
  part("name").textContent = data ? data.name : "";
  part("about").textContent = data ? data.about : "";
  playButton.disabled = scrub.disabled = !data;
  if (!data) {
    pause();
    images = [];
    picture.setAttribute("aria-label", "No recording is open");
    part("layers").replaceChildren();
    part("clock").textContent = "";
    timeline.place = undefined;
    timeline.show(null);
    draw();
    return;
  }
  if (!isSame) images = [];
  scrub.max = data.frames.length - 1;
  picture.setAttribute("aria-label", `${data.name}, playing: its frames with what the model reads`);
  part("time").setAttribute("aria-label", timelineLabel());
  timeline.show(data);
  const key = data.key, overlays = data.overlays || {};
  const load = async (list) => Promise.all((list || []).map(loadImage));
  const loaded = isSame ? images : await load(data.frames);
  const idleImage = data.idle ? await loadImage(data.idle) : null;
  const depthImages = await load(overlays.depth);
  if (!data || data.key !== key) return; // another one was opened meanwhile
  images = loaded;
  depths = depthImages;
  idle = idleImage ? pixelsOf(idleImage) : null;
  mask = overlays.contact ? maskCanvas(overlays.contact.mask) : null;
  showLayers();
  if (!isSame) {
    go(0);
    if (!wantsRest) play();
  }
  draw();
  element.querySelector(".stage").dataset.shown = data.pending ? "frames" : "all";
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
    arrows: data.overlays, contact: data.overlays, difference: data.idle,
    depth: depths.length, truth: data.overlays && data.overlays.fields.some((one) => one.key === "truth"),
  };
  const buttons = Object.keys(LAYER_NAMES).filter((name) => has[name]).map((name) => {
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
  if (layers.contact && mask) {
    const touch = data.timeline ? data.timeline.panels[2].curves[0].mean[k] : 1;
    if (touch >= 0.5) drawContact(context, size, overlays.contact, mask, touch);
    const numbers = overlays.looked_at;
    const when = data.timeline ? ` in frames ${numbers[0]} to ${numbers[numbers.length - 1]}` : "";
    lines.push({ text: `red: where it touches${when}` });
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
    const far = panels[1].curves.map((one) => one.mean[k].toFixed(1));
    lines.push({ text: `since the start: ${turn.toFixed(0)}°, ${far[0]} ${panels[1].unit} right, ${far[1]} down` });
  }
  drawLegend(context, size, lines);
}

function go(place) {
  if (!data) return;
  frame = Math.min(Math.max(Math.round(place), 0), data.frames.length - 1);
  scrub.value = frame;
  const when = data.x[frame], number = data.numbers[frame];
  part("clock").textContent = data.unit === "s" ? `${when.toFixed(2)} s` : `frame ${number}`;
  scrub.setAttribute("aria-valuetext", data.unit === "s" ? `${when.toFixed(2)} seconds` : `frame ${number}`);
  timeline.at(when);
  draw();
}

function play() {
  if (!data || isPlaying) return;
  if (frame >= data.frames.length - 1) go(0);
  isPlaying = true;
  began = performance.now();
  beganAt = frame;
  shownAsPlaying();
  requestAnimationFrame(advance);
}

function pause() {
  isPlaying = false;
  shownAsPlaying();
}

function shownAsPlaying() {
  playButton.textContent = isPlaying ? "❚❚" : "▶";
  playButton.setAttribute("aria-label", isPlaying ? "Pause" : "Play");
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

playButton.onclick = () => (isPlaying ? pause() : play());
scrub.oninput = () => seek(Number(scrub.value));
picture.onclick = () => (isPlaying ? pause() : play());
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
