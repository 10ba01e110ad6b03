// @ts-check
/** A game on a table: the block of numbers that the kernels get, the ball, its ghosts, and what the player did. */

/** @typedef {import("./machine.js").Machine} Machine */
/** @typedef {import("./machine.js").Floats} Floats */
/** @typedef {Record<string, number>} Shape */
/** @typedef {{name: string, kind: "disc" | "segment" | "arc" | "flipper" | "drain", shape: Shape, law: {name: string, params: string[]} | null}} Thing */
/**
 * A table as the page has it.
 * @typedef {{
 *   objects: Thing[], rho: number, box: [number, number, number, number], block: number[], params: string[], row: number, values: number[],
 *   launch: [number, number, number], speeds: [number, number], from: [number, number, number], mm: number,
 * }} Table
 */
/** @typedef {{t: number, owner: number, before: number, x: number, y: number}} Hit */
/** @typedef {[number, number, number, number]} State x, y and the velocity */
/** @typedef {{t: number, state: State}} Nudge when the table was nudged, and the ball just after that */

/** Bits of outcomes, as kernels.json names them, that the page asks for. @typedef {{fatal: number, escaped: number, ambiguous: number}} Bits */

/**
 * A table in full: tables.json leaves out names that follow from the objects, and runs of zeros.
 * @param {any} packed @returns {Table}
 */
export const unpacked = ({ block, params: [before, after], ...one }) => ({
  ...one,
  block: block.flatMap((/** @type {any} */ each) => (Array.isArray(each) ? Array(each[0]).fill(0) : each)),
  params: [...before, ...one.objects.flatMap((/** @type {Thing} */ { name, shape, law }) => [...Object.keys(shape), ...(law?.params ?? [])].map((each) => `${name}.${each}`)), ...after],
});

/** Pieces of a flipper's motion that a game has room for, and flights of one look. */
const ROOM = 600, CAPACITY = 64;
/** Seconds between two switches at one time. */
const INSTANT = 1e-6;
/** So many nudges in so many seconds tilt the machine. */
const NUDGES = 3, CALM = 2;
/** Columns of a flight: see grazing/billiard/flown.py. */
const WIDTH = 20, TIME = 0, SURFACE = 1, OWNER = 2, BEFORE = 3, SAID = 5, LAST = 10, NEXT = 14;
/** Numbers of a ball that is followed among many, and where its outcome is. */
const BALL = 9, FLAGS = 8;
/** Impacts of a ghost in one look at most, and of the ball in a game: a link may make gravity so strong that looks would never end. */
const MOST = 400, HITS = 1e5;

export class Played {
  /** @type {Hit[]} all impacts of the ball */ hits = [];
  /** @type {Record<string, number[]>} by flipper, when its button was pressed, released, pressed … */ presses = {};
  /** @type {Nudge[]} */ nudges = [];
  /** Time of the game, and how it ended: a drain's name, *away*, or in words what stopped it; empty while the ball lives. */
  t = 0;
  end = "";
  /** Decisions that doubles could not make. */
  unsure = 0;
  /** @type {State} where the ball was launched */ start = [0, 0, 0, 0];
  /** Whether the table has been changed since: then a recording would be of two tables. */
  changed = false;
  /** Time, surface just left and state at the begin of the flight; −2 for no ball. @type {Floats} */ #now = Float64Array.of(0, -2, 0, 0, 0, 0);
  /** @type {Floats} */ ghosts = new Float64Array(0);
  /** @type {Floats} */ places = new Float64Array(0);
  /** @type {{motion: Floats, count: number, thing: Thing, down: boolean}[]} */ #flippers = [];

  /** @type {Floats} the block with all flippers at rest */ #resting;

  /** @param {Machine} machine @param {Record<string, number>} layout @param {Table} table @param {Bits} bits */
  constructor(machine, layout, table, bits) {
    /** The objects as they are now: discs may be moved. */
    this.things = table.objects.map((one) => ({ ...one, shape: { ...one.shape } }));
    this.machine = machine;
    this.layout = layout;
    this.table = table;
    this.bits = bits;
    this.values = [...table.values];
    const moved = table.objects.filter((one) => one.kind === "flipper");
    const at = layout, own = table.block.length;
    this.block = new Float64Array(own + ROOM * at.PIECE_WIDTH * moved.length);
    this.block.set(table.block);
    table.objects.forEach((one, j) => {
      if (!one.law) return;
      const thing = at.HEAD + at.THING * j, first = table.params.indexOf(`${one.name}.${one.law.params[0]}`);
      this.block[thing + at.LAW] = machine.call(`law_${one.law.name}`, {}).result;
      this.block[thing + at.ROW] = machine.first + 8 * (table.row + first);
    });
    const surfaces = this.block[at.FACES] + this.block[at.CIRCLES] + this.block[at.SIDES];
    const rows = at.HEAD + at.THING * table.objects.length + at.WIDTH * surfaces;
    moved.forEach((thing, i) => {
      const row = rows + at.FLIPPER_WIDTH * i, old = rows + this.block[row + at.AT], begin = own + ROOM * at.PIECE_WIDTH * i;
      this.block.copyWithin(begin, old, old + at.PIECE_WIDTH);
      this.block[row + at.AT] = begin - rows;
      const motion = new Float64Array(3 * ROOM);
      motion[1] = thing.shape.rest;
      this.#flippers.push({ motion, count: 1, thing, down: false });
    });
    this.#resting = this.block.slice();
  }

  get names() {
    return this.table.objects.map((one) => one.name);
  }

  /** The numbers of the table with all flippers at rest. */
  get atRest() {
    return this.#resting.slice();
  }

  get flippers() {
    return this.#flippers.map((one) => one.thing.name);
  }

  /** Whether a ball is in play. */
  get alive() {
    return !this.end && this.#now[1] !== -2;
  }

  /** A parameter's value. @param {string} name */
  value(name) {
    return this.values[this.table.params.indexOf(name)];
  }

  /** Whether a number can be changed here: those of laws, the tilt and gravity, and where discs stand. @param {Table} table @param {string} name */
  static canSet({ objects, params }, name) {
    const [front, last] = name.split("."), one = objects.find((each) => each.name === front);
    return params.includes(name) && (name === "tilt" || name === "g" || Boolean(one?.law?.params.includes(last)) || (one?.kind === "disc" && (last === "x" || last === "y")));
  }

  /** Change a number that `canSet` allows. @param {string} name @param {number} value */
  set(name, value) {
    const { table } = this, [front, last] = name.split("."), j = this.names.indexOf(front);
    const moved = this.things[j]?.kind === "disc" && (last === "x" || last === "y");
    if (moved) this.things[j].shape[last] = value;
    this.values[table.params.indexOf(name)] = value;
    for (const block of [this.block, this.#resting]) {
      block[table.row + table.params.indexOf(name)] = value;
      if (moved) block[this.#circle(j) + (last === "x" ? this.layout.PX : this.layout.PY)] = value;
      if (name === "tilt" || name === "g") block[this.layout.GRAVITY] = this.machine.call("gravity", { g: this.value("g"), tilt: this.value("tilt") }).result;
    }
    this.changed = this.changed || this.t > 0;
  }

  /** Where the circle of a disc stands in a block. @param {number} j */
  #circle(j) {
    const at = this.layout, first = at.HEAD + at.THING * this.things.length + at.WIDTH * this.block[at.FACES];
    for (let i = 0; i < this.block[at.CIRCLES]; i++) if (this.block[first + at.WIDTH * i + at.OWNER] === j) return first + at.WIDTH * i;
    throw new Error(`${this.names[j]} has no circle`);
  }

  /** Take the ball away. */
  clear() {
    this.launch([0, 0, 0, 0]);
    this.#now[1] = -2;
  }

  /** Launch a ball; flippers begin at rest. @param {State} state */
  launch(state) {
    this.start = [...state];
    this.block.set(this.#resting);
    for (const one of this.#flippers) {
      one.count = 1;
      one.down = false;
    }
    this.presses = Object.fromEntries(this.flippers.map((name) => [name, []]));
    this.nudges = [];
    this.#now = Float64Array.from([0, -1, ...state]);
    this.hits = [];
    this.ghosts = this.places = new Float64Array(0);
    this.t = this.unsure = 0;
    this.end = "";
    this.changed = false;
  }

  /** Press or release the button of a flipper, now. @param {number} i @param {boolean} down */
  press(i, down, now = this.t) {
    const one = this.#flippers[i], { rest, raised, up, down: back } = one.thing.shape;
    const last = this.presses[one.thing.name]?.at(-1) ?? -Infinity;
    if (one.down === down) return;
    if (one.count > ROOM - 3) this.#forget(one);
    if (one.count > ROOM - 3) return;
    const t = now > last ? now : last + INSTANT; // pressed and released between two frames
    one.down = down;
    this.presses[one.thing.name]?.push(t);
    const way = Math.sign(raised - rest), goal = down ? raised : rest, rate = down ? way * up : -way * back;
    const { result, block, motion } = this.machine.call("pressed",
      { numbers: this.block.length, capacity: ROOM, block: this.block, flipper: i, motion: one.motion, pieces: one.count, t, goal, rate }, ["block", "motion"]);
    one.count = result;
    one.motion = motion;
    this.block = block;
  }

  /** Nudge the table: a ball in the air is that much faster. Whether it was; one that lies on something is not. @param {number} vx @param {number} vy */
  nudge(vx, vy) {
    if (!this.alive || this.slides || !(this.t > this.#now[0] + INSTANT)) return false;
    const [x, y, u, v] = this.place;
    this.leap({ t: this.t, state: [x, y, u + vx, v + vy] });
    for (let i = 0; i < this.ghosts.length; i += BALL) {
      if (this.ghosts[i + FLAGS] & (this.bits.fatal | this.bits.escaped) || !Number.isInteger(this.ghosts[i + 1])) continue;
      const [a, b, p, q] = this.places.subarray((4 * i) / BALL);
      this.ghosts.set([this.t, -1, a, b, p + vx, q + vy], i);
    }
    return true;
  }

  /** Go on from a nudge. @param {Nudge} nudge */
  leap({ t, state }) {
    this.nudges.push({ t, state: [...state] });
    this.#now = Float64Array.of(t, -1, ...state);
  }

  /** Whether the table has been nudged too often: its flippers are dead until the next ball. */
  get tilted() {
    return this.nudges.some(({ t }, i) => t - (this.nudges[i - NUDGES + 1]?.t ?? -Infinity) < CALM);
  }

  /** Forget how a flipper moved before the flights that are under way. @param {{motion: Floats, count: number}} one */
  #forget(one) {
    let since = this.#now[0], gone = 0;
    for (let i = 0; i < this.ghosts.length; i += BALL) {
      if (!(this.ghosts[i + FLAGS] & (this.bits.fatal | this.bits.escaped))) since = Math.min(since, this.ghosts[i]);
    }
    while (gone + 1 < one.count && one.motion[3 * (gone + 1)] <= since) gone += 1;
    one.motion.copyWithin(0, 3 * gone, 3 * one.count);
    one.count -= gone;
  }

  /** The angle of a flipper at a time. @param {string} name */
  angle(name, t = this.t) {
    const one = this.#flippers.find((each) => each.thing.name === name);
    if (!one) return 0;
    let n = one.count - 1;
    while (n > 0 && one.motion[3 * n] > t) n -= 1;
    const [begin, angle, omega] = one.motion.subarray(3 * n, 3 * n + 3);
    return omega ? angle + omega * (t - begin) : angle;
  }

  /** Whether a flipper is on its way. @param {string} name */
  turns(name) {
    return this.angle(name, this.t) !== this.angle(name, this.t - INSTANT);
  }

  /** Move on to a time; returns the impacts since. @param {number} until */
  advance(until) {
    const { block, bits } = this, numbers = block.length, from = this.hits.length;
    for (let more = true; more && this.alive;) {
      const { result, flights, now } = this.machine.call("record",
        { numbers, capacity: CAPACITY, block, now: this.#now, flights: new Float64Array(CAPACITY * WIDTH), until }, ["flights", "now"]);
      let begun = this.#now[0];
      this.#now = now;
      const rows = Math.abs(result);
      more = result === CAPACITY;
      for (let k = 0; k < rows; k++) {
        const row = flights.subarray(k * WIDTH, (k + 1) * WIDTH), said = row[SAID];
        if (said & bits.fatal) this.end = "stopped";
        if (this.end || !(begun + row[TIME] <= until)) break; // the last one is under way
        begun += row[TIME];
        if (said & bits.escaped) {
          this.end = row[OWNER] >= 0 ? this.names[row[OWNER]] : "away";
          this.#now = Float64Array.from([begun, -1, ...row.subarray(LAST, LAST + 4)]);
          break;
        }
        if (row[OWNER] >= 0) this.hits.push({ t: begun, owner: row[OWNER], before: row[BEFORE], x: row[LAST], y: row[LAST + 1] });
        if (said & bits.ambiguous && result < 0 && k === rows - 1) {
          // Python decides this exactly; here the ball goes on as doubles have it
          this.unsure += 1;
          this.#now = Float64Array.from([begun, row[SURFACE] + (row[OWNER] >= 0 ? 0 : this.layout.ON), ...row.subarray(NEXT, NEXT + 4)]);
          more = true;
        }
      }
      if (this.hits.length >= HITS) this.end ||= "too often";
    }
    this.t = this.end ? Math.max(this.t, Math.min(until, this.#now[0])) : until;
    this.#ghosts();
    return this.hits.slice(from);
  }

  /** The state of the ball now. @returns {State} */
  get place() {
    const { state } = this.machine.call("place", { numbers: this.block.length, block: this.block, now: this.#now, until: this.end ? this.#now[0] : this.t }, ["state"]);
    return /** @type {State} */ (/** @type {unknown} */ (state));
  }

  /** Whether the ball slides or rests on something. */
  get slides() {
    return !Number.isInteger(this.#now[1]);
  }

  /** The flight under way: its state at the begin, and how long it has lasted. */
  get flight() {
    return { state: Float64Array.from(this.#now.subarray(2, 6)), length: this.t - this.#now[0], begin: this.#now[0] };
  }

  /** Let balls fly beside this one, each turned by a little; the least turn is `small`. @param {number} many @param {number} small in radians */
  fan(many, small) {
    const [x, y, vx, vy] = this.flight.state, speed = Math.hypot(vx, vy), angle = Math.atan2(vy, vx), { begin } = this.flight;
    this.ghosts = new Float64Array(many * BALL);
    for (let i = 0; i < many; i++) {
      const turn = small * (i - (many - 1) / 2), a = angle + turn;
      this.ghosts.set([begin, this.#now[1], x, y, speed * Math.cos(a), speed * Math.sin(a), 0, -1, 0], i * BALL);
    }
    this.#ghosts();
  }

  #ghosts() {
    const many = this.ghosts.length / BALL;
    if (!many) return;
    const found = this.machine.call("follow",
      { numbers: this.block.length, many, block: this.block, balls: this.ghosts, until: this.t, most: MOST, places: new Float64Array(4 * many) }, ["balls", "places"]);
    this.ghosts = found.balls;
    this.places = found.places;
  }

  /** The ghosts that still fly: their places. @returns {[number, number][]} */
  get flying() {
    /** @type {[number, number][]} */
    const found = [];
    for (let i = 0; i < this.ghosts.length / BALL; i++) {
      if (!(this.ghosts[i * BALL + FLAGS] & (this.bits.fatal | this.bits.escaped))) found.push([this.places[4 * i], this.places[4 * i + 1]]);
    }
    return found;
  }

  /** The logarithm of the ghosts' mean distance from the ball, NaN for none. */
  get spread() {
    const [x, y] = this.place, near = this.flying.map(([a, b]) => Math.hypot(a - x, b - y)).filter((d) => d > 0);
    return near.length ? near.reduce((sum, d) => sum + Math.log(d), 0) / near.length : NaN;
  }

  /** What is changed on the table, by name. @returns {Record<string, number>} */
  get changes() {
    return Object.fromEntries(this.table.params.map((name, i) => [name, this.values[i]]).filter(([, value], i) => value !== this.table.values[i]));
  }
}

