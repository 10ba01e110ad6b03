// @ts-check
/** The page: loads the kernels, keeps the state, and shows the view that the state names. */
import { BallView } from "./ball.js";
import { ChartView } from "./chart.js";
import { dark } from "./colours.js";
import { nodes, plainSymbol, typeset } from "./controls.js";
import { EdgesView } from "./edges.js";
import { FlowView } from "./flow.js";
import { GapView } from "./gap.js";
import { guided } from "./guide.js";
import { BROUGHT, above, fileOf, ofLaws, ownOf } from "./laws.js";
import { load } from "./load.js";
import { MapView } from "./mapped.js";
import { WORDS } from "./names.js";
import { panel } from "./panel.js";
import { Pinned } from "./pinned.js";
import { EXERCISES, PRESETS } from "./presets.js";
import { copy, save } from "./share.js";
import { HINTS, NEEDS, SHOWN, ZOOMED } from "./scenes.js";
import { CHOICES, DEFAULTS, PINNABLE, VARIED, adopt, allowed, fromFragment, mended, narrowest, opening, refusal, tidy, toFragment, varied, wholeOf, zoomedOut } from "./state.js";
import { isTyped, stage } from "./stage.js";
import { StrobeView } from "./strobe.js";
import { command, isFigure, python } from "./text.js";
import { TOUR } from "./tour.js";
import { still } from "./walls.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./state.js").Pair} Pair */
/** @typedef {import("./controls.js").Control} Control */
/**
 * What the page asks of a view; `record` puts what has moved since into the state.
 * @typedef {{show: (state: State) => void, repaint: () => void, raster: () => Record<string, any>, lead?: () => {headline: string, said: import("./state.js").Line[]}, summary: () => import("./state.js").Line[], panels: () => import("./svg.js").Panel[], record?: () => void, key?: string, diagram?: import("./diagram.js").Diagram}} View
 */

const $ = (/** @type {string} */ id) => /** @type {any} */ (document.getElementById(id));
/** @type {Record<string, View>} */
const views = {};
/** @type {BallView | undefined} */
let ball;
/** @type {Record<string, Control>} */
const controls = {};
/** @type {Map<string, string>} */
const problems = new Map();
/** @type {import("./state.js").Fields} */
const fields = {};
let state = structuredClone(DEFAULTS), home = structuredClone(DEFAULTS), scheduled = 0, waiting = false, linking = 0, stepped = false, failed = false;
/** @type {import("./pool.js").Pool | null} */
let pool = null;
/** @type {((state: State) => void) | undefined} */
let guide;
/** @type {Pinned | undefined} */
let pinned;
/** The address as the page wrote or read it, the text that asked last for sliders, and the note when a hand last acted. */
let linked = "", asked = "", acted = "";
/** What makes another scene. */
const SCENE = ["view", "chart", "vary", "second", "law", "tour"];
/** Milliseconds without a change after which the address follows. */
const REST = 150;
/** A part of a state by its name. @param {State} of @param {string} key */
const part = (of, key) => /** @type {Record<string, any>} */ (of)[key];
/** @returns {View | undefined} */
const current = () => views[state.view];
/** What `share.js` asks of the page. */
const page = { view: current, more: () => pinned?.panels() ?? [], repaint: () => (current()?.repaint(), pinned?.repaint()), state: () => state, drawn: () => !problems.has("picture"), address: () => address() };
/** @param {unknown} error */
const wordsOf = (error) => (error instanceof Error ? error.message : String(error));
/** @param {string} selector @returns {HTMLElement[]} */
const all = (selector) => [...document.querySelectorAll(selector)].map((each) => /** @type {HTMLElement} */ (each));

/** Say a problem in words, one for each subject; an empty text takes it back. @param {string} text */
function problem(text, about = "input") {
  if (text) problems.set(about, text);
  else problems.delete(about);
  $("problem").hidden = problems.size === 0;
  const shown = [...problems.values()].join("\n");
  if ($("problem").firstElementChild.textContent !== shown) $("problem").firstElementChild.textContent = shown;
}

/** What is on screen: the view, and in charts what is charted. */
const scene = () => (state.view === "chart" ? `chart-${state.chart}` : state.view);

/** Change parts of the state; null for an axis shows all of it. Returns what takes that back. @param {object} given */
function change(given) {
  /** @type {Record<string, any>} */
  const next = { ...given }, before = structuredClone(state);
  if ("vary" in next && !next.reach) Object.assign(next, { reach: wholeOf("reach", next.vary), window: null });
  if ("second" in next && !next.heights) next.heights = wholeOf("heights", next.second);
  if ("coordinate" in next) next.window = null;
  follow(next);
  const named = /** @type {Record<string, string>} */ ({ reach: next.vary ?? state.vary, heights: next.second ?? state.second });
  for (const key of Object.values(ZOOMED).flat()) {
    if (key in next) next[key] = next[key] ? trimmed(allowed(fields[named[key]], next[key])) : part(home, key);
  }
  for (const key of Object.keys(next)) {
    if (typeof next[key] !== "number" || !fields[key]) continue;
    if (key === "mu" || key === state.vary) {
      const [from, to] = key === "mu" ? state.span : state.reach;
      if (document.activeElement?.tagName !== "INPUT") next[key] = tidy(next[key], to - from);
    }
    const why = refusal(key, next[key], fields);
    if (!why) continue;
    problem(`${why}.`);
    delete next[key];
  }
  const { vary, second } = state;
  acted = "note" in next ? "" : state.note;
  if (SCENE.some((key) => key in next && next[key] !== part(state, key))) leave();
  Object.assign(state, next);
  mended(state, fields);
  if (state.vary !== vary) home.reach = wholeOf("reach", state.vary);
  if (state.second !== second) home.heights = wholeOf("heights", state.second);
  refresh();
  return () => {
    Object.assign(state, before);
    refresh();
  };
}

/** Where a parameter leaves its diagram, that goes along. @param {Record<string, any>} next */
function follow(next) {
  const [name, axis, other] = state.view === "gap" ? ["mu", "span", "range"] : [state.vary, "reach", "window"], value = next[name];
  const [low, high] = part(state, axis), middle = (high - low) / 2;
  if (typeof value === "number" && !(axis in next) && !(value >= low && value <= high) && !refusal(name, value, fields)) Object.assign(next, { [axis]: [value - middle, value + middle], [other]: null });
}

/** @param {Pair} ends @returns {Pair} */
const trimmed = ([low, high]) => {
  const least = narrowest(low, high), middle = (low + high) / 2;
  if (high - low < 1.01 * least) [low, high] = [middle - least, middle + least];
  return [tidy(low, high - low), tidy(high, high - low)];
};

/** Show the state: the first change of a frame at once, those after it together in the next frame. */
function refresh() {
  if (scheduled) {
    waiting = true;
    return;
  }
  scheduled = requestAnimationFrame(() => {
    scheduled = 0;
    if (!waiting) return;
    waiting = false;
    refresh();
  });
  try {
    $("main").classList.toggle("failed", (failed = false));
    render();
  } catch (error) {
    $("main").classList.toggle("failed", (failed = true)); // no frame stands empty
    problem(`The picture could not be made: ${wordsOf(error)}.`, "picture");
    console.error(error);
    // neither words nor picture of another state
    $("summary").replaceChildren();
    const first = current()?.panels()[0]?.sheet;
    first?.say(`No picture: ${wordsOf(error)}.`);
    if (first) first.canvas.dataset.stage = "failed";
  }
}

function render() {
  problem("", "picture");
  const shown = scene();
  const isIn = (/** @type {string | undefined} */ scenes) => (scenes ?? "").split(" ").includes(shown);
  for (const section of all("[data-for]")) section.hidden = !isIn(section.dataset.for);
  $("main").dataset.shown = state.view;
  $("main").classList.toggle("web", Boolean((TOUR[state.tour - 1]?.state ?? home).web)); // where there is room for one picture it is the cobweb
  for (const button of all("[data-view]")) button.setAttribute("aria-pressed", String(button.dataset.view === state.view));
  for (const [name, control] of Object.entries(controls)) {
    control.set(part(state, name));
    if (SHOWN[name]) control.box.hidden = !isIn(SHOWN[name]);
  }
  for (const name of ["theory", "reduced"]) controls[name].box.hidden ||= state.view === "oscillator" && (!still(state) || Boolean(ownOf(state))); // there is no normal form
  if (BROUGHT.model?.coordinates?.length === 1) for (const name of ["coordinate", "velocities", "chart_rows"]) controls[name].box.hidden = true;
  const had = varied(state);
  for (const name of VARIED.filter((each) => above(each) || ofLaws(each))) controls[name].box.hidden = !had.includes(name);
  for (const axis of ["vary", "second"]) controls[axis].offer?.(had);
  controls.window.name?.(state.coordinate);
  if (fields[state.second]) controls.heights.name?.(plainSymbol(fields[state.second]));
  if (fields[state.vary]) controls.reach.name?.(plainSymbol(fields[state.vary]));
  for (const name of /** @type {("twin" | "sweeps")[]} */ (["twin", "sweeps"])) $(name).setAttribute("aria-pressed", String(state[name]));
  guide?.(state);
  const { text = "", question } = TOUR[state.tour - 1] ?? {}, asks = [state.note, text, question?.ask].join(" ");
  if (asks !== asked) for (const name of VARIED) controls[name].box.classList.toggle("asked", RegExp(`(?<!\\p{L})${plainSymbol(fields[name])}(?![\\p{L}²_])`, "u").test(asks));
  asked = asks;
  if (acted !== state.note) fold();
  typeset($("hint"), ((!still(state) || ownOf(state)) && HINTS[`${shown}-${state.two ? "two" : "moving"}`]) || HINTS[shown]);
  if ($("preset").value && !($("preset").value in PRESETS && isFigure(state, $("preset").value))) $("preset").value = "";
  clearTimeout(linking);
  linking = window.setTimeout(address, REST);
  const view = current();
  $("summary").hidden = !view;
  if (!view && problems.has("kernels")) return;
  if (!view) {
    problem(`This view needs the module ${NEEDS[state.view]}.wasm, which could not be loaded; choose another view.`, NEEDS[state.view]);
    return;
  }
  pool?.see(shown);
  pinned?.show();
  view.show(state);
  $("all").hidden = ZOOMED[shown].every((key) => same(part(state, key), part(home, key)));
  tell();
}

/** Put the state into the address. Not at every move of a slider: that costs more than a picture, and browsers allow few. */
function address() {
  clearTimeout(linking);
  if (location.hash !== linked) {
    // the browser has gone elsewhere in its history, and is about to say so
    linked = location.hash;
    linking = window.setTimeout(address, REST);
    return;
  }
  const link = toFragment(state);
  if (link !== location.hash) history[stepped ? "pushState" : "replaceState"](null, "", link);
  linked = location.hash;
  stepped = false;
}

/** What an exercise asks takes one line once a hand has acted, until it is clicked. */
const fold = () => $("note").classList.toggle("folded", acted !== "" && acted === state.note);

/** Another scene comes: the one that is left is a step of the history, to which Back leads. */
function leave() {
  if (location.hash) address();
  stepped = true;
}

const same = (/** @type {unknown} */ a, /** @type {unknown} */ b) => JSON.stringify(a) === JSON.stringify(b);

/** The slider of the diagram's parameter reaches as far as the diagram, whose colours are its track. @param {import("./diagram.js").Diagram | undefined} diagram */
function spanSliders(diagram) {
  const turned = state.view === "gap" ? "mu" : state.vary;
  for (const name of ["mu", ...VARIED]) {
    controls[name].box.classList.toggle("turned", name === turned);
    if (name !== turned) controls[name].span?.(null);
  }
  controls[turned].span?.(!diagram ? null : state.view === "gap" ? state.span : state.reach, diagram?.band());
}

/** A text after a chip of its colour. @param {import("./state.js").Line} line */
function chipped({ colour, text, exact = "" }) {
  const chip = document.createElement("i"), rest = document.createElement("span");
  chip.className = "chip";
  chip.style.background = colour ?? "";
  rest.className = "exact";
  rest.textContent = exact;
  return [...(colour ? [chip] : []), ...nodes(text.replace(/(?<!\w)-(?=\d)/g, "−")), ...(exact ? [rest] : [])];
}

/** Say in words what is shown. */
function tell() {
  const view = current();
  if (!view || failed || waiting) return;
  const made = view.summary();
  const diagram = view.diagram;
  const lead = view.lead?.();
  if (lead) {
    $("headline").textContent = lead.headline;
    $("lead").replaceChildren(...lead.said.flatMap(chipped));
    const word = WORDS[state.vary], text = state.vary.includes(".") ? word : `the ${word}`;
    if ($("turned").textContent !== text) $("turned").textContent = text;
    $("turned").nextElementSibling.textContent = plainSymbol(fields[state.vary]);
  }
  spanSliders(diagram);
  const { low, high } = view.raster(), axis = state.view === "gap" ? "range" : ["oscillator", "map"].includes(state.view) ? "window" : null;
  if (axis && !state[axis] && !Number.isNaN(low) && !controls[axis].box.contains(document.activeElement)) controls[axis].set([low, high]);
  if (diagram?.stage === "done" && diagram.ended) made.push({ text: `${diagram.ended} of the starts in the diagram ended early.` });
  if (diagram?.stage === "done" && diagram.ambiguous) made.push({ text: `${diagram.ambiguous} starts of the diagram met a decision that double precision cannot make.` });
  $("summary").replaceChildren(
    ...made.map((each) => {
      const line = document.createElement("p");
      line.append(...chipped(each));
      return line;
    }),
  );
}

/** Show a figure of the paper or a step of the tour: its state, and the defaults in all else. @param {Partial<State>} shown */
function present(shown) {
  leave();
  state = { ...structuredClone(DEFAULTS), theory: state.theory, colour: state.colour, pinned: state.pinned, ...structuredClone(shown) };
  home = structuredClone(state);
  anew();
  refresh();
}

/** What is shown is another thing: the ball does not go on in it. */
const anew = () => ball && (ball.another = true);

/** The diagram on screen that can be kept to compare. */
const comparable = () => /** @type {import("./pinned.js").Shown | undefined} */ (PINNABLE.includes(state.view) ? current() : undefined);

/** Show all of every axis. */
const showAll = () => change(Object.fromEntries(ZOOMED[scene()].map((key) => [key, null])));

function build() {
  Object.assign(controls, panel({ fields, change, problem, state: () => state }));
  for (const button of all("[data-view]")) {
    button.hidden = !CHOICES.view.includes(button.dataset.view ?? "");
    button.addEventListener("click", () => {
      const { view } = button.dataset, gone = Object.values(EXERCISES).some(([ask, link]) => ask === state.note && !link.includes(`view=${view}&`) && !ask.includes(`(${button.textContent})`));
      change({ view, ...(gone && { note: "" }), ...(view === "chart" ? { chart: chartOf(state) } : {}) });
    });
  }
  $("preset").hidden = $("tour").hidden = Boolean(BROUGHT.model?.map);
  for (const [name, { title }] of Object.entries(PRESETS)) $("preset").add(new Option(`${name}  ${title}`, name));
  const asked = Object.assign(document.createElement("optgroup"), { label: "Exercises" });
  const table = /** @type {HTMLAnchorElement | null} */ (document.querySelector("nav a"));
  for (const [title, [ask, link]] of Object.entries(EXERCISES)) if (table || !link.startsWith("#table")) asked.append(new Option(title, `${link}&note=${encodeURIComponent(ask)}`));
  $("preset").append(asked);
  // who has chosen with a mouse leaves the keys to the picture; who goes through the list by keys stays in it
  let pointed = false;
  $("preset").addEventListener("pointerdown", () => (pointed = true));
  $("preset").addEventListener("keydown", () => (pointed = false));
  $("preset").addEventListener("change", () => {
    const { value } = $("preset");
    if (pointed) $("preset").blur();
    if (value in PRESETS) present(PRESETS[value].state);
    else if (table && value.startsWith("#table")) location.href = table.href + value;
    else if (value) location.hash = value;
  });
  if (pool) pinned = new Pinned($("pin"), pool, { fields, change, problem: (text) => problem(text, "picture"), view: comparable, state: () => state });
  for (const { diagram } of PINNABLE.map((name) => views[name] ?? {})) if (diagram) diagram.drew = () => pinned?.draw();
  guide = guided({ change, present, state: () => state });
  $("problem").lastElementChild.addEventListener("click", () => {
    problems.clear();
    problem("");
  });
  $("all").addEventListener("click", showAll);
  for (const button of all("[data-copy]")) button.addEventListener("click", () => copy(page, button.dataset.copy ?? ""));
  for (const button of all("[data-save]")) button.addEventListener("click", () => save(page, button.dataset.save ?? ""));
  $("play").addEventListener("click", () => ball?.play(!ball.playing));
  $("step").addEventListener("click", () => ball?.step());
  $("sound").addEventListener("click", () => {
    problem(ball?.sound.turn(!ball.sound.on) ?? "", "sound");
    $("sound").setAttribute("aria-pressed", String(Boolean(ball?.sound.on)));
  });
  const web = () => /** @type {GapView | MapView | undefined} */ (views.gap ?? views.map)?.cobweb;
  for (const [id, by] of /** @type {[string, number][]} */ ([["web-step", 1], ["web-many", 10], ["web-none", -Infinity]])) $(id).addEventListener("click", () => web()?.step(by));
  for (const name of /** @type {("twin" | "sweeps")[]} */ (["twin", "sweeps"])) $(name).addEventListener("click", () => change({ [name]: !state[name] }));
  $("settle").addEventListener("click", () => ball?.settle());
  $("speed").addEventListener("input", () => ball && (ball.speed = Number($("speed").value)));
  $("controls").addEventListener("submit", (/** @type {Event} */ event) => event.preventDefault());
  addEventListener("hashchange", (event) => {
    const { hash } = new URL(event.newURL);
    linked = hash;
    if (hash !== toFragment(state)) read(hash);
  });
  dark.addEventListener("change", () => { again(); tell(); });
  // a button that a mouse has pressed leaves the keys to the picture; so does what has no use for a key
  addEventListener("click", ({ detail, target }) => detail && /** @type {HTMLElement | null} */ (/** @type {HTMLElement} */ (target).closest("button, summary, [type=checkbox]"))?.blur());
  addEventListener("keydown", (event) => {
    const target = /** @type {HTMLElement} */ (event.target), pictures = seen(), { key } = event, free = target === document.body;
    if (event.ctrlKey || event.metaKey || event.altKey || isTyped(target) || (target.tagName === "CANVAS" && !(key === "0" && state.web && target.id === "gap-diagram")) || (!free && (/^(Arrow|Enter)/.test(key) || (key === " " && target.tagName !== "INPUT")))) return;
    // beside a cobweb with stairs the key that begins again is first of all the cobweb's
    const took = offered(event, key === "0" && state.web ? [...pictures].reverse() : pictures);
    if (took < 0) return;
    event.preventDefault();
    if (key === "0") event.stopPropagation();
    if (free && took === 0 && key !== "0") pictures[0].focus({ preventScroll: true });
  }, true);
  addEventListener("keydown", (event) => {
    const { target, defaultPrevented, ctrlKey, metaKey, altKey, key } = event;
    if (/** @type {HTMLElement} */ (target).tagName !== "CANVAS" || defaultPrevented || ctrlKey || metaKey || altKey || /^(Arrow|Enter)/.test(key)) return;
    if (offered(event, seen().filter((each) => each !== target)) >= 0) event.preventDefault();
  });
  for (const end of ["pointerup", "keyup"]) addEventListener(end, () => setTimeout(fold)); // and not under a hand that drags
  const sizes = new ResizeObserver(again);
  for (const canvas of all(".view canvas")) sizes.observe(canvas);
}

/** Take the state from the link. @param {string} hash */
function read(hash) {
  clearTimeout(linking);
  stepped = false;
  linked = hash;
  const { state: found, problems: wrong } = fromFragment(hash, fields);
  state = hash.length > 1 ? found : opening();
  home = zoomedOut(state);
  anew();
  problem(wrong.length ? `Parts of the link could not be used: ${wrong.join("; ")}. They are shown as usual.` : "", "link");
  refresh();
}

/** Offer a key to pictures, and say which of them took it. @param {KeyboardEvent} event @param {HTMLElement[]} pictures */
const offered = ({ key, shiftKey }, pictures) => pictures.findIndex((each) => !each.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey, cancelable: true })));

/** The chart of the system that is seen. @param {State} state */
const chartOf = ({ view, chart }) => (["gap", "edges"].includes(view) ? "gap" : chart === "gap" && view !== "chart" ? "oscillator" : chart);

/** The pictures that have the keys, each those that the ones before do not take. */
const seen = () => all(".view canvas[tabindex]").filter((each) => each.offsetParent);

/** Draw all once more. */
const again = () => (failed ? refresh() : page.repaint());

async function begin() {
  $("unread").remove();
  stage(again); // its key waits for nothing that is loaded
  let loaded;
  const afresh = () => {
    for (const view of Object.values(views)) view.key = undefined;
    if (current()) refresh();
  };
  try {
    loaded = await load({ problem, again: afresh });
  } catch (error) {
    problem(`The kernels could not be loaded (${wordsOf(error)}). This page must come from a web server together with the folder kernels: run "grazing explore".`, "kernels");
    return;
  }
  const { described, machines } = loaded;
  pool = loaded.pool;
  if (!document.createElement("canvas").getContext("2d")) problem("This browser gives the page no canvas: pictures cannot be drawn. What is shown is said in words below, and what is copied is right all the same.", "canvas");
  for (const module of Object.values(described.modules)) for (const field of module.fields) fields[field.name] = field;
  if (described.model) {
    const { name, state: shown } = described.model;
    adopt(described.model);
    if (!described.model.map) PRESETS[name] = { title: `of ${fileOf(described.model)}`, state: shown };
  }
  const events = { change, problem: (/** @type {string} */ text) => problem(text, "picture"), done: tell };
  if (machines.gap && pool) {
    views.gap = new GapView(machines.gap, pool, described, events);
    views.edges = new EdgesView(machines.gap, described, events);
  }
  if (machines.oscillator && pool) {
    views.oscillator = new FlowView(machines.oscillator, machines.gap, pool, described, events);
    views.strobe = new StrobeView(machines.oscillator, events);
    views.ball = ball = new BallView(machines.oscillator, described, events, pool);
  }
  if (machines.map && pool) views.map = new MapView(machines.map, pool, described, events);
  if (pool && Object.keys(machines).length) views.chart = new ChartView(machines, pool, described, events);
  build();
  read(location.hash);
  // for tests and for the curious: what is on screen
  Object.assign(globalThis, { explorer: { views, state: () => state, link: () => toFragment(state), texts: () => ({ python: python(state, views[state.view].raster()), command: command(state, views[state.view].raster()) }) } });
}

begin();
