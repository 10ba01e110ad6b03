// @ts-check
/** What a ball has done: its curve, impacts and word, on the clock of the forcing, which goes on when parameters change. */

/** @typedef {{turn: number, u: number}} Point */
/** @typedef {{turn: number, speed: number, wall: number, place: number, at: number}} Mark an impact, with when it was seen */

/** Whether a letter is that of completed chatter, or of that or of rest. @param {number | string | undefined} letter */
export const chattered = (letter) => typeof letter === "string" && letter.startsWith("C");
const dead = (/** @type {number | string} */ letter) => /^[CS]/.test(String(letter));

/** Turns of the forcing that are kept. */
const KEPT = 16;

export class Past {
  /** @type {(Point | null)[]} u over the clock, null where nothing is known */ line = [];
  /** @type {Mark[]} */ marks = [];
  /** @type {Map<number, number | string>} letters by turn: impacts in it, or the walls that are hit, C where chatter completed, S for rest */ letters = new Map();

  /** Nothing is known of before. */
  clear() {
    this.line = [];
    this.marks = [];
    this.letters.clear();
  }

  /**
   * Add what a flight did. `clock` gives the turn of the forcing at a time of the flight, `section` where in a turn a letter begins.
   * @param {{times: ArrayLike<number>, u: ArrayLike<number>, hits: import("./flight.js").Hit[], rests: import("./flight.js").Rest[]}} moved @param {(t: number) => number} clock @param {number} section @param {number} at when it is seen
   */
  add({ times, u, hits, rests }, clock, section, at) {
    const letter = (/** @type {number} */ t) => Math.floor(clock(t) - section + 1e-9);
    let hit = 0;
    for (let i = 0; i < times.length; i++) {
      while (hit < hits.length && hits[hit].t <= times[i]) this.line.push({ turn: clock(hits[hit].t), u: hits[hit++].place });
      this.line.push({ turn: clock(times[i]), u: u[i] });
      if (!this.letters.has(letter(times[i]))) this.letters.set(letter(times[i]), 0);
    }
    for (const each of hits) {
      const n = letter(each.t), so = this.letters.get(n) ?? 0;
      this.marks.push({ turn: clock(each.t), speed: each.speed, wall: each.wall, place: each.place, at });
      this.letters.set(n, each.name ? (so === 0 ? each.name : dead(so) ? so : `${so}${each.name}`) : typeof so === "number" ? so + 1 : so);
    }
    const first = times[0], last = times[times.length - 1];
    for (const [from, to, name] of rests) {
      if (to < first || from > last) continue;
      for (let n = letter(Math.max(from, first)); n <= letter(Math.min(to, last)); n++) {
        const dies = from > 0 && letter(from) === n && this.letters.get(n) !== 0;
        if (!chattered(this.letters.get(n))) this.letters.set(n, `${dies ? "C" : "S"}${name}`);
      }
    }
    this.#forget(clock(last) - KEPT);
  }

  /**
   * Which of some orbits the ball is on: that whose word the last letters repeat, without the turn that is under way.
   * @param {import("./jobs.js").Class[]} classes
   */
  heard(classes) {
    const said = [...this.letters].sort(([a], [b]) => a - b).slice(0, -1).map(([, letter]) => String(letter));
    return classes.find(({ period, word }) => {
      const letters = (word.match(/\(\w+\)|./g) ?? []).map((each) => each.replace(/[()]/g, "")), size = letters.length;
      const last = said.slice(-Math.min(2 * size, size + 4));
      if (!(period > 0) || last.length < Math.min(2 * size, size + 4)) return false;
      return letters.some((_, turn) => last.every((letter, i) => letter === letters[(i + turn) % size]));
    });
  }

  /** @param {number} turn */
  #forget(turn) {
    const first = this.line.findIndex((point) => point && point.turn >= turn);
    if (first > 0) this.line.splice(0, first);
    this.marks = this.marks.filter((mark) => mark.turn >= turn);
    for (const n of this.letters.keys()) if (n < turn - 1) this.letters.delete(n);
  }
}
