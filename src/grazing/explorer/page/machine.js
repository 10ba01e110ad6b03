// @ts-check
/** Call the kernels: numbers as they are, arrays by address. How a module is called is said in kernels.json. */

const VIEWS = { float64: Float64Array, int64: BigInt64Array, int32: Int32Array, int8: Int8Array };
const PAGE = 65536;

/** A size: a number, a name, or a name plus a number. */
function whole(expression, known) {
  if (typeof expression === "number") return expression;
  const [name, more] = expression.split(" + ");
  return Number(known[name]) + Number(more ?? 0);
}

export class Machine {
  /**
   * @param {WebAssembly.Instance} instance
   * @param {any} described the module's part of kernels.json
   */
  constructor(instance, described) {
    this.exports = /** @type {any} */ (instance.exports);
    this.described = described;
    this.fields = described.fields.map((field) => field.name);
    this.functions = new Map(described.functions.map((each) => [each.name, each]));
  }

  /**
   * Call a function. `given` holds sizes, numbers and the arrays that are read; arrays left out begin with zeros.
   * Returns copies of the arrays named in `wanted`, and `result`.
   */
  call(name, given, wanted = []) {
    const called = this.functions.get(name);
    let free = this.exports.__heap_base.value;
    const values = called.sizes.map((size) => given[size]);
    const places = [];
    for (const { name: key, kind, shape } of called.arguments) {
      if (!shape.length) {
        values.push(given[key]); // whole numbers are 32 bits wide, whatever their kind
        continue;
      }
      const length = shape.reduce((product, size) => product * whole(size, given), 1);
      const view = VIEWS[kind];
      if (given[key] && given[key].length !== length) throw new RangeError(`${name}: ${key} has ${given[key].length} numbers, not ${length}`);
      const place = Math.ceil(free / 64) * 64;
      free = place + length * view.BYTES_PER_ELEMENT;
      places.push({ key, view, place, length });
      values.push(place);
    }
    const memory = this.exports.memory;
    const missing = Math.ceil(free / PAGE) - memory.buffer.byteLength / PAGE;
    if (missing > 0) memory.grow(missing);
    for (const { key, view, place, length } of places) {
      const array = new view(memory.buffer, place, length);
      if (given[key]) array.set(given[key]);
      else array.fill(/** @type {never} */ (view === BigInt64Array ? 0n : 0));
    }
    this.exports.arena(free);
    const found = { result: this.exports[name](...values) };
    for (const { key, view, place, length } of places) {
      if (wanted.includes(key)) found[key] = new view(memory.buffer, place, length).slice();
    }
    return found;
  }
}
