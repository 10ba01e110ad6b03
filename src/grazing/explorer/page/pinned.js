// @ts-check
/** A picture that is kept while settings change: drawn above the present one on the scale of that, to compare. */
import { theme } from "./colours.js";
import { plainSymbol } from "./controls.js";
import { Axes } from "./plot.js";
import { numeral } from "./state.js";

/** @typedef {import("./diagram.js").Diagram} Diagram */
/** @typedef {import("./diagram.js").Spec} Spec */
/** @typedef {{image: HTMLCanvasElement, spec: Spec, fields: import("./machine.js").Field[]}} Kept a picture, what it shows, and what is known of its numbers */

/** Rows of a picture that one pixel shows at most. */
const MOST = 64;
/** Numbers of a row that nobody sets. */
const WITHIN = ["order", "paper"];

/** Parameters in which one picture differs from another, but for that along the axis. @param {Kept} one @param {Spec} other */
export function differing({ spec, fields }, other) {
  const value = (/** @type {import("./machine.js").Field} */ { choices }, /** @type {number} */ number) => choices?.[number] ?? numeral(number);
  return fields.flatMap((field, i) => (i === spec.which || WITHIN.includes(field.name) || spec.row[i] === other.row[i] ? [] : [`${plainSymbol(field)} = ${value(field, spec.row[i])}`]));
}

export class Pinned {
  /** @type {Kept | null} */ kept = null;

  /** @param {HTMLElement} button */
  constructor(button) {
    this.button = button;
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { id: "pinned", hidden: true });
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "The pinned diagram");
    document.body.append(canvas); // until it is put above a diagram
    this.axes = new Axes(canvas);
  }

  /** Keep the picture of a diagram, or let go of what is kept. @param {Diagram | undefined} diagram @param {import("./machine.js").Field[]} fields of the row of its parameters */
  turn(diagram, fields) {
    const image = this.kept || !diagram?.drawn ? null : document.createElement("canvas"), source = diagram?.image;
    this.kept = null;
    if (image && source && diagram?.drawn) {
      Object.assign(image, { width: source.width, height: source.height });
      image.getContext("2d")?.drawImage(source, 0, 0);
      this.kept = { image, spec: diagram.drawn, fields };
    }
    this.show(diagram);
  }

  /** Draw what is kept on the scale of the diagram beside it; nothing where that shows something else. @param {Diagram | undefined} diagram */
  show(diagram) {
    const { kept, axes } = this, now = diagram?.drawn;
    const fits = Boolean(kept && now && kept.spec.machine === now.machine && kept.spec.which === now.which && kept.spec.coordinate === now.coordinate);
    this.button.setAttribute("aria-pressed", String(Boolean(kept)));
    this.button.hidden = !diagram;
    const { canvas } = axes, below = diagram?.axes.canvas;
    const moves = canvas.hidden === fits || (fits && canvas.nextElementSibling !== below);
    canvas.hidden = !fits;
    if (!fits || !kept || !now || !diagram || !below) return;
    if (moves) below.before(canvas);
    const { spec, image } = kept, c = axes.begin();
    axes.span(diagram.axes.x0, diagram.axes.x1, diagram.axes.y0, diagram.axes.y1);
    const [left, top] = [axes.x(spec.span[0]), axes.y(spec.high)], [w, h] = [axes.x(spec.span[1]) - left, axes.y(spec.low) - top];
    const rows = Math.min(MOST, Math.max(1, Math.ceil(image.height / (h * axes.ratio)))); // of the picture in a pixel: each is drawn, so that no line is lost
    /** @type {CanvasRenderingContext2D} */ (c).imageSmoothingEnabled = rows === 1;
    axes.inside(() => {
      for (let j = 0; j < rows; j++) c.drawImage(image, left, top - (j * h) / image.height, w, h);
    });
    axes.frame(spec.labels[0], spec.labels[1]);
    const said = differing(kept, now), text = `pinned${said.length ? `: ${said.join(", ")}` : ""}`;
    c.fillStyle = theme().ink;
    c.textAlign = "right";
    c.textBaseline = "top";
    c.fillText(text, axes.box.x + axes.box.w, 4);
    canvas.setAttribute("aria-label", `The ${text}, on the scale of the diagram below`);
  }
}
