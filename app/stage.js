// Keeps what arrives of a stream that is watched: each value brings one picture more, and the whole
// timeline as far as it is shown.

const MOST_PICTURES = 320; // of more every second one is let go of
const STALE_MS = 3000; // without a picture it is not live any more
const SILENT = "No picture has come for 3 s: the camera has stalled.";

class Received {
  begin(stream) {
    this.stream = stream;
    this.images = [];
    this.outlines = [];
    this.x = [];
    this.numbers = [];
    this.idle = null;
  }

  // What the stage shows once a value has come; null where another stream has begun meanwhile.
  async with(value) {
    if (this.stream !== value.stream) this.begin(value.stream);
    const given = value.picture;
    const [image, idle] = await Promise.all(
      [given && given.image, value.idle].map((address) => (address ? loadImage(address) : null)));
    if (this.stream !== value.stream) return null;
    if (idle) this.idle = canvasOf(idle).pixels.data;
    if (image && !(given.at <= this.x[this.x.length - 1])) this.add(given, image);
    const { outlines, x, numbers, rate } = this;
    return { ...value, count: this.images.length, outlines, x, numbers, rate };
  }

  add(given, image) {
    this.images.push(image);
    this.outlines.push(given.outline);
    this.x.push(given.at);
    this.numbers.push(given.number);
    if (this.images.length <= MOST_PICTURES) return;
    for (const name of ["images", "outlines", "x", "numbers"]) {
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
const layers = [...part("layers").children];
const isSecond = Boolean(element.querySelector("[data-event=collapse]"));
const GALLERY_HIGH = 120; // pixels; what is compared is chosen there
let data = null, images = [], idle = null, depths = [];
let frame = 0, isPlaying = false, isFollowing = false, isResting = false, began = 0, beganAt = 0;
let shows = 0, stale = null;
let cameraClicked = -Infinity; // when its own buttons were used
let loading = null; // whether the pictures are there, once that is known
const received = new Received();

async function show(given) {
  shows += 1;
  const value = given && given.json ? JSON.parse(given.json) : given; // as of `toolkit.sent`
  part("condition").textContent = (value && value.condition) || "";
  part("condition").classList.toggle("held", Boolean(value && (value.marks || []).length));
  element.querySelector(".stage").toggleAttribute("data-open", Boolean(value && Object.keys(value).length));
  if (value && value.stream) await showStream(value, shows);
  else if (value && value.pack) await showRecording(value, shows);
  else showNothing();
}

function showNothing() {
  data = null;
  images = [];
  received.begin(null);
  pause();
  title();
  picture.setAttribute("aria-label", "No recording is open");
  for (const button of layers) button.hidden = true;
  part("clock").textContent = "";
  timeline.place = undefined;
  timeline.show(null);
  draw();
  if (isSecond && element.querySelector("[data-open]")) reveal(GALLERY_HIGH);
}

async function showRecording(value, turn) {
  const before = data, isSame = data && data.pack === value.pack && data.name === value.name;
  data = value;
  received.begin(null);
  const isLike = before && !before.stream && before.name === value.name && before.count === value.count;
  if (!isSame && !isLike) images = [];
  title();
  scrub.min = 0;
  timeline.show(data);
  if (!isSame) {
    if (before || isSecond) reveal();
    loading = loadPictures(value, turn, isLike);
  }
  showLayers();
  if (isResting) rest();
  draw();
  if ((await loading) && data) element.querySelector(".stage").dataset.shown = data.pending ? "frames" : "all";
}

// Tells whether the pictures are there, unless another recording was opened meanwhile.
async function loadPictures(value, turn, isLike) {
  const isGone = () => turn !== shows && (!data || data.pack !== value.pack);
  const all = await imagesOf(value.pack);
  if (isGone()) return false;
  // What is like the one before takes its place at once, at the same frame.
  if (isLike && all) await Promise.all(all.map((image) => image.decode().catch(() => null)));
  images = all ? all.slice(0, value.count) : [];
  for (const image of images) image.addEventListener("load", () => image === images[frame] && draw());
  const [idleImage] = all && value.has_idle ? all.slice(value.count) : [];
  depths = all ? all.slice(value.count + (value.has_idle ? 1 : 0)) : [];
  if (idleImage) await idleImage.decode().catch(() => null);
  if (isGone()) return false;
  idle = idleImage && idleImage.naturalWidth ? canvasOf(idleImage).pixels.data : null;
  showLayers();
  go(isLike ? frame : 0);
  if (wantsRest) rest();
  else play();
  return true;
}

// On a narrow page the picture of what was just opened may be out of sight. The page is scrolled by
// hand: after `scrollIntoView` the keyboard would go on from there.
function reveal(below = 0) {
  const { top, bottom } = element.querySelector(".stage-screen").getBoundingClientRect();
  window.scrollBy(0, top < 0 ? top : Math.min(Math.max(bottom + below - window.innerHeight, 0), top));
}

// While it is live the newest picture is shown, unless another one was looked for.
async function showStream(value) {
  const isNew = !data || data.stream !== value.stream, place = isNew ? 0 : data.x[frame];
  const merged = await received.with(value);
  if (!merged || received.stream !== value.stream) return;
  data = merged;
  ({ images, idle } = received);
  depths = [];
  if (isNew) {
    isPlaying = false;
    isFollowing = true;
    reveal();
  }
  title();
  const oldest = data.x.findIndex((time) => time >= data.window[0]);
  scrub.min = Math.max(oldest, 0);
  timeline.show(data);
  showLayers();
  go(isFollowing ? images.length - 1 : nearest(data.x, place));
  shownAsPlaying();
  clearTimeout(stale);
  if (data.live) stale = setTimeout(() => endLive(value.stream), STALE_MS);
  else if (isFollowing) rest();
}

function endLive(stream) {
  if (!data || data.stream !== stream) return;
  const isStopped = performance.now() - cameraClicked < 1.5 * STALE_MS; // by hand
  data = { ...data, live: false, notes: isStopped ? data.notes : [SILENT, ...data.notes] };
  part("condition").textContent = data.condition.replace(/^Waiting for this:/, "Did not hold so far:");
  title();
  shownAsPlaying();
}

function title() {
  element.querySelector(".stage").dataset.shown = !data ? "nothing" : data.stream ? "all" : "";
  part("empty").hidden = Boolean(data);
  part("name").textContent = data ? data.name : "";
  part("about").textContent = data ? data.about : "";
  part("live").hidden = !(data && data.live);
  part("notes").textContent = ((data && data.notes) || []).join(" ");
  part("stop").hidden = !(data && data.pending);
  part("zoom").hidden = part("legend").hidden = !(data && data.timeline);
  playButton.disabled = scrub.disabled = !data;
  if (!data) return;
  scrub.max = data.count - 1;
  const how = data.stream ? "watched" : "playing";
  picture.setAttribute("aria-label", `${data.name}, ${how}: its frames with what the model reads`);
  part("time").setAttribute("aria-label", timelineLabel());
}

function timelineLabel() {
  if (data.timeline) {
    const all = data.timeline.lanes.flatMap((lane) => lane.events).sort((a, b) => a.begin - b.begin);
    return `Timeline: ${all.map((event) => event.text).join("; ") || "nothing moves"}`;
  }
  const rows = data.step ? data.step.rows.map((row) => `${row.name}: ${row.text}`) : [];
  return `Timeline: ${(data.step && data.step.text) || rows.join("; ") || "being read"}`;
}

function showLayers() {
  const has = {
    contact: hasOutlines(), arrows: data.motion || data.timeline, shear: data.shear,
    difference: idle, depth: depths.length, truth: data.truth,
  };
  for (const button of layers) button.hidden = !has[button.dataset.layer];
}

// Without an idle frame what has changed is no contact: only arrows are drawn there.
const hasOutlines = () => data.outlines && (!data.timeline || data.timeline.lanes[0].is_known);

const isShown = (name) => part("layers").querySelector(`[data-layer=${name}]`).getAttribute("aria-pressed") === "true";

function draw() {
  const ratio = window.devicePixelRatio || 1;
  const box = picture.getBoundingClientRect();
  picture.width = Math.round(Math.max(box.width, 1) * ratio);
  picture.height = Math.round(Math.max(box.height, 1) * ratio);
  const context = picture.getContext("2d");
  part("result").textContent = data ? resultText().replace(/(\d) (px|mm|s)\b/g, "$1\u00a0$2") : "";
  const image = images[frame];
  if (!data || !image || !image.naturalWidth) return;
  // As large as it fits, in the shape of the camera.
  const wide = Math.min(box.width, box.height * data.aspect), size = [wide, wide / data.aspect];
  context.setTransform(ratio, 0, 0, ratio, ratio * (box.width - size[0]) / 2, ratio * (box.height - size[1]) / 2);
  let seen = image;
  if (isShown("difference") && idle) seen = differenceOf(image, idle);
  if (isShown("depth") && depths[frame]) seen = depths[frame];
  context.imageSmoothingQuality = "high";
  context.drawImage(seen, 0, 0, ...size);
  drawLayers(context, size);
}

function drawLayers(context, size) {
  const lines = [], outlines = data.outlines || [];
  const polygons = outlines[Math.min(frame, outlines.length - 1)] || [];
  if (isShown("contact") && hasOutlines() && polygons.length) {
    strokeOver(context, pathOf(polygons, size), 1.6, "#ffffff");
    lines.push({ text: "where the gel has changed" });
  }
  if (isShown("depth") && depths[frame]) lines.push({ text: `bright: ${data.deepest_mm} mm deep` });
  if (isShown("difference") && idle) lines.push({ text: "change against the idle gel, four times" });
  const field = (ends, colour, text) => {
    if (drawField(context, size, ends, colour)) lines.push({ colour, text });
  };
  if (isShown("shear")) field(data.shear, "#ff9df0", "learned shear change, no unit");
  if (isShown("truth")) field(data.truth, "#35e0ff", "true motion, to scale");
  const motion = isShown("arrows") && polygons.length && (data.timeline ? motionNow() : data.motion);
  if (motion) {
    const when = data.timeline ? `of the next ${LOOK_AHEAD_S} s` : "from the first to the last frame";
    field(rigidArrows(size, polygons, (motion.turn * Math.PI) / 180, motion.travel), "#ffdc00", `motion ${when}, to scale`);
  }
  drawLegend(context, size, lines);
}

// The turn and the slide that go on at this moment; null at rest.
function motionNow() {
  const { x, way, lanes } = data.timeline, now = data.x[frame];
  const going = (name) => timeline.eventsAt(now, [name]).length > 0;
  if (!going("turn") && !going("slide")) return null;
  const ahead = data.unit === "s" ? LOOK_AHEAD_S : LOOK_AHEAD_S * data.rate;
  const until = Math.min(now + ahead, x[x.length - 1]), [a, b] = [nearest(x, now), nearest(x, until)];
  const turned = lanes.find((lane) => lane.name === "turn").curves[0].mean;
  return {
    turn: going("turn") ? turned[b] - turned[a] : 0,
    travel: going("slide") ? [way[b][0] - way[a][0], way[b][1] - way[a][1]] : [0, 0],
  };
}

const eventsOf = (...names) => data.timeline.lanes.filter((lane) => names.includes(lane.name)).flatMap((lane) => lane.events);

// What moves it; of what is only pressed, the presses.
const moves = () => (eventsOf("turn", "slide").length ? eventsOf("turn", "slide") : eventsOf("contact"));

// Once it has been played it rests in the middle of what goes farthest: a degree of a turn is about
// a pixel at the edge of a contact.
function rest() {
  pause();
  isResting = true;
  const farthest = data.timeline && moves().sort((a, b) => b.size - a.size)[0];
  go(farthest ? nearest(data.x, (farthest.begin + farthest.end) / 2) : data.count - 1);
}

// The motion that goes on, else the last one: in the words of the timeline.
function resultText() {
  if (data.step) return data.step.text;
  if (data.pending) return data.progress || "reading the motion…";
  if (!data.timeline) return "";
  const now = data.x[frame];
  const begun = moves().filter((event) => event.begin <= now).sort((a, b) => a.begin - b.begin);
  const going = begun.filter((event) => event.end >= now);
  const unit = data.unit === "s" ? " s" : "", digits = data.unit === "s" ? 2 : 0;
  const times = (event) => `${data.unit === "s" ? "" : "frames "}${+event.begin.toFixed(digits)} to ${+event.end.toFixed(digits)}${unit}`;
  const words = (event) => `${event.text}${event.span && ` (${event.span})`}, ${times(event)}`;
  return going.length ? going.map(words).join(" · ") : begun.slice(-1).map((event) => `last: ${words(event)}`).join("");
}

function go(place) {
  if (!data || !data.count) return;
  frame = Math.min(Math.max(Math.round(place), Number(scrub.min)), data.count - 1);
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
  if (isResting || frame >= data.count - 1) go(Number(scrub.min));
  isPlaying = true;
  isResting = false;
  began = performance.now();
  beganAt = frame;
  shownAsPlaying();
  requestAnimationFrame(advance);
}

function pause() {
  isPlaying = isFollowing = isResting = false;
  shownAsPlaying();
}

const runs = () => isPlaying || Boolean(data && data.live && isFollowing);

function shownAsPlaying() {
  playButton.textContent = runs() ? "❚❚" : "▶";
  playButton.setAttribute("aria-label", runs() ? "Pause" : data && data.live ? "Show the newest" : "Play");
}

function advance(now) {
  if (!isPlaying || !data || !element.isConnected) return;
  const count = data.count;
  let place = placeAfter((now - began) / 1000);
  if (place >= count && !data.loops) {
    rest();
    return;
  }
  place = Math.floor(place) % count;
  if (place !== frame && element.offsetParent !== null) go(place);
  requestAnimationFrame(advance);
}

// Frames are not always as far apart: where times are known, they are shown by them.
function placeAfter(seconds) {
  if (data.unit !== "s") return beganAt + seconds * data.rate;
  const when = data.x[beganAt] + seconds, last = data.x.length - 1;
  if (when > data.x[last]) return last + (when - data.x[last]) * data.rate;
  return data.x.findLastIndex((time) => time <= when);
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
  const zooms = { "+": 2, "-": 0.5, 0: 0 };
  if (event.key === " " && event.target.tagName !== "BUTTON") playButton.click();
  else if (event.key in steps) seek(steps[event.key]);
  else if (event.key in zooms) timeline.zoom(zooms[event.key]);
  else return;
  event.preventDefault();
});
document.addEventListener("click", (event) => {
  if (event.target.closest(".live-camera")) cameraClicked = performance.now();
}, true);
document.addEventListener("seek", (event) => {
  if (data && data.timeline && element.offsetParent) seek(nearest(data.x, event.detail));
});

const tip = part("tip"), time = part("time");
let movedFrom = null; // where the shown part was taken hold of
const toPlace = (event) => timeline.valueAt(event.clientX - time.getBoundingClientRect().left);
time.addEventListener("pointerdown", (event) => {
  if (!data) return;
  time.setPointerCapture(event.pointerId);
  // Below the rows the part that is shown is moved, on them the moment.
  const below = event.clientY - time.getBoundingClientRect().top > timeline.height - AXIS;
  movedFrom = timeline.view && below ? event.clientX : null;
  if (movedFrom === null) seek(nearest(data.x, toPlace(event)));
  else pause();
});
time.addEventListener("pointermove", (event) => {
  if (!data) return;
  const value = toPlace(event);
  if (time.hasPointerCapture(event.pointerId)) {
    if (movedFrom === null) seek(nearest(data.x, value));
    else {
      timeline.pan(((event.clientX - movedFrom) / timeline.width) * (timeline.whole[1] - timeline.whole[0]));
      movedFrom = event.clientX;
    }
  }
  if (!data.timeline) return;
  tip.textContent = timeline.textAt(value);
  tip.hidden = false;
  const box = element.getBoundingClientRect();
  const left = Math.min(event.clientX - box.left + 14, box.width - tip.offsetWidth - 4);
  tip.style.left = `${left}px`;
  tip.style.top = `${time.getBoundingClientRect().top - box.top - tip.offsetHeight - 4}px`;
});
for (const ending of ["pointercancel", "pointerleave"]) time.addEventListener(ending, () => { tip.hidden = true; });
// With a key held the wheel zooms; once a part is shown it moves that part along.
time.addEventListener("wheel", (event) => {
  if (event.ctrlKey || event.metaKey) timeline.zoom(event.deltaY < 0 ? 1.25 : 0.8, toPlace(event));
  else if (timeline.view) {
    pause(); // the moment would draw it back
    timeline.pan(((event.deltaX || event.deltaY) / timeline.width) * (timeline.span[1] - timeline.span[0]));
  } else return;
  event.preventDefault();
}, { passive: false });
for (const action of element.querySelectorAll("[data-event]")) action.onclick = () => trigger(action.dataset.event);
// What is dropped on the picture goes where its tab takes recordings.
const screen = element.querySelector(".stage-screen");
screen.addEventListener("dragover", (event) => event.preventDefault());
screen.addEventListener("drop", (event) => {
  event.preventDefault();
  const input = element.closest(".tabitem").querySelector(".drop input[type=file]"), given = event.dataTransfer.files;
  if (!input || !given.length) return;
  input.files = given;
  input.dispatchEvent(new Event("change", { bubbles: true }));
});
for (const button of layers) {
  button.onclick = () => {
    button.setAttribute("aria-pressed", !isShown(button.dataset.layer));
    draw();
  };
}
for (const button of part("zoom").children) button.onclick = () => timeline.zoom(Number(button.dataset.zoom));
const resized = new ResizeObserver(() => {
  if (timeline.width !== time.clientWidth) timeline.draw();
  draw();
});
resized.observe(time);
resized.observe(picture);
watch("value", () => show(props.value));
show(props.value);
