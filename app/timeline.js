// Draws what happened when: bands of events over curves with their spreads, or a short clip's motion
// as one step. Where the pointer stands is told by `at`, in the units of the axis.

const SVG = "http://www.w3.org/2000/svg";
const LEFT = 46, RIGHT = 10, BAND = 15, GAP = 7, AXIS = 18;
const PANEL = { turn: 48, travel: 48, contact: 26 };

function svg(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes || {})) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

function stepFor(span, count) {
  const raw = span / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw || 1));
  return power * ([1, 2, 5, 10].find((one) => one * power >= raw) || 10);
}

// Events that overlap lie in rows below each other.
function packed(events) {
  const ends = [];
  return events.map((event) => {
    let row = ends.findIndex((end) => end <= event.begin + 1e-9);
    if (row < 0) row = ends.push(0) - 1;
    ends[row] = Math.max(event.end, event.begin);
    return { ...event, row };
  });
}

class Timeline {
  constructor(box) {
    this.box = box;
    this.data = null;
    this.rows = 1;
  }

  show(data) {
    this.data = data;
    this.draw();
  }

  get span() {
    if (this.data.window) return this.data.window;
    const x = this.data.x;
    return [x[0], x[x.length - 1] > x[0] ? x[x.length - 1] : x[0] + 1];
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

  draw() {
    this.box.replaceChildren();
    if (!this.data) return;
    this.width = this.box.clientWidth || 600;
    this.root = svg("svg", { width: this.width, class: "timeline" });
    this.box.append(this.root);
    const top = this.data.timeline ? this.drawTrack() : this.drawStep();
    this.drawAxis(top);
    this.height = top + AXIS;
    this.root.setAttribute("height", this.height);
    this.root.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    this.cursor = svg("line", { class: "cursor", y1: 0, y2: top });
    this.root.append(this.cursor);
    this.at(this.place ?? this.span[0]);
  }

  drawTrack() {
    const events = packed(this.data.timeline.events);
    // What is below must not jump while events come and go.
    this.rows = Math.max(this.data.stream ? this.rows : 1, ...events.map((one) => one.row + 1));
    for (const event of events) this.drawEvent(event);
    if (!events.length) this.text(LEFT + 4, 11, this.data.live ? "nothing yet" : "nothing touches or moves", "quiet");
    this.text(2, 11, "events", "name");
    let top = this.rows * (BAND + 1) + GAP;
    for (const panel of this.data.timeline.panels) {
      this.drawPanel(panel, top, PANEL[panel.name]);
      top += PANEL[panel.name] + GAP;
    }
    return top;
  }

  drawEvent(event) {
    const from = Math.max(this.placeOf(event.begin), LEFT), to = this.placeOf(event.end);
    const y = event.row * (BAND + 1), width = Math.max(to - from, 3);
    const group = svg("g", { class: `event ${event.kind}` });
    group.append(svg("rect", { x: from, y, width, height: BAND, rx: 3 }));
    const label = event.far ? `${event.name} ${event.far.split(" (")[0]}` : event.name;
    for (const text of [label, event.name]) {
      if (width > 6.1 * text.length + 6) {
        group.append(svg("text", { x: from + 4, y: y + 11 }, text));
        break;
      }
    }
    const far = event.far ? `, ${event.far}` : "";
    group.append(svg("title", {}, `${event.name}${far}, ${event.sure} % sure`));
    this.root.append(group);
  }

  drawPanel(panel, top, height) {
    let [low, high] = panel.range || [0, 0];
    if (!panel.range) {
      for (const curve of panel.curves) {
        curve.mean.forEach((mean, k) => {
          low = Math.min(low, mean - curve.spread[k]);
          high = Math.max(high, mean + curve.spread[k]);
        });
      }
      if (high - low < 1) [low, high] = [low - 0.5, high + 0.5];
    }
    const y = (value) => top + height - ((value - low) / (high - low)) * height;
    const far = this.width - RIGHT;
    this.root.append(svg("rect", { class: "ground", x: LEFT, y: top, width: far - LEFT, height }));
    this.root.append(svg("line", { class: "zero", x1: LEFT, x2: far, y1: y(0), y2: y(0) }));
    panel.curves.forEach((curve, k) => this.drawCurve(curve, `${panel.name}-${k}`, y));
    this.text(LEFT + 5, top + 11, panel.told, "name");
    const step = panel.range ? high - low : stepFor(high - low, 2);
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      const middle = Math.min(Math.max(y(value) + 3, top + 8), top + height);
      this.text(LEFT - 4, middle, `${+value.toFixed(2)}${panel.unit === "°" ? "°" : ""}`, "tick", "end");
    }
  }

  drawCurve(curve, name, y) {
    const x = this.data.timeline.x.map((one) => this.placeOf(one));
    if (curve.spread) {
      const upper = x.map((one, k) => `${one.toFixed(1)},${y(curve.mean[k] + curve.spread[k]).toFixed(1)}`);
      const lower = x.map((one, k) => `${one.toFixed(1)},${y(curve.mean[k] - curve.spread[k]).toFixed(1)}`);
      this.root.append(svg("polygon", { class: `spread ${name}`, points: [...upper, ...lower.reverse()].join(" ") }));
    }
    const points = x.map((one, k) => `${one.toFixed(1)},${y(curve.mean[k]).toFixed(1)}`).join(" ");
    this.root.append(svg("polyline", { class: `curve ${name}`, points }));
  }

  // From the first frame to the last: a bar for each part of the motion, with what is told of it.
  drawStep() {
    const step = this.data.step;
    if (!step) {
      this.text(LEFT, 24, this.data.pending ? "Reading the motion…" : "", "quiet");
      return 40;
    }
    if (step.told) this.text(LEFT, 24, step.told, "quiet");
    step.rows.forEach((row, k) => {
      const y = 4 + k * 26, far = this.width - RIGHT - LEFT;
      const group = svg("g", { class: `event ${row.name} ${row.moves ? "" : "absent"}` });
      group.append(svg("rect", { x: LEFT, y, width: far, height: 21, rx: 4 }));
      group.append(svg("text", { x: LEFT + 8, y: y + 15 }, row.text));
      this.root.append(group);
      this.text(2, y + 15, row.name, "name");
    });
    return Math.max(step.rows.length * 26 + 6, 40);
  }

  drawAxis(top) {
    const [first, last] = this.span, unit = this.data.unit;
    let step = stepFor(last - first, Math.floor((this.width - LEFT) / 70));
    if (unit === "frame") step = Math.max(1, Math.round(step));
    for (let value = Math.ceil(first / step) * step; value <= last + 1e-9; value += step) {
      const x = this.placeOf(value);
      this.root.append(svg("line", { class: "mark", x1: x, x2: x, y1: top, y2: top + 4 }));
      this.text(x, top + 15, `${+value.toFixed(3)}`, "tick", "middle");
    }
    this.text(2, top + 15, unit, "name");
  }

  text(x, y, words, kind, anchor) {
    this.root.append(svg("text", { x, y, class: kind, "text-anchor": anchor || "start" }, words));
  }

  at(value) {
    this.place = value;
    if (!this.cursor) return;
    const x = this.placeOf(value);
    this.cursor.setAttribute("visibility", x < LEFT - 1 || x > this.width ? "hidden" : "visible");
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
  }

  // What is known of a time, in words with units.
  toldAt(value) {
    const { timeline, unit } = this.data;
    const when = unit === "s" ? `${value.toFixed(2)} s` : `frame ${Math.round(value)}`;
    if (!timeline) return when;
    const k = nearest(timeline.x, value), lines = [when];
    for (const panel of timeline.panels) {
      for (const curve of panel.curves) {
        const gap = panel.unit === "°" ? "" : " ";
        const spread = curve.spread ? ` ± ${(+curve.spread[k].toPrecision(2))}` : "";
        const told = panel.unit ? +curve.mean[k].toFixed(1) : `${Math.round(100 * curve.mean[k])} %`;
        lines.push(`${curve.name} ${told}${spread}${gap}${panel.unit}`);
      }
    }
    const now = timeline.events.filter((one) => one.begin <= value && value <= one.end);
    for (const event of now) lines.push([event.name, event.far].filter(Boolean).join(" "));
    return lines.join("\n");
  }
}

function nearest(values, wanted) {
  let low = 0, high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= wanted) low = middle;
    else high = middle;
  }
  return wanted - values[low] <= values[high] - wanted ? low : high;
}
