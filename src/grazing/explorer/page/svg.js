// @ts-check
/** Pictures as vectors: a context that records what is drawn on it, and the pictures on screen put together as one file. */

/**
 * The part of a canvas that the page draws with. Views draw on a pen, so what they draw can be recorded.
 * @typedef {Pick<CanvasRenderingContext2D, "fillStyle" | "strokeStyle" | "lineWidth" | "lineJoin" | "globalAlpha" | "font" | "textAlign" | "textBaseline" | "imageSmoothingEnabled" | "setTransform" | "save" | "restore" | "beginPath" | "moveTo" | "lineTo" | "rect" | "arc" | "clip" | "stroke" | "fill" | "fillRect" | "strokeRect" | "fillText" | "setLineDash" | "drawImage" | "measureText">} Pen
 */
/** @typedef {{canvas: HTMLCanvasElement, context: Pen, zoom?: number}} Sheet a canvas, what is drawn with on it, and how much it is enlarged */
/** @typedef {{sheet: import("./plot.js").Axes, draw: () => void}} Panel a sheet and how its picture is drawn once more */

const SIGNS = /** @type {Record<string, string>} */ ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" });
/** @param {string} text */
const escaped = (text) => text.replace(/[&<>"]/g, (sign) => SIGNS[sign]);
/** @param {number} value */
const short = (value) => String(Number(value.toFixed(3)));
const ANCHORS = /** @type {Record<string, string>} */ ({ center: "middle", right: "end", end: "end" });

let clips = 0;

/** A context that writes down what is drawn; a new picture begins with `setTransform`. Lengths are CSS pixels. */
export class Recorder {
  /** @type {string | CanvasGradient | CanvasPattern} */ fillStyle = "#000000";
  /** @type {string | CanvasGradient | CanvasPattern} */ strokeStyle = "#000000";
  lineWidth = 1;
  /** @type {CanvasLineJoin} */ lineJoin = "miter";
  globalAlpha = 1;
  font = "10px sans-serif";
  /** @type {CanvasTextAlign} */ textAlign = "start";
  /** @type {CanvasTextBaseline} */ textBaseline = "alphabetic";
  imageSmoothingEnabled = true;
  /** @type {string[]} */ #parts = [];
  /** @type {number[]} */ #dash = [];
  /** @type {{kept: object, dash: number[], groups: number}[]} */ #stack = [];
  #groups = 0;
  #path = "";
  /** Rectangles of one opaque colour that follow one another: one element. */
  #run = { paint: "", d: "" };

  /** @param {Pen | null} ruler a context that measures text; without one its size is guessed */
  constructor(ruler) {
    this.ruler = ruler;
  }

  /** What was drawn, as elements. */
  text() {
    this.#flush();
    return this.#parts.join("\n");
  }

  setTransform() {
    this.#parts = [];
    this.#run = { paint: "", d: "" };
  }

  save() {
    const { fillStyle, strokeStyle, lineWidth, lineJoin, globalAlpha, font, textAlign, textBaseline, imageSmoothingEnabled } = this;
    const kept = { fillStyle, strokeStyle, lineWidth, lineJoin, globalAlpha, font, textAlign, textBaseline, imageSmoothingEnabled };
    this.#stack.push({ kept, dash: this.#dash, groups: this.#groups });
    this.#groups = 0;
  }

  restore() {
    const before = this.#stack.pop();
    if (!before) return;
    if (this.#groups) this.#put("</g>".repeat(this.#groups));
    Object.assign(this, before.kept);
    this.#dash = before.dash;
    this.#groups = before.groups;
  }

  /** @param {number[]} dash */
  setLineDash(dash) {
    this.#dash = [...dash];
  }

  beginPath() {
    this.#path = "";
  }

  /** @param {number} x @param {number} y */
  moveTo(x, y) {
    if (Number.isFinite(x + y)) this.#path += `M${short(x)} ${short(y)}`;
  }

  /** @param {number} x @param {number} y */
  lineTo(x, y) {
    if (Number.isFinite(x + y)) this.#path += `${this.#path ? "L" : "M"}${short(x)} ${short(y)}`;
  }

  /** @param {number} x @param {number} y @param {number} w @param {number} h */
  rect(x, y, w, h) {
    this.#path += rectangle(x, y, w, h);
  }

  /** @param {number} x @param {number} y @param {number} r @param {number} from @param {number} to clockwise on screen */
  arc(x, y, r, from, to) {
    if (!Number.isFinite(x + y + r)) return;
    const place = (/** @type {number} */ angle) => `${short(x + r * Math.cos(angle))} ${short(y + r * Math.sin(angle))}`;
    const turn = Math.min(to - from, 2 * Math.PI), middle = from + turn / 2;
    const half = `A${short(r)} ${short(r)} 0 0 1 `;
    this.#path += `${this.#path ? "L" : "M"}${place(from)}${half}${place(middle)}${half}${place(from + turn)}`;
  }

  clip() {
    const id = `clip${clips++}`;
    this.#put(`<clipPath id="${id}"><path d="${this.#path}"/></clipPath><g clip-path="url(#${id})">`);
    this.#groups++;
  }

  stroke() {
    if (this.#path) this.#put(`<path d="${this.#path}" fill="none" ${this.#line()}/>`);
  }

  fill() {
    if (this.#path) this.#put(`<path d="${this.#path}" ${this.#paint("fill", this.fillStyle)}/>`);
  }

  /** @param {number} x @param {number} y @param {number} w @param {number} h */
  fillRect(x, y, w, h) {
    if (!Number.isFinite(x + y + w + h)) return;
    const paint = this.#paint("fill", this.fillStyle), d = rectangle(x, y, w, h);
    if (paint !== this.#run.paint) this.#flush();
    if (paint.includes("opacity")) this.#put(`<path d="${d}" ${paint}/>`);
    else this.#run = { paint, d: this.#run.d + d };
  }

  /** @param {number} x @param {number} y @param {number} w @param {number} h */
  strokeRect(x, y, w, h) {
    this.#put(`<path d="${rectangle(x, y, w, h)}" fill="none" ${this.#line()}/>`);
  }

  /** @param {string} text @param {number} x @param {number} y */
  fillText(text, x, y) {
    if (!text || !Number.isFinite(x + y)) return;
    const anchor = ANCHORS[this.textAlign];
    this.#put(`<text x="${short(x)}" y="${short(y + this.#drop(text))}" style="font: ${escaped(this.font)}"${anchor ? ` text-anchor="${anchor}"` : ""} ${this.#paint("fill", this.fillStyle)}>${escaped(text)}</text>`);
  }

  /** @param {string} text */
  measureText(text) {
    if (!this.ruler) return /** @type {TextMetrics} */ ({ width: 6.5 * text.length });
    this.ruler.font = this.font;
    return this.ruler.measureText(text);
  }

  /** @param {CanvasImageSource} image a canvas @param {number} x @param {number} y @param {number} [w] @param {number} [h] */
  drawImage(image, x, y, w, h) {
    const canvas = /** @type {HTMLCanvasElement} */ (image);
    if (!canvas.width || !canvas.height) return;
    const size = `width="${short(w ?? canvas.width)}" height="${short(h ?? canvas.height)}"`;
    const look = this.imageSmoothingEnabled ? "" : ' style="image-rendering: pixelated"';
    this.#put(`<image x="${short(x)}" y="${short(y)}" ${size} preserveAspectRatio="none"${look} xlink:href="${canvas.toDataURL()}"/>`);
  }

  /** How far the line on which text stands is below the place that was given. @param {string} text */
  #drop(text) {
    const { ruler, textBaseline } = this;
    if (textBaseline === "alphabetic") return 0;
    if (!ruler) return { top: 10, middle: 4 }[/** @type {string} */ (textBaseline)] ?? -3;
    ruler.save();
    ruler.font = this.font;
    const [stands, given] = /** @type {CanvasTextBaseline[]} */ (["alphabetic", textBaseline]).map((baseline) => {
      ruler.textBaseline = baseline;
      return ruler.measureText(text).actualBoundingBoxAscent;
    });
    ruler.restore();
    return stands - given;
  }

  #line() {
    const dash = this.#dash.length ? ` stroke-dasharray="${this.#dash.join(" ")}"` : "";
    return `${this.#paint("stroke", this.strokeStyle)} stroke-width="${short(this.lineWidth)}" stroke-linejoin="${this.lineJoin}"${dash}`;
  }

  /** A colour with its transparency, which readers of SVG want apart. @param {string} what @param {Pen["fillStyle"]} style */
  #paint(what, style) {
    const [, colour, alpha] = /^(#\w{6})(\w\w)$/.exec(String(style)) ?? [null, String(style), "ff"];
    const opacity = (parseInt(alpha, 16) / 255) * this.globalAlpha;
    return `${what}="${escaped(colour)}"${opacity < 1 ? ` ${what}-opacity="${short(opacity)}"` : ""}`;
  }

  #flush() {
    if (this.#run.d) this.#parts.push(`<path d="${this.#run.d}" ${this.#run.paint}/>`);
    this.#run = { paint: "", d: "" };
  }

  /** @param {string} element */
  #put(element) {
    this.#flush();
    this.#parts.push(element);
  }
}

/** @param {number} x @param {number} y @param {number} w @param {number} h */
function rectangle(x, y, w, h) {
  return Number.isFinite(x + y + w + h) ? `M${short(x)} ${short(y)}h${short(w)}v${short(h)}h${short(-w)}z` : "";
}

/** Pixels between the pictures of one file, as on a wide screen. */
const BETWEEN = 26;

/**
 * Where pictures lie in one file, and how large they are together: side by side where they are so on screen, else one
 * below the other, whatever lies between them there. @param {Panel[]} panels
 */
export function layout(panels) {
  const places = /** @type {{x: number, y: number, w: number, h: number}[]} */ ([]);
  panels.forEach(({ sheet: { canvas } }, i) => {
    const last = places[i - 1], w = canvas.clientWidth, h = canvas.clientHeight;
    const beside = last && canvas.getBoundingClientRect().left >= panels[i - 1].sheet.canvas.getBoundingClientRect().right;
    if (!last) places.push({ x: 0, y: 0, w, h });
    else places.push(beside ? { x: last.x + last.w + BETWEEN, y: last.y, w, h } : { x: last.x, y: last.y + last.h + BETWEEN, w, h });
  });
  return { places, width: Math.max(...places.map(({ x, w }) => x + w)), height: Math.max(...places.map(({ y, h }) => y + h)) };
}

/**
 * The pictures on screen as one SVG file.
 * @param {Panel[]} panels
 * @param {{title: string, about: string, paper: string}} said
 */
export function svgOf(panels, { title, about, paper }) {
  const { places, width, height } = layout(panels);
  const parts = panels.map(({ sheet, draw }, i) => {
    const { x, y, w, h } = places[i], pen = sheet.context;
    const recorder = new Recorder(pen instanceof Recorder ? null : pen);
    sheet.context = recorder;
    try {
      draw();
    } finally {
      sheet.context = pen;
    }
    const zoom = sheet.zoom ?? 1;
    return `<svg x="${x}" y="${y}" width="${w}" height="${h}" viewBox="0 0 ${short(w / zoom)} ${short(h / zoom)}">\n${recorder.text()}\n</svg>`;
  });
  const head = `<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">`;
  return `${head}\n<title>${escaped(title)}</title>\n<desc>${escaped(about)}</desc>\n<rect width="${width}" height="${height}" fill="${paper}"/>\n${parts.join("\n")}\n</svg>\n`;
}

/**
 * The pictures on screen on one canvas.
 * @param {Panel[]} panels
 * @param {string} paper
 * @param {number} ratio pixels in one of CSS, as they are drawn
 */
export function canvasOf(panels, paper, ratio) {
  const { places, width, height } = layout(panels);
  const canvas = document.createElement("canvas");
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const c = canvas.getContext("2d");
  if (!c) return null;
  c.fillStyle = paper;
  c.fillRect(0, 0, canvas.width, canvas.height);
  panels.forEach(({ sheet }, i) => c.drawImage(sheet.canvas, Math.round(places[i].x * ratio), Math.round(places[i].y * ratio)));
  return canvas;
}
