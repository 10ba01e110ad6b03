// @ts-check
/** What keeps the ball company when it is asked for: the twin with the rate at which near balls part, and sweeps over the diagram. */
import { Flight } from "./flight.js";
import { numeral } from "./state.js";
import { Sweeps } from "./sweeps.js";
import { Rate, Twin } from "./twin.js";
import { inside } from "./walls.js";

/** Intervals that are named at most. */
const NAMED = 4;
/** Pushes to come over which the rate is measured, and milliseconds of a frame that this may take. */
const TURNS = 1000, BUDGET = 3;

export class Company {
  rate = new Rate();
  /** @type {Twin | null} */ twin = null;
  /** @type {[number, number] | null} where the ball will be at the section after the pushes that are measured */ #ahead = null;

  /** @param {import("./ball.js").BallView} view @param {import("./pool.js").Pool} pool */
  constructor(view, pool) {
    this.view = view;
    this.sweeps = new Sweeps(pool, () => {
      view.diagram.draw();
      view.told();
    });
    this.told = /** @type {HTMLElement} */ (document.getElementById("rate"));
  }

  /** Take what a state asks for. @param {import("./state.js").State} state */
  show({ twin, sweeps, vary, reach, seed }) {
    const { view } = this;
    if (twin !== Boolean(this.twin)) {
      this.twin = twin ? new Twin() : null;
      if (view.flight) this.begin();
    }
    if (sweeps && !view.diagram.axes.canvas.hidden) this.sweeps.show(view.model.row, view.machine.fields.indexOf(vary), reach, seed);
    this.#tell();
  }

  /** The ball flies on from elsewhere, or in another way than before: what was measured is over. */
  begin() {
    const { view: { machine, model, turn, section, begun, T, place, now } } = this, [u, v] = now ? place : begun;
    this.rate.forget();
    this.#ahead = null;
    if (this.twin) {
      this.#meet();
      const time = (Math.ceil(turn - section) + section - turn) * T, gone = new Flight(machine, model, [u, v, begun[2] + now]).advance(time, []);
      if (gone) this.#ahead = [gone.u[gone.u.length - 1], gone.v[gone.v.length - 1]];
      this.#measure();
    } else this.#tell();
  }

  /** The height of the picture. */
  get #size() {
    return this.view.axes.x1 - this.view.state.sigma;
  }

  #meet() {
    const { view } = this, [u, v] = view.place;
    this.twin?.begin(view.machine, view.model, [u, v, view.begun[2] + view.now], view.turn, this.#size);
  }

  /** The ball has moved on by a time. @param {number} time */
  moved(time) {
    const { view, twin } = this;
    if (!twin) return;
    if (!twin.flight || !twin.advance(time, view.T, view.section, view.place)) this.#meet();
    this.#measure();
  }

  /** Of a ball that stands, the frame that goes on measuring. */ #next = 0;

  /** Measure the rate along the pushes that are to come. */
  #measure() {
    const { machine, model, state } = this.view, ends = performance.now() + BUDGET;
    const turn = (/** @type {number} */ u, /** @type {number} */ v) => {
      const { points } = machine.call("orbits", { columns: 1, starts: 1, keep: 1, rows: model.row, lanes: Float64Array.of(u, v), transient: 0 }, ["points"]);
      return /** @type {[number, number]} */ ([points[0], points[1]]);
    };
    while (this.#ahead && this.rate.turns < TURNS && performance.now() < ends) {
      this.rate.pass(this.#ahead, turn, (u) => inside(model.walls, u, state.phase), this.#size);
      this.#ahead = turn(...this.#ahead);
      if (!this.#ahead.every(Number.isFinite)) this.#ahead = null;
    }
    if (this.#ahead && this.rate.turns < TURNS) this.#next ||= requestAnimationFrame(() => {
      this.#next = 0;
      if (this.twin && !this.view.playing) this.#measure();
    });
    this.#tell();
  }

  /** What sweeps show, in words. @param {string} name of the parameter @returns {import("./state.js").Line[]} */
  said(name) {
    const { sweeps } = this;
    if (!this.view.state.sweeps || !sweeps.found) return [];
    const apart = sweeps.differ().map((ends) => ends.map((end) => numeral(end, 4))).map(([from, to]) => (from === to ? `${name} ≈ ${from}` : `${from} ≤ ${name} ≤ ${to}`));
    if (!apart.length) return [{ text: "Carried up and down, a ball is on the same orbits both ways." }];
    const more = apart.splice(NAMED).length;
    return [{ text: `Carried up and down, a ball is on different orbits for ${apart.join(", ")}${more ? `, and in ${more} more places` : ""}: hysteresis.` }];
  }

  #tell() {
    const { twin, rate } = this, pushes = (/** @type {number} */ n) => (n > 1 ? `${Math.ceil(n)} pushes` : "a push");
    if (!twin) return void (this.told.textContent = "");
    const together = rate.exponent < 0, why = together ? ", begun 1 % of the picture away, too far for that," : "";
    const end = !together ? "“Settle” begins anew." : twin.met ? `It was back after ${pushes(twin.met)}.` : "";
    this.told.textContent = `${rate.said()}${twin.parted ? ` The twin${why} parted within ${pushes(twin.parted)}. ${end}` : ""}`;
  }

  /** @param {import("./plot.js").Axes} axes @param {import("./svg.js").Pen} c */
  draw(axes, c) {
    const { state } = this.view;
    if (!state.sweeps) return;
    axes.inside(() => this.sweeps.draw(axes, c));
    this.sweeps.key(axes, c);
  }
}
