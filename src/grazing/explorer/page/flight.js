// @ts-check
/** The flight of a ball in time, impact by impact, by the kernels: no step of its own. */

import { moved, still } from "./walls.js";

/** @typedef {import("./machine.js").Machine} Machine */
/** @typedef {import("./machine.js").Floats} Floats */
/** @typedef {[number, number, number]} Thrown u, v and the time */
/**
 * An impact: its time since the throw, the velocities, the speed of approach, the wall, where that was then, and its name if there are two.
 * @typedef {{t: number, before: number, after: number, speed: number, wall: number, place: number, name: string}} Hit
 */
/** @typedef {{row: Floats, walls: import("./walls.js").Walls, T: number}} Model parameters at the section, the walls, and the period of the forcing */
/** @typedef {[number, number, string]} Rest from and to, in time since the throw, and the name of the wall */

const CAPACITY = 512, WIDTH = 11, AHEAD = 3;
/** Legs of the few periods that are known, at most: maps give up at 10,000 impacts in one. */
const MOST = 1e5;
/** Legs of a flight that is drawn, and points of the curve on each, where they are many. */
const LEGS = 800, POINTS = 6;
/** Samples in a period. */
export const SAMPLES = 160;
/** Chatter is followed down to this share of its first speed. */
const PATIENCE = 1e-6;

/** The impacts of legs. @param {ArrayLike<number>} legs @param {Model} model @param {number} start when the ball was thrown */
function hitsOf(legs, { T, walls }, start) {
  /** @type {Hit[]} */
  const found = [];
  for (let k = 0; k < legs.length; k += WIDTH) {
    if (Number.isNaN(legs[k + 5])) continue;
    const t = legs[k] * T + legs[k + 4], wall = legs[k + 10], side = wall ? -1 : 1, [at, speed] = moved(walls, start + t);
    found.push({ t, before: speed + side * legs[k + 5], after: speed + side * legs[k + 6], speed: -legs[k + 5], wall, place: (wall ? walls.sigma_B : walls.sigma) + at, name: walls.two ? "AB"[wall] : "" });
  }
  return found;
}

/** When the ball rests on the wall: from and to, in time since the throw. @param {ArrayLike<number>} legs @param {Model} model */
function restsOf(legs, { T, walls }) {
  /** @type {Rest[]} */
  const found = [];
  for (let k = 0; k < legs.length; k += WIDTH) if (legs[k + 8] === 1) found.push([legs[k] * T + legs[k + 1], legs[k] * T + legs[k + 4], walls.two ? "AB"[legs[k + 9]] : ""]);
  return found;
}

/** The state of a flight that begins. @param {Model} model @param {number} u @param {number} v */
const begins = ({ walls }, u, v) => Float64Array.of(0, 0, still(walls) ? u - walls.sigma : u, v, 0, 0, 0, 0);

/** A flight over so many periods. @param {Machine} machine @param {Model} model @param {number} u @param {number} v @param {number} periods */
export function flown(machine, model, u, v, periods) {
  const { row, T } = model, start = row[machine.fields.indexOf("phase")], state = begins(model, u, v);
  const { result, legs, state: end } = machine.call("legs", { capacity: LEGS, row, state, until: periods * T, patience: PATIENCE }, ["legs", "state"]);
  const count = Number(result), samples = Math.max(periods * SAMPLES, POINTS * count) + 1;
  const reached = end[0] * T + end[1], until = reached < (1 - 1e-9) * periods * T ? reached : periods * T;
  const times = Float64Array.from({ length: samples }, (_, i) => (i / (samples - 1)) * until);
  const known = legs.subarray(0, count * WIDTH);
  const path = machine.call("sample", { count, samples, row, legs: known, times }, ["u", "v"]);
  return { times, cut: until < periods * T, u: Array.from(path.u), v: Array.from(path.v), hits: hitsOf(known, model, start).filter((hit) => hit.t <= until), rests: restsOf(known, model) };
}

/** A flight that goes on: what is known of it reaches a few periods further than it was asked for. */
export class Flight {
  /** Time since the throw. */
  now = 0;
  /** How far the flight is known. */ #known = 0;
  /** @type {number[]} */ #legs = [];

  /** @param {Machine} machine @param {Model} model @param {Thrown} begun */
  constructor(machine, model, begun) {
    this.machine = machine;
    this.model = model;
    this.T = model.T;
    this.begun = begun;
    /** The parameters of the flight: its clock begins at the throw, as in `gz.trajectory`. */
    this.row = Float64Array.from(model.row);
    this.row[machine.fields.indexOf("phase")] = begun[2];
    /** The state of the flight at its known end. */
    this.end = begins(model, begun[0], begun[1]);
  }

  /** Know the flight beyond a time; whether it goes on so far. @param {number} until */
  ahead(until) {
    const { T } = this;
    while (this.#known <= until) {
      const goal = this.#known + AHEAD * T;
      const { result, legs, state } = this.machine.call("legs", { capacity: CAPACITY, row: this.row, state: this.end, until: goal, patience: PATIENCE }, ["legs", "state"]);
      const count = Number(result), reached = state[0] * T + state[1];
      if (count === 0 || !(reached > this.#known) || this.#legs.length > MOST * WIDTH) return false;
      this.#legs.push(...legs.subarray(0, count * WIDTH));
      this.#known = reached;
      this.end = state;
    }
    const early = this.now - 2 * T; // legs that nobody asks for any more
    let drop = 0;
    while (drop + 2 * WIDTH < this.#legs.length && this.#legs[drop + WIDTH] * T + this.#legs[drop + WIDTH + 1] < early) drop += WIDTH;
    if (drop) this.#legs.splice(0, drop);
    return true;
  }

  /** The next impact within a time from now, if there is one. @param {number} time */
  next(time) {
    const last = this.now + time, after = () => hitsOf(this.#legs, this.model, this.begun[2]).find((hit) => hit.t > this.now + 1e-12);
    while (!after() && this.#known <= last) if (!this.ahead(this.#known)) return undefined;
    const hit = after();
    return hit && hit.t <= last ? hit : undefined;
  }

  /**
   * Move on by a time, and say where the ball was at even times, and at `also`, and what it hit; null if the orbit ended.
   * @param {number} time @param {number[]} also times since the throw
   */
  advance(time, also) {
    const from = this.now, until = from + time;
    if (!this.ahead(until)) return null;
    const even = Math.max(2, Math.ceil((time / this.T) * SAMPLES));
    const times = Float64Array.from([...Array.from({ length: even }, (_, i) => from + ((i + 1) / even) * time), ...also]).sort();
    const legs = Float64Array.from(this.#legs);
    const { u, v } = this.machine.call("sample", { count: legs.length / WIDTH, samples: times.length, row: this.row, legs, times }, ["u", "v"]);
    this.now = until;
    return { times, u, v, hits: hitsOf(legs, this.model, this.begun[2]).filter((hit) => hit.t > from && hit.t <= until), rests: restsOf(legs, this.model) };
  }
}
