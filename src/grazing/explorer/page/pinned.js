// @ts-check
/** A setting that is kept while others are shown: its diagram stands above the present one, on the scale of that, to compare. */
import { theme } from "./colours.js";
import { plainSymbol } from "./controls.js";
import { Diagram } from "./diagram.js";
import { inscribe } from "./plot.js";
import { kept, numeral, settingOf } from "./state.js";

/** @typedef {import("./diagram.js").Spec} Spec */
/** @typedef {import("./state.js").State} State */
/** @typedef {import("./gap.js").GapView | import("./flow.js").FlowView | import("./mapped.js").MapView} Shown a view whose diagram can be kept */

/** Numbers of a row that nobody sets. */
const WITHIN = ["order", "paper"];

/** Parameters in which one picture differs from another, but for that along the axis. @param {Spec} one @param {Spec} other @param {import("./machine.js").Field[]} fields of their rows */
function differing(one, other, fields) {
  const value = (/** @type {import("./machine.js").Field} */ { choices }, /** @type {number} */ number) => choices?.[number] ?? numeral(number);
  return fields.flatMap((field, i) => (i === one.which || WITHIN.includes(field.name) || one.row[i] === other.row[i] ? [] : [`${plainSymbol(field)} = ${value(field, one.row[i])}`]));
}

/** Axes along which both pictures lie: the kept one is computed for what is seen. @type {Record<string, (state: State, of: State) => Partial<State>>} */
const SEEN = {
  gap: (state, { range }) => ({ span: state.span, range: state.range ?? range }),
  map: (state, { window }) => ({ reach: state.reach, window: state.window ?? window }),
  oscillator: (state, { window }) => ({ reach: state.reach, window: state.window ?? window }),
};

export class Pinned {
  /** What is computed. */ #key = "";

  /** @param {HTMLElement} button @param {import("./pool.js").Pool} pool @param {{fields: import("./state.js").Fields, change: (part: object) => import("./gestures.js").Undo, problem: (text: string) => void, view: () => Shown | undefined, state: () => State}} page */
  constructor(button, pool, page) {
    this.button = button;
    this.page = page;
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { id: "pinned", hidden: true });
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "The pinned diagram");
    document.body.append(canvas); // until it is put above a diagram
    const beside = () => (page.view()?.diagram.drawn ? page.view()?.diagram : undefined), answers = () => beside()?.events;
    this.diagram = new Diagram(canvas, pool, "pinned", {
      pick: (x, y) => answers()?.pick?.(x, y) ?? (() => {}),
      zoom: (x, y) => answers()?.zoom?.(x, y),
      zoomOut: () => answers()?.zoomOut?.(),
      chosen: () => answers()?.chosen?.() ?? NaN,
      on: () => beside()?.axes,
      under: (axes, c) => {
        const view = page.view();
        if (view && "backdrop" in view && page.state().theory) view.backdrop(axes, c, kept(page.state().pinned, page.fields));
      },
      overlay: (axes, c) => this.#overlay(axes, c),
      problem: page.problem,
    });
    button.addEventListener("click", () => page.view() && page.change({ pinned: page.state().pinned ? "" : settingOf(page.state()) }));
  }

  /** Show what is kept above the diagram on screen; nothing where that shows something else. */
  show() {
    const { state: now, view: shown, fields } = this.page, state = now(), view = shown(), { canvas } = this.diagram.axes;
    this.button.setAttribute("aria-pressed", String(Boolean(state.pinned)));
    this.button.hidden = !view;
    const of = view && state.pinned ? kept(state.pinned, fields) : null;
    const fits = of && of.view === state.view && (of.view === "gap" || (of.vary === state.vary && of.coordinate === state.coordinate));
    const below = view?.diagram.axes.canvas;
    canvas.hidden = !fits;
    if (!fits || !view || !below) return;
    if (canvas.nextElementSibling !== below) below.before(canvas);
    const asked = { ...of, ...SEEN[of.view](state, of) }, key = JSON.stringify([asked, state.colour]);
    if (key === this.#key) return;
    this.#key = key;
    this.diagram.show(view.specOf({ ...asked, colour: state.colour }));
  }

  /** Draw what is kept once more: the diagram beside it has been drawn. */
  draw() {
    if (!this.diagram.axes.canvas.hidden) this.diagram.draw();
  }

  /** Paint it at the size and in the colours of now. */
  repaint() {
    if (!this.diagram.axes.canvas.hidden) this.diagram.paint();
  }

  /** What of it is on screen, for a file. @returns {import("./svg.js").Panel[]} */
  panels() {
    return [{ sheet: this.diagram.axes, draw: () => this.diagram.draw() }];
  }

  /** @param {import("./plot.js").Axes} axes @param {import("./svg.js").Pen} c */
  #overlay(axes, c) {
    const view = this.page.view(), own = this.diagram.drawn, other = view?.diagram.spec;
    axes.vertical(this.diagram.events.chosen?.() ?? NaN, theme().accent, [], 1.6);
    if (!view || !own || !other) return;
    const said = differing(own, other, view.machine.described.fields), text = `pinned${said.length ? `: ${said.join(", ")}` : ""}`;
    c.fillStyle = theme().ink;
    c.textAlign = "left";
    c.textBaseline = "bottom";
    inscribe(c, text, axes.box.x, axes.box.y + axes.box.h + 42); // above it stand the periods of windows
    axes.canvas.setAttribute("aria-label", `The ${text.replaceAll("_", "")}, on the scale of the diagram below`);
  }
}
