// Draws what happened when: a row for each kind of event with its curve, or a short clip's motion
// with its spans. Where the pointer stands is put into words by `textAt`.

const SVG = "http://www.w3.org/2000/svg";
const LEFT = 64, RIGHT = 10, STRIP = 16, GAP = 5, AXIS = 22;
const CURVE = { contact: 16, turn: 44, slide: 44, rest: 0 };

function svg(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes || {})) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

function stepFor(span, count) {
  const raw = span / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw || 1));
  return power * ([1, 2, 5, 10].find((factor) => factor * power >= raw) || 10);
}

// "3 px left", "18° clockwise": an amount along an axis without a sign.
const WAYS = { turn: ["clockwise", "counterclockwise"], right: ["right", "left"], down: ["down", "up"] };

function along(name, value, unit) {
  const digits = Math.abs(value) < 9.95 && unit !== "°" ? 1 : 0, size = Math.abs(value).toFixed(digits);
  const gap = unit === "°" ? "" : " ";
  return Number(size) ? `${+size}${gap}${unit} ${WAYS[name][value < 0 ? 1 : 0]}` : "";
}

// What goes up in the picture is drawn upwards.
const upward = (curve) => (curve.name === "down" ? -1 : 1);

class Timeline {
  constructor(box) {
    this.box = box;
    this.data = null;
    this.view = null;
    this.id = `inside-${Math.random().toString(36).slice(2)}`; // there are several stages
  }

  show(data) {
    if (!data || !this.data || data.name !== this.data.name) this.view = null;
    this.data = data;
    this.draw();
  }

  get whole() {
    if (this.data.window) return this.data.window;
    const x = this.scale("x") || this.data.x;
    return [x[0], x[x.length - 1] > x[0] ? x[x.length - 1] : x[0] + 1];
  }

  // The lowest and highest value of a row that two recordings share.
  scale(name) {
    return (this.data.scale || {})[name];
  }

  get span() {
    return this.view || this.whole;
  }

  placeOf(value) {
    const [first, last] = this.span;
    return LEFT + ((value - first) / (last - first)) * (this.width - LEFT - RIGHT);
  }

  valueAt(pixels) {
    const [first, last] = this.span;
    const share = (pixels - LEFT) / (this.width - LEFT - RIGHT);
    return first + Math.min(Math.max(share, 0), 1) * (last - first);
  }

  // Shows less of the time about a moment, or more; a factor of 0 shows all.
  zoom(factor, about) {
    if (!this.data || !this.data.timeline) return;
    const [low, high] = this.whole, [first, last] = this.span;
    const length = factor ? (last - first) / factor : Infinity;
    if (length >= high - low) this.view = null;
    else {
      const middle = about ?? this.place ?? (first + last) / 2;
      const from = middle - ((middle - first) / (last - first)) * length;
      this.view = this.held(from, Math.max(length, (high - low) / 200));
    }
    this.draw();
  }

  pan(by) {
    if (!this.view) return;
    this.view = this.held(this.view[0] + by, this.view[1] - this.view[0]);
    this.draw();
  }

  held(from, length) {
    const [low, high] = this.whole, first = Math.min(Math.max(from, low), high - length);
    return [first, first + length];
  }

  draw() {
    this.box.replaceChildren();
    if (!this.data) return;
    this.width = this.box.clientWidth || 600;
    this.root = svg("svg", { width: this.width, class: "timeline" });
    const clip = svg("clipPath", { id: this.id });
    clip.append(svg("rect", { x: LEFT, y: 0, width: Math.max(this.width - LEFT - RIGHT, 1), height: 400 }));
    const hatch = svg("pattern", { id: `${this.id}-hatch`, width: 5, height: 5, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" });
    hatch.append(svg("line", { class: "hatch", y2: 5 }));
    this.root.append(clip, hatch);
    this.box.append(this.root);
    const top = this.data.timeline ? this.drawTrack() : this.drawStep();
    this.drawAxis(top);
    this.height = top + AXIS;
    this.root.setAttribute("height", this.height);
    this.root.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    this.cursor = svg("line", { class: "cursor", y1: 0, y2: top });
    if (this.data.timeline) this.root.append(this.cursor);
    this.showCursor();
  }

  drawTrack() {
    let top = 0;
    for (const lane of this.data.timeline.lanes) {
      this.text(2, top + 12, lane.name, "name");
      const height = CURVE[lane.name], far = this.width - RIGHT;
      this.root.append(svg("rect", { class: "ground", x: LEFT, y: top, width: far - LEFT, height: STRIP + height }));
      if (lane.curves.length) this.drawCurves(lane, top + STRIP, height);
      for (const event of lane.events) this.drawEvent(event, top);
      const none = !lane.is_known ? "not known" : this.data.live ? "nothing yet" : "nothing";
      if (!lane.events.length) this.text(LEFT + 6, top + 12, none, "quiet");
      top += STRIP + height + GAP;
    }
    for (const mark of this.data.marks || []) {
      const x = this.placeOf(mark);
      if (x >= LEFT) this.root.append(svg("path", { class: "moment", d: `M${x} ${top - GAP}V0l6 6 -6 6` }));
    }
    return top;
  }

  drawEvent(event, y) {
    const [first, last] = this.span;
    if (event.end < first || event.begin > last) return;
    const from = Math.max(this.placeOf(event.begin), LEFT), to = Math.min(this.placeOf(event.end), this.width - RIGHT);
    const width = Math.max(to - from, 3);
    const group = svg("g", { class: `event ${event.kind}` });
    group.append(svg("rect", { x: from, y, width, height: STRIP, rx: 3 }));
    const label = [event.text, inShort(event.text), inShort(event.text)[0]].find((text) => text && width > 6.2 * text.length + 6);
    if (label) group.append(svg("text", { x: from + 4, y: y + 12 }, label));
    this.root.append(group);
  }

  drawCurves(lane, top, height) {
    const limit = lane.limit || 0;
    let [low, high] = lane.name === "contact" ? [0, 1] : [-limit, limit];
    for (const curve of lane.curves) {
      curve.mean.forEach((mean, k) => {
        const spread = curve.spread ? curve.spread[k] : 0;
        low = Math.min(low, upward(curve) * mean - spread);
        high = Math.max(high, upward(curve) * mean + spread);
      });
    }
    if (this.scale(lane.name)) [low, high] = [Math.min(low, this.scale(lane.name)[0]), Math.max(high, this.scale(lane.name)[1])];
    if (high - low < 1) [low, high] = [low - 0.5, high + 0.5];
    const y = (value) => top + height - 2 - ((value - low) / (high - low)) * (height - 4);
    const far = this.width - RIGHT;
    const undetected = { x: LEFT, y: y(limit), width: far - LEFT, height: y(-limit) - y(limit) };
    if (limit) this.root.append(svg("rect", { fill: `url(#${this.id}-hatch)`, ...undetected }));
    this.root.append(svg("line", { class: "zero", x1: LEFT, x2: far, y1: y(0), y2: y(0) }));
    lane.curves.forEach((curve, k) => this.drawCurve(curve, `${lane.name}-${k}`, y));
    if (lane.name === "contact") return;
    const step = stepFor(high - low, 3);
    let before = Infinity;
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      if (before - y(value) < 10) continue;
      before = y(value);
      this.text(LEFT - 5, before + 3.5, `${+value.toFixed(2)}${lane.unit === "°" ? "°" : ""}`.replace("-", "−"), "tick", "end");
    }
    if (lane.unit !== "°") this.text(2, top + height - 4, lane.unit, "tick");
  }

  drawCurve(curve, name, y) {
    const x = this.data.timeline.x.map((value) => this.placeOf(value));
    const points = (sign) => x.map((at, k) => `${at.toFixed(1)},${y(upward(curve) * curve.mean[k] + sign * (curve.spread ? curve.spread[k] : 0)).toFixed(1)}`);
    const inside = { "clip-path": `url(#${this.id})` };
    if (curve.spread) {
      this.root.append(svg("polygon", { ...inside, class: `spread ${name}`, points: [...points(1), ...points(-1).reverse()].join(" ") }));
    }
    this.root.append(svg("polyline", { ...inside, class: `curve ${name}`, points: points(0).join(" ") }));
  }

  // From the first frame to the last: how far each part of the motion goes, and the span it lies in.
  drawStep() {
    const step = this.data.step;
    if (!step) {
      this.text(LEFT, 24, this.data.pending ? this.data.progress || "Reading the motion…" : "", "quiet");
      return 40;
    }
    if (!step.rows.length) this.text(LEFT, 24, step.text, "quiet");
    const hasTruth = step.rows.some((row) => row.true !== undefined);
    const isNarrow = this.width < 520, tall = isNarrow ? 44 : 26; // words stand below, not beside
    const wide = (isNarrow ? 1 : hasTruth ? 0.5 : Math.min(220 / this.width, 0.32)) * (this.width - LEFT - RIGHT);
    step.rows.forEach((row, k) => {
      const y = 2 + k * tall, middle = y + 12;
      const drawn = [0, row.low || 0, row.high || 1, row.true || 0, ...(this.scale(row.name) || [])];
      const least = 1.1 * Math.min(...drawn), most = 1.1 * Math.max(...drawn);
      this.text(2, y + 16, row.name, "name");
      const group = svg("g", { class: `amount ${row.name}` }), at = (value) => LEFT + ((value - least) / (most - least)) * wide;
      group.append(svg("rect", { class: "ground", x: LEFT, y: y + 2, width: wide, height: 20 }));
      if (row.mean !== undefined) {
        group.append(svg("line", { class: "reach", x1: at(row.low), x2: at(row.high), y1: middle, y2: middle }));
        group.append(svg("circle", { cx: at(row.mean), cy: middle, r: 4.5 }));
      }
      if (row.true !== undefined) {
        const x = at(row.true);
        group.append(svg("line", { class: "zero", x1: at(0), x2: at(0), y1: y + 2, y2: y + 22 }));
        group.append(svg("path", { class: "true", d: `M${x} ${middle - 8}l6 8 -6 8 -6 -8z` }));
      }
      this.root.append(group);
      const sure = row.sure === undefined ? "" : `, ${row.sure} % sure`;
      this.text(isNarrow ? 2 : LEFT + wide + 12, y + (isNarrow ? 37 : 16), `${row.text}${sure}`, row.moves ? "claim" : "quiet");
    });
    const below = step.rows.length * tall + 4;
    if (hasTruth) this.text(LEFT, below + 12, "● read, bar: 90 % range    ◇ true", "tick");
    return Math.max(below + 16 * hasTruth, 40);
  }

  drawAxis(top) {
    if (!this.data.timeline) return;
    const [first, last] = this.span, unit = this.data.unit;
    let step = stepFor(last - first, Math.floor((this.width - LEFT) / 70));
    if (unit === "frame") step = Math.max(1, Math.round(step));
    for (let value = Math.ceil(first / step) * step; value <= last + 1e-9; value += step) {
      const x = this.placeOf(value);
      this.root.append(svg("line", { class: "mark", x1: x, x2: x, y1: top - GAP, y2: top }));
      this.text(x, top + 11, `${+value.toFixed(3)}`, "tick", "middle");
    }
    this.text(2, top + 11, unit, "name");
    if (!this.view) return;
    const [low, high] = this.whole, wide = this.width - LEFT - RIGHT, share = (value) => (value - low) / (high - low);
    const at = { x: LEFT + share(first) * wide, width: Math.max((share(last) - share(first)) * wide, 12), rx: 2 };
    this.root.append(svg("rect", { class: "all", x: LEFT, y: top + 14, width: wide, height: 6, rx: 2 }));
    this.root.append(svg("rect", { class: "part", y: top + 14, height: 6, ...at }));
  }

  text(x, y, words, kind, anchor) {
    this.root.append(svg("text", { x, y, class: kind, "text-anchor": anchor || "start" }, words));
  }

  // Shows a moment; the part that is shown follows.
  at(value) {
    this.place = value;
    if (!this.cursor) return;
    if (this.view && (value < this.view[0] || value > this.view[1])) {
      this.view = this.held(value, this.view[1] - this.view[0]);
      this.draw();
    } else this.showCursor();
  }

  showCursor() {
    const x = this.placeOf(this.place ?? this.span[0]);
    this.cursor.setAttribute("visibility", x < LEFT - 1 || x > this.width ? "hidden" : "visible");
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
  }

  // What goes on at a time, of the rows that are named.
  eventsAt(value, names) {
    const lanes = this.data.timeline.lanes.filter((lane) => !names || names.includes(lane.name));
    return lanes.flatMap((lane) => lane.events).filter((event) => event.begin <= value && value <= event.end);
  }

  // What is known of a time, in words with units.
  textAt(value) {
    const { timeline, unit } = this.data;
    const when = unit === "s" ? `${value.toFixed(2)} s` : `frame ${Math.round(value)}`;
    if (!timeline) return when;
    const k = nearest(timeline.x, value), lines = [when];
    for (const { name, unit: of, curves } of timeline.lanes) {
      for (const curve of curves) {
        const spread = curve.spread ? ` ± ${+curve.spread[k].toPrecision(2)}` : "";
        if (name === "contact") lines.push(`contact ${Math.round(100 * curve.mean[k])} %`);
        else lines.push(`${name === "turn" ? "turned" : curve.name === "right" ? "sideways" : "vertically"} ${along(curve.name, curve.mean[k], of) || `0${of}`}${spread}`);
      }
    }
    for (const event of this.eventsAt(value)) {
      const span = event.span ? ` (${event.span})` : "";
      lines.push(`${event.text}${span}, ${event.sure} % sure`);
    }
    return lines.join("\n");
  }
}

const GLYPHS = { counterclockwise: "↺", clockwise: "↻", left: "←", right: "→", up: "↑", down: "↓" };

const DIAGONALS = { "↑→": "↗", "→↓": "↘", "←↓": "↙", "←↑": "↖" };

// An event's way as a sign and how far it goes, where there is no room for the words.
function inShort(text) {
  const [main] = text.split(" and a little ");
  const ways = main.split(" ").flatMap((word) => GLYPHS[word] || []).sort().join("");
  return ways && `${DIAGONALS[ways] || ways} ${text.match(/[0-9.]+°?/)?.[0] || ""}`;
}

function nearest(values, wanted) {
  const off = (k) => Math.abs(values[k] - wanted);
  return values.reduce((best, _, k) => (off(k) < off(best) ? k : best), 0);
}
