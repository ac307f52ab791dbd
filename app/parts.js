// The page's small parts, each of which is run by the name of its class. `element`, `props`,
// `trigger` and `watch` are the toolkit's. All text is set as text: nothing of it is markup.

function made(kind, className, text, ...inside) {
  const one = document.createElement(kind);
  if (className) one.className = className;
  if (text) one.textContent = text;
  one.append(...inside);
  return one;
}

function button(text, act, name) {
  const one = made("button", "", text);
  one.type = "button";
  one.onclick = act;
  if (name) one.setAttribute("aria-label", name);
  return one;
}

// What a part returns, if anything, shows its value, now and whenever that changes.
function run(part) {
  const show = part && part();
  if (!show) return;
  watch("value", show);
  show();
}

function table(heads, rows) {
  const line = (cells, kind) => made("tr", "", "", ...cells.map((cell) => made(kind, "", String(cell))));
  return made("table", "", "", line(heads, "th"), ...rows.map((row) => line(row, "td")));
}

// Moments in an answer, which a click shows: "at 1.7 s and 2 s", "from 1.4 to 2.28 s".
const MOMENT = /(\b(?:at|from|to|until|after|before) |(?<=\bat (?:[\d.]+ s(?:,| and) )+))(\d+(?:\.\d+)?)(?=( to \d+(\.\d+)?)? s\b)/gi;

function withMoments(text) {
  const place = made("p", "answer");
  let end = 0;
  for (const match of text.matchAll(MOMENT)) {
    const [whole, before, number] = match;
    const show = button(number, () => document.dispatchEvent(new CustomEvent("seek", { detail: +number })), `Show ${number} s`);
    place.append(text.slice(end, match.index) + before, show);
    end = match.index + whole.length;
  }
  place.append(text.slice(end));
  return place;
}

const SURE = "How probable it is that this answer is right, the question's reading included. It is calibrated: of a hundred answers at 90 % about ninety are right.";

function exchange({ question, answer, sure }) {
  const block = made("div", "exchange", "", made("p", "asked", question));
  if (answer === undefined) {
    block.append(made("p", "waits", "Answering…", button("Stop", () => trigger("stop"))));
    return block;
  }
  const told = withMoments(answer);
  if (sure != null) {
    const mark = made("span", "sure", `${sure} % sure`);
    mark.title = SURE;
    mark.style.setProperty("--sure", `${sure}%`);
    told.append(" ", mark);
  }
  block.append(told);
  return block;
}

const parts = {
  talk() {
    const [list, clear, details] = ["list", "clear", "details"].map((name) => element.querySelector(`[data-part=${name}]`));
    const { empty } = props.value || {}; // what stands here as long as nothing was asked
    clear.onclick = () => trigger("clear");
    const drawer = () => element.closest(".tabitem").querySelector(".drawer");
    details.onclick = () => {
      const isOpen = drawer().classList.toggle("open");
      details.setAttribute("aria-expanded", isOpen);
      if (isOpen) drawer().querySelector(".drawer-close").focus();
    };
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && drawer().classList.contains("open")) details.click();
    });
    return () => {
      const { exchanges = [], pending } = props.value || {};
      const all = [...exchanges.map(exchange), ...(pending ? [exchange({ question: pending })] : [])];
      const last = exchanges[exchanges.length - 1];
      if (last && last.sure !== undefined && !pending) all[all.length - 1].append(button("Retry", () => trigger("retry")));
      list.replaceChildren(...(all.length ? all : [made("p", "empty-talk", empty)]));
      clear.hidden = !all.length;
      // A long answer is read from its question on.
      list.scrollTop += list.lastElementChild.getBoundingClientRect().top - list.getBoundingClientRect().top - 12;
    };
  },

  "drawer-head"() {
    element.querySelector("button").onclick = () => element.closest(".tabitem").querySelector("[data-part=details]").click();
  },

  chips() {
    return () => element.firstElementChild.replaceChildren(
      ...(props.value || []).map((text) => button(text, () => trigger("click", { text }))));
  },

  examples() {
    element.addEventListener("click", (event) => {
      const chosen = event.target.closest("button");
      if (chosen) trigger("click", { example: chosen.dataset.example });
    });
  },

  evidence() {
    return () => {
      const { notes = [], probabilities, verdicts, band, regions, timing, about = [] } = props.value || {};
      const inside = [];
      if (!verdicts && !about.length) inside.push(made("p", "", "Nothing was asked yet: what an answer rests on stands here."));
      for (const note of [...notes, ...about]) inside.push(made("p", "note", note));
      if (probabilities && probabilities.length) {
        inside.push(made("h4", "", "Calibrated probabilities"), ...probabilities.map(([word, share]) => {
          const bar = made("p", "probability", "", made("span", "", word), made("b", "", `${Math.round(100 * share)} %`));
          bar.style.setProperty("--share", share);
          return bar;
        }));
      }
      if (band) inside.push(made("p", "note", band));
      if (verdicts) {
        inside.push(made("h4", "", regions ? "Read by three methods" : "Both recordings"));
        inside.push(table([regions ? "read by" : "recording", "motion", "how"], verdicts));
      }
      if (regions) {
        inside.push(made("h4", "", "Seven regions"), table(["region", "shear change x", "y", "contact mass"], regions));
        inside.push(made("p", "note", timing));
      }
      element.firstElementChild.replaceChildren(...inside);
    };
  },

  code() {
    const [copy, text] = [element.querySelector("button"), element.querySelector("pre")];
    copy.onclick = () => navigator.clipboard.writeText(props.value);
    return () => {
      text.textContent = props.value || "Ask a question: the conversation stands here as a program.";
      copy.hidden = !props.value;
    };
  },

  saving() {
    const labels = {
      "track.csv": "Track as CSV", "track.json": "Track as JSON", "track.png": "Timeline as PNG",
      "talk.txt": "Conversation as text", "talk.json": "Conversation as JSON", "link": "Copy link",
    };
    const [bar, status] = element.querySelectorAll("[data-part]");
    return () => {
      const value = props.value || {}, kinds = value.kinds || [];
      bar.replaceChildren(...kinds.map((kind) => button(labels[kind], () => trigger("click", { kind }))));
      status.textContent = kinds.length ? "" : "Open a recording first: its track is saved here.";
      if (value.link !== undefined) {
        const link = location.origin + location.pathname + value.link;
        navigator.clipboard.writeText(link).then(
          () => { status.textContent = "Link copied."; }, () => { status.textContent = link; });
      }
      if (value.content === undefined) return;
      const address = `data:${value.mime};base64,${value.content}`;
      Object.assign(document.createElement("a"), { href: address, download: value.name }).click();
      status.textContent = `${value.name} saved.`;
    };
  },
};
