// The page's small parts, each of which is run by the name of its class: questions to try, examples,
// and what can be saved. `element`, `props`, `trigger` and `watch` are the toolkit's.

function showButtons(place, names, told) {
  place.replaceChildren(...names.map((name) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = told(name).label;
    button.onclick = () => trigger("click", told(name).click);
    return button;
  }));
}

const parts = {
  complaint() {},

  chips() {
    const show = () => showButtons(
      element.firstElementChild, props.value || [], (text) => ({ label: text, click: { text } }));
    watch("value", show);
    show();
  },

  examples() {
    element.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button) trigger("click", { example: button.dataset.example });
    });
  },

  saving() {
    const labels = {
      "track.csv": "Track as CSV", "track.json": "Track as JSON", "track.png": "Timeline as PNG",
      "talk.txt": "Conversation as text", "talk.json": "Conversation as JSON", "link": "Copy link",
    };
    const [bar, status] = element.querySelectorAll("[data-part]");
    const show = () => {
      const value = props.value || {}, kinds = value.kinds || [];
      showButtons(bar, kinds, (kind) => ({ label: labels[kind], click: { kind } }));
      status.textContent = kinds.length
        ? "" : "Open a recording first: what is found of it is saved here.";
      if (value.link !== undefined) {
        const link = location.origin + location.pathname + value.link;
        navigator.clipboard.writeText(link).then(
          () => { status.textContent = "Link copied."; }, () => { status.textContent = link; });
      }
      if (value.content === undefined) return;
      const bytes = Uint8Array.from(atob(value.content), (letter) => letter.charCodeAt(0));
      const address = URL.createObjectURL(new Blob([bytes], { type: value.mime }));
      Object.assign(document.createElement("a"), { href: address, download: value.name }).click();
      setTimeout(() => URL.revokeObjectURL(address), 1000);
      status.textContent = `${value.name} saved.`;
    };
    watch("value", show);
    show();
  },
};
