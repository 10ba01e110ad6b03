// @ts-check
/** The controls of the page, in their places. */
import { choice, pair, slider, symbolOf, toggle } from "./controls.js";
import { BROUGHT, above, fileOf } from "./laws.js";
import { WORDS } from "./names.js";
import { CHOICES, GAP_EXTENTS, ORDERS, OSCILLATOR_EXTENTS, VARIED, VERSION, fromFragment } from "./state.js";

/** @typedef {import("./controls.js").Control} Control */
/** What the page lends. @typedef {{fields: import("./state.js").Fields, change: (part: object) => void, problem: (text: string) => void, state: () => import("./state.js").State}} Page */

const place = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** Make the controls, by the names of what they change. @param {Page} page */
export function panel(page) {
  const { fields, change, problem, state } = page;
  /** @type {Record<string, Control>} */
  const controls = {};
  const own = (/** @type {string} */ name) => (/** @type {unknown} */ value) => change({ [name]: value });
  /** @param {string[]} names @returns {[string, string][]} */
  const named = (names) => names.map((name) => [name, name]);
  for (const [name, extent] of Object.entries(GAP_EXTENTS)) {
    controls[name] = slider(fields[name], /** @type {[number, number]} */ (extent), own(name), problem);
    place("gap-sliders").append(controls[name].box);
  }
  const more = document.createElement("details");
  const title = document.createElement("summary");
  title.textContent = "More settings";
  more.append(title);
  const { model } = BROUGHT, added = Object.keys(OSCILLATOR_EXTENTS).filter((name) => name.includes("."));
  /** @type {[string, string][]} */
  const brought = model?.own.length ? [[model.law, `${model.law} (of ${fileOf(model)})`]] : [];
  for (const name of added) WORDS[name] = above(name) ? "your law’s, above" : "your law’s";
  for (const [name, units] of Object.entries(model?.units ?? {})) if (units && units !== "1") fields[name].units = units;
  controls.law = choice("bumper", [["newton", "passive (Newton)"], ["active", "adds the kick V (active)"], ["triggered", "adds V when hit hard (triggered)"], ...brought], own("law"));
  place("oscillator-sliders").append(controls.law.box);
  controls.two = toggle("a second wall, above the ball", own("two"));
  const first = ["offset", ...added.filter((name) => !above(name)), "V", "trigger", "r", "omega", "alpha", "k", "sigma_B", "r_B", ...added.filter(above), "V_B", "trigger_B"];
  for (const name of [...first, ...Object.keys(OSCILLATOR_EXTENTS).filter((each) => !first.includes(each))]) {
    controls[name] = slider(fields[name], OSCILLATOR_EXTENTS[name], own(name), problem);
    (first.includes(name) ? place("oscillator-sliders") : more).append(controls[name].box);
  }
  place("oscillator-sliders").append(controls.two.box, ...first.filter(above).map((name) => controls[name].box), more);
  for (const name of model?.map ? VARIED : []) {
    WORDS[name] = "your map’s";
    controls[name] = slider(fields[name], model?.extents[name] ?? [0, 1], own(name), problem);
    place("map-sliders").append(controls[name].box);
  }
  place("map-title").textContent = model?.map ? `Map ${model.name} (of ${fileOf(model)})` : "";
  const picture = place("picture");
  const put = (/** @type {string} */ name, /** @type {Control} */ control) => {
    controls[name] = control;
    picture.append(control.box);
  };
  const axis = (/** @type {string} */ key, /** @type {string} */ symbol) => pair(symbol, (ends) => change({ [key]: ends }), problem, (text) => {
    const { law, vary, second, two, sigma, sigma_B } = state();
    return fromFragment(`version=${VERSION}&law=${law}&two=${two ? "yes" : "no"}&sigma=${sigma}&sigma_B=${sigma_B}&vary=${vary}&second=${second}&${key}=${text}`, fields).problems;
  });
  /** @type {[string, string][]} */
  const axes = VARIED.map((name) => [name, `${WORDS[name]} ${symbolOf(fields[name]).join("")}`]);
  put("u0", slider({ name: "u0", symbol: "u_0", meaning: "start of the zero-time map", low: null, high: null, open_low: false }, [0, 0.5], own("u0"), problem));
  put("v0", slider({ name: "v0", symbol: "v_0", meaning: "velocity at the start", low: null, high: null, open_low: false }, [-1, 1], own("v0"), problem));
  put("line", axis("line", "u(0)"));
  put("order", choice("local map", named(ORDERS), own("order")));
  const charts = Object.entries({ gap: "gap map", oscillator: "oscillator", basins: "basins of the oscillator", map: "periods", "map-basins": "basins" });
  put("chart", choice("chart of", charts.filter(([name]) => CHOICES.chart.includes(name)), own("chart")));
  put("vary", choice("axis", axes, own("vary")));
  put("second", choice("second axis", axes, own("second")));
  const [across, up] = model?.coordinates ?? ["u", "v"], called = [`${across}: position`, `${up}: velocity`];
  put("coordinate", choice("coordinate", CHOICES.coordinate.map((name, i) => [name, model?.map ? name : called[i]]), own("coordinate")));
  put("periods", pair("periods", (periods) => change({ periods }), problem, (text) => fromFragment(`version=${VERSION}&periods=${text}`, fields).problems, true));
  put("span", axis("span", "μ"));
  put("range", axis("range", "x"));
  put("positions", axis("positions", across));
  put("velocities", axis("velocities", up ?? ""));
  put("gaps", axis("gaps", "l"));
  put("reach", axis("reach", "reach"));
  put("heights", axis("heights", "heights"));
  put("window", axis("window", "window"));
  put("theory", toggle("windows of theory", own("theory")));
  put("colour", toggle("colour by period", own("colour")));
  put("reduced", toggle("reduced diagram below", own("reduced")));
  const finer = document.createElement("details");
  const word = document.createElement("summary");
  word.textContent = "Accuracy";
  finer.append(word);
  for (const [name, text, least] of /** @type {[string, string, number][]} */ ([["chart_columns", "columns of the chart", 2], ["chart_rows", "rows of the chart", 2], ["columns", "columns", 2], ["bins", "rows", 2], ["starts", "starts, gap map", 1], ["transient", "steps passed over", 0], ["keep", "steps counted", 1], ["flow_starts", "starts, oscillator", 1], ["flow_transient", "periods passed over", 0], ["flow_keep", "periods counted", 1], ["seed", "seed", 0]])) {
    controls[name] = whole(name, text, least, page);
    finer.append(controls[name].box);
  }
  put("accuracy", { box: finer, set() {} });
  return controls;
}

/** A number field for a whole number. @param {string} name @param {string} text @param {number} least @param {Page} page @returns {Control} */
function whole(name, text, least, { fields, change, problem }) {
  const made = pair(text, () => {}, problem);
  const [, field, second] = made.box.children;
  made.box.children[0].textContent = text;
  second.remove();
  const input = /** @type {HTMLInputElement} */ (field.cloneNode());
  field.replaceWith(input);
  input.min = String(least);
  input.step = "1";
  input.name = name;
  input.setAttribute("aria-label", text);
  made.box.append(document.createElement("span"));
  input.addEventListener("change", () => {
    const { state: found, problems: why } = fromFragment(`version=${VERSION}&${name}=${input.value}`, fields);
    input.toggleAttribute("aria-invalid", why.length > 0);
    problem(why.join("; "));
    if (!why.length) change({ [name]: /** @type {Record<string, any>} */ (found)[name] });
  });
  return { box: made.box, set: (/** @type {number} */ value) => (input.value = String(value)) };
}
