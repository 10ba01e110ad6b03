// @ts-check
/** A diagram as density: computed by the pool, coarse at once, then refined; painted column by column. */
import { periodColour, rgb, theme } from "./colours.js";
import { Gestures } from "./gestures.js";
import { linspace } from "./jobs.js";
import { Axes } from "./plot.js";

const CHUNK_WORK = 4e5;

export class Diagram {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {import("./pool.js").Pool} pool
   * @param {string} channel
   * @param {{pick?: (x: number, y: number) => void, zoom?: (x: number[], y: number[]) => void, under?: (axes: Axes, c: import("./svg.js").Pen) => void, overlay?: (axes: Axes, c: import("./svg.js").Pen) => void, problem?: (text: string) => void, done?: () => void, zoomOut?: () => void, chosen?: () => number}} events
   */
  constructor(canvas, pool, channel, events) {
    this.axes = new Axes(canvas);
    this.pool = pool;
    this.channel = channel;
    this.events = events;
    this.image = document.createElement("canvas");
    this.stage = "empty";
    this.milliseconds = {};
    this.gestures = new Gestures(this.axes, {
      ready: () => Boolean(this.spec),
      redraw: () => this.draw(),
      pick: (x, y) => events.pick?.(x, y),
      zoom: (x, y) => events.zoom?.(x, y),
      zoomOut: () => events.zoomOut?.(),
      chosen: () => [events.chosen?.() ?? NaN, NaN],
      steps: () => [this.columns - 1, 1],
    });
  }

  /**
   * Compute and show a raster; replaces whatever is under way.
   * `spec`: machine, row, which, span, columns, bins, low, high, coordinate, starts, transient, keep, seed, tolerance,
   * colour, labels; `values` instead of an even span; `quick` for the first picture.
   */
  show(spec) {
    this.spec = spec;
    const values = spec.values ?? linspace(...spec.span, spec.columns);
    this.values = values;
    this.columns = values.length;
    this.bins = spec.bins;
    this.counts = new Int32Array(this.columns * (this.bins + 3));
    this.totals = new Float64Array(this.columns);
    this.codes = new Uint8Array(this.columns * this.bins);
    this.ambiguous = 0;
    this.ended = 0;
    this.stage = this.axes.canvas.dataset.stage = "computing";
    const batch = this.pool.batch(this.channel);
    const begun = performance.now();
    return this.#compute(batch, begun).catch((error) => {
      this.stage = this.axes.canvas.dataset.stage = "failed";
      this.events.problem?.(`The diagram could not be computed: ${error.message}.`);
    });
  }

  async #compute(batch, begun) {
    const { spec } = this;
    const quick = spec.quick;
    const firsts = Array.from({ length: Math.ceil(this.columns / quick.stride) }, (_, i) => i * quick.stride);
    const share = Math.ceil(firsts.length / this.pool.workers.length);
    const parts = [];
    for (let i = 0; i < firsts.length; i += share) parts.push(firsts.slice(i, i + share));
    await Promise.all(
      parts.map(async (some) => {
        const settings = { ...this.#job(some.map((i) => this.values[i])), ...quick };
        const found = await batch.run(spec.machine, "raster", settings);
        some.forEach((q, i) => {
          for (let k = q; k < Math.min(q + quick.stride, this.columns); k++) this.#put(k, found.counts, i, quick.starts * quick.keep);
        });
      }),
    );
    if (!batch.live()) return;
    this.milliseconds.coarse = performance.now() - begun;
    this.stage = "coarse";
    this.paint();
    this.milliseconds.coarsePainted = performance.now() - begun;
    const size = Math.max(1, Math.round(CHUNK_WORK / (spec.starts * (spec.transient + spec.keep) * spec.cost)));
    const chunks = [];
    for (let q = 0; q < this.columns; q += size) chunks.push(q);
    await Promise.all(
      chunks.map(async (from) => {
        const some = this.values.slice(from, from + size);
        const found = await batch.run(spec.machine, "raster", this.#job(some));
        for (let i = 0; i < some.length; i++) {
          this.#put(from + i, found.counts, i, spec.starts * spec.keep);
          this.ambiguous += found.ambiguous[i];
          this.ended += found.ended[i];
        }
        this.#soon();
      }),
    );
    if (!batch.live()) return;
    this.milliseconds.full = performance.now() - begun;
    this.stage = "full";
    if (spec.colour) {
      const few = Math.max(1, Math.round(CHUNK_WORK / (8 * (spec.transient + 64) * spec.cost)));
      const later = [];
      for (let q = 0; q < this.columns; q += few) later.push(q);
      await Promise.all(
        later.map(async (from) => {
          const settings = { ...this.#job(this.values.slice(from, from + few)), starts: Math.min(8, spec.starts), keep: 64, tolerance: spec.tolerance };
          const found = await batch.run(spec.machine, "periods", settings);
          this.codes.set(found.codes, from * this.bins);
          this.#soon();
        }),
      );
      if (!batch.live()) return;
    }
    this.stage = "done";
    this.paint();
    this.events.done?.();
  }

  #job(values) {
    const { row, which, low, high, bins, coordinate, starts, transient, keep, seed } = this.spec;
    return { row, which, values: Float64Array.from(values), low, high, bins, coordinate, starts, transient, keep, seed };
  }

  #put(column, counts, i, total) {
    const width = this.bins + 3;
    this.counts.set(counts.subarray(i * width, (i + 1) * width), column * width);
    this.totals[column] = total;
  }

  #soon() {
    if (this.asked) return;
    this.asked = requestAnimationFrame(() => {
      this.asked = 0;
      this.paint();
    });
  }

  /** Draw what is known now: the strongest tone of all parts of the raster that share a pixel, so that no line is lost. */
  paint() {
    if (!this.spec) return;
    if (!this.image.getContext("2d")) return this.draw();
    const { columns, bins, counts, codes, axes } = this;
    axes.begin();
    const ratio = window.devicePixelRatio || 1;
    const W = Math.max(1, Math.round(axes.box.w * ratio)), H = Math.max(1, Math.round(axes.box.h * ratio));
    if (!this.pixels || this.pixels.width !== W || this.pixels.height !== H) {
      this.image.width = W;
      this.image.height = H;
      this.pixels = this.image.getContext("2d").createImageData(W, H);
    }
    const { ink } = theme();
    const plain = rgb(ink), shades = Array.from({ length: 256 }, (_, N) => rgb(periodColour(N || 1)));
    const colouring = this.spec.colour && this.stage !== "coarse" && this.stage !== "computing";
    const data = this.pixels.data;
    data.fill(0); // transparent: the paper, and what lies under the raster, shows
    const width = bins + 3, thick = Math.max(1, Math.round(ratio));
    for (let q = 0; q < columns; q++) {
      const strength = bins / 12 / (this.totals[q] || 1);
      const left = Math.floor((q * W) / columns), right = Math.max(left + 1, Math.floor(((q + 1) * W) / columns));
      for (let b = 0; b < bins; b++) {
        const count = counts[q * width + b + 1];
        if (count === 0) continue;
        let code = 0;
        if (colouring) {
          const place = q * bins + b;
          code = codes[place] || (b > 0 && codes[place - 1]) || (b + 1 < bins && codes[place + 1]) || 0;
        }
        const shade = code ? shades[code] : plain;
        const tone = code ? 255 : 40 + 215 * Math.sqrt(Math.min(1, count * strength));
        const high = H - 1 - Math.floor((b * H) / bins);
        const low = Math.min(high, H - Math.floor(((b + 1) * H) / bins), high - (code ? thick : thick - 1));
        for (let y = Math.max(low, 0); y <= high; y++) {
          for (let x = left; x < right; x++) {
            const at = (y * W + x) * 4;
            if (data[at + 3] >= tone) continue;
            data[at] = shade[0];
            data[at + 1] = shade[1];
            data[at + 2] = shade[2];
            data[at + 3] = tone;
          }
        }
      }
    }
    this.image.getContext("2d").putImageData(this.pixels, 0, 0);
    this.draw();
  }

  /** Draw the picture with its axes again, without painting the raster. */
  draw() {
    if (!this.spec) return;
    const { axes, spec } = this;
    const c = axes.begin();
    axes.span(this.spec.span[0], this.spec.span[1], spec.low, spec.high);
    this.events.under?.(axes, c);
    axes.inside(() => c.drawImage(this.image, axes.box.x, axes.box.y, axes.box.w, axes.box.h));
    this.events.overlay?.(axes, c);
    axes.frame(spec.labels[0], spec.labels[1]);
    this.gestures.draw(c);
    this.axes.canvas.dataset.stage = this.stage;
  }
}
