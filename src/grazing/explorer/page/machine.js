// @ts-check
/** Call the kernels: numbers as they are, arrays by address. How a module is called is said in kernels.json. */

/** @typedef {{name: string, kind: "float64" | "int64" | "int32" | "int8", shape: (string | number)[], meaning: string}} Argument */
/** @typedef {{name: string, sizes: string[], arguments: Argument[], result: string, meaning: string}} Described */
/**
 * A parameter, or a choice, which has `choices` and no limits; null for no limit.
 * @typedef {{name: string, meaning: string, symbol?: string, units?: string, low?: number | null, high?: number | null, open_low?: boolean, choices?: string[]}} Field
 */
/** `calls` is where the server computes, in place of a module. @typedef {{file: string, calls?: string, coordinates: string[], letters: string | null, fields: Field[], functions: Described[]}} Module */
/** @typedef {{tolerance: number, modules: Record<string, Module>, model?: import("./laws.js").Model}} Kernels what kernels.json says, as far as the page reads it */

/** @typedef {Float64Array<ArrayBuffer> | BigInt64Array<ArrayBuffer> | Int32Array<ArrayBuffer> | Int8Array<ArrayBuffer>} Numbers */
/** @typedef {Float64Array<ArrayBuffer>} Floats */
/** @typedef {Int32Array<ArrayBuffer>} Whole */
/**
 * The arrays of the kernels by their names, which have the same kind in all functions.
 * @typedef {{
 *   boxes: Floats, lanes: Floats, corners: Floats, points: Floats, table: Floats, state: Floats, legs: Floats, u: Floats, v: Floats,
 *   block: Floats, now: Floats, flights: Floats, balls: Floats, places: Floats, motion: Floats, angle: Floats, speed: Floats, times: Floats,
 *   ways: BigInt64Array<ArrayBuffer>, hits: BigInt64Array<ArrayBuffer>, said: BigInt64Array<ArrayBuffer>,
 *   heights: Floats, numbers: Floats, counts: Whole, ended: Whole, ambiguous: Whole, letters: Whole, outcomes: Whole,
 *   period: Whole, begin: Whole, length: Whole, count: Whole, first: Whole, label: Whole, key: BigInt64Array<ArrayBuffer>,
 * }} Arrays
 */
/** @typedef {Record<string, number | Numbers>} Given */

const VIEWS = { float64: Float64Array, int64: BigInt64Array, int32: Int32Array, int8: Int8Array };
const PAGE = 65536;

/** A size: a number, a name, or a name plus a number. @param {string | number} expression @param {Given} known */
function whole(expression, known) {
  if (typeof expression === "number") return expression;
  const [name, more] = expression.split(" + ");
  return Number(known[name]) + Number(more ?? 0);
}

export class Machine {
  /** @param {WebAssembly.Instance} instance @param {Module} described the module's part of kernels.json */
  constructor(instance, described) {
    this.exports = /** @type {any} */ (instance.exports);
    this.described = described;
    this.fields = described.fields.map((field) => field.name);
    this.functions = new Map(described.functions.map((each) => [each.name, each]));
  }

  /** Where the first array of a call lies. */
  get first() {
    return Math.ceil(this.exports.__heap_base.value / 64) * 64;
  }

  /**
   * Call a function. `given` holds sizes, numbers and the arrays that are read; arrays left out begin with zeros,
   * but those of `into`, which a function fills. Returns copies of the arrays named in `wanted`, in those of `into`
   * where these are, and `result`.
   * @template {keyof Arrays} [Name=never]
   * @param {string} name
   * @param {Given} given
   * @param {Name[]} wanted
   * @param {Partial<Arrays>} into
   * @returns {Pick<Arrays, Name> & {result: number}}
   */
  call(name, given, wanted = [], into = {}) {
    const called = this.functions.get(name);
    if (!called) throw new RangeError(`the module has no function ${name}`);
    let free = this.first;
    /** @type {(number | Numbers)[]} */
    const values = called.sizes.map((size) => given[size]);
    const places = [];
    for (const { name: key, kind, shape } of called.arguments) {
      if (!shape.length) {
        values.push(given[key]); // whole numbers are 32 bits wide, whatever their kind
        continue;
      }
      const length = shape.reduce((/** @type {number} */ product, size) => product * whole(size, given), 1);
      const view = VIEWS[kind];
      const array = /** @type {Numbers | undefined} */ (given[key]);
      if (array && array.length !== length) throw new RangeError(`${name}: ${key} has ${array.length} numbers, not ${length}`);
      const place = Math.ceil(free / 64) * 64;
      free = place + length * view.BYTES_PER_ELEMENT;
      places.push({ key, view, place, length, array });
      values.push(place);
    }
    const memory = this.exports.memory;
    const missing = Math.ceil(free / PAGE) - memory.buffer.byteLength / PAGE;
    if (missing > 0) memory.grow(missing);
    for (const { key, view, place, length, array } of places) {
      const there = new view(memory.buffer, place, length);
      if (array) there.set(/** @type {never} */ (array));
      else if (!(key in into)) there.fill(/** @type {never} */ (view === BigInt64Array ? 0n : 0));
    }
    this.exports.arena(free);
    /** @type {Record<string, any>} */
    const found = { result: this.exports[name](...values) };
    for (const { key, view, place, length } of places) {
      if (!wanted.includes(/** @type {Name} */ (key))) continue;
      const there = new view(memory.buffer, place, length), here = into[/** @type {Name} */ (key)];
      here?.set(/** @type {never} */ (there));
      found[key] = here ?? there.slice();
    }
    return /** @type {any} */ (found);
  }
}

/** Calls kernels where the server computes, at once as in a module: the page waits for the answer. */
class Served extends Machine {
  /** @param {Module} described */
  constructor(described) {
    super(/** @type {any} */ ({ exports: {} }), described);
    this.address = new URL(`..${described.calls}`, location.href).href;
  }

  /**
   * @template {keyof Arrays} [Name=never]
   * @param {string} name @param {Given} given @param {Name[]} wanted
   * @returns {Pick<Arrays, Name> & {result: number}}
   */
  call(name, given, wanted = []) {
    const arrays = (this.functions.get(name)?.arguments ?? []).filter(({ shape }) => shape.length), read = arrays.filter((each) => given[each.name]);
    const head = { name, numbers: Object.fromEntries(Object.entries(given).filter(([, value]) => typeof value === "number")), given: read.map((each) => each.name), wanted };
    const text = new TextEncoder().encode(JSON.stringify(head));
    const parts = [Uint32Array.of(text.length), text, ...read.map((each) => /** @type {Numbers} */ (given[each.name]))];
    const request = new XMLHttpRequest();
    request.open("POST", this.address, false);
    request.setRequestHeader("Content-Type", "application/octet-stream");
    request.overrideMimeType("text/plain; charset=x-user-defined"); // bytes as letters: a page that waits gets nothing else
    try {
      request.send(new Blob(parts));
    } catch {
      throw new Error("the server, which computes a law of your own, does not answer: run “grazing explore” again");
    }
    const bytes = Uint8Array.from(request.responseText, (letter) => letter.charCodeAt(0));
    if (request.status !== 200) throw new Error(new TextDecoder().decode(bytes));
    /** @type {Record<string, any>} */
    const found = { result: new Float64Array(bytes.buffer, 0, 1)[0] };
    let from = 8;
    for (const { name: key, kind, shape } of arrays.filter((each) => wanted.includes(/** @type {Name} */ (each.name)))) {
      const length = shape.reduce((/** @type {number} */ product, size) => product * whole(size, given), 1), view = VIEWS[kind];
      found[key] = new view(bytes.slice(from, (from += length * view.BYTES_PER_ELEMENT)).buffer);
    }
    return /** @type {any} */ (found);
  }
}

/** What calls kernels: a module that runs here, or the server in its place. @param {WebAssembly.Module | null} module @param {Module} described */
export const machineOf = (module, described) => (module ? new Machine(new WebAssembly.Instance(module, {}), described) : new Served(described));
