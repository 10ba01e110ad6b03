// @ts-check
/** What is computed: rasters, classes of orbits, the normal form. The same code runs in workers and in the page. */

import { inside, wallsOf } from "./walls.js";

/** @typedef {import("./machine.js").Machine} Machine */
/** @typedef {import("./machine.js").Floats} Floats */
/**
 * Columns: a row of parameters, of which the one numbered `which` takes the `values`.
 * @typedef {{row: Floats, which: number, values: Floats, seed: number}} Columns
 */
/** @typedef {{starts: number, transient: number, keep: number}} Steps */
/** @typedef {{low: number, high: number, bins: number, coordinate: number}} Range */

/** The numbers of numpy's linspace, to the bit. @param {number} from @param {number} to @param {number} count */
export function linspace(from, to, count) {
  const step = (to - from) / (count - 1);
  const values = Float64Array.from({ length: count }, (_, i) => i * step + from);
  if (count > 1) values[count - 1] = to;
  return values;
}

/** One row of parameters for each value of one of them. @param {Floats} row @param {number} which @param {Floats} values */
function rowsOf(row, which, values) {
  const rows = new Float64Array(values.length * row.length);
  values.forEach((value, q) => {
    rows.set(row, q * row.length);
    rows[q * row.length + which] = value;
  });
  return rows;
}

/** Random starts. @param {Machine} machine @param {Floats} rows @param {Floats} values @param {number} starts @param {number} seed */
function drawn(machine, rows, values, starts, seed) {
  const columns = values.length;
  const { boxes } = machine.call("boxes", { columns, rows }, ["boxes"]);
  return machine.call("draw", { columns, starts, axes: 1, seed, names: values, boxes }, ["lanes"]).lanes;
}

/** Orbits and steps of a column that are asked for their periods. */
const ASKED = 8, SEEN = 64;

/**
 * Counts (columns, bins + 3): below, the parts of the range, above, what is no number; with `colour` periods. `into` may
 * be where the counts go.
 * @param {Machine} machine
 * @param {Columns & Steps & Range & {colour?: boolean, tolerance: number, into?: {counts: Int32Array<ArrayBuffer>}}} job
 */
export function raster(machine, job) {
  const { row, which, values, low, high, bins, coordinate, starts, transient, keep, seed, colour } = job;
  const columns = values.length, rows = rowsOf(row, which, values);
  const { counts, ended, ambiguous, lanes } = machine.call(
    "density",
    { columns, starts, rows, lanes: drawn(machine, rows, values, starts, seed), transient, keep, coordinate, low, high, bins },
    ["counts", "ended", "ambiguous", "lanes"],
    job.into,
  );
  return { counts, ended, ambiguous, codes: colour ? codesOf(machine, job, rows, lanes) : undefined };
}

/** Follow orbits and find what they settle on. @param {Machine} machine @param {Steps & {columns: number, rows: Floats, lanes: Floats, tolerance: number}} job */
function settled(machine, { columns, rows, lanes, starts, transient, keep, tolerance }) {
  const sizes = { columns, starts, keep };
  const orbits = machine.call("orbits", { ...sizes, rows, lanes, transient }, ["points", "letters", "outcomes"]);
  const classes = machine.call("classify", { ...sizes, rows, ...orbits, tolerance }, ["period", "key", "begin", "length"]);
  const ranks = machine.call("rank", { columns, starts, period: classes.period, key: classes.key }, ["count", "first"]);
  return { ...orbits, ...classes, ...ranks };
}

/**
 * The period of the orbits that go on from `lanes` through each part of the raster; 0 where none was found.
 * @param {Machine} machine @param {Parameters<typeof raster>[1]} job @param {Floats} rows @param {Floats} lanes
 */
function codesOf(machine, { values, low, high, bins, coordinate, starts, tolerance }, rows, lanes) {
  const dimension = machine.described.coordinates.length, columns = values.length, few = Math.min(ASKED, starts);
  const first = lanes.filter((_, i) => i % starts < few);
  const { period, points } = settled(machine, { columns, rows, lanes: first, starts: few, transient: 0, keep: SEEN, tolerance });
  const codes = new Uint8Array(columns * bins), scale = bins / (high - low);
  for (let q = 0; q < columns; q++) {
    for (let j = 0; j < few; j++) {
      const N = period[q * few + j];
      for (let n = 0; n < Math.min(N, SEEN); n++) {
        const x = points[((q * SEEN + n) * dimension + coordinate) * few + j];
        if (x >= low && x <= high) codes[q * bins + Math.min(Math.floor((x - low) * scale), bins - 1)] = Math.min(N, 255);
      }
    }
  }
  return codes;
}

export const CHATTER = -1;
/** Letters as Python writes them: impacts in a step, above 9 as (12), C for completed chatter, S for rest on the wall. @param {number[]} letters */
export const written = (letters) => letters.map((k) => (k === CHATTER ? "C" : k < 0 ? "S" : k > 9 ? `(${k})` : String(k))).join("");

/** More impacts between two walls than a letter tells apart. */
const MANY = -5;
/** The walls that are hit in a step between two, in order. @param {number} letter @returns {string} */
const walls = (letter) => (letter > 0 ? walls(Math.floor(letter / 3)) + "0AB"[letter % 3] : "");
/** Letters between two walls as Python writes them: the walls that are hit, (CA) for chatter completed at A, (SA) for rest on it. @param {number[]} letters */
function between(letters) {
  return letters.map((k) => (k === MANY ? "(more)" : k < 0 ? `(${"CS"[(-k - 1) % 2]}${"AB"[(-k - 1) >> 1]})` : k === 0 ? "0" : k < 3 ? walls(k) : `(${walls(k)})`)).join("");
}

/** Whether a row of parameters has two walls. @param {Machine} machine @param {Floats} row */
const two = (machine, row) => row[machine.fields.indexOf("two")] === 1;

/** What spells letters as Python does. @param {Machine} machine @param {Floats} row @returns {(letters: number[]) => string} */
function speller(machine, row) {
  const { letters: names } = machine.described, each = names && [...names];
  return each ? (letters) => letters.map((k) => each[k]).join("") : two(machine, row) ? between : written;
}

/** A word in its least rotation. @param {number[]} letters */
function least(letters) {
  const turns = letters.map((_, i) => [...letters.slice(i), ...letters.slice(0, i)]);
  turns.sort((a, b) => {
    const at = a.findIndex((letter, i) => letter !== b[i]);
    return at < 0 ? 0 : a[at] - b[at];
  });
  return turns[0] ?? [];
}

/**
 * Orbits of one period and word, with one cycle; `impacts` in the word, null where they are not counted, undefined where letters count none.
 * @typedef {{period: number, word: string, share: number, starts: number, points: number[][], impacts: number | null | undefined, length: number, multiplier?: number}} Class
 */

/** Starts of a map: its steps cost little, and few starts miss an orbit that one in ten reaches. */
export const DRAWN = 64;

/**
 * The classes of orbits that random starts settle on at one parameter value, most starts first.
 * @param {Machine} machine
 * @param {{row: Floats, which: number, value: number, starts?: number, transient: number, keep?: number, seed: number, tolerance: number}} job
 */
export function found(machine, { row, which, value, starts = 16, transient, keep = 128, seed, tolerance }) {
  const values = Float64Array.of(value), rows = rowsOf(row, which, values);
  const made = settled(machine, { columns: 1, rows, lanes: drawn(machine, rows, values, starts, seed), starts, transient, keep, tolerance });
  const dimension = machine.described.coordinates.length;
  /** @type {Class[]} */
  const classes = [];
  for (let i = 0; i < starts && made.count[i] > 0; i++) {
    const j = made.first[i];
    const period = made.period[j];
    const begin = made.begin[j] - Math.max(period, 0); // the letters repeat, and here none of the word lies beyond the end
    const letters = Array.from({ length: made.length[j] }, (_, n) => made.letters[(begin + n) * starts + j]);
    const pair = two(machine, row), word = speller(machine, row)(least(letters));
    const length = period > 0 ? Math.min(period, keep) : keep;
    const points = Array.from({ length }, (_, n) => Array.from({ length: dimension }, (_, d) => made.points[(n * dimension + d) * starts + j]));
    const impacts = letters.every((k) => k >= 0) ? letters.reduce((sum, k) => sum + (pair ? walls(k).length : k), 0) : null;
    classes.push({ period, word, share: made.count[i] / starts, starts, points, impacts: machine.fields.includes("two") ? impacts : undefined, length: letters.length });
  }
  return classes;
}

/** A coordinate of orbits, column by column, and where random starts are drawn. @param {Machine} machine @param {Columns & Steps & {coordinate: number}} job */
export function points(machine, { row, which, values, coordinate, starts, transient, keep, seed }) {
  const dimension = machine.described.coordinates.length, columns = values.length, rows = rowsOf(row, which, values);
  const { points: all } = machine.call("orbits", { columns, starts, keep, rows, lanes: drawn(machine, rows, values, starts, seed), transient }, ["points"]);
  const seen = Float64Array.from({ length: columns * keep * starts }, (_, i) => all[(Math.floor(i / starts) * dimension + coordinate) * starts + (i % starts)]);
  return { seen, box: machine.call("boxes", { columns, rows }, ["boxes"]).boxes.slice(2 * coordinate, 2 * coordinate + 2) };
}

/** Where points are, and a little more. @param {({from: number} & ReturnType<typeof points>)[]} found @returns {[number, number]} */
export function extent(found) {
  let low = Infinity, high = -Infinity;
  for (const { seen } of found) for (const x of seen.filter(Number.isFinite)) [low, high] = [Math.min(low, x), Math.max(high, x)];
  if (!(low <= high)) [low, high] = found.sort((a, b) => a.from - b.from)[0].box;
  const room = 0.05 * (high - low) || 1e-3 * (Math.abs(high) || 1);
  return outwards(low - room, high + room);
}

/** An interval with no more digits than its width needs, and nothing of it lost. @param {number} low @param {number} high @returns {[number, number]} */
export function outwards(low, high) {
  const places = 3 - Math.floor(Math.log10(high - low));
  const unit = 10 ** Math.abs(places);
  const step = (/** @type {number} */ value, /** @type {(value: number) => number} */ to) => (places < 0 ? to(value / unit) * unit : to(value * unit) / unit);
  const ends = /** @type {[number, number]} */ ([step(low, Math.floor), step(high, Math.ceil)]);
  return ends[0] <= low && ends[1] >= high && places < 15 ? ends : [low, high];
}

/** Points, so many in a column, counted as `raster` counts them. @param {Floats} seen @param {number} each @param {Omit<Range, "coordinate">} range */
export function counted(seen, each, { low, high, bins }) {
  const counts = new Int32Array((seen.length / each) * (bins + 3)), scale = bins / (high - low);
  seen.forEach((x, i) => {
    const at = x < low ? 0 : x <= high ? 1 + Math.min(Math.floor((x - low) * scale), bins - 1) : x > high ? bins + 1 : bins + 2;
    counts[Math.floor(i / each) * (bins + 3) + at] += 1;
  });
  return counts;
}

/**
 * The normal form at the nearest graze in one parameter, or null.
 * @param {Machine} machine
 * @param {Floats} row
 * @param {number} which
 * @param {import("./machine.js").Field} field that parameter
 */
export function normalForm(machine, row, which, field) {
  const far = 1e3 * Math.max(1, Math.abs(row[which]));
  const low = field.low ?? row[which] - far, high = field.high ?? row[which] + far;
  const graze = machine.call("graze", { row, which, low, high, open_low: field.open_low ? 1 : 0 }).result;
  if (!Number.isFinite(graze)) return null;
  const at = Float64Array.from(row);
  at[which] = graze;
  const { numbers } = machine.call("reduce", { row: at }, ["numbers"]);
  const [time, acceleration, lam, l, b, det, scale] = numbers;
  if (!(Number.isFinite(lam) && Number.isFinite(l))) return null;
  const factor = numbers[12];
  const mu = (/** @type {Floats} */ values) => {
    const { heights } = machine.call("clearance", { count: values.length, row: at, which, values }, ["heights"]);
    return heights.map((height) => factor * height);
  };
  return { graze, time, acceleration, lam, l, b, det, scale, mu };
}

/**
 * The period that most starts settle on, for pairs of two parameters' values; 0 where none was found.
 * @param {Machine} machine
 * @param {Omit<Columns, "which"> & Steps & {which: number[], tolerance: number}} job
 */
export function chart(machine, { row, which, values, starts, transient, keep, seed, tolerance }) {
  const columns = values.length / 2;
  const rows = new Float64Array(columns * row.length);
  for (let q = 0; q < columns; q++) {
    rows.set(row, q * row.length);
    rows[q * row.length + which[0]] = values[2 * q];
    rows[q * row.length + which[1]] = values[2 * q + 1];
  }
  const { boxes } = machine.call("boxes", { columns, rows }, ["boxes"]);
  const { lanes } = machine.call("draw", { columns, starts, axes: 2, seed, names: values, boxes }, ["lanes"]);
  const { period, first } = settled(machine, { columns, rows, lanes, starts, transient, keep, tolerance });
  return { codes: Uint8Array.from({ length: columns }, (_, q) => Math.min(254, Math.max(0, period[q * starts + first[q * starts]]))) };
}

/** @typedef {{period: number, word: string, point: number[]}} Reached an attractor, or a kind of orbit without a period */

/** @param {number} n @param {number} N */
const modulo = (n, N) => ((n % N) + N) % N;

/**
 * Follow initial states and say what each reaches: the number of a row of `reached`.
 * @param {Machine} machine
 * @param {{row: Floats, values: Floats, transient: number, keep: number, tolerance: number, same: Floats}} given
 */
export function basins(machine, { row, values, transient, keep, tolerance, same }) {
  const dimension = machine.described.coordinates.length, starts = values.length / dimension;
  const lanes = values.map((_, i) => values[(i % starts) * dimension + Math.floor(i / starts)]);
  const sizes = { columns: 1, starts, keep };
  const orbits = machine.call("orbits", { ...sizes, rows: row, lanes, transient }, ["points", "letters", "outcomes"]);
  const classes = machine.call("classify", { ...sizes, rows: row, ...orbits, tolerance }, ["period", "key", "begin", "length"]);
  const { label } = machine.call("attractors", { ...sizes, points: orbits.points, ...classes, same }, ["label"]);
  /** @type {Map<number, number>} */
  const rows = new Map();
  /** @type {Reached[]} */
  const reached = [];
  const which = new Int32Array(starts);
  for (let j = 0; j < starts; j++) {
    let k = rows.get(label[j]);
    if (k === undefined) {
      k = reached.length;
      rows.set(label[j], k);
      reached.push(described(orbits, classes, starts, keep, j, dimension, speller(machine, row)));
    }
    which[j] = k;
  }
  return { which, reached };
}

/** What an orbit is on: period, word, and the point at which the word begins, of several the first in order. @param {any} orbits @param {any} classes @param {number} starts @param {number} keep @param {number} j @param {number} dimension @param {(letters: number[]) => string} spelled @returns {Reached} */
function described({ points, letters }, { period, begin, length }, starts, keep, j, dimension, spelled) {
  const N = period[j], p = length[j], start = keep - N;
  if (N < 1) return { period: N, word: "", point: [] };
  const point = (/** @type {number} */ turn) => Array.from({ length: dimension }, (_, i) => points[(dimension * turn + i) * starts + j]);
  const turns = Array.from({ length: N / p }, (_, k) => point(start + modulo(begin[j] - 1 - start + k * p, N)));
  turns.sort((a, b) => a.reduce((sign, x, i) => sign || x - b[i], 0));
  const word = Array.from({ length: p }, (_, n) => letters[(start + modulo(begin[j] - start + n, N)) * starts + j]);
  return { period: N, word: spelled(word), point: turns[0] };
}

/**
 * Launch balls at many angles and speeds: the drain through which each leaves, and its impacts.
 * @param {Machine} machine
 * @param {{block: Floats, x: number, y: number, most: number, angle: Floats, speed: Floats}} job
 */
export function exits(machine, job) {
  const { ways, hits } = machine.call("fan", { numbers: job.block.length, angles: job.angle.length, speeds: job.speed.length, ...job }, ["ways", "hits"]);
  return { ways: Int32Array.from(ways, Number), hits: Int32Array.from(hits, Number) };
}

/**
 * A ball that is carried along the values of a parameter, and one that is carried back: `keep` positions at each value, on the way up
 * and on the way down. Each way begins with a random start; where an orbit ends, another one begins.
 * @param {Machine} machine
 * @param {{row: Floats, which: number, values: Floats, seed: number, transient: number, keep: number}} job
 */
export function sweep(machine, { row, which, values, seed, transient, keep }) {
  const rows = rowsOf(row, which, values), all = drawn(machine, rows, values, 1, seed), width = row.length, phase = row[machine.fields.indexOf("phase")];
  const way = (/** @type {number[]} */ order) => {
    const found = new Float64Array(values.length * keep).fill(NaN);
    let lanes = Float64Array.of(NaN, NaN);
    for (const q of order) {
      const at = rows.subarray(q * width, (q + 1) * width);
      if (!lanes.every(Number.isFinite)) lanes = all.slice(2 * q, 2 * q + 2);
      lanes[0] = inside(wallsOf(machine.fields, at), lanes[0], phase);
      const { points } = machine.call("orbits", { columns: 1, starts: 1, keep, rows: at, lanes, transient }, ["points"]);
      for (let n = 0; n < keep; n++) found[q * keep + n] = points[2 * n];
      lanes = points.slice(-2);
    }
    return found;
  };
  const order = Array.from(values, (_, q) => q);
  return { up: way(order), down: way([...order].reverse()) };
}

export const JOBS = { raster, points, chart, basins, found, sweep, exits };
