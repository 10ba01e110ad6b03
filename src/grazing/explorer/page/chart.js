// @ts-check
/** A chart of two parameters by the period that most starts settle on, for either map; coarse at once, then refined. */
import { periodColour, rgb, theme } from "./colours.js";
import { plainSymbol } from "./controls.js";
import { rowOf } from "./flow.js";
import { linspace } from "./jobs.js";
import { found, words } from "./orbits.js";
import { Axes } from "./plot.js";

const NONE = 255; // no cell yet

export class ChartView {
  constructor(machines, pool, described, { change, problem, done }) {
    this.machines = machines;
    this.pool = pool;
    this.problem = problem;
    this.done = done;
    this.tolerance = described.tolerance;
    this.axes = new Axes(document.getElementById("chart"));
    this.image = document.createElement("canvas");
    this.canvas.addEventListener("click", (event) => {
      const { left, top } = this.canvas.getBoundingClientRect();
      const x = this.axes.atX(event.clientX - left), y = this.axes.atY(event.clientY - top);
      const { x0, x1, y0, y1 } = this.axes;
      if (this.plan && !this.plan.basins && x >= x0 && x <= x1 && y >= y0 && y <= y1) change({ [this.plan.names[0]]: Number(x.toPrecision(5)), [this.plan.names[1]]: Number(y.toPrecision(5)) });
    });
    this.canvas.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowDown: [1, -1], ArrowUp: [1, 1] }[event.key];
      if (!way || !this.plan || this.plan.basins) return;
      event.preventDefault();
      const [i, sign] = way, [low, high] = this.plan.ends[i], name = this.plan.names[i];
      const value = this.state[name] + (sign * (high - low)) / (this.plan.sizes[i] - 1);
      change({ [name]: Number(Math.min(Math.max(value, low), high).toPrecision(6)) });
    });
  }

  get canvas() {
    return /** @type {HTMLCanvasElement} */ (this.axes.canvas);
  }

  /** What is computed: machine, row, names and ends of both parameters, starts, steps. */
  #planOf(state) {
    const gap = state.chart === "gap";
    const machine = this.machines[gap ? "gap" : "oscillator"];
    if (!machine) throw new Error(`the module ${gap ? "gap" : "oscillator"}.wasm is not loaded`);
    if (state.chart === "basins") {
      if (state.positions[0] < state.sigma) throw new Error(`positions begin at ${state.positions[0]}, behind the wall at ${state.sigma}; begin at the wall or above`);
      return {
        machine, name: "oscillator", basins: true, names: ["u", "v"], which: [], row: rowOf(machine, state), ends: [state.positions, state.velocities],
        sizes: [state.chart_columns, state.chart_rows], settings: { starts: 1, transient: 300, keep: 64 }, cost: 40,
      };
    }
    const names = gap ? ["mu", "l"] : [state.vary, state.second];
    if (names[0] === names[1]) throw new Error("both axes show the same parameter; choose another one for the second axis");
    const which = names.map((name) => machine.fields.indexOf(name));
    return {
      machine, name: gap ? "gap" : "oscillator", names, which,
      row: gap ? Float64Array.of(state.lam, state.mu, state.l) : rowOf(machine, state),
      ends: [gap ? state.span : state.reach, gap ? state.gaps : state.heights],
      sizes: [state.chart_columns, state.chart_rows],
      settings: gap ? { starts: 8, transient: 500, keep: 64 } : { starts: 4, transient: 100, keep: 64 },
      cost: gap ? 1 : 40,
    };
  }

  show(state) {
    this.state = state;
    const plan = this.#planOf(state);
    const fixed = Array.from(plan.row);
    plan.which.forEach((i) => (fixed[i] = 0));
    const key = JSON.stringify([fixed, plan.names, plan.ends, plan.sizes, plan.settings, state.seed]);
    this.plan = plan;
    if (key !== this.key) {
      this.key = key;
      this.codes = new Uint8Array(plan.sizes[0] * plan.sizes[1]).fill(NONE);
      this.canvas.dataset.stage = "computing";
      this.#compute().catch((error) => {
        this.canvas.dataset.stage = "failed";
        this.problem(`The chart could not be computed: ${error.message}.`);
      });
    }
    this.classes = found(plan.machine, { row: plan.row, which: plan.which[0] ?? 0, value: plan.row[plan.which[0] ?? 0], transient: plan.name === "gap" ? 2000 : 300, keep: plan.name === "gap" ? 128 : 64, seed: state.seed, tolerance: this.tolerance });
    this.paint();
  }

  async #compute() {
    const { plan, codes } = this;
    const batch = this.pool.batch("chart");
    const [xs, ys] = plan.sizes.map((size, i) => linspace(...plan.ends[i], size));
    this.xs = xs;
    this.ys = ys;
    const cells = (columns, rows) => {
      const size = Math.max(1, Math.round(8e5 / (plan.settings.starts * (plan.settings.transient + 64) * plan.cost * columns.length)));
      const chunks = [];
      for (let i = 0; i < rows.length; i += size) chunks.push(rows.slice(i, i + size));
      return chunks.map(async (chunk) => {
        const pairs = chunk.flatMap((j) => columns.map((i) => [i, j]));
        const values = Float64Array.from(pairs.flatMap(([i, j]) => [xs[i], ys[j]]));
        const made = await batch.run(plan.name, plan.basins ? "basins" : "chart", { row: plan.row, which: plan.which, values, ...plan.settings, seed: this.state.seed, tolerance: this.tolerance });
        pairs.forEach(([i, j], k) => (codes[j * xs.length + i] = made.codes[k]));
        this.#soon();
      });
    };
    const every = (size, step) => Array.from({ length: Math.ceil(size / step) }, (_, i) => i * step);
    for (const step of [8, 2, 1]) {
      this.step = step;
      await Promise.all(cells(every(xs.length, step), every(ys.length, step)));
      if (!batch.live()) return;
    }
    this.canvas.dataset.stage = "done";
    this.paint();
    this.done();
  }

  #soon() {
    this.asked ||= requestAnimationFrame(() => {
      this.asked = 0;
      this.paint();
    });
  }

  repaint() {
    if (this.plan) this.paint();
  }

  paint() {
    const [W, H] = this.plan.sizes;
    this.image.width = W;
    this.image.height = H;
    const pixels = this.image.getContext("2d").createImageData(W, H);
    const shades = Array.from({ length: 256 }, (_, code) => (code === NONE ? null : rgb(code ? periodColour(code) : theme().chaos)));
    for (let j = 0; j < H; j++) {
      for (let i = 0; i < W; i++) {
        let code = this.codes[j * W + i];
        for (const step of [2, 8]) if (code === NONE) code = this.codes[(j - (j % step)) * W + i - (i % step)];
        const shade = shades[code];
        if (!shade) continue;
        pixels.data.set([...shade, 255], ((H - 1 - j) * W + i) * 4);
      }
    }
    this.image.getContext("2d").putImageData(pixels, 0, 0);
    const { axes, plan, state } = this;
    const c = axes.begin();
    axes.span(...plan.ends[0], ...plan.ends[1]);
    axes.inside(() => {
      c.imageSmoothingEnabled = false;
      c.drawImage(this.image, axes.box.x, axes.box.y, axes.box.w, axes.box.h);
      if (plan.basins) return;
      const [x, y] = [axes.x(state[plan.names[0]]), axes.y(state[plan.names[1]])];
      for (const [colour, width] of /** @type {[string, number][]} */ ([["#ffffff", 4], ["#000000", 1.6]])) {
        c.strokeStyle = colour;
        c.lineWidth = width;
        c.beginPath();
        c.arc(x, y, 7, 0, 7);
        c.stroke();
      }
    });
    const symbols = this.#symbols();
    axes.frame(symbols[0], symbols[1]);
    // the colours that occur
    const seen = [...new Set(this.codes)].filter((code) => code !== NONE).sort((a, b) => a - b).slice(0, Math.floor(axes.box.w / 44));
    c.textAlign = "left";
    c.textBaseline = "middle";
    seen.forEach((code, k) => {
      c.fillStyle = code ? periodColour(code) : theme().chaos;
      c.fillRect(axes.box.x + 44 * k, 5, 11, 11);
      c.fillStyle = theme().faint;
      c.fillText(code ? String(code) : "no", axes.box.x + 44 * k + 15, 11);
    });
  }

  #symbols() {
    const { names, machine, basins } = this.plan;
    return basins ? names : names.map((name) => plainSymbol(machine.described.fields[machine.fields.indexOf(name)]));
  }

  raster() {
    const { settings, ends, sizes, names, name } = this.plan;
    return { ...settings, ends, sizes, names, name };
  }

  summary() {
    const { plan, state } = this;
    const symbols = this.#symbols();
    if (plan.basins) return [{ text: "Initial states (u, v), coloured by the period that they reach:" }, ...this.classes.map((each) => ({ colour: periodColour(each.period), text: words(each) }))];
    return [{ text: `At ${symbols.map((symbol, i) => `${symbol} = ${state[plan.names[i]]}`).join(", ")}:` }, ...this.classes.map((each) => ({ colour: periodColour(each.period), text: words(each) }))];
  }
}
