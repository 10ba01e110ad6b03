// @ts-check
/** Axes on a canvas: places of numbers, ticks, labels. */
import { theme } from "./colours.js";
import { scaleLinear } from "./d3.mjs";
import { pieces } from "./names.js";
import { Recorder } from "./svg.js";

/** @typedef {import("./svg.js").Pen} Pen */

const MARGIN = { left: 62, right: 14, top: 24, bottom: 42, equal: false };
/** The least that is written in a picture, in pixels. */
const TEXT = 14;
export const FONT = `${TEXT}px system-ui, sans-serif`;

/** How much larger everything in a picture is drawn: before a room, where the style says what is the least. */
export const enlarged = () => (document.body.classList.contains("presenting") ? parseFloat(getComputedStyle(document.body).fontSize) / TEXT : 1);

/** Letters of a tick's number for which there is room; longer ones are told as what is left beside a common part. */
const ROOM = 7;
/** Ticks at most, and at least where double precision has them: one alone is no scale. */
const MOST = 100, LEAST = 2;

const minus = (/** @type {string} */ text) => text.replace("-", "−");
const raised = (/** @type {number} */ power) => [...String(power)].map((each) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(each)]).join("");

/**
 * Ticks at round numbers. Where their numbers are too long, the texts are those of (value − `base`)·10^`power`.
 * @param {number} low @param {number} high @param {number} about how many
 */
export function scaled(low, high, about) {
  const { ticks } = scaleLinear([low, high], [0, 1]);
  let values = ticks(Math.min(Math.max(about, 1), MOST));
  for (let more = Math.max(about, 1) + 1; values.length < LEAST && more < MOST; more++) values = ticks(more);
  const step = values.length > 1 ? values[1] - values[0] : high - low;
  const places = 1 - Math.floor(Math.log10(step));
  const texts = (/** @type {number} */ base, /** @type {number} */ power) => values.map((value) => ({
    value, text: minus(Number(((value - base) * 10 ** power).toFixed(Math.min(100, Math.max(0, places - power)))).toString()),
  }));
  const fits = (/** @type {{text: string}[]} */ some) => some.every(({ text }) => text.length <= ROOM);
  const plain = texts(0, 0);
  if (fits(plain)) return { ticks: plain, base: 0, power: 0 };
  const unit = 10 ** Math.ceil(Math.log10(high - low) - 1e-9);
  const base = Number((Math.floor(low / unit + 1e-4) * unit).toPrecision(12));
  const beside = texts(base, 0);
  if (fits(beside) && 1e-3 < high - low) return { ticks: beside, base, power: 0 };
  const power = -Math.floor(Math.log10(Math.max(Math.abs(low - base), Math.abs(high - base))));
  return { ticks: texts(base, power), base, power };
}

/** Ticks at round numbers. @param {number} low @param {number} high @param {number} about how many */
export const ticks = (low, high, about) => scaled(low, high, about).ticks;

/** Write a text as `fillText` does, with the subscripts of σ_B and its like set below. @param {Pen} c @param {string} text @param {number} x @param {number} y */
export function inscribe(c, text, x, y) {
  const parts = pieces(text), { font, textAlign: align } = c;
  if (parts.length < 2) return c.fillText(text, x, y);
  const as = (/** @type {number} */ i) => (c.font = i % 2 ? font.replace(/[\d.]+px/, (size) => `${Math.max(TEXT, 0.75 * parseFloat(size))}px`) : font);
  const wide = parts.map((part, i) => (as(i), c.measureText(part).width));
  let left = x - wide.reduce((sum, each) => sum + each, 0) * (align === "right" ? 1 : align === "center" ? 0.5 : 0);
  c.textAlign = "left";
  parts.forEach((part, i) => {
    as(i);
    c.fillText(part, left, y + (i % 2 ? 4 : 0));
    left += wide[i];
  });
  c.font = font;
  c.textAlign = align;
}

/** What is written at an axis whose numbers are scaled. @param {string} label @param {{base: number, power: number}} scale */
function beside(label, { base, power }) {
  const part = base ? `${label} ${base < 0 ? "+" : "−"} ${Math.abs(base)}` : label;
  if (!power) return part;
  return `${base ? `(${part})` : part} · 10${raised(power)}`;
}

let times = 1;
/** Draw from now on with so many times the pixels of the screen, for a file. @param {number} factor */
export const magnify = (factor) => (times = factor);
/** Pixels of a bitmap in one of CSS. */
export const resolution = () => (window.devicePixelRatio || 1) * times;

/** A canvas with axes; the scales `x` and `y` give places in pixels of the picture, `atX` and `atY` go back. */
export class Axes {
  /** @param {HTMLElement | null} canvas @param {Partial<typeof MARGIN>} margin */
  constructor(canvas, margin = {}) {
    this.canvas = /** @type {HTMLCanvasElement} */ (canvas);
    this.margin = { ...MARGIN, ...margin };
    /** @type {Pen} nothing is seen of what is drawn where the browser gives no canvas */
    this.context = this.canvas.getContext("2d") ?? new Recorder(null);
    /** @type {import("./d3.mjs").ScaleLinear<number, number>} */
    this.x = scaleLinear();
    /** @type {import("./d3.mjs").ScaleLinear<number, number>} */
    this.y = scaleLinear();
    this.x0 = this.y0 = 0;
    this.x1 = this.y1 = 1;
    this.box = { x: 0, y: 0, w: 1, h: 1 };
    /** CSS pixels, and those of the bitmap, in a pixel of the picture. */
    this.zoom = this.ratio = 1;
  }

  /** Where an event is in the picture. @param {{clientX: number, clientY: number}} event @returns {[number, number]} */
  place({ clientX, clientY }) {
    const { left, top } = this.canvas.getBoundingClientRect();
    return [(clientX - left) / this.zoom, (clientY - top) / this.zoom];
  }

  /** @param {number} x0 @param {number} x1 @param {number} y0 @param {number} y1 */
  span(x0, x1, y0, y1) {
    this.x0 = x0;
    this.x1 = x1;
    this.y0 = y0;
    this.y1 = y1;
    this.x.domain([x0, x1]);
    this.y.domain([y0, y1]);
  }

  /** Fit the bitmap to its place on the page and clear it. */
  begin() {
    const ratio = resolution();
    this.zoom = enlarged();
    this.ratio = ratio * this.zoom;
    const { clientWidth, clientHeight } = this.canvas, width = clientWidth / this.zoom, height = clientHeight / this.zoom;
    const [w, h] = [Math.max(1, Math.round(clientWidth * ratio)), Math.max(1, Math.round(clientHeight * ratio))];
    if (this.canvas.width !== w || this.canvas.height !== h) {
      this.canvas.width = w;
      this.canvas.height = h;
    }
    const { left, right, top, bottom, equal } = this.margin;
    this.box = { x: left, y: top, w: Math.max(10, width - left - right), h: Math.max(10, height - top - bottom) };
    if (equal) {
      const side = Math.min(this.box.w, this.box.h);
      this.box = { x: left + Math.round((this.box.w - side) / 2), y: top, w: side, h: side };
    }
    this.x.range([this.box.x, this.box.x + this.box.w]);
    this.y.range([top + this.box.h, top]);
    const c = this.context;
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.fillStyle = theme().paper;
    c.fillRect(0, 0, width, height);
    c.font = FONT;
    c.lineJoin = "round";
    return c;
  }

  atX = (/** @type {number} */ place) => this.x.invert(place);
  atY = (/** @type {number} */ place) => this.y.invert(place);

  /** Draw inside the frame only. @param {(c: Pen) => void} draw */
  inside(draw) {
    const { context: c, box } = this;
    c.save();
    c.beginPath();
    c.rect(box.x, box.y, box.w, box.h);
    c.clip();
    draw(c);
    c.restore();
  }

  /** @param {number} value @param {string} colour @param {number[]} dash */
  vertical(value, colour, dash = [], width = 1.2) {
    if (!(value >= this.x0 && value <= this.x1)) return;
    const { context: c, box } = this;
    c.save();
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.setLineDash(dash);
    c.beginPath();
    c.moveTo(this.x(value), box.y);
    c.lineTo(this.x(value), box.y + box.h);
    c.stroke();
    c.restore();
  }

  /** @param {string} labelX @param {string} labelY */
  frame(labelX, labelY) {
    const { context: c, box } = this;
    const { ink, faint } = theme();
    c.strokeStyle = faint;
    c.lineWidth = 1;
    c.beginPath();
    c.moveTo(box.x - 0.5, box.y);
    c.lineTo(box.x - 0.5, box.y + box.h + 0.5);
    c.lineTo(box.x + box.w, box.y + box.h + 0.5);
    c.stroke();
    c.fillStyle = faint;
    c.textAlign = "center";
    c.textBaseline = "top";
    const across = scaled(this.x0, this.x1, box.w / 130), upwards = scaled(this.y0, this.y1, box.h / 50);
    const edge = box.x + box.w + this.margin.right - 1;
    for (const { value, text } of across.ticks) {
      const x = this.x(value);
      c.fillRect(x - 0.5, box.y + box.h, 1, 4);
      c.fillText(text, Math.min(x, edge - c.measureText(text).width / 2), box.y + box.h + 6);
    }
    c.textAlign = "right";
    c.textBaseline = "middle";
    let last = Infinity;
    for (const { value, text } of labelY ? upwards.ticks : []) {
      const y = this.y(value);
      if (last - y < TEXT) continue; // in a low picture there is no room for it
      c.fillRect(box.x - 5, y - 0.5, 4, 1);
      c.fillText(text, box.x - 8, y);
      last = y;
    }
    c.fillStyle = ink;
    c.font = "italic 17px Georgia, 'Times New Roman', serif";
    c.textBaseline = "bottom";
    c.textAlign = "right";
    inscribe(c, beside(labelX, across), box.x + box.w, box.y + box.h + 42);
    c.textAlign = "left";
    c.textBaseline = "top";
    const up = beside(labelY, upwards);
    if (up === labelY || !labelY) inscribe(c, labelY, box.x + 6 - this.margin.left, 2);
    else {
      // too long for the margin: inside, over what is drawn, which is seen through
      c.globalAlpha = 0.75;
      c.fillStyle = theme().paper;
      c.fillRect(box.x + 1, box.y + 1, c.measureText(up).width + 10, 22);
      c.globalAlpha = 1;
      c.fillStyle = ink;
      inscribe(c, up, box.x + 6, box.y + 3);
    }
    c.font = FONT;
  }

  /** Write words in place of a picture. @param {string} text */
  say(text) {
    const c = this.begin(), middle = [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2].map((each) => each / this.zoom);
    let lines = [""];
    for (const word of text.split(" ")) {
      const longer = `${lines[lines.length - 1]} ${word}`.trim();
      lines = c.measureText(longer).width > Math.min(2 * middle[0] - 24, 560) ? [...lines, word] : [...lines.slice(0, -1), longer];
    }
    c.fillStyle = theme().faint;
    c.textAlign = "center";
    c.textBaseline = "middle";
    lines.forEach((line, i) => c.fillText(line, middle[0], middle[1] + 20 * (i - (lines.length - 1) / 2)));
  }

  /** Say under the axis, where nothing is drawn, how far the picture is, if it is one that takes more than half a second. @param {number} share @param {number} begun in milliseconds */
  progress(share, begun) {
    if (!(performance.now() - begun > 500)) return;
    const { context: c, box } = this;
    c.fillStyle = theme().ink;
    c.textAlign = "center";
    c.textBaseline = "bottom";
    c.fillText(`${Math.min(99, Math.floor(100 * share))} %`, box.x + box.w / 2, box.y + box.h + 42);
  }
}
