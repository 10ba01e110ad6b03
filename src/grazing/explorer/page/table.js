// @ts-check
/** The page of the pinball table: keys and buttons, the clock, words. What is computed is in played.js, by the kernels. */
import { dark, theme } from "./colours.js";
import { Edit, hasRoom } from "./edit.js";
import { Exits } from "./exits.js";
import { load } from "./load.js";
import { missedBy } from "./near.js";
import { note } from "./note.js";
import { Played, unpacked } from "./played.js";
import { Axes } from "./plot.js";
import { RUNGS } from "./rungs.js";
import { Sound } from "./sound.js";
import { isTyped, stage } from "./stage.js";
import { TableDraw, kicks } from "./tabledraw.js";
import { fromLink, python, toLink } from "./tablelink.js";
import { addressOf, reach } from "./where.js";

/** @typedef {import("./played.js").State} State */
/** @typedef {import("./played.js").Table} Table */

const $ = (/** @type {string} */ id) => /** @type {any} */ (document.getElementById(id));
/** Seconds to pull the plunger all the way, and of a frame at most. */
const PULL = 1.2, FRAME = 0.05;
/** Of a pull shorter than this share a hand means none: the ball has the usual strength. */
const TAP = 0.2, USUAL = 0.8;
/** How much faster a nudge makes the ball, as a share of how fast one may be thrown by hand. */
const NUDGE = 0.1;
/** Near balls, and the angle between two of them. */
const MANY = 100, SMALL = 1e-7;
/** The logarithm of the share of the table up to which distances are small: beyond it they grow no more. */
const FAR = -2;
/** Letters of the word that are shown; how near a miss is told, as a share of the radius of the disc, or else of the ball; seconds for which. */
const WORD = 40, NEAR = 0.12, TOLD = 2.5;
/** Columns of the curve of distances, in seconds of play. */
const REMEMBERED = 12;

/** @type {Record<string, Table>} */
let tables = {};
/** @type {Record<string, number>} */
let layout = {};
/** @type {import("./played.js").Bits} */
let bits = { fatal: 0, escaped: 0, ambiguous: 0 };
/** @type {import("./machine.js").Machine | undefined} */
let machine;
/** @type {Played} */
let game;
let rung = RUNGS[0], pulled = 0, pace = 1, paused = false, before = 0, told = 0, frame = 0, asked = 0;
/** @type {{t: number, act: (t: number) => void}[] | null} what is replayed */
let replaying = null;
/** @type {{t: number, spread: number}[]} */
let parted = [];
/** The first and the last of them while all balls were near, and whether they are no more. @type {{from: {t: number, spread: number}, to: {t: number, spread: number}} | null} */
let near = null, far = false;
/** @type {Map<number, string>} */
let letters = new Map();
/** @type {Exits} */
let exits;
/** @type {Edit} */
let edit;
const sound = new Sound(), drawing = new TableDraw($("table")), curve = new Axes($("spread"), { left: 54, top: 30 });
const still = matchMedia("(prefers-reduced-motion: reduce)"), touch = matchMedia("(hover: none)");

/** @param {string} text */
function problem(text) {
  $("problem").hidden = !text;
  $("problem").firstElementChild.textContent = text;
}

/** @param {string} text */
function say(text, near = false) {
  if ($("said").textContent !== text) $("said").textContent = text;
  $("said").classList.toggle("near", near);
  told = performance.now();
}

/** Objects that a name of a slider stands for. @param {string} name */
const meant = (name) => (name.startsWith("*") ? game.table.params.filter((each) => each.endsWith(name.slice(1)) && kicks_or_hits(each)) : [name]);
/** Whether a parameter is that of a disc. @param {string} name */
const kicks_or_hits = (name) => game.table.objects.some((one) => one.kind === "disc" && name.startsWith(`${one.name}.`));

/** Sliders of a rung: words, those for one object, and the ends. @type {Record<string, {words: string, own?: string, low: number, high: (now: number) => number, unit: string}>} */
const SLIDERS = {
  "*.V": { words: "Kick of the bumpers V", own: "Kick V", low: 0, high: (now) => 2 * now || 1, unit: "" },
  "*.r": { words: "How much speed a bounce keeps r", own: "Bounce r", low: 0, high: () => 1, unit: "" },
  tilt: { words: "Tilt of the table", low: 0.02, high: (now) => (now > 1 ? Math.PI / 2 : 0.25), unit: "°" },
};

/**
 * A slider that is told in words.
 * @param {{name: string, words: string, low: number, high: number, value: number, told: (value: number) => string, set: (value: number) => void}} given
 */
function slider({ name, words, low, high, value, told: words_of, set }) {
  const label = document.createElement("label"), input = document.createElement("input"), shown = document.createElement("output");
  Object.assign(input, { type: "range", name, min: String(low), max: String(high), step: "any", value: String(value) });
  label.append(words, shown, input);
  shown.value = words_of(value);
  input.addEventListener("input", () => {
    set(Number(input.value));
    shown.value = words_of(Number(input.value));
  });
  return label;
}

/** Change numbers of the table, and show what comes of it. @param {string[]} names @param {number} value */
function turn(names, value) {
  for (const each of names) game.set(each, value);
  clearTimeout(asked);
  asked = window.setTimeout(basins, 200);
}

/** The sliders of the rung; of a disc that is edited, its own. */
function sliders() {
  const one = edit.on ? game.things[edit.chosen] : undefined;
  const own = one ? (one.law?.params ?? []).map((last) => `*.${last}`).filter((name) => name in SLIDERS) : rung.sliders;
  const made = own.map((name) => {
    const names = one ? [one.name + name.slice(1)] : meant(name), { words, own: single, low, high, unit } = SLIDERS[name], value = game.value(names[0]);
    const told = (/** @type {number} */ x) => (unit ? `${((180 / Math.PI) * x).toFixed(1)}${unit}` : x.toFixed(2));
    return slider({ name: one ? names[0] : name, words: one ? `${single} of ${letters.get(edit.chosen) ?? one.name.replaceAll("_", " ")}` : words, low, high: high(game.table.values[game.table.params.indexOf(names[0])]), value, told, set: (x) => turn(names, x) });
  });
  const told = (/** @type {number} */ x) => (x > 0.995 ? "real time" : `${x.toFixed(2)} of real time`);
  $("controls").replaceChildren(...made, slider({ name: "pace", words: "Slow motion", low: 0.05, high: 1, value: pace, told, set: (x) => (pace = x) }));
}

const basins = () => exits.show(game);

/** Say how the launches part. */
function shares() {
  if (!exits.shares || !exits.names) return $("shares").replaceChildren();
  const parts = exits.names.map((name, i) => {
    const chip = document.createElement("i");
    chip.style.setProperty("background", exits.colour(i));
    const line = document.createElement("span");
    const share = exits.shares?.[i] ?? 0;
    line.append(chip, `${name.replaceAll("_", " ")} ${share < 5e-4 ? "under 0.1" : (100 * share).toFixed(1)} %`);
    return { line, share };
  });
  const most = parts.filter(({ share }) => share > 0).sort((a, b) => b.share - a.share).slice(0, 5);
  $("shares").replaceChildren(...most.flatMap(({ line }) => [line, " "]));
}

/** Show a table. @param {string} name @param {Record<string, number>} changes */
function choose(name, changes = {}) {
  $("note").hidden = true;
  rung = RUNGS.find((each) => each.table === name) ?? RUNGS[0];
  for (const button of $("rungs").querySelectorAll("button")) button.setAttribute("aria-pressed", String(button.textContent === rung.name));
  $("headline").textContent = rung.headline;
  $("text").textContent = (touch.matches && rung.touch) || rung.text;
  $("asked").textContent = rung.heights ? "How often a ball hits" : "Where a ball leaves";
  if (!machine) return;
  game = new Played(machine, layout, tables[rung.table], bits);
  for (const [key, value] of Object.entries(changes)) game.set(key, value);
  if (game.things.some(({ name: own, shape }, j) => (`${own}.x` in changes || `${own}.y` in changes) && !hasRoom(game, j, shape.x, shape.y))) {
    problem("In the link a bumper overlaps something. The table is shown as it is built.");
    return choose(name);
  }
  const kicked = game.table.objects.map((one, j) => ({ one, j })).filter(({ one }) => one.law?.name === "triggered" || (one.kind === "disc" && (kicks(one) || rung.table === "three_discs")));
  letters = new Map(kicked.slice(0, 26).map(({ j }, i) => [j, String.fromCharCode(65 + i)]));
  for (const button of document.querySelectorAll("[data-press]")) /** @type {HTMLButtonElement} */ (button).hidden = !game.flippers.length;
  drawing.clear();
  forget();
  replaying = null;
  edit.turn(false);
  say("");
  $("word").textContent = "";
  exits.begin(game, rung);
  draw();
}

/** A disc was chosen, or editing begins or ends. */
function edited() {
  $("edit").setAttribute("aria-pressed", String(edit.on));
  $("table").classList.toggle("edited", edit.on);
  if (edit.on) {
    game.clear();
    drawing.clear();
    say(edit.chosen < 0 ? `Drag a bumper${touch.matches ? "." : "; [ and ] choose one by key, arrows move it."}` : `${letters.get(edit.chosen) ?? game.things[edit.chosen].name.replaceAll("_", " ")}: drag it, or turn its sliders.`);
  }
  sliders();
  draw();
}

/** Launch a ball. @param {State} state */
function launch(state) {
  if (edit.on) edit.turn(false);
  game.launch(state);
  drawing.clear();
  forget();
  paused = false;
  $("word").textContent = "";
  say("");
  run();
}

/** Launch by the plunger. @param {number} share how far it was pulled, from 0 to 1 */
function plunge(share) {
  replaying = null;
  const [x, y, angle] = game.table.launch, [low, high] = game.table.speeds, speed = low + share * (high - low);
  launch([x, y, speed * Math.cos(angle), speed * Math.sin(angle)]);
}

/** @param {number} i @param {boolean} down */
function press(i, down) {
  if (!game?.alive || replaying || i >= game.flippers.length || (down && game.tilted)) return;
  game.press(i, down);
}

/** Nudge the table: sideways and upwards, −1, 0 or 1. @param {number} across @param {number} up */
function nudge(across, up) {
  if (!game?.alive || replaying) return;
  const size = NUDGE * game.table.from[2];
  if (!game.nudge(across * size, up * size)) return say("A nudge moves a ball in the air; this one lies on something.");
  drawing.shake(across, up);
  if (!game.tilted) return;
  for (const i of game.flippers.keys()) game.press(i, false);
  say(game.flippers.length ? "TILT: nudged too often, the flippers are dead until the next ball." : "", true);
}

function split() {
  if (!game.alive) plunge(USUAL);
  game.fan(MANY, SMALL);
  forget();
}

/** What was measured of near balls is over. */
function forget() {
  parted = [];
  near = null;
  far = false;
}

/** The logarithm of the size of the table. */
const size = () => Math.log10(Math.max(game.table.box[1] - game.table.box[0], game.table.box[3] - game.table.box[2]));

/** Do again what the player did. */
function replay(start = game.start, presses = game.presses, nudges = game.nudges) {
  const list = Object.entries(presses).flatMap(([name, times]) => times.map((t, j) => ({ t, act: () => game.press(game.flippers.indexOf(name), j % 2 === 0, t) })));
  list.push(...nudges.map((each) => ({ t: each.t, act: () => game.leap(each) })));
  launch(start);
  replaying = list.sort((a, b) => a.t - b.t);
}

/** Start the clock. */
function run() {
  if (frame) return;
  before = performance.now();
  frame = requestAnimationFrame(tick);
}

/** @param {number} now */
function tick(now) {
  frame = 0;
  const passed = Math.min(FRAME, Math.max(0, (now - before) / 1000));
  before = now;
  if (pulled && now - pulled > 1000 * PULL) $("plunger").textContent = "Let go";
  if (game.alive && !paused) step(pace * passed);
  draw();
  if ((game.alive && !paused) || pulled) run();
}

/** Move on by some seconds of play. @param {number} seconds */
function step(seconds) {
  const until = game.t + seconds, flight = game.flight.begin;
  while (replaying?.length && replaying[0].t <= until) {
    const next = replaying.shift();
    if (!next) break;
    heard(game.advance(next.t));
    if (game.alive) next.act(next.t);
  }
  heard(game.advance(until));
  drawing.follow(game);
  if (game.ghosts.length && (!parted.length || game.t - parted[parted.length - 1].t > 1 / 60)) {
    const now = { t: game.t, spread: game.spread / Math.LN10 };
    parted.push(now);
    far ||= now.spread > size() + FAR;
    if (!far && Number.isFinite(now.spread)) near = { from: near?.from ?? now, to: now };
    parted = parted.filter(({ t }) => t > game.t - REMEMBERED);
  }
  if (game.end) over();
  else if (game.flight.begin === flight && !game.slides) nearMiss();
}

/** @param {import("./played.js").Hit[]} hits */
function heard(hits) {
  const fastest = Math.max(1e-9, game.table.speeds[1]);
  for (const hit of hits.slice(-3)) sound.hit(Math.abs(hit.before), fastest);
}

/** Tell of what has just been missed by little: there the next ball may go another way. */
let missed = "";
function nearMiss() {
  const { table, things, flight } = game;
  const near = [...things.entries()].flatMap(([j, one]) => {
    if (one.kind === "drain") return [];
    const off = missedBy(game, j), close = off >= 0 && off < NEAR * (one.kind === "disc" ? one.shape.radius : table.rho);
    return close ? [{ off, name: letters.get(j) ?? `the ${one.name.replaceAll("_", " ").replace(/\d+$/, "")}`, kick: kicks(one) || game.turns(one.name) }] : [];
  });
  // of several with one corner that which kicks: a touch of the others, if it is light, turns the ball by little
  const [told] = near.sort((a, b) => Number(b.kick) - Number(a.kick) || a.off - b.off), key = `${flight.begin} ${told?.name}`;
  if (!told || key === missed) return;
  missed = key;
  const far = table.mm ? `${(told.off / table.mm).toPrecision(2)} mm` : told.off.toPrecision(2);
  say(`Missed ${told.name} by ${far}: ${told.kick ? "here your future splits in two" : "near balls touch it and part from yours"}.`, true);
}

function over() {
  const many = game.hits.length, hits = `${many} hit${many === 1 ? "" : "s"} in ${game.t.toFixed(2)} s`;
  const how = game.end === "away" ? "The ball is gone for good" : game.end === "stopped" ? "The ball came to rest, or doubles could not follow it further" : game.end === "too often" ? "The ball hits too often to be followed further" : `The ball left through “${game.end.replaceAll("_", " ")}”`;
  const unsure = game.unsure ? ` ${game.unsure} of them doubles could not decide for sure; Python does.` : "";
  say(`${how}: ${hits}.${unsure} ${touch.matches ? "Launch" : "Space"} sends another.`);
  replaying = null;
}

function draw() {
  if (!game) return;
  const [x, y] = game.table.launch;
  drawing.draw(game, { letters, aim: game.alive ? null : [x, y], chosen: edit.chosen, at: before });
  if (letters.size) {
    const word = game.hits.map((hit) => letters.get(hit.owner) ?? "").join("").slice(-WORD);
    if ($("word").textContent !== word) $("word").textContent = word;
  }
  if ($("said").classList.contains("near") && performance.now() - told > 1000 * TOLD) say("");
  $("pause").setAttribute("aria-pressed", String(paused));
  $("table").classList.toggle("played", game.alive && !paused && game.flippers.length > 0);
  $("replay").disabled = !game.hits.length || game.changed;
  spread();
}

/** A large number in words that are read at a glance. @param {number} factor */
function said(factor) {
  const power = Math.floor(Math.log10(factor)), digit = (/** @type {number} */ x) => Number(x.toPrecision(2)).toLocaleString("en");
  return power < 6 ? digit(factor) : power < 9 ? `${digit(factor / 1e6)} million` : power < 12 ? `${digit(factor / 1e9)} billion` : `${digit(factor / 1e12)} trillion`;
}

/** The live curve of distances: on a logarithmic scale a straight line, as long as they are small. */
function spread() {
  const c = curve.begin(), { accent, faint } = theme();
  const logs = parted.filter(({ spread }) => Number.isFinite(spread)).map(({ t, spread }) => [t, spread]);
  const last = logs.at(-1)?.[0] ?? 1;
  curve.span(Math.max(0, last - REMEMBERED), Math.max(last, 1), Math.log10(SMALL) - 1, Math.ceil(size()));
  curve.frame("t", "log₁₀ of the distance");
  if (!logs.length) {
    c.fillStyle = faint;
    c.textAlign = "center";
    c.font = "15px system-ui, sans-serif";
    c.fillText(`Split the ball${touch.matches ? "." : ": G"}`, curve.box.x + curve.box.w / 2, curve.box.y + curve.box.h / 2);
    $("parted").textContent = "";
    return;
  }
  curve.inside((pen) => {
    pen.strokeStyle = accent;
    pen.lineWidth = 2;
    pen.beginPath();
    logs.forEach(([t, log], i) => (i ? pen.lineTo(curve.x(t), curve.y(log)) : pen.moveTo(curve.x(t), curve.y(log))));
    pen.stroke();
  });
  const [time, grown] = near ? [near.to.t - near.from.t, near.to.spread - near.from.spread] : [0, 0];
  $("parted").textContent = grown > 1 ? `In ${time.toFixed(1)} s distances grew ${said(10 ** grown)} times: tenfold every ${(time / grown).toFixed(2)} s${far ? ", as long as they were below a hundredth of the table" : ""}.` : "Near balls, each turned by a ten-millionth of a radian from the one before.";
}

const again = () => (draw(), exits?.draw());

const why = (/** @type {unknown} */ error) => (error instanceof Error ? error.message : String(error));

async function start() {
  stage(again); // its key waits for nothing that is loaded
  for (const each of RUNGS) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", textContent: each.name, disabled: true });
    button.addEventListener("click", () => {
      if (each !== rung) history.pushState(deep() + 1, "", `#v=1&table=${each.table}`); // Back leads to the table before
      choose(each.table);
    });
    $("paper").before(button);
  }
  $("paper").addEventListener("click", (/** @type {Event} */ event) => {
    // back to the step of the tour that was left here, unless in another tab
    if (!location.search || !document.referrer.startsWith(location.origin) || history.length < deep() + 2) return;
    event.preventDefault();
    history.go(-1 - deep());
  });
  $("problem").lastElementChild.addEventListener("click", () => problem(""));
  try {
    const [{ described, machines, pool }, answer] = await Promise.all([load({ problem: (text) => problem(text), again: () => exits && basins() }, ["table"]), fetch(addressOf("kernels/tables.json"))]);
    if (!answer.ok) throw new Error(`tables.json: ${answer.status} ${answer.statusText}`);
    ({ tables, layout } = await answer.json());
    for (const name in tables) tables[name] = unpacked(tables[name]);
    const { outcomes, fatal } = /** @type {any} */ (described);
    bits = { fatal: fatal & ~outcomes.no_impact, escaped: outcomes.escaped, ambiguous: outcomes.ambiguous };
    machine = machines.table;
    if (!machine || !pool) return;
    pool.see("table");
    exits = new Exits($("exits"), pool, shares, (state) => {
      replaying = null;
      launch(state);
      if (document.activeElement === exits.axes.canvas && game.flippers.length && !touch.matches) say("In the picture of exits arrows choose a launch; Z and M work the flippers there.");
      $("machine").scrollIntoView({ block: "nearest" }); // on a phone it is off the screen
    }, problem);
    edit = new Edit($("table"), { game: () => game, drawing, chose: edited, moved: () => (turn([], 0), draw()) });
  } catch (error) {
    problem(`The table could not be loaded: ${why(error)}.`);
    return;
  }
  for (const button of $("rungs").querySelectorAll("button")) button.disabled = false;
  listen();
  addEventListener("popstate", () => (problem(""), arrive()));
  if (!arrive() && !still.matches) {
    plunge(0.83);
    game.fan(60, SMALL);
    say(`A ball to show the table: ${touch.matches ? "Launch" : "Space"} sends yours.`);
  }
}

/** How many tables were chosen since the page was come to. */
const deep = () => Number(history.state);

/** Show what the address says; returns whether a ball flies there. */
function arrive() {
  let given = null;
  try {
    given = fromLink(location.hash, tables);
  } catch (error) {
    problem(`The link could not be read: ${why(error)}. The machine is shown instead.`);
  }
  choose(given?.table ?? "classic", given?.changes);
  note($("note"), given?.note ?? "");
  if (given?.start) replay(given.start, given.presses, given.nudges);
  return Boolean(given?.start);
}

function listen() {
  if (touch.matches) $("thumbs").append($("fan")); // within reach while the table is seen
  /** @type {Record<string, number>} */
  const KEYS = { ArrowLeft: 0, z: 0, Z: 0, ArrowRight: 1, m: 1, M: 1 };
  /** @type {Record<string, [number, number]>} */
  const NUDGES = { ArrowUp: [0, 1], a: [-1, 0], A: [-1, 0], d: [1, 0], D: [1, 0] };
  addEventListener("keydown", (event) => {
    const target = /** @type {HTMLElement} */ (event.target);
    // what is used by the picture of exits, or moves a slider, is no key of the table
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || isTyped(target) || (target.tagName === "INPUT" && event.key.startsWith("Arrow"))) return;
    if (event.key === "Enter" && target.id === "exits") return exits.chosen && exits.choose(...exits.chosen);
    const onButton = ["BUTTON", "A"].includes(target.tagName);
    if (event.key in KEYS) press(KEYS[event.key], true);
    else if (event.key in NUDGES) event.repeat || nudge(...NUDGES[event.key]);
    else if (event.key === " " && !onButton) {
      if (!pulled && !event.repeat) pulled = performance.now();
      run();
    } else if (event.key === "k" || event.key === "K") pause();
    else if (event.key === "g" || event.key === "G") split();
    else return;
    event.preventDefault();
  });
  addEventListener("keyup", (event) => {
    if (event.key in KEYS) press(KEYS[event.key], false);
    if (event.key === " " && pulled) release();
  });
  addEventListener("blur", () => {
    pulled = 0;
    for (const i of [0, 1]) press(i, false);
  });
  for (const button of document.querySelectorAll("[data-press]")) {
    const i = Number(/** @type {HTMLElement} */ (button).dataset.press);
    button.addEventListener("pointerdown", () => press(i, true));
    for (const up of ["pointerup", "pointercancel", "pointerleave"]) button.addEventListener(up, () => press(i, false));
  }
  // thumbs on the table itself: the half that is touched
  const touched = /** @type {Map<number, number>} */ (new Map()), canvas = $("table");
  let idle = false;
  canvas.addEventListener("click", () => idle && !edit.on && plunge(USUAL)); // and not where a finger begins to scroll
  canvas.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
    canvas.focus();
    if (edit.on) return;
    idle = !game.alive;
    if (idle) return;
    const i = event.offsetX < canvas.clientWidth / 2 ? 0 : 1;
    touched.set(event.pointerId, i);
    press(i, true);
  });
  for (const up of ["pointerup", "pointercancel"]) canvas.addEventListener(up, (/** @type {PointerEvent} */ event) => {
    const i = touched.get(event.pointerId);
    touched.delete(event.pointerId);
    if (i !== undefined) press(i, false);
  });
  $("plunger").addEventListener("pointerdown", () => {
    pulled = performance.now();
    run();
  });
  $("nudge").addEventListener("click", () => nudge(0, 1));
  $("plunger").addEventListener("pointerup", () => release(true));
  $("plunger").addEventListener("click", (/** @type {MouseEvent} */ event) => event.detail === 0 && plunge(USUAL)); // by key
  $("pause").addEventListener("click", pause);
  $("fan").addEventListener("click", split);
  // a hand that has pressed a button plays on by keys: Space launches, and presses it not again
  document.addEventListener("click", ({ detail, target }) => detail && /** @type {Element} */ (target).closest("button") && canvas.focus({ preventScroll: true }));
  $("edit").addEventListener("click", () => edit.turn(!edit.on));
  $("replay").addEventListener("click", () => replay());
  $("sound").addEventListener("click", () => {
    problem(sound.turn(!sound.on));
    $("sound").setAttribute("aria-pressed", String(sound.on));
  });
  for (const button of document.querySelectorAll("[data-copy]")) button.addEventListener("click", async () => {
    const what = /** @type {HTMLElement} */ (button).dataset.copy;
    const text = what === "link" ? new URL(toLink(rung.table, game), location.href).href : python(rung.table, game);
    try {
      await navigator.clipboard.writeText(text);
      const said = ($("copied").textContent = `Copied${what === "link" ? reach("site” makes a folder for a web server") : ""}.`);
      setTimeout(() => $("copied").textContent === said && ($("copied").textContent = ""), 4000 + 60 * said.length);
    } catch {
      $("copied").textContent = text;
    }
  });
  const sizes = new ResizeObserver(again);
  for (const each of [document.body, $("spread"), $("exits")]) sizes.observe(each); // before a room they change, and the page does not
  dark.addEventListener("change", again);
}

/** Let go of the plunger. @param {boolean} [tapped] whether a pull may have been meant for none */
function release(tapped) {
  if (!pulled) return;
  const share = Math.min(1, (performance.now() - pulled) / 1000 / PULL);
  pulled = 0;
  $("plunger").textContent = "Launch";
  const usual = tapped && share < TAP;
  plunge(usual ? USUAL : share);
  if (usual) say("Hold Launch to choose how hard.");
}

function pause() {
  paused = !paused;
  say(paused ? "Paused: press Pause again to go on." : "");
  if (!paused) run();
  draw();
}

/** For tests: what is shown. */
Object.assign(window, { pinball: { game: () => game, edit: () => edit, drawing: () => drawing, exits: () => exits, step: (/** @type {number} */ s) => (step(s), draw()), pause, launch, plunge, press, nudge, split, letters: () => [...letters.values()], parted: () => parted } });
start();
