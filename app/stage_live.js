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
