// @ts-check
/** Axes on a canvas: places of numbers, ticks, labels. */
import { theme } from "./colours.js";
import { Recorder } from "./svg.js";

/** @typedef {import("./svg.js").Pen} Pen */

const MARGIN = { left: 54, right: 12, top: 20, bottom: 34 };

/** Ticks at round numbers. @param {number} low @param {number} high @param {number} about how many */
export function ticks(low, high, about) {
  const raw = (high - low) / Math.max(about, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((m) => m * power).find((s) => s >= raw) ?? 10 * power;
  const digits = Math.max(0, 1 - Math.floor(Math.log10(step)));
  const found = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n++) {
    const value = n * step;
    found.push({ value, text: Number(value.toFixed(Math.min(digits, 12))).toString().replace("-", "−") });
  }
  return found;
}

/** A canvas with axes; `x` and `y` give places in CSS pixels, `atX` and `atY` go back. */
export class Axes {
  /** @param {HTMLElement | null} canvas @param {Partial<typeof MARGIN>} margin */
  constructor(canvas, margin = {}) {
    this.canvas = /** @type {HTMLCanvasElement} */ (canvas);
    this.margin = { ...MARGIN, ...margin };
    /** @type {Pen} nothing is seen of what is drawn where the browser gives no canvas */
    this.context = this.canvas.getContext("2d") ?? new Recorder(null);
    this.x0 = this.y0 = 0;
    this.x1 = this.y1 = 1;
    this.box = { x: 0, y: 0, w: 1, h: 1 };
  }

  /** @param {number} x0 @param {number} x1 @param {number} y0 @param {number} y1 */
  span(x0, x1, y0, y1) {
    this.x0 = x0;
    this.x1 = x1;
    this.y0 = y0;
    this.y1 = y1;
  }

  /** Fit the bitmap to its place on the page and clear it. */
  begin() {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
    if (this.canvas.width !== w || this.canvas.height !== h) {
      this.canvas.width = w;
      this.canvas.height = h;
    }
    const { left, right, top, bottom } = this.margin;
    this.box = { x: left, y: top, w: Math.max(10, width - left - right), h: Math.max(10, height - top - bottom) };
    const c = this.context;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = theme().paper;
    c.fillRect(0, 0, width, height);
    c.font = "12px system-ui, sans-serif";
    c.lineJoin = "round";
    return c;
  }

  x = (/** @type {number} */ value) => this.box.x + ((value - this.x0) / (this.x1 - this.x0)) * this.box.w;
  y = (/** @type {number} */ value) => this.box.y + ((this.y1 - value) / (this.y1 - this.y0)) * this.box.h;
  atX = (/** @type {number} */ place) => this.x0 + ((place - this.box.x) / this.box.w) * (this.x1 - this.x0);
  atY = (/** @type {number} */ place) => this.y1 - ((place - this.box.y) / this.box.h) * (this.y1 - this.y0);

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
    for (const { value, text } of ticks(this.x0, this.x1, box.w / 85)) {
      const x = this.x(value);
      c.fillRect(x - 0.5, box.y + box.h, 1, 4);
      c.fillText(text, Math.min(x, box.x + box.w - 8), box.y + box.h + 6);
    }
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const { value, text } of ticks(this.y0, this.y1, box.h / 45)) {
      c.fillRect(box.x - 5, this.y(value) - 0.5, 4, 1);
      c.fillText(text, box.x - 8, this.y(value));
    }
    c.fillStyle = ink;
    c.font = "italic 14px Georgia, 'Times New Roman', serif";
    c.textBaseline = "bottom";
    c.textAlign = "right";
    c.fillText(labelX, box.x + box.w, box.y + box.h + 33);
    c.textAlign = "left";
    c.textBaseline = "top";
    c.fillText(labelY, 6, 2);
    c.font = "12px system-ui, sans-serif";
  }
}
