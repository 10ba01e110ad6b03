// @ts-check
/** The stroboscopic map against the discontinuity map, along a line of starts: Figure 2.2. */
import { periodColour, theme } from "./colours.js";
import { rowOf } from "./flow.js";
import { linspace } from "./jobs.js";
import { Axes } from "./plot.js";

const SAMPLES = 600;

export class StrobeView {
  constructor(machine) {
    this.machine = machine;
    this.axes = new Axes(document.getElementById("strobe"));
  }

  get canvas() {
    return /** @type {HTMLCanvasElement} */ (this.axes.canvas);
  }

  show(state) {
    this.state = state;
    const { machine } = this;
    const rows = rowOf(machine, state);
    rows[machine.fields.indexOf("order")] = machine.described.fields.find(({ name }) => name === "order").choices.indexOf(state.order);
    this.u = linspace(...state.line, SAMPLES);
    const lanes = new Float64Array(2 * SAMPLES).fill(state.v0);
    lanes.set(this.u);
    const once = (name) => machine.call(name, { columns: 1, starts: SAMPLES, keep: 1, rows, lanes, transient: 0 }, ["points", "letters"]);
    const full = once("orbits"), local = once("orbits_local");
    this.full = full.points.subarray(0, SAMPLES);
    this.local = local.points.subarray(0, SAMPLES);
    this.letters = full.letters;
    this.paint();
  }

  repaint() {
    if (this.state) this.paint();
  }

  paint() {
    const { axes, state } = this;
    const seen = [...this.full, ...this.local].filter(Number.isFinite);
    const low = Math.min(...seen), high = Math.max(...seen), room = 0.06 * (high - low) || 0.01;
    const c = axes.begin();
    axes.span(...state.line, low - room, high + room);
    const curves = /** @type {[Float64Array, string, number, string][]} */ ([
      [this.full, theme().ink, 3.4, "stroboscopic map"],
      [this.local, periodColour(2), 1.8, `discontinuity map, ${state.order}`],
    ]);
    axes.inside(() => {
      for (const [values, colour, size] of curves) {
        c.fillStyle = colour;
        values.forEach((value, i) => Number.isFinite(value) && c.fillRect(axes.x(this.u[i]) - size / 2, axes.y(value) - size / 2, size, size));
      }
    });
    axes.frame("u(0)", "u(T)");
    c.textAlign = "left";
    c.textBaseline = "middle";
    curves.forEach(([, colour, , text], k) => {
      c.fillStyle = colour;
      c.fillRect(axes.box.x + 14, axes.box.y + axes.box.h - 34 + 18 * k, 11, 5);
      c.fillStyle = theme().faint;
      c.fillText(text, axes.box.x + 31, axes.box.y + axes.box.h - 31 + 18 * k);
    });
    this.canvas.dataset.stage = "done";
  }

  raster() {
    return { samples: SAMPLES };
  }

  summary() {
    const { state, u, full, local, letters } = this;
    const number = (value) => Number(value.toPrecision(6)).toString().replace("-", "−");
    const differ = Array.from(full, (value, i) => Math.abs(value - local[i]));
    const most = differ.reduce((best, value, i) => (value > differ[best] ? i : best), 0);
    const said = [{ text: `One period of the forcing from u(0) between ${number(state.line[0])} and ${number(state.line[1])}, v(0) = ${number(state.v0)}.` }];
    const change = letters.findIndex((letter, i) => i > 0 && letter !== letters[i - 1]);
    if (change > 0) said.push({ text: `The oscillator has ${letters[change - 1]} impact${letters[change - 1] === 1 ? "" : "s"} below u(0) ≈ ${number((u[change - 1] + u[change]) / 2)}, and ${letters[change]} above: between them one is gained or lost, at a graze or across the strobe.` });
    else said.push({ text: `No graze on this line: ${letters[0]} impact${letters[0] === 1 ? "" : "s"} everywhere.` });
    said.push({ text: `The maps differ most at u(0) = ${number(u[most])}, by ${number(differ[most])}.` });
    return said;
  }
}
