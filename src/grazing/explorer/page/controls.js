// @ts-check
/** Sliders with number fields, made from the descriptions of parameters in kernels.json. */
import { WORDS, pieces } from "./names.js";
import { refusal, tidy } from "./state.js";

/** @typedef {import("./machine.js").Field} Field */
/** @typedef {[number, number]} Pair */
/** @typedef {(text: string) => void} Say */
/** @typedef {{box: HTMLElement, set: (value: any) => void, name?: (text: string) => void, offer?: (values: string[]) => void, span?: (ends: Pair | null, band?: string) => void}} Control its place on the page; `set` shows a value, `name` its name, `offer` what can be chosen, `span` where a slider ends, with a picture of what lies between */

/** @type {Record<string, string>} */
const GREEK = { alpha: "α", beta: "β", gamma: "γ", delta: "δ", lambda: "λ", mu: "μ", nu: "ν", omega: "ω", phi: "φ", rho: "ρ", sigma: "σ", tau: "τ", theta: "θ", varphi: "φ" };

/** A symbol of kernels.json as text with subscripts: [letter, subscript]. @param {Field} field */
export function symbolOf(field) {
  const [, name, below] = /^\\?([A-Za-z]+)(?:_\{?(\w+)\}?)?$/.exec(field.symbol ?? "") ?? [null, field.symbol ?? field.name, ""];
  return [GREEK[name] ?? name, below ?? ""];
}

/** A symbol as `typeset` takes it. @param {Field} field */
export function plainSymbol(field) {
  return symbolOf(field).filter(Boolean).join("_");
}

/** Nodes of a text, with its subscripts set below. @param {string} text */
export const nodes = (text) => pieces(text).map((part, i) => (i % 2 ? Object.assign(document.createElement("sub"), { textContent: part }) : part));

/** Write a text, with the subscripts of μ_PD and its like set below; what stands there already is left: it would be read aloud again. @param {HTMLElement} element @param {string} text */
export function typeset(element, text) {
  if (element.textContent !== pieces(text).join("")) element.replaceChildren(...nodes(text));
}

let count = 0;
/** So many pixels a finger goes across a slider before it may go up in fine steps. */
const ACROSS = 8;
/** Steps of a slider by a key in its length; a fine step, by a key with Shift or a pixel up, is a part of one. */
const STEPS = 500, FINE = 10;
/** A number typed is taken after so many milliseconds without a key, up to so many lengths of the slider beyond its ends; farther away by Enter, or on leaving the field. */
const PAUSE = 600, FAR = 10;

/**
 * A slider and a number field for one parameter; `change(value)` is called with values that are allowed.
 * @param {Field} field @param {Pair} ends of the slider @param {(value: number) => void} change @param {Say} problem @returns {Control}
 */
export function slider(field, [low, high], change, problem) {
  const box = document.createElement("div");
  box.className = "control";
  box.dataset.name = field.name;
  const id = `control-${count++}`;
  const label = document.createElement("label");
  label.htmlFor = id;
  const symbol = document.createElement("b");
  const [letter, below] = symbolOf(field);
  symbol.textContent = letter;
  if (below) {
    const sub = document.createElement("sub");
    sub.textContent = below;
    symbol.append(sub);
  }
  label.append(`${WORDS[field.name] ?? field.meaning} `, symbol);
  if (field.units) label.append(`, ${field.units}`);
  label.title = field.meaning.replaceAll("^2", "²");
  const number = document.createElement("input");
  number.type = "number";
  number.id = id;
  number.step = "any";
  number.name = field.name;
  if (typeof field.low === "number") number.min = String(field.low);
  if (typeof field.high === "number") number.max = String(field.high);
  const range = document.createElement("input");
  range.type = "range";
  /** @type {Pair} */
  let [from, to] = [low, high];
  const step = () => 10 ** Math.floor(Math.log10((to - from) / STEPS)), fine = () => step() / FINE;
  const scale = () => Object.assign(range, { min: String(from), max: String(to), step: String(fine()) });
  scale();
  range.setAttribute("aria-label", `${field.name}: ${field.meaning}`);
  let seen = NaN;
  /** @param {number} wanted @param {number} unit */
  const slide = (wanted, unit) => {
    const value = tidy(Math.min(Math.max(Math.round(wanted / unit) * unit, from), to), to - from);
    range.value = number.value = String(value);
    seen = value;
    number.removeAttribute("aria-invalid");
    change(value);
  };
  /**
   * Where a pointer took the slider, and the value that it stands for across, without what it has moved up. A finger that goes up at once scrolls:
   * until it has gone across from x it has not moved up.
   * @type {{x: number, y: number, across: number, up: number} | null}
   */
  let held = null;
  const lift = (/** @type {PointerEvent} */ event) => {
    if (!held || Math.abs(event.clientX - held.x) < ACROSS) return;
    if (!Number.isNaN(held.x)) [held.x, held.y] = [NaN, event.clientY];
    const up = Math.round(held.y - event.clientY);
    if (up === held.up) return; // what goes across is an input of the slider itself
    held.up = up;
    slide(held.across + held.up * fine(), fine());
  };
  const leave = () => {
    held = null;
    removeEventListener("pointermove", lift);
  };
  range.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    held = { x: event.pointerType === "touch" ? event.clientX : NaN, y: event.clientY, across: seen, up: 0 };
    addEventListener("pointermove", lift);
    for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => setTimeout(leave), { once: true });
  });
  range.addEventListener("input", () => {
    if (held) held.across = Math.round(Number(range.value) / step()) * step();
    slide(held ? held.across + held.up * fine() : Number(range.value), held ? fine() : step());
  });
  range.addEventListener("keydown", (event) => {
    const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (!sign || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const unit = event.shiftKey ? fine() : step();
    slide(seen + sign * unit, fine());
  });
  let typed = 0;
  const take = (/** @type {boolean} */ typing) => {
    clearTimeout(typed);
    const value = number.value === "" ? NaN : Number(number.value);
    const why = number.validity.badInput && Number.isNaN(value) ? `give ${field.name} as a number; those of double precision end at ±1.8e308` : refusal(field.name, value, { [field.name]: field });
    number.removeAttribute("aria-invalid");
    if (why) {
      number.setAttribute("aria-invalid", "true");
      problem(`${why}. The picture still shows the value before.`);
      return;
    }
    problem("");
    // a number far beyond the slider is one more digit away from another one: it is taken when it is complete
    if (typing && (value < low - FAR * (high - low) || value > high + FAR * (high - low))) return;
    range.value = String(value);
    seen = value;
    change(value);
  };
  number.addEventListener("input", (event) => {
    const { inputType, data } = /** @type {InputEvent} */ (event);
    clearTimeout(typed);
    // 0.7 is no 0 on the way; what is pasted, or stepped by an arrow, is whole
    if (data?.length === 1 || /^(delete|insertComp)/.test(inputType)) typed = window.setTimeout(() => take(true), PAUSE);
    else take(true);
  });
  number.addEventListener("change", () => take(false));
  box.append(label, number, range);
  return {
    box,
    set(value) {
      // while a number is typed, what stands there may be the beginning of another one
      if (document.activeElement !== number || value !== seen) {
        if (Number(number.value) !== value || number.value === "") number.value = String(value);
        number.removeAttribute("aria-invalid");
      }
      seen = value;
      range.value = String(value);
    },
    span(ends, band = "") {
      const [a, b] = ends && seen >= ends[0] && seen <= ends[1] ? ends : [low, high];
      if (a !== from || b !== to) {
        [from, to] = [a, b];
        scale();
        range.value = String(seen);
      }
      const painted = ends && from === ends[0] ? band : "";
      range.classList.toggle("painted", painted !== "");
      range.style.backgroundImage = painted && `url(${painted})`;
    },
  };
}

/**
 * Two number fields, low and high; `refused` says what else is wrong with `low:high`, `equal` whether they may be the same.
 * @param {string} text @param {(ends: Pair) => void} change @param {Say} problem @param {(text: string) => string[]} [refused]
 */
export function pair(text, change, problem, refused, equal = false) {
  const box = document.createElement("div");
  box.className = "pair";
  const label = document.createElement("span");
  let called = text;
  const fields = ["from", "to"].map(() => {
    const input = document.createElement("input");
    input.type = "number";
    input.step = "any";
    input.addEventListener("change", () => {
      const [low, high] = fields.map((field) => (field.value === "" ? NaN : Number(field.value)));
      const ordered = low < high || (equal && low === high);
      const why = ordered || equal ? (refused?.(`${low}:${high}`) ?? []) : [];
      if (why.length || !ordered) {
        input.setAttribute("aria-invalid", "true");
        problem(why.length ? `${why.join("; ")}.` : `${called} runs from ${fields[0].value || "nothing"} to ${fields[1].value || "nothing"}; give two numbers, the first below the second.`);
        return;
      }
      fields.forEach((field) => field.removeAttribute("aria-invalid"));
      problem("");
      change([low, high]);
    });
    return input;
  });
  const name = (/** @type {string} */ symbol) => {
    called = symbol;
    typeset(label, `${symbol} from, to`);
    fields.forEach((field, i) => field.setAttribute("aria-label", `${symbol.replace("_", "")} ${["from", "to"][i]}`));
  };
  name(text);
  box.append(label, ...fields);
  return { box, set: (/** @type {Pair | null} */ ends) => ends && fields.forEach((field, i) => (field.value = String(ends[i]))), name };
}

/** @param {string} text @param {[string, string][]} options values, and what is shown @param {(value: string) => void} change @returns {Control} */
export function choice(text, options, change) {
  const box = document.createElement("div");
  box.className = "control choice";
  const id = `control-${count++}`;
  const label = document.createElement("label");
  label.htmlFor = id;
  label.textContent = text;
  const select = document.createElement("select");
  select.id = id;
  for (const [value, shown] of options) select.add(new Option(shown, value));
  select.addEventListener("change", () => change(select.value));
  box.append(label, select);
  const offer = (/** @type {string[]} */ values) => {
    for (const option of select.options) option.hidden = option.disabled = !values.includes(option.value);
  };
  return { box, set: (value) => (select.value = value), offer };
}

/** @param {string} text @param {(on: boolean) => void} change @returns {Control} */
export function toggle(text, change) {
  const box = document.createElement("label");
  box.className = "switch";
  const input = document.createElement("input");
  input.type = "checkbox";
  input.addEventListener("change", () => change(input.checked));
  box.append(input, ` ${text}`);
  return { box, set: (on) => (input.checked = on) };
}
