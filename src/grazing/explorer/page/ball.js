// @ts-check
/** The ball against its bumper in time, and its phase portrait. */
import { periodColour, theme } from "./colours.js";
import { rowOf } from "./flow.js";
import { Here } from "./here.js";
import { SEARCHING, Search, costOf, within, words } from "./orbits.js";
import { Axes } from "./plot.js";
import { later, tidy } from "./state.js";

const CAPACITY = 512, WIDTH = 9, AHEAD = 3;
/** Legs of a flight that is drawn, and points of the curve on each, where they are many; points in one stroke: longer ones take long. */
const LEGS = 800, POINTS = 6, STROKE = 400;
/** Periods of forcing in a second at speed 1, and samples in a period. */
const PACE = 0.7, SAMPLES = 160;

/** @typedef {import("./state.js").State} State */
/** @typedef {[number, number, number]} Thrown u, v and the time */
/** @typedef {{t: number, before: number, after: number}} Hit an impact: its time since the throw, and the velocities */

export class BallView {
  /** @type {State} */ state = later();
  /** @type {import("./machine.js").Floats} parameters at the section */ row = later();
  /** @type {import("./machine.js").Floats} the same, with the time of the throw as the section's */ flying = later();
  /** The period of the forcing. */ T = 1;
  /** @type {string | undefined} what is computed, undefined for nothing */ key = undefined;
  /** @type {string | undefined} where the ball is thrown, as text */ thrown = undefined;
  /** @type {string | undefined} where it was when it was last noted, as text: nobody threw it from there */ recorded = undefined;
  /** @type {{times: Float64Array, cut: boolean, u: number[], v: number[], hits: Hit[]}} once around the orbit that most starts settle on, or a part of it */ attractor = later();
  /** @type {Thrown} on the attractor */ home = later();
  /** @type {[number, number, number, number]} the axes that show the attractor */ ends = later();
  /** @type {Thrown} where the flight began */ begun = later();
  /** Time since the throw, and how far the flight is known. */
  now = 0;
  known = 0;
  /** @type {import("./machine.js").Floats} the state of the flight at its known end */ ball = later();
  /** @type {number[]} what is known of the flight */ legs = [];
  /** @type {([number, number] | null)[]} where the ball was, null at impacts */ trail = [];
  /** @type {(Hit & {at: number})[]} impacts that are seen to flash */ flash = [];
  impacts = 0;
  /** @type {number | undefined} */ last = undefined;
  frame = 0;

  /**
   * @param {import("./machine.js").Machine} machine
   * @param {{tolerance: number}} described
   * @param {import("./state.js").Events} events
   * @param {Pick<import("./pool.js").Pool, "batch">} pool what searches where that takes long; else the page itself, a moment later
   */
  constructor(machine, described, { change, problem, done }, pool = new Here({ oscillator: machine })) {
    this.machine = machine;
    this.search = new Search(pool, "ball", { found: () => this.#found(), problem });
    this.tolerance = described.tolerance;
    this.change = change;
    this.problem = problem;
    this.told = done;
    this.axes = new Axes(document.getElementById("phase"));
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.speed = 1;
    this.canvas.addEventListener("click", (event) => {
      const { left, top } = this.canvas.getBoundingClientRect();
      const u = this.axes.atX(event.clientX - left), v = this.axes.atY(event.clientY - top);
      if (this.state && u >= this.axes.x0 && v >= this.axes.y0 && v <= this.axes.y1) this.throw(Math.max(u, this.state.sigma), v);
    });
    this.canvas.addEventListener("keydown", (event) => {
      if (event.key === " ") this.play(!this.playing);
      else if (event.key === "s" || event.key === "S") this.step();
      else return;
      event.preventDefault();
    });
  }

  get canvas() {
    return /** @type {HTMLCanvasElement} */ (this.axes.canvas);
  }

  /** @returns {import("./svg.js").Panel[]} */
  panels() {
    return [{ sheet: this.axes, draw: () => this.draw() }];
  }

  /** Show a state: find what random starts settle on, and follow it, or the ball that was thrown, in time. @param {State} state */
  show(state) {
    // a wall that is moved takes the ball along that was shown before it; a link that begins behind the wall is wrong
    if (state.ball && state.ball[0] < state.sigma && JSON.stringify(state.ball) === this.thrown) this.change({ ball: [state.sigma, state.ball[1], state.ball[2]] });
    if (state.ball && state.ball[0] < state.sigma) throw new Error(`the ball begins at u = ${state.ball[0]}, behind the wall at ${state.sigma}; begin at the wall or above`);
    this.state = state;
    const { machine } = this;
    this.row = rowOf(machine, state);
    this.T = (2 * Math.PI) / state.omega;
    const key = JSON.stringify(Array.from(this.row)), thrown = JSON.stringify(state.ball);
    if (this.key === undefined) this.search.forget();
    const which = machine.fields.indexOf(state.vary);
    this.search.ask("oscillator", machine, { row: this.row, which, value: this.row[which], transient: within(400, this.T), keep: within(64, this.T), seed: state.seed, tolerance: this.tolerance }, costOf(this.T));
    if (key === this.key && thrown === this.thrown) return this.draw();
    this.thrown = thrown;
    if (key === this.key) return this.begin();
    this.key = key;
    this.#portrait();
    this.begin();
  }

  /** The pool has found what starts settle on: the ball that was not thrown goes on from there. */
  #found() {
    this.#portrait();
    if (this.state.ball) this.draw();
    else this.begin();
    this.told();
  }

  get classes() {
    return this.search.classes;
  }

  /** Follow the attractor that most starts reach once around; while it is searched, a few periods from above the wall, not drawn. */
  #portrait() {
    const most = this.classes[0];
    const [u, v] = most?.points[0]?.every(Number.isFinite) ? most.points[0] : [this.state.sigma + 0.1, 0];
    const periods = Math.min(most?.period > 0 ? most.period : 24, 24);
    this.attractor = this.#fly(u, v, this.search.waiting ? 1 : periods, this.row);
    this.ends = this.#around(this.attractor);
    if (this.search.waiting) this.attractor = { times: new Float64Array(0), cut: false, u: [], v: [], hits: [] };
    this.home = [u, v, this.state.phase];
  }

  /** Axes in which a flight is seen. @param {{u: number[], v: number[], hits: Hit[]}} flight @returns {[number, number, number, number]} */
  #around({ u, v, hits }) {
    const { sigma } = this.state, vs = [...v, ...hits.flatMap((hit) => [hit.before, hit.after])];
    const [low, high] = [Math.min(...vs, 0), Math.max(...vs, 0)];
    const top = Math.max(...u, sigma + 0.05), room = 0.08 * (high - low) || 0.1;
    return [sigma - 0.06 * (top - sigma), top + 0.06 * (top - sigma), low - room, high + room];
  }

  /** Throw the ball from a state at the section. @param {number} u @param {number} v */
  throw(u, v) {
    const [width, height] = [this.axes.x1 - this.axes.x0, this.axes.y1 - this.axes.y0];
    this.change({ ball: [Math.max(tidy(u, width), this.state.sigma), tidy(v, height), this.state.phase] });
  }

  /** Begin on the attractor again. */
  settle() {
    if (this.state.ball) this.change({ ball: null });
    else this.begin();
  }

  /** Put where the ball is into the state, and so into the link: who opens it sees the ball go on from there. */
  record() {
    if (!this.attractor || !this.now) return;
    const [u, v] = this.trail.at(-1) ?? this.begun;
    const time = this.begun[2] + this.now;
    const ball = [u, v, time - this.T * Math.floor(time / this.T)];
    this.thrown = this.recorded = JSON.stringify(ball); // it is there already
    this.change({ ball });
  }

  /** Begin the flight: from where the ball is thrown, or on the attractor. */
  begin() {
    this.begun = this.state.ball ?? this.home;
    const [u, v, time] = this.begun;
    /** The parameters of the flight: its clock begins at the throw, as in `gz.trajectory`. */
    this.flying = Float64Array.from(this.row);
    this.flying[this.machine.fields.indexOf("phase")] = time;
    const [x0, x1, y0, y1] = this.ends, [a0, a1, b0, b1] = this.state.ball ? this.#around(this.#fly(u, v, 3, this.flying)) : this.ends;
    this.axes.span(Math.min(x0, a0), Math.max(x1, a1), Math.min(y0, b0), Math.max(y1, b1));
    this.now = 0;
    this.known = 0;
    this.ball = Float64Array.of(0, 0, u - this.state.sigma, v, 0, 0, 0);
    this.legs = [];
    this.trail = [];
    this.flash = [];
    this.impacts = 0;
    this.last = undefined;
    this.draw();
    this.play(this.playing);
  }

  /** @param {number} u @param {number} v @param {number} periods @param {import("./machine.js").Floats} row */
  #fly(u, v, periods, row) {
    const { machine, T } = this;
    const state = Float64Array.of(0, 0, u - this.state.sigma, v, 0, 0, 0);
    const { result, legs, state: end } = machine.call("legs", { capacity: LEGS, row, state, until: periods * T, patience: 1e-6 }, ["legs", "state"]);
    const count = Number(result), samples = Math.max(periods * SAMPLES, POINTS * count) + 1;
    const reached = end[0] * T + end[1], until = reached < (1 - 1e-9) * periods * T ? reached : periods * T;
    const times = Float64Array.from({ length: samples }, (_, i) => (i / (samples - 1)) * until);
    const flown = legs.subarray(0, count * WIDTH);
    const path = machine.call("sample", { count, samples, row, legs: flown, times }, ["u", "v"]);
    return { times, cut: until < periods * T, u: Array.from(path.u), v: Array.from(path.v), hits: this.#hits(flown).filter((hit) => hit.t <= until) };
  }

  /** @param {ArrayLike<number>} legs */
  #hits(legs) {
    /** @type {Hit[]} */
    const found = [];
    for (let k = 0; k < legs.length; k += WIDTH) {
      if (!Number.isNaN(legs[k + 5])) found.push({ t: legs[k] * this.T + legs[k + 4], before: legs[k + 5], after: legs[k + 6] });
    }
    return found;
  }

  /** Follow the ball a few periods further than it is needed. @param {number} until */
  #ahead(until) {
    while (this.known <= until) {
      const goal = this.known + AHEAD * this.T;
      const { result, legs, state } = this.machine.call("legs", { capacity: CAPACITY, row: this.flying, state: this.ball, until: goal, patience: 1e-6 }, ["legs", "state"]);
      const count = Number(result);
      const reached = state[0] * this.T + state[1];
      if (count === 0 || !(reached > this.known)) {
        this.problem("The ball cannot be followed further: its orbit ended.");
        this.play(false);
        return false;
      }
      this.legs.push(...legs.subarray(0, count * WIDTH));
      this.known = reached;
      this.ball = state;
    }
    const early = this.now - 2 * this.T; // legs that nobody asks for any more
    let drop = 0;
    while (drop + 2 * WIDTH < this.legs.length && this.legs[drop + WIDTH] * this.T + this.legs[drop + WIDTH + 1] < early) drop += WIDTH;
    if (drop) this.legs.splice(0, drop);
    return true;
  }

  /** Move the ball on by a time. @param {number} time */
  #advance(time) {
    const until = this.now + time;
    if (!this.#ahead(until)) return;
    const samples = Math.max(2, Math.ceil((time / this.T) * SAMPLES));
    const times = Float64Array.from({ length: samples }, (_, i) => this.now + ((i + 1) / samples) * time);
    const legs = Float64Array.from(this.legs);
    const { u, v } = this.machine.call("sample", { count: legs.length / WIDTH, samples, row: this.flying, legs, times }, ["u", "v"]);
    const hits = this.#hits(legs).filter((hit) => hit.t > this.now && hit.t <= until);
    for (let i = 0; i < samples; i++) {
      for (const hit of hits.filter((each) => each.t <= times[i] && each.t > times[i] - time / samples)) {
        this.trail.push([this.state.sigma, hit.before], null, [this.state.sigma, hit.after]);
      }
      this.trail.push([u[i], v[i]]);
    }
    this.trail.splice(0, Math.max(0, this.trail.length - 5 * SAMPLES));
    for (const hit of hits) {
      this.impacts++;
      this.flash.push({ ...hit, at: performance.now() });
    }
    this.flash.splice(0, Math.max(0, this.flash.length - 12));
    this.now = until;
  }

  /** @param {boolean} on */
  play(on) {
    this.playing = on;
    /** @type {HTMLElement} */ (document.getElementById("play")).textContent = on ? "Pause" : "Play";
    this.last = undefined;
    if (!on) this.record();
    if (on && !this.frame && !this.#hidden) this.frame = requestAnimationFrame(this.#tick);
  }

  get #hidden() {
    return Boolean(this.canvas.closest("section")?.hidden);
  }

  #tick = (/** @type {number} */ at) => {
    this.frame = 0;
    if (!this.playing || this.#hidden) return;
    if (this.last !== undefined) this.#advance((Math.min(at - this.last, 100) / 1000) * PACE * this.speed * this.T);
    this.last = at;
    this.draw();
    if (this.playing) this.frame = requestAnimationFrame(this.#tick);
  };

  /** Stop, and move on to just after the next impact, or by a period if there is none in twenty. */
  step() {
    this.play(false);
    const last = this.now + 20 * this.T, after = () => this.#hits(this.legs).find((hit) => hit.t > this.now + 1e-12);
    if (!this.#ahead(this.now)) return;
    while (!after() && this.known <= last) if (!this.#ahead(this.known)) return;
    const next = after();
    this.#advance(next && next.t <= last ? next.t - this.now + 1e-9 : this.T);
    this.draw();
    this.record();
    this.told();
  }

  repaint() {
    if (this.state) this.draw();
  }

  draw() {
    const { axes, state } = this;
    if (!this.attractor) return;
    const c = axes.begin();
    const shown = theme();
    const most = this.classes[0];
    const colour = periodColour(most?.period ?? 0);
    const [u, v] = this.trail.at(-1) ?? this.begun;
    const wall = axes.x(state.sigma);
    c.fillStyle = shown.wall;
    c.fillRect(axes.box.x, axes.box.y, wall - axes.box.x, axes.box.h);
    axes.inside(() => {
      c.strokeStyle = shown.line;
      c.beginPath();
      c.moveTo(axes.box.x, axes.y(0));
      c.lineTo(axes.box.x + axes.box.w, axes.y(0));
      c.stroke();
      c.globalAlpha = 0.4;
      c.lineWidth = most?.period > 0 ? 1.6 : 0.7;
      c.strokeStyle = colour;
      c.beginPath();
      let hit = 0, open = false;
      const { times, hits } = this.attractor;
      for (let i = 0; i < times.length; i++) {
        while (hit < hits.length && hits[hit].t <= times[i]) {
          if (open) c.lineTo(wall, axes.y(hits[hit].before));
          c.moveTo(wall, axes.y(hits[hit].after));
          hit++;
        }
        const place = [axes.x(this.attractor.u[i]), axes.y(this.attractor.v[i])];
        if (open && i % STROKE === 0) {
          c.lineTo(place[0], place[1]);
          c.stroke();
          c.beginPath();
          open = false;
        }
        open ? c.lineTo(place[0], place[1]) : c.moveTo(place[0], place[1]);
        open = true;
      }
      c.stroke();
      c.globalAlpha = 1;
      c.lineWidth = 2;
      c.strokeStyle = shown.accent;
      const tail = this.trail.slice(-1.2 * SAMPLES);
      for (let i = 1; i < tail.length; i++) {
        const from = tail[i - 1], to = tail[i];
        if (!from || !to) continue;
        c.globalAlpha = i / tail.length;
        c.beginPath();
        c.moveTo(axes.x(from[0]), axes.y(from[1]));
        c.lineTo(axes.x(to[0]), axes.y(to[1]));
        c.stroke();
      }
      c.globalAlpha = 1;
    });
    // the bumper, and the impacts of the last moment
    c.fillStyle = shown.faint;
    c.fillRect(wall - 3, axes.box.y, 3, axes.box.h);
    const now = performance.now();
    for (const each of this.flash) {
      const age = (now - each.at) / 600;
      if (age > 1 && this.playing) continue;
      c.globalAlpha = this.playing ? 1 - age : 0.8;
      c.strokeStyle = c.fillStyle = shown.graze;
      c.lineWidth = 2;
      for (const velocity of [each.before, each.after]) {
        c.beginPath();
        c.arc(wall, axes.y(velocity), 4 + (this.playing ? 10 * age : 0), 0, 7);
        c.stroke();
      }
      c.setLineDash([3, 3]);
      c.beginPath();
      c.moveTo(wall, axes.y(each.before));
      c.lineTo(wall, axes.y(each.after));
      c.stroke();
      c.setLineDash([]);
      if (age < 0.4 && this.playing) c.fillRect(wall - 5, axes.box.y, 5, axes.box.h);
      c.globalAlpha = 1;
    }
    // the ball itself, on its line below the portrait, and in the portrait
    const track = axes.box.y + axes.box.h - 13;
    c.strokeStyle = shown.line;
    c.lineWidth = 1;
    c.beginPath();
    c.moveTo(wall, track + 9.5);
    c.lineTo(axes.box.x + axes.box.w, track + 9.5);
    c.stroke();
    c.fillStyle = shown.ink;
    c.beginPath();
    c.arc(axes.x(u) + 8, track, 8, 0, 7);
    c.fill();
    c.fillStyle = shown.accent;
    c.beginPath();
    c.arc(axes.x(u), axes.y(v), 5, 0, 7);
    c.fill();
    c.fillStyle = shown.faint;
    c.textAlign = "right";
    c.textBaseline = "top";
    c.fillText(`t = ${(this.begun[2] + this.now).toFixed(2)} · period ${Math.floor(this.now / this.T) + 1} · ${this.impacts} impact${this.impacts === 1 ? "" : "s"}`, axes.box.x + axes.box.w - 4, axes.box.y + 2);
    axes.frame("u", "v");
    this.canvas.dataset.stage = "done";
  }

  raster() {
    const [u, v, start] = this.state.ball ?? this.begun;
    return { u, v, start, periods: Math.min(this.classes[0]?.period > 0 ? this.classes[0].period : 24, 24) };
  }

  summary() {
    const { state } = this;
    /** @type {import("./state.js").Line[]} */
    const said = [{ text: `Ball against ${state.law === "newton" || state.V === 0 ? "a passive wall" : `a bumper with V = ${state.V}${state.law === "triggered" && state.trigger > 0 ? `, passive below the impact speed v_s = ${state.trigger}` : ""}`}, constant force d = ${state.offset}:` }];
    if (this.search.waiting) said.push({ text: SEARCHING });
    for (const each of this.classes) said.push({ colour: periodColour(each.period), text: words(each) });
    if (state.ball) said.push({ text: `${JSON.stringify(state.ball) === this.recorded ? "Stopped at" : "Thrown from"} (${state.ball[0].toPrecision(6)}, ${state.ball[1].toPrecision(6)}) at t = ${state.ball[2].toPrecision(6)}: the link and the copied program begin there. “Settle” goes back to the orbit.`.replaceAll("-", "−") });
    const hits = this.attractor?.hits ?? [];
    if (this.attractor?.cut) said.push({ text: `The faint curve shows the first ${hits.length} impacts of it.` });
    if (hits.length && hits.length <= 4) said.push({ text: `Hits at ${hits.map((hit) => `v = ${hit.before.toFixed(4).replace("-", "−")}, leaves with ${hit.after.toFixed(4)}`).join("; ")}.` });
    return said;
  }
}
