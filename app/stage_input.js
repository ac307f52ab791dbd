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
