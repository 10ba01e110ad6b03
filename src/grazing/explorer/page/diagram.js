// @ts-check
/** A diagram as density: computed by the pool, coarse at once, then refined; painted column by column. */
import { faded, periodColour, rgb, theme } from "./colours.js";
import { Gestures } from "./gestures.js";
import { counted, extent, linspace } from "./jobs.js";
import { Axes } from "./plot.js";

/** @typedef {import("./machine.js").Floats} Floats */
/** @typedef {import("./jobs.js").Steps} Steps */
/** @typedef {[number, number]} Pair */
/**
 * What a diagram shows. `values` stands instead of an even `span`; `quick` is for the first picture, which has a
 * column for every `stride` of them; `cost` is the time of a step beside that of the gap map. A range that is NaN
 * is put where the orbits of the first picture are.
 * @typedef {{
 *   machine: string, row: Floats, which: number, span: Pair, columns: number, values?: Floats, coordinate: number,
 *   low: number, high: number, bins: number, seed: number, tolerance: number, cost: number, colour: boolean,
 *   labels: [string, string], quick: Steps & {stride: number},
 * } & Steps} Spec
 */

/** Steps of the gap map in one job: so short that a new picture need not wait for one that is under way. */
const CHUNK_WORK = 4e5;
/** A first picture of so few steps is computed in the page, if that takes so few milliseconds. */
const AT_ONCE = 1.1e6, SOON = 12;
/** Milliseconds between pictures: each takes the processors from what it shows. */
const PAUSE = 200;
/** Rows of a picture that one pixel shows at most. */
const MOST = 64;

/** What is known of a diagram. Takes the arrays of one that nobody needs, if they fit. */
class Raster {
  /** @param {Spec} spec @param {Raster | null} old */
  constructor(spec, old) {
    this.spec = spec;
    this.values = spec.values ?? linspace(...spec.span, spec.columns);
    this.columns = this.values.length;
    this.bins = spec.bins;
    const fitting = old && old.columns === this.columns && old.bins === this.bins ? old : null;
    /** @type {Int32Array<ArrayBuffer>} */
    this.counts = fitting?.counts ?? new Int32Array(this.columns * (this.bins + 3));
    /** @type {Float64Array} points that were counted in each column */
    this.totals = fitting?.totals ?? new Float64Array(this.columns);
    /** @type {Uint8Array} periods, 0 where none is known */
    this.codes = fitting?.codes.fill(0) ?? new Uint8Array(this.columns * this.bins);
    this.ambiguous = this.ended = 0;
  }

  /** Put columns that were counted into their places, each `stride` times. @param {number} from @param {Int32Array} counts @param {number} total @param {number} stride */
  put(from, counts, total, stride = 1) {
    const width = this.bins + 3, all = this.counts;
    if (stride === 1 && counts !== all) all.set(counts, from * width);
    const end = Math.min(from + (counts.length / width) * stride, this.columns);
    for (let q = from; stride > 1 && q < end; q++) {
      const i = Math.floor((q - from) / stride) * width;
      all.set(counts.subarray(i, i + width), q * width);
    }
    this.totals.fill(total, from, end);
  }
}

/** The colours of periods, and of what has none or is not known yet, as numbers of a pixel without its opacity: ABGR, as bytes lie in memory. */
const shades = { ink: "", plain: 0, chaos: 0, unknown: 0, words: new Uint32Array(256) };
function mixed() {
  const { ink, chaos } = theme();
  if (shades.ink !== ink) {
    const word = (/** @type {string} */ colour) => rgb(colour).reduce((all, part, i) => all | (part << (8 * i)), 0);
    Object.assign(shades, { ink, plain: word(ink), chaos: word(chaos), unknown: word(faded(ink, 0.4)), words: Uint32Array.from({ length: 256 }, (_, N) => word(periodColour(N || 1))) });
  }
  return shades;
}

/** Opacities of so many shares of the strongest count; where there are no more counts than that, each has its own. */
const TONES = 4096;

/** The opacities of counts times `scale`, rounded down, of which the last stands for all above it. @param {number} bins @param {number} total of a column */
export function tonesOf(bins, total) {
  const strength = bins / 12 / (total || 1), scale = Math.min(1, TONES * strength);
  const size = Math.ceil(scale / strength) + 1;
  return { scale, tones: Uint8Array.from({ length: size }, (_, count) => Math.round(40 + 215 * Math.sqrt(Math.min(1, (count / scale) * strength)))) };
}

/** Milliseconds without a new picture after which a hand may be thought to rest. */
const RESTS = 40;
/** Wait until a frame has been made and the hand rests; of a page that nobody sees none is made. */
const atRest = () => new Promise((done) => {
  requestAnimationFrame(() => setTimeout(done, RESTS));
  setTimeout(done, 100);
});

export class Diagram {
  /** @type {Raster | null} what is on screen */ #shown = null;
  /** @type {Raster | null} one that is no more on screen */ #spare = null;
  /** @type {Spec | null} what was asked for while a first picture was under way */ #wanted = null;
  /** @type {ImageData | null} */ #pixels = null;
  #asked = 0;
  /** When the picture was begun, and which share of its columns is known. */
  #begun = 0;
  #share = 1;
  /** @type {(() => void) | undefined} told when the picture has been drawn */ drew = undefined;
  /** Milliseconds that pictures computed in the page have taken lately; less while none is, so that it is tried again. */
  #took = 0;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {import("./pool.js").Pool} pool
   * @param {string} channel
   * @param {{pick?: (x: number, y: number) => import("./gestures.js").Undo, zoom?: (x: number[], y: number[] | null) => void, follows?: () => boolean, under?: (axes: Axes, c: import("./svg.js").Pen) => void, overlay?: (axes: Axes, c: import("./svg.js").Pen) => void, on?: () => Axes | undefined, problem?: (text: string) => void, done?: () => void, ranged?: () => void, zoomOut?: () => void, chosen?: () => number}} events `on` gives the picture on whose scale this one is drawn
   */
  constructor(canvas, pool, channel, events) {
    this.axes = new Axes(canvas);
    this.pool = pool;
    this.channel = channel;
    this.events = events;
    this.image = document.createElement("canvas");
    this.stage = "empty";
    /** What was asked for last. */
    this.spec = /** @type {Spec} */ (/** @type {unknown} */ (null));
    /** Pictures that were never begun because another one was asked for. */
    this.skipped = 0;
    this.gestures = new Gestures(this.axes, {
      ready: () => this.#shown !== null,
      redraw: () => this.draw(),
      pick: events.pick,
      zoom: events.zoom,
      follows: events.follows,
      zoomOut: () => events.zoomOut?.(),
      chosen: () => [events.chosen?.() ?? NaN, NaN],
      steps: () => [this.columns - 1, 1],
    });
  }

  /** What is on screen; while a picture is being computed, that is not `spec`. */
  get drawn() {
    return this.#shown?.spec ?? null;
  }

  get columns() {
    return this.#shown?.columns ?? 0;
  }

  get bins() {
    return this.#shown?.bins ?? 0;
  }

  get counts() {
    return this.#shown?.counts ?? new Int32Array(0);
  }

  get codes() {
    return this.#shown?.codes ?? new Uint8Array(0);
  }

  get ambiguous() {
    return this.#shown?.ambiguous ?? 0;
  }

  get ended() {
    return this.#shown?.ended ?? 0;
  }

  /**
   * Compute and show a raster; refinement that is under way is dropped. A first picture that is under way is finished
   * and shown before, so that pictures follow a slider that is dragged faster than they come.
   * @param {Spec} spec
   */
  show(spec) {
    this.spec = spec;
    if (this.stage === "computing") {
      this.skipped += this.#wanted ? 1 : 0;
      this.#wanted = spec;
    } else this.#begin(spec);
  }

  /** @param {Spec} spec */
  #begin(spec) {
    this.#stage("computing");
    this.#compute(spec).catch((error) => {
      this.#stage("failed");
      this.events.problem?.(`The diagram could not be computed: ${error.message}.`);
      this.#next();
    });
  }

  /** Begin what was asked for meanwhile; whether there was anything. */
  #next() {
    const spec = this.#wanted;
    this.#wanted = null;
    if (spec) this.#begin(spec);
    return spec !== null;
  }

  /** @param {string} stage */
  #stage(stage) {
    this.stage = this.axes.canvas.dataset.stage = stage;
  }

  /** @param {Spec} spec */
  async #compute(spec) {
    const batch = this.pool.batch(this.channel), begun = (this.#begun = performance.now());
    this.#share = 0;
    const made = new Raster(spec, this.#spare);
    this.#spare = null;
    const { values, columns } = made, { quick } = spec;
    const firsts = values.filter((_, q) => q % quick.stride === 0);
    const put = (/** @type {number} */ from, /** @type {Int32Array} */ counts) => made.put(from * quick.stride, counts, quick.starts * quick.keep, quick.stride);
    const asks = Number.isNaN(spec.low), name = asks ? "points" : "raster", job = (/** @type {Floats} */ some) => ({ ...this.#job(spec, some), ...quick });
    /** @type {({from: number} & ReturnType<typeof import("./jobs.js").points>)[]} */
    const found = [];
    const take = (/** @type {number} */ from, /** @type {any} */ got) => (asks ? found.push({ from, ...got }) : put(from, got.counts));
    const work = firsts.length * quick.starts * (quick.transient + quick.keep) * spec.cost;
    if (batch.now && work <= AT_ONCE && this.#took < SOON) {
      take(0, batch.now(spec.machine, name, { ...job(firsts), into: quick.stride === 1 ? { counts: made.counts } : undefined }));
      this.#took += (performance.now() - begun - this.#took) / 4;
    } else {
      this.#took *= 0.9;
      await this.#inParts(firsts, Math.ceil(firsts.length / this.pool.workers.length), async (some, from) => {
        take(from, await batch.run(spec.machine, name, job(some)));
      });
    }
    if (asks) [spec.low, spec.high] = extent(found);
    for (const { from, seen } of found) put(from, counted(seen, quick.starts * quick.keep, spec));
    [this.#shown, this.#spare] = [made, this.#shown];
    this.stage = "coarse";
    this.paint();
    if (this.#next()) return;
    if (asks) this.events.ranged?.();
    await atRest(); // refinement would take the processors from this picture's frame, and from the next one

    await this.#inParts(values, CHUNK_WORK / spec.cost / (spec.starts * (spec.transient + spec.keep)), async (some, from) => {
      const found = await batch.run(spec.machine, "raster", { ...this.#job(spec, some), colour: spec.colour });
      made.put(from, found.counts, spec.starts * spec.keep);
      if (found.codes) made.codes.set(found.codes, from * made.bins);
      for (let i = 0; i < some.length; i++) {
        made.ambiguous += found.ambiguous[i];
        made.ended += found.ended[i];
      }
      this.#share += some.length / columns;
      this.#soon();
    });
    this.stage = "done";
    this.paint();
    this.events.done?.();
  }

  /** Do a job for so many values at a time. @param {Floats} values @param {number} size @param {(some: Floats, from: number) => Promise<void>} job */
  #inParts(values, size, job) {
    const whole = Math.max(1, Math.round(size)), parts = [];
    for (let q = 0; q < values.length; q += whole) parts.push(job(values.slice(q, q + whole), q));
    return Promise.all(parts);
  }

  /** @param {Spec} spec @param {Floats} values */
  #job({ row, which, low, high, bins, coordinate, starts, transient, keep, seed, tolerance }, values) {
    return { row, which, values, low, high, bins, coordinate, starts, transient, keep, seed, tolerance };
  }

  #soon() {
    this.#asked ||= window.setTimeout(() => this.paint(), PAUSE);
  }

  /** Draw what is known now: the strongest tone of all parts of the raster that share a pixel, so that no line is lost. */
  paint() {
    clearTimeout(this.#asked);
    this.#asked = 0;
    if (!this.#shown) return;
    const image = this.image.getContext("2d");
    if (!image) return this.draw();
    const c = this.axes.begin();
    const { ratio } = this.axes;
    const W = Math.max(1, Math.round(this.axes.box.w * ratio)), H = Math.max(1, Math.round(this.axes.box.h * ratio));
    if (this.#pixels?.width !== W || this.#pixels.height !== H) {
      this.image.width = W;
      this.image.height = H;
      this.#pixels = image.createImageData(W, H);
    }
    this.#fill(this.#shown, new Uint32Array(this.#pixels.data.buffer), W, H, Math.max(1, Math.round(ratio)));
    image.putImageData(this.#pixels, 0, 0);
    this.#draw(c);
  }

  /** @param {Raster} raster @param {Uint32Array} pixels @param {number} W @param {number} H @param {number} thick lines of a period, in pixels */
  #fill({ spec, columns, bins, counts, codes, totals }, pixels, W, H, thick) {
    const { plain: ink, chaos, unknown, words } = mixed(), plain = !spec.colour ? ink : this.stage === "done" ? chaos : unknown;
    pixels.fill(0); // transparent: the paper, and what lies under the raster, shows
    const bottoms = Int32Array.from({ length: bins }, (_, b) => H - 1 - Math.floor((b * H) / bins));
    const tops = bottoms.map((bottom, b) => Math.min(bottom, H - Math.floor(((b + 1) * H) / bins)));
    let { tones, scale } = tonesOf(bins, 0), total = NaN;
    for (let q = 0; q < columns; q++) {
      if (totals[q] !== total) {
        total = totals[q];
        ({ tones, scale } = tonesOf(bins, total));
      }
      const strongest = tones.length - 1, first = q * (bins + 3) + 1, place = q * bins;
      const left = Math.floor((q * W) / columns), right = Math.max(left + 1, Math.floor(((q + 1) * W) / columns));
      for (let b = 0; b < bins; b++) {
        const count = counts[first + b];
        if (count === 0) continue;
        const code = spec.colour ? codes[place + b] || (b > 0 && codes[place + b - 1]) || (b + 1 < bins && codes[place + b + 1]) || 0 : 0;
        const tone = code ? 255 : tones[Math.min(Math.floor(count * scale), strongest)];
        const word = ((tone << 24) | (code ? words[code] : plain)) >>> 0;
        const bottom = bottoms[b];
        for (let y = Math.max(0, Math.min(tops[b], bottom - (code ? thick : thick - 1))); y <= bottom; y++) {
          for (let at = y * W + left; at < y * W + right; at++) if (pixels[at] >>> 24 < tone) pixels[at] = word;
        }
      }
    }
  }

  /** The periods over the parameter as a strip, of two rows where two orbits are found; empty until they are known. */
  band() {
    const raster = this.#shown, strip = document.createElement("canvas");
    const c = raster?.spec.colour && this.stage === "done" && !this.axes.canvas.hidden ? strip.getContext("2d") : null;
    if (!raster || !c) return "";
    const { columns, bins, codes } = raster;
    strip.width = columns;
    strip.height = 2;
    for (let q = 0; q < columns; q++) {
      let low = 256, next = 256; // the two least
      for (const N of codes.subarray(q * bins, (q + 1) * bins)) if (N > 0 && N < next && N !== low) [low, next] = N < low ? [N, low] : [low, N];
      [low, next < 256 ? next : low].forEach((N, i) => {
        c.fillStyle = periodColour(N % 256);
        c.fillRect(q, i, 1, 1);
      });
    }
    return strip.toDataURL();
  }

  /** Draw the picture with its axes again, without painting the raster. */
  draw() {
    if (this.#shown) this.#draw(this.axes.begin());
  }

  /** Whether what is on screen is the picture that was asked for in other axes: it moves with the hand until that comes. @param {Spec} shown */
  #follows(shown) {
    const { spec } = this, same = /** @type {const} */ (["machine", "which", "coordinate"]);
    return same.every((key) => shown[key] === spec[key]) && shown.row.every((value, i) => i === spec.which || value === spec.row[i]);
  }

  /** @param {import("./svg.js").Pen} c a canvas that is empty */
  #draw(c) {
    if (!this.#shown) return;
    const { axes } = this, { spec } = this.#shown, wanted = this.#follows(spec) ? this.spec : spec;
    const { low, high } = Number.isNaN(wanted.low) ? spec : wanted;
    const { x0, x1, y0, y1 } = this.events.on?.() ?? { x0: wanted.span[0], x1: wanted.span[1], y0: low, y1: high };
    axes.span(x0, x1, y0, y1);
    this.events.under?.(axes, c);
    const [left, top] = [axes.x(spec.span[0]), axes.y(spec.high)], [w, h] = [axes.x(spec.span[1]) - left, axes.y(spec.low) - top];
    const rows = Math.min(MOST, Math.max(1, Math.round(this.image.height / (h * axes.ratio)))); // of the picture in a pixel: each is drawn, so that no line is lost
    axes.inside(() => {
      c.imageSmoothingEnabled = rows === 1;
      for (let j = 0; j < rows; j++) c.drawImage(this.image, left, top - (j * h) / this.image.height, w, h);
    });
    this.events.overlay?.(axes, c);
    axes.frame(spec.labels[0], spec.labels[1]);
    if (this.stage !== "done") axes.progress(this.#share, this.#begun);
    this.gestures.draw(c);
    this.axes.canvas.dataset.stage = this.stage;
    this.drew?.();
  }
}
