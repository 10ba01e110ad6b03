// @ts-check
/** The windows of the maximal orbits against the gap l, Figures 3.4 and 3.6: period doubling, border collision, and where windows appear and meet. */
import { periodColour, theme } from "./colours.js";
import { Gestures } from "./gestures.js";
import { DRAWN, found, linspace } from "./jobs.js";
import { words } from "./orbits.js";
import { Axes, FONT } from "./plot.js";
import { numeral, tidy, told } from "./state.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./machine.js").Machine} Machine */
/** @typedef {{N: number, doubling: Float64Array, collision: Float64Array}} Edge both edges of a window at each gap */
/** @typedef {{periods: number[], l: number, mu: number}} Mark where a window appears, or two meet */

const SAMPLES = 401;
/** Periods of which the words tell. */
const SAID = 6;

/** K_N = 1 + lam + ... + lam^(N-1). @param {number} N @param {number} lam */
function sum(N, lam) {
  let total = 0;
  for (let n = 0; n < N; n++) total = total * lam + 1;
  return total;
}

/** Gap from which period N has a window. @param {number} N @param {number} lam */
export const appears = (N, lam) => (N === 1 ? -Infinity : lam ** (N - 1) * ((sum(N, lam) - 3) / 4));

/** Gap from which the windows of N and N + 1 overlap. @param {number} N @param {number} lam */
export const meets = (N, lam) => lam ** (N - 1) * 0.1875 * (3 * sum(N, lam) - 4);

export class EdgesView {
  /** @type {string | undefined} what is computed, undefined for nothing */ key = undefined;

  /** @param {Machine} machine @param {{tolerance: number}} described @param {Pick<import("./state.js").Events, "change">} events */
  constructor(machine, described, { change }) {
    this.machine = machine;
    this.tolerance = described.tolerance;
    this.axes = new Axes(document.getElementById("edges"), { right: 72 });
    this.gestures = new Gestures(this.axes, {
      ready: () => Boolean(this.state),
      redraw: () => this.paint(),
      pick: (l, mu) => change({ l: tidy(l, this.axes.x1 - this.axes.x0), mu: tidy(mu, this.axes.y1 - this.axes.y0) }),
      zoom: ([low, high], span) => change({ gaps: [Math.max(low, 0), high], span }),
      zoomOut: () => change({ gaps: null, span: null }),
      chosen: () => [this.state?.l ?? NaN, this.state?.mu ?? NaN],
    });
  }

  get canvas() {
    return this.axes.canvas;
  }

  /** @returns {import("./svg.js").Panel[]} */
  panels() {
    return [{ sheet: this.axes, draw: () => this.paint() }];
  }

  /** @param {State} state */
  show(state) {
    const { lam, gaps, periods } = state;
    if (!(lam > 0 && lam < 1)) throw new Error(`λ = ${lam}; the windows of theory are known for 0 < λ < 1`);
    if (gaps[0] < 0) throw new Error(`l begins at ${gaps[0]}; the windows of theory are known for l ≥ 0`);
    this.state = state;
    const key = JSON.stringify([lam, gaps, periods]);
    if (key !== this.key) {
      this.key = key;
      this.#compute(lam, gaps, periods);
    }
    const row = Float64Array.of(lam, state.mu, state.l);
    this.classes = found(this.machine, { row, which: 1, value: state.mu, starts: DRAWN, transient: Math.max(2000, state.transient), seed: state.seed, tolerance: this.tolerance });
    this.paint();
  }

  /** @param {number} lam @param {import("./state.js").Pair} gaps @param {import("./state.js").Pair} periods */
  #compute(lam, gaps, [first, last]) {
    const table = (/** @type {number} */ l) => this.machine.call("edges", { periods: last + 1, lam, l }, ["table"]).table;
    const named = Array.from({ length: last - first + 1 }, (_, i) => first + i);
    this.l = linspace(...gaps, SAMPLES);
    /** @type {Edge[]} */
    this.edges = named.map((N) => ({ N, doubling: new Float64Array(SAMPLES), collision: new Float64Array(SAMPLES) }));
    this.l.forEach((l, i) => {
      const row = table(l);
      for (const { N, doubling, collision } of /** @type {Edge[]} */ (this.edges)) [doubling[i], collision[i]] = [row[3 * N - 2], row[3 * N - 1]];
    });
    const mark = (/** @type {number[]} */ some, /** @type {number} */ l) => ({ periods: some, l, mu: l >= 0 ? table(l)[3 * some[0] - 2] : NaN });
    /** @type {Mark[]} */
    this.marks = [...named.map((N) => mark([N], appears(N, lam))), ...named.slice(0, -1).map((N) => mark([N, N + 1], meets(N, lam)))];
  }

  repaint() {
    if (this.state) this.paint();
  }

  paint() {
    const { axes } = this, state = /** @type {State} */ (this.state);
    const l = /** @type {Float64Array} */ (this.l), edges = /** @type {Edge[]} */ (this.edges);
    axes.span(...state.gaps, ...state.span);
    const c = axes.begin(), { box } = axes, shown = theme();
    const top = state.span[1] + (state.span[1] - state.span[0]); // beyond the frame; period 1 has no upper end
    const trace = (/** @type {Float64Array} */ values, /** @type {number[]} */ order) => order.forEach((i, n) => {
      const [x, y] = [axes.x(l[i]), axes.y(Math.min(values[i], top))];
      if (n) c.lineTo(x, y);
      else c.moveTo(x, y);
    });
    const along = Array.from(l, (_, i) => i);
    axes.inside(() => {
      for (const { N, doubling, collision } of edges) {
        const open = along.filter((i) => doubling[i] < collision[i]);
        c.fillStyle = periodColour(N) + "2e";
        c.beginPath();
        trace(doubling, open);
        [...open].reverse().forEach((i) => c.lineTo(axes.x(l[i]), axes.y(Math.min(collision[i], top))));
        if (open.length) c.fill();
      }
      for (const { N, doubling, collision } of edges) {
        c.strokeStyle = periodColour(N);
        c.lineWidth = 1.8;
        for (const [values, dash] of /** @type {[Float64Array, number[]][]} */ ([[doubling, [6, 4]], [collision, []]])) {
          c.setLineDash(dash);
          c.beginPath();
          trace(values, along);
          c.stroke();
        }
        c.setLineDash([]);
      }
    });
    this.#drawMarks(c);
    axes.inside(() => {
      for (const [colour, width] of /** @type {[string, number][]} */ ([[shown.paper, 4], [shown.ink, 1.6]])) {
        c.strokeStyle = colour;
        c.lineWidth = width;
        c.beginPath();
        c.arc(axes.x(state.l), axes.y(state.mu), 7, 0, 2 * Math.PI);
        c.stroke();
      }
    });
    this.#name(c, edges);
    axes.frame("l", "μ");
    this.gestures.draw(c);
    this.canvas.dataset.stage = "done";
  }

  /** Thresholds: a dotted line, a point, and the number. @param {import("./svg.js").Pen} c */
  #drawMarks(c) {
    const { axes } = this, { box } = axes;
    const marks = (this.marks ?? []).filter(({ l }) => l > 0 && l >= axes.x0 && l <= axes.x1).sort((a, b) => a.l - b.l);
    const colourOf = (/** @type {number[]} */ periods) => (periods.length > 1 ? theme().ink : periodColour(periods[0]));
    for (const { periods, l } of marks) axes.vertical(l, colourOf(periods), [2, 3], 1);
    marks.forEach(({ periods, l, mu }, k) => {
      const colour = colourOf(periods);
      c.fillStyle = periods.length > 1 ? theme().paper : colour;
      c.strokeStyle = colour;
      c.lineWidth = 1.4;
      if (mu >= axes.y0 && mu <= axes.y1) {
        c.beginPath();
        c.arc(axes.x(l), axes.y(mu), 4, 0, 2 * Math.PI);
        c.fill();
        c.stroke();
      }
      const text = `${periods.length > 1 ? `${periods.join(" and ")} meet` : `${periods[0]} appears`}, l = ${numeral(l, 4)}`;
      const wide = c.measureText(text).width, left = axes.x(l) + 6 + wide > box.x + box.w;
      const x = left ? Math.max(axes.x(l) - 6 - wide, box.x + 3) : axes.x(l) + 6, y = box.y + 12 + 25 * k;
      c.fillStyle = theme().paper + "d0";
      c.fillRect(x - 2, y - 10, wide + 4, 20);
      c.fillStyle = theme().ink;
      c.textAlign = "left";
      c.textBaseline = "middle";
      c.fillText(text, x, y);
    });
  }

  /** The names of the curves at their right ends, kept apart. @param {import("./svg.js").Pen} c @param {Edge[]} edges */
  #name(c, edges) {
    const { axes } = this, { box } = axes, last = SAMPLES - 1;
    const ends = edges.flatMap(({ N, doubling, collision }) => [{ N, kind: "PD", at: doubling[last] }, { N, kind: "BC", at: collision[last] }])
      .filter(({ at }) => at >= axes.y0 && at <= axes.y1).sort((a, b) => a.at - b.at);
    let below = Infinity;
    for (const { N, kind, at } of ends) {
      const y = Math.min(axes.y(at), below - 22), x = box.x + box.w + 5;
      below = y;
      if (y < box.y) break; // no room for more
      c.fillStyle = periodColour(N);
      c.textAlign = "left";
      c.textBaseline = "middle";
      c.font = "italic 17px Georgia, 'Times New Roman', serif";
      c.fillText("μ", x, y);
      c.font = FONT;
      c.fillText(`${kind},${N}`, x + 11, y + 5);
    }
  }

  raster() {
    return { samples: SAMPLES };
  }

  /** What is shown, in words. @returns {{colour?: string, text: string}[]} */
  summary() {
    const { lam, l, mu, periods, span, gaps } = /** @type {State} */ (this.state);
    const said = /** @type {{colour?: string, text: string}[]} */ ([{ text: `At l = ${told(l, gaps)}, μ = ${told(mu, span)}, λ = ${numeral(lam)}:` }]);
    said.push(...words(this.classes ?? []));
    if (l < 0) return [...said, { text: "The windows of theory are known for l ≥ 0." }];
    const { table } = this.machine.call("edges", { periods: periods[1], lam, l }, ["table"]);
    const last = Math.min(periods[1], periods[0] + SAID - 1);
    for (let N = periods[0]; N <= last; N++) {
      const [doubling, collision] = [table[3 * N - 2], table[3 * N - 1]];
      const from = appears(N, lam);
      const window = doubling < collision ? `stable for ${told(doubling, span)} < μ${Number.isFinite(collision) ? ` < ${told(collision, span)}` : ""}` : "no window at this gap";
      said.push({ colour: periodColour(N), text: `Period ${N}: ${window}${from > 0 ? `; it has one from l = ${told(from, gaps)} on` : ""}.` });
    }
    for (const { periods: both, l: from } of this.marks ?? []) {
      if (both.length > 1 && both[1] <= last) said.push({ text: `Windows ${both.join(" and ")} ${from > 0 ? `overlap from l = ${told(from, gaps)} on` : "overlap at every gap"}.` });
    }
    if (last < periods[1]) said.push({ text: `${periods[1] - last} further periods are drawn and not listed.` });
    return said;
  }
}
