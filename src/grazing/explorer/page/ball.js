// @ts-check
/** The opening: the ball above its bumper in time, its phase portrait, and the diagram in the parameter that is turned. */
import { periodColour, theme } from "./colours.js";
import { Company } from "./company.js";
import { plainSymbol } from "./controls.js";
import { Diagram } from "./diagram.js";
import { Flight, flown } from "./flight.js";
import { diagramOf, events, rowOf, valueOf } from "./flow.js";
import { Gestures } from "./gestures.js";
import { Here } from "./here.js";
import { LAWS, fileOf, kicks, ownOf, plain, unit } from "./laws.js";
import { SEARCHING, Search, costOf, drawnFrom, within, words } from "./orbits.js";
import { Past, chattered } from "./past.js";
import { Axes } from "./plot.js";
import { portrait } from "./portrait.js";
import { Sling } from "./sling.js";
import { Sound } from "./sound.js";
import { later, numeral, tidy } from "./state.js";
import { Strip } from "./strip.js";
import { tune } from "./tune.js";
import { ceiling, inside, moved, swing } from "./walls.js";

/** Periods of forcing in a second at speed 1, and points of the portrait that are remembered. */
const PACE = 0.7, TRAIL = 800;
/** Turns between impacts that the ball would hide: they are seen from near, and through it. */
const CLOSE = 0.2;
/** Turns of the forcing that the ball has behind it when it begins on a periodic orbit. */
const TURNS = 9;
/** Orbits that are drawn at most. */
const ORBITS = 6;
/** What of a state the past was drawn with. */
const WALLS = /** @type {const} */ (["sigma", "omega", "two", "sigma_B", "cos_A", "sin_A"]);
/** How narrow and how wide the portrait is seen at most, as shares of what it shows by itself. */
const LEAST = 1e-6, MOST = 10;
/** Columns and parts of the small diagram at most, and points of the ball's own in it. */
const COLUMNS = 320, BINS = 260, VISITED = 6000;

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./flight.js").Thrown} Thrown */
/** @typedef {import("./flight.js").Hit} Hit */

export class BallView {
  /** @type {State} */ state = later();
  /** @type {import("./flight.js").Model} */ model = later();
  /** @type {string | undefined} what is computed, undefined for nothing: then the ball begins anew */ key = undefined;
  /** Whether what is shown next is another thing: the ball does not go on in it. */ another = false;
  #walls = "";
  /** @type {[number, number, number, number]} what the portrait shows, and a part that is looked at */ #whole = later();
  /** @type {[number, number, number, number] | null} */ #part = null;
  /** @type {string | undefined} the small diagram */ #drawn = undefined;
  /** @type {string | undefined} where the ball is thrown, as text */ thrown = undefined;
  /** @type {string | undefined} where it was when it was last noted, as text: nobody threw it from there */ recorded = undefined;
  /** @type {ReturnType<typeof flown>} once around the orbit that most starts settle on, or a part of it */ attractor = later();
  /** @type {import("./portrait.js").Orbit[]} all that starts settle on */ orbits = [];
  /** @type {Thrown} on the attractor */ home = later();
  /** @type {[number, number, number, number]} the axes that show the attractor */ ends = later();
  /** @type {Flight} */ flight = later();
  /** Turns of the forcing at the throw: they go on when parameters change. */ #turns = 0;
  /** The section that it passes next, counted in turns: rounding would pass one twice or none. */ #next = 0;
  /** Whether the ball has lived through a change of parameters. */ lived = false;
  past = new Past();
  /** @type {[number, number][]} where the ball was at the section, over the parameter of the diagram */ visited = [];
  /** @type {([number, number] | null)[]} where the ball was, null at impacts */ trail = [];
  /** @type {(Hit & {at: number})[]} impacts that are seen to flash */ flash = [];
  impacts = 0;
  /** The turn in which the ball began: of those before it is known what it would have done. */ #first = 0;
  /** @type {number | undefined} */ last = undefined;
  frame = 0;
  /** Whether it was stepped to an impact soon after another. */ hops = false;
  /** @type {import("./jobs.js").Class | undefined} the orbit it is on */ heard = undefined;

  /**
   * @param {import("./machine.js").Machine} machine
   * @param {{tolerance: number}} described
   * @param {import("./state.js").Events} told
   * @param {import("./pool.js").Pool} pool what computes the diagram, and searches where that takes long; else the page itself, a moment later
   */
  constructor(machine, described, told, pool) {
    const { change, problem, done } = told;
    this.machine = machine;
    this.search = new Search(pool ?? new Here({ oscillator: machine }), "ball", { found: () => this.#found(), problem });
    this.tolerance = described.tolerance;
    this.change = change;
    this.problem = problem;
    this.told = done;
    this.sound = new Sound();
    this.strip = new Strip(document.getElementById("strip"));
    this.axes = new Axes(document.getElementById("phase"));
    const answers = events(this, machine, told);
    this.diagram = new Diagram(/** @type {HTMLCanvasElement} */ (document.getElementById("ball-diagram")), pool, "ball-diagram", {
      ...answers, follows: () => true, zoom: (span) => answers.zoom(span, this.state.window), overlay: (axes, c) => this.#overlay(axes, c),
    });
    this.company = new Company(this, pool);
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.speed = 1;
    this.sling = new Sling(this);
    const held = true, ready = () => Boolean(this.attractor && this.flight), redraw = () => this.draw();
    this.gestures = new Gestures(this.axes, { held, ready, redraw, zoom: (x, y) => y && this.#look([...x, ...y]), zoomOut: () => this.#look(null) });
    new Gestures(this.strip.axes, { held, ready, redraw, follows: () => true, zoom: ([from, to]) => this.strip.look(to - from, redraw), zoomOut: () => this.strip.look(0, redraw) });
    for (const canvas of [this.strip.axes.canvas, this.canvas]) canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === " ") this.play(!this.playing);
      else if (event.key === "s" || event.key === "S") this.step();
      else return;
      event.preventDefault();
    });
  }

  get canvas() {
    return /** @type {HTMLCanvasElement} */ (this.axes.canvas);
  }

  /** The period of the forcing. */
  get T() {
    return this.model.T;
  }

  /** Where the flight began, and the time since. */
  get begun() {
    return this.flight.begun;
  }

  get now() {
    return this.flight?.now ?? 0;
  }

  /** Turns of the forcing at a time since the throw, and where in a turn the section is. */
  #clock = (/** @type {number} */ t) => this.#turns + t / this.T;

  /** Turns of the forcing until now. */
  get turn() {
    return this.#clock(this.now);
  }

  get section() {
    return this.state.phase / this.T;
  }

  /** @returns {import("./svg.js").Panel[]} */
  panels() {
    return [{ sheet: this.strip.axes, draw: () => this.draw() }, { sheet: this.axes, draw: () => this.draw() }, { sheet: this.diagram.axes, draw: () => this.diagram.draw() }];
  }

  /** Show a state: find what random starts settle on; the ball goes on from where it is, or from where it was thrown. @param {State} state */
  show(state) {
    // a wall that is moved takes the ball along that was shown before it; a link that begins behind the wall is wrong
    const free = state.ball && inside(state, state.ball[0], state.ball[2]);
    if (state.ball && free !== state.ball[0] && JSON.stringify(state.ball) === this.thrown) this.change({ ball: [free, state.ball[1], state.ball[2]] });
    if (state.ball && free !== state.ball[0]) throw new Error(`the ball begins at u = ${state.ball[0]}, behind the wall at ${free}; begin at the wall or ${Number(free) < state.ball[0] ? "below" : "above"}`);
    const { machine } = this, row = rowOf(machine, state), T = (2 * Math.PI) / state.omega;
    const key = JSON.stringify(Array.from(row)), thrown = JSON.stringify(state.ball), anew = this.key === undefined, { another } = this;
    const turn = this.flight ? this.turn : 0, walls = JSON.stringify(WALLS.map((name) => state[name])), moves = walls !== this.#walls;
    this.#walls = walls;
    this.another = false;
    this.state = state;
    this.model = { row, walls: state, T };
    if (anew) this.search.forget();
    const which = machine.fields.indexOf(state.vary);
    this.search.ask("oscillator", machine, { row, which, value: row[which], transient: within(400, T), keep: within(64, T), seed: state.seed, tolerance: this.tolerance }, costOf(state));
    if (another) {
      this.visited = [];
      this.#part = null;
    }
    this.#diagram(anew);
    this.company.show(state);
    if (key === this.key && thrown === this.thrown && !another) return this.draw();
    const same = key === this.key, goes = !anew && !another && !same && thrown === this.thrown;
    this.key = key;
    this.thrown = thrown;
    if (!same) this.#portrait();
    if (!goes) return this.begin();
    const [u, v] = this.place;
    this.lived = true;
    if (moves) this.past.clear();
    const time = (turn - Math.floor(turn)) * T;
    this.#fly([inside(state, u, time), v, time], turn);
    this.#fit();
    this.draw();
  }

  /** The diagram beside the ball, if it is another one. */
  #diagram(anew = false) {
    const { state } = this, asked = diagramOf(this.machine, { ...state, columns: Math.min(state.columns, COLUMNS), bins: Math.min(state.bins, BINS), coordinate: "u", window: null }, this.tolerance);
    this.diagram.axes.canvas.hidden = asked.slow; // it would take a minute: the oscillator's view has it
    if (asked.slow) return;
    if (!anew && asked.key === this.#drawn) return this.diagram.draw();
    this.#drawn = asked.key;
    this.visited = [];
    this.diagram.show(asked.spec);
  }

  /** The pool has found what starts settle on: the ball that was not thrown goes on from there. */
  #found() {
    this.#portrait();
    if (this.state.ball || this.lived) {
      this.#fit();
      this.draw();
    } else this.begin();
    this.told();
  }

  get classes() {
    return this.search.classes;
  }

  /** Follow the attractor that most starts reach once around; while it is searched, a few periods from above the wall, not drawn. */
  #portrait() {
    const most = this.classes[0];
    const [u, v] = most?.points[0]?.every(Number.isFinite) ? most.points[0] : [inside(this.state, this.state.sigma + moved(this.state, this.state.phase)[0] + 0.1 * unit(), this.state.phase), 0];
    const periods = Math.min(most?.period > 0 ? most.period : 24, 24);
    this.attractor = flown(this.machine, this.model, u, v, this.search.waiting ? 1 : periods);
    this.ends = this.#around(this.attractor);
    if (this.search.waiting) this.attractor = { times: new Float64Array(0), cut: false, u: [], v: [], hits: [], rests: [] };
    this.orbits = this.search.waiting ? [] : this.classes.filter(({ period }, i) => period > 0 || i === 0).slice(0, ORBITS).map((each, i) => ({
      flight: i ? flown(this.machine, this.model, each.points[0][0], each.points[0][1], Math.min(each.period, 24)) : this.attractor,
      colour: periodColour(each.period), thin: !(each.period > 0), name: `${each.word || "no period"}: ${Math.round(16 * each.share)}`,
    }));
    for (const { flight } of this.orbits.slice(1)) this.ends = /** @type {typeof this.ends} */ (this.#around(flight).map((end, i) => Math[i % 2 ? "max" : "min"](end, this.ends[i])));
    this.home = [u, v, this.state.phase];
  }

  /** Axes in which a flight is seen. @param {{u: number[], v: number[], hits: Hit[]}} flight @returns {[number, number, number, number]} */
  #around({ u, v, hits }) {
    const { sigma } = this.state, amplitude = swing(this.state), vs = [...v, ...hits.flatMap((hit) => [hit.before, hit.after])];
    const [low, high] = [Math.min(...vs, 0), Math.max(...vs, 0)];
    const top = this.state.two ? this.state.sigma_B + amplitude : Math.max(...u, sigma + amplitude + 0.05 * unit()), room = 0.08 * (high - low) || 0.1, bottom = sigma - amplitude;
    return [bottom - 0.06 * (top - bottom), top + 0.06 * (top - bottom), low - room, high + room];
  }

  /** Axes in which the attractor is seen, and a flight that does not begin on it. */
  #fit() {
    const { row, begun: [u, v] } = this.flight, [x0, x1, y0, y1] = this.ends;
    const [a0, a1, b0, b1] = this.state.ball || this.lived ? this.#around(flown(this.machine, { ...this.model, row }, u, v, 3)) : this.ends;
    this.#whole = [Math.min(x0, a0), Math.max(x1, a1), Math.min(y0, b0), Math.max(y1, b1)];
    this.axes.span(...(this.#part ?? this.#whole));
  }

  /** Look at a part of the portrait, or at all of it; it is no more than ten times as wide. @param {[number, number, number, number] | null} part */
  #look(part) {
    const size = (/** @type {number} */ i) => part && (part[i + 1] - part[i]) / (this.#whole[i + 1] - this.#whole[i]);
    if ([0, 2].some((i) => { const is = size(i); return is !== null && !(is > LEAST && is < MOST); })) return;
    this.#part = part;
    this.#fit();
    this.draw();
  }

  /** Throw the ball from a state at the section. @param {number} u @param {number} v */
  throw(u, v) {
    const [width, height] = [this.axes.x1 - this.axes.x0, this.axes.y1 - this.axes.y0];
    this.change({ ball: [inside(this.state, tidy(u, width), this.state.phase), tidy(v, height), this.state.phase] });
  }

  /** Begin on the attractor again. */
  settle() {
    if (this.state.ball) this.change({ ball: null });
    else this.begin();
  }

  /** Where the ball is. @returns {[number, number]} */
  get place() {
    return this.trail.at(-1) ?? [this.begun[0], this.begun[1]];
  }

  /** Put where the ball is into the state, and so into the link: who opens it sees the ball go on from there. */
  record() {
    if (!this.attractor || !(this.now || this.lived)) return;
    const [u, v] = this.place, time = this.begun[2] + this.now;
    const ball = [u, v, time - this.T * Math.floor(time / this.T)];
    this.thrown = this.recorded = JSON.stringify(ball); // it is there already
    this.change({ ball });
  }

  /** @param {Thrown} begun @param {number} turns of the forcing at the throw */
  #fly(begun, turns) {
    this.flight = new Flight(this.machine, this.model, begun);
    this.#turns = turns;
    this.#next = Math.floor(turns - this.section + 1e-9) + 1;
    this.company.begin();
  }

  /** What a ball on a periodic orbit has done before: the same, so many periods ago. */
  #before() {
    const period = this.classes[0]?.period ?? 0, { attractor } = this;
    if (!(period > 0) || attractor.cut || !attractor.times.length) return;
    const turns = Math.round(attractor.times[attractor.times.length - 1] / this.T);
    for (let ago = Math.ceil(TURNS / turns) * turns; ago > 0; ago -= turns) this.past.add(attractor, (t) => this.#clock(t) - ago, this.section, -Infinity);
  }

  /** Begin the flight: from where the ball is thrown, or on the attractor. */
  begin() {
    const begun = this.state.ball ?? this.home;
    this.lived = false;
    this.trail = [];
    this.#fly(begun, begun[2] / this.T);
    this.#fit();
    this.past.clear();
    if (!this.state.ball) this.#before();
    this.flash = [];
    this.impacts = 0;
    this.#first = Math.floor(begun[2] / this.T - this.section + 1e-9);
    this.hops = false;
    this.last = undefined;
    this.draw();
    this.play(this.playing);
  }

  /** Move the ball on by a time. @param {number} time */
  #advance(time) {
    const { flight, T, section } = this, until = this.now + time;
    /** When it passes the section. @type {number[]} */
    const passes = [];
    for (let at; (at = (this.#next + section - this.#turns) * T) <= until; this.#next++) passes.push(at);
    const count = passes.length, gone = flight.advance(time, passes);
    if (!gone) {
      this.problem("The ball cannot be followed further: its orbit ended.");
      return this.play(false);
    }
    const { times, u, v, hits } = gone;
    let hit = 0;
    times.forEach((t, i) => {
      for (; hit < hits.length && hits[hit].t <= t; hit++) this.trail.push([hits[hit].place, hits[hit].before], null, [hits[hit].place, hits[hit].after]);
      this.trail.push([u[i], v[i]]);
      if (t === passes[0]) {
        passes.shift();
        this.visited.push([valueOf(this.state, this.state.vary), u[i]]);
      }
    });
    this.trail.splice(0, Math.max(0, this.trail.length - TRAIL));
    this.visited.splice(0, Math.max(0, this.visited.length - VISITED));
    this.past.add(gone, this.#clock, section, performance.now());
    for (const each of hits) {
      this.impacts++;
      this.flash.push({ ...each, at: performance.now() });
      this.sound.hit(each.speed, Math.max(-this.axes.y0, this.axes.y1));
    }
    this.flash.splice(0, Math.max(0, this.flash.length - 12));
    this.company.moved(time);
    if (count) this.diagram.draw();
  }

  /** @param {boolean} on */
  play(on) {
    this.hops = false;
    this.playing = on;
    /** @type {HTMLElement} */ (document.getElementById("play")).textContent = on ? "Pause" : "Play";
    this.last = undefined;
    if (!on) this.record();
    if (on) this.#run();
  }

  /** A ball whose button says Pause goes on wherever it is drawn: a view that was away has lost its frames. */
  #run() {
    if (this.playing && !this.frame && !this.#hidden) this.frame = requestAnimationFrame(this.#tick);
  }

  get #hidden() {
    return Boolean(this.canvas.closest("section")?.hidden);
  }

  #tick = (/** @type {number} */ at) => {
    this.frame = 0;
    if (!this.playing || this.#hidden) return;
    if (this.last !== undefined && !this.sling.aim) this.#advance((Math.min(at - this.last, 100) / 1000) * PACE * this.speed * this.T);
    this.last = at;
    const { heard } = this;
    this.draw();
    if (this.heard !== heard) this.told();
  };

  /** Stop, and move on to just after the next impact, or by a period if there is none in twenty. */
  step() {
    this.play(false);
    const next = this.flight.next(20 * this.T);
    this.hops = this.impacts > 0 && (next?.t ?? Infinity) - this.now < CLOSE * this.T;
    this.#advance(next ? next.t - this.now + 1e-9 : this.T);
    this.draw();
    this.record();
    this.told();
  }

  repaint() {
    if (!this.state) return;
    this.draw();
    this.diagram.paint();
  }

  /** The force at a turn. @param {number} turn */
  #force = (turn = 0) => {
    const { state } = this, phase = 2 * Math.PI * turn + state.omega * state.t0;
    const harmonic = (/** @type {number} */ j) => valueOf(state, `cos${j}`) * Math.cos(j * phase) + valueOf(state, `sin${j}`) * Math.sin(j * phase);
    return state.offset + harmonic(1) + harmonic(2) + harmonic(3);
  };

  draw() {
    const { axes, state, past } = this;
    if (!this.attractor || !this.flight) return;
    this.#run();
    this.heard = past.heard(this.classes);
    const colour = periodColour(this.heard?.period ?? 0), { twin } = this.company, { aim } = this.sling;
    const endless = [...past.letters].some(([turn, letter]) => turn >= this.#first && chattered(letter)); // completed chatter has impacts without end
    const time = `t = ${(this.turn * this.T).toFixed(2)} · ${endless ? "∞" : this.impacts} impact${this.impacts === 1 && !endless ? "" : "s"}`;
    const [shift] = moved(state, this.begun[2] + this.now);
    portrait(axes, { low: state.sigma + shift, high: ceiling(state) + shift, orbits: this.orbits, colour, trail: this.trail, place: this.place, flash: this.flash, playing: this.playing, twin: twin?.place ?? null, aim });
    this.gestures.draw(axes.context);
    this.strip.draw({ past, turn: this.turn, section: this.section, u: this.place[0], walls: state, top: axes.x1, force: this.#force, colour: aim ? theme().accent : colour, live: this.playing, said: time, twin, T: this.T, begins: this.section, aim, hops: this.hops });
    this.canvas.dataset.stage = this.strip.axes.canvas.dataset.stage = "done";
  }

  /** The ball's own points at the section, and the parameter: where it went when that was turned. @param {Axes} axes @param {import("./svg.js").Pen} c */
  #overlay(axes, c) {
    this.company.draw(axes, c);
    axes.inside(() => {
      c.fillStyle = theme().accent;
      for (const [value, u] of this.visited) c.fillRect(axes.x(value) - 1.5, axes.y(u) - 1.5, 3, 3);
    });
    axes.vertical(valueOf(this.state, this.state.vary), theme().ink, [], 2);
  }

  raster() {
    const [u, v, start] = this.state.ball ?? this.begun;
    return { u, v, start, periods: Math.min(this.classes[0]?.period > 0 ? this.classes[0].period : 24, 24) };
  }

  /** What there is, and what it does, in a visitor's words. */
  lead() {
    const { two, cos_A, sin_A } = this.state, moves = cos_A !== 0 || sin_A !== 0, kick = kicks(this.state), own = ownOf(this.state);
    const between = kick.below && kick.above ? "two bumpers that kick" : kick.below ? "a bumper that kicks and a wall" : kick.above ? "a wall and a bumper that kicks" : "two walls";
    const where = own ? `${two ? "between two walls" : "above a wall"} with the law ${own.law}` : two ? `between ${between}` : `above a ${kick.below ? "bumper that kicks" : "wall"}`;
    return { headline: `A force pushes a ball up and down ${where}${moves ? `, which ${two ? "move" : "moves"}` : ""}.`, said: this.search.waiting ? [{ text: SEARCHING }] : tune(this.classes, Boolean(this.state.ball || this.lived) && !this.heard) };
  }

  summary() {
    const { state } = this, own = ownOf(state);
    const bumper = `a bumper with V = ${state.V}${state.law === "triggered" && state.trigger > 0 ? `, passive below the impact speed v_s = ${state.trigger}` : ""}`;
    const wall = own ? `a wall with the law ${own.law} of ${fileOf(own)}, ${own.own.map((name) => `${plain(name)} = ${numeral(valueOf(state, name))}`).join(", ")}` : kicks(state).below ? bumper : "a passive wall";
    /** @type {import("./state.js").Line[]} */
    const said = [{ text: `Ball against ${wall}, constant force d = ${numeral(state.offset, 15)}:` }];
    if (state.two) said.push({ text: `A second wall, B, is above the ball at u = ${numeral(state.sigma_B)}${LAWS[state.law].includes("V") ? `, and kicks with V = ${numeral(state.V_B)}` : ""}; a word names the walls that are hit.` });
    if (swing(state)) said.push({ text: `${state.two ? "Both walls move" : "The wall moves"} by ${numeral(swing(state))} to each side, at the pace of the pushes.` });
    if (this.search.waiting) said.push({ text: SEARCHING });
    said.push(...words(this.classes), drawnFrom(this.machine, this.model.row));
    if (state.ball) said.push({ text: `${JSON.stringify(state.ball) === this.recorded ? "Stopped at" : "Thrown from"} (${numeral(state.ball[0])}, ${numeral(state.ball[1])}) at t = ${numeral(state.ball[2])}: the link and the copied program begin there. “Settle” goes back to the orbit.` });
    const hits = this.attractor?.hits ?? [];
    if (this.attractor?.cut) said.push({ text: `The faint curve shows the first ${hits.length} impacts of it.` });
    said.push(...this.company.said(plainSymbol(this.machine.described.fields[this.machine.fields.indexOf(state.vary)])));
    if (hits.length && hits.length <= 4) said.push({ text: `Hits at ${hits.map((hit) => `v = ${hit.before.toFixed(4)}, leaves with ${hit.after.toFixed(4)}`).join("; ")}.` });
    return said;
  }
}
