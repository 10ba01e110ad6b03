// @ts-check
/** A second ball that begins near the first: whether near balls part, and at what rate. */
import { Flight } from "./flight.js";
import { Past } from "./past.js";
import { numeral } from "./state.js";
import { inside } from "./walls.js";

/** @typedef {import("./flight.js").Model} Model */

/** How far apart the balls begin, of the height of the picture: less than what the ball hides; how far balls are that have parted. */
const NEAR = 1e-2, APART = 0.3;
/** Where it begins beside the ball, in place and velocity: where balls are farthest apart after so many turns. */
const SIDES = [[1, 0], [-1, 0], [0, 1], [0, -1]], TRIED = 5;
/** Times a turn at which the distance is noted, and how many of them are kept. */
const NOTED = 40, KEPT = 16 * NOTED;
/** The distance at which the rate is measured, of the height of the picture: small, and far above the rounding of a turn. */
const SMALL = 1e-7;
/** Turns that are passed over, in which what is near turns into the direction that grows most. */
const WARM = 3;
/** Turns whose mean is one sample of the rate; samples that say how sure it is. */
const BLOCK = 25, FEW = 4;

/** The rate at which near orbits part, by one of them that is brought near again after each turn (Benettin et al., Meccanica 15 (1980) 9-20). */
export class Rate {
  /** @type {number[]} sums over blocks of turns */ #sums = [];
  #passed = 0;
  turns = 0;
  /** @type {[number, number] | null} the orbit nearby, at the section */ #near = null;

  forget() {
    this.#sums = [];
    this.turns = this.#passed = 0;
    this.#near = null;
  }

  /** Per turn of the forcing: minus infinity where orbits meet exactly, as in completed chatter. */
  get exponent() {
    return this.#sums.reduce((sum, each) => sum + each, 0) / this.turns;
  }

  /** Its standard error, by the blocks that are complete. */
  get error() {
    const full = this.#sums.slice(0, Math.floor(this.turns / BLOCK)).map((sum) => sum / BLOCK), n = full.length, mean = full.reduce((sum, each) => sum + each / n, 0);
    return Math.sqrt(full.reduce((sum, each) => sum + (each - mean) ** 2, 0) / (n - 1) / n);
  }

  /**
   * The orbit passes the section.
   * @param {[number, number]} place where @param {(u: number, v: number) => [number, number]} turn where a state is a turn later @param {(u: number) => number} free the nearest place that is not behind a wall @param {number} height of the picture
   */
  pass([u, v], turn, free, height) {
    const small = SMALL * height;
    let [du, dv] = [small, 0];
    if (this.#near) {
      const [U, V] = turn(...this.#near), far = Math.hypot(U - u, V - v);
      if (Number.isFinite(far)) {
        if (this.#passed++ >= WARM) {
          if (this.turns++ % BLOCK === 0) this.#sums.push(0);
          this.#sums[this.#sums.length - 1] += Math.log(far / this.#size);
        }
        if (far > 0) [du, dv] = [((U - u) * small) / far, ((V - v) * small) / far];
      }
    }
    if (free(u + du) !== u + du) [du, dv] = [-du, -dv]; // behind the wall is no state
    this.#near = [u + du, v + dv];
    this.#size = Math.hypot(this.#near[0] - u, this.#near[1] - v);
  }

  #size = SMALL;

  /** In words. */
  said() {
    const { exponent, turns } = this;
    if (!turns) return "The twin begins near the ball …";
    const over = `a push (the next ${turns})`;
    if (exponent === -Infinity) return `λ = −∞ ${over}: near balls meet exactly.`;
    if (turns < FEW * BLOCK) return `So far λ = ${numeral(exponent, 2)} ${over}.`;
    const error = Math.max(this.error, 1e-3), places = Math.min(3, Math.max(0, Math.ceil(-Math.log10(error)))), up = Math.ceil(error * 10 ** places) / 10 ** places;
    const what = Math.abs(exponent) < Math.max(0.01, 2 * up) ? "stay about as far apart" : exponent > 0 ? "part" : "come together";
    return `λ = ${exponent.toFixed(places).replace("-", "−")} ± ${up.toFixed(places)} ${over}: near balls ${what}.`;
  }
}

/** The second ball, as it is seen. */
export class Twin {
  /** @type {Flight | null} */ flight = null;
  past = new Past();
  place = [0, 0];
  /** Turns of the forcing at a time since it began. */ clock = (/** @type {number} */ t) => t;
  /** The height of the picture. */ height = 1;
  /** When the balls had parted, in turns since they met; 0 if they have not, and when they had met again after that. */ parted = 0;
  met = 0;
  /** @type {[number, number][]} the logarithm of the distance over the clock */ distances = [];

  /**
   * Begin near a state, at a time of the forcing.
   * @param {import("./machine.js").Machine} machine @param {Model} model @param {import("./flight.js").Thrown} at @param {number} turn of the forcing @param {number} height of the picture
   */
  begin(machine, model, [u, v, time], turn, height) {
    const near = NEAR * height, flight = (/** @type {number} */ u, /** @type {number} */ v) => new Flight(machine, model, [u, v, time]);
    const end = (/** @type {Flight} */ each) => each.advance(TRIED * model.T, [])?.u.at(-1) ?? NaN, ball = end(flight(u, v));
    const free = SIDES.map(([du, dv]) => [u + du * near, v + (dv * near * 2 * Math.PI) / model.T]).filter(([u]) => inside(model.walls, u, time) === u);
    const far = free.map(([u, v]) => Math.abs(end(flight(u, v)) - ball) || 0);
    this.place = free[far.indexOf(Math.max(...far))];
    this.flight = flight(this.place[0], this.place[1]);
    this.clock = (/** @type {number} */ t) => turn + t / model.T;
    this.height = height;
    this.past.clear();
    this.parted = this.met = 0;
    this.distances = [];
  }

  /** Move on; whether its orbit goes on. @param {number} time @param {number} T @param {number} section @param {[number, number]} ball */
  advance(time, T, section, ball) {
    const moved = this.flight?.advance(time, []);
    if (!moved || !this.flight) return false;
    this.past.add(moved, this.clock, section, -Infinity);
    this.place = [moved.u[moved.u.length - 1], moved.v[moved.v.length - 1]];
    const { now } = this.flight, turns = now / T, [du, dv] = this.place.map((each, i) => each - ball[i]), far = Math.hypot(du, (dv * T) / (2 * Math.PI));
    if (far > 0 && !(this.clock(now) < (this.distances.at(-1)?.[0] ?? -Infinity) + 1 / NOTED)) this.distances.push([this.clock(now), Math.log(far / this.height)]);
    this.distances.splice(0, this.distances.length - KEPT);
    if (!this.parted && Math.abs(du) > APART * this.height) this.parted = turns;
    if (this.parted && !this.met && far < (NEAR * this.height) / 2) this.met = turns;
    return true;
  }
}
