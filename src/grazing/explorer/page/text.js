// @ts-check
/** What is shown, as a Python program and as a command: both make exactly the raster on screen. */
import { BROUGHT, LAWS, ownOf, plain } from "./laws.js";
import { PRESETS } from "./presets.js";
import { DEFAULTS } from "./state.js";
import { SWEEP } from "./sweeps.js";
import { still } from "./walls.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {Record<string, any>} Raster what a view says of its picture */

const numbers = (/** @type {number[]} */ list) => `(${list.join(", ")}${list.length === 1 ? "," : ""})`;

/** Amplitudes up to the last that is not zero, at least one. @param {State} state @param {"cos" | "sin"} kind */
function amplitudes(state, kind) {
  const all = /** @type {const} */ ([1, 2, 3]).map((j) => state[`${kind}${j}`]);
  if (!still(state)) return all; // rounding between walls knows how many there are
  while (all.length > 1 && all.at(-1) === 0 && state.vary !== `${kind}${all.length}` && !(state.view === "chart" && state.second === `${kind}${all.length}`)) all.pop();
  return all;
}

/** Whether the model is the paper's pinball machine, whose constant force is called d. @param {State} state */
export function isPinball(state) {
  return still(state) && state.law === "active" && amplitudes(state, "cos").length === 1 && amplitudes(state, "sin").length === 1 && state.sin1 === 0 && state.cos1 === 1 && state.sigma === 0 && ![state.vary, ...(state.view === "chart" ? [state.second] : [])].some((name) => /^(sin|cos|sigma)/.test(name));
}

/** The parameters of the lower wall. @param {State} state */
const ofWall = ({ law }) => ["sigma", ...LAWS[law]];
const WAVES = /** @type {const} */ (["cos1", "sin1", "cos2", "sin2", "cos3", "sin3"]);

/** The model of the user's own whose parameters say all of a state: one wall, and no harmonics that it does not have. @param {State} state */
function brought(state) {
  const own = ownOf(state), turned = [state.vary, ...(state.view === "chart" ? [state.second] : [])];
  return own && still(state) && WAVES.every((name) => name in own.names || (state[name] === 0 && !turned.includes(name))) ? own : null;
}

/** The parameters of a model of the user's own, by what it calls them. @param {State} state @param {import("./laws.js").Model} own @returns {[string, number][]} */
const valuesOf = (state, own) => Object.entries(own.names).map(([field, name]) => [name, /** @type {any} */ (state)[field]]);

const moves = (/** @type {State} */ { cos_A, sin_A }) => cos_A !== 0 || sin_A !== 0;

/** What a model with walls calls a parameter. @param {State} state @param {string} name */
function ofWalls(state, name) {
  if (/^\w+_B$/.test(name)) return `B.${name.slice(0, -2)}`;
  return !state.two ? plain(name) : ofWall(state).includes(name) && !name.includes(".") ? `A.${name}` : name;
}

/** What a command calls a parameter. @param {State} state @param {string} name */
const optionOf = (state, name) => ownOf(state)?.names[name] ?? (!still(state) ? ofWalls(state, name) : name === "offset" ? "d" : name);

/** Walls as options of a command, without the parameters that vary. @param {State} state @param {string[]} varied */
function wallOptions(state, varied) {
  const own = ofWall(state), names = state.two ? [...own, ...own.map((name) => `${name}_B`)] : own;
  const all = names.filter((name) => !varied.includes(name)).map((name) => `${ofWalls(state, name)}=${/** @type {any} */ (state)[name]}`);
  const motion = moves(state) ? (state.two ? ["A", "B"] : ["A"]).map((name) => ` ${name}.cos=${state.cos_A} ${name}.sin=${state.sin_A}`).join("") : "";
  return `--walls A=${state.law}${state.two ? `,B=${state.law}` : ""} ${all.join(" ")}${motion}`;
}

/** The model as a program makes it. @param {State} state */
function model(state) {
  if (isPinball(state)) {
    return `gz.pinball(alpha=${state.alpha}, k=${state.k}, omega=${state.omega}, t0=${state.t0}, d=${state.offset}, r=${state.r}, V=${state.V})`;
  }
  const own = ownOf(state), given = brought(state);
  if (given) return `own.replace(${valuesOf(state, given).map(([name, value]) => `${name}=${value}`).join(", ")})`;
  /** The law of a wall: the lower one, or the upper. @param {(name: string) => string} at */
  const lawOf = (at) => {
    const values = LAWS[state.law].map((name) => [plain(name), /** @type {any} */ (state)[at(name)]]);
    return own ? `own.reset.replace(${values.map(([name, value]) => `${name}=${value}`).join(", ")})` : `gz.${state.law}(${values.map(([, value]) => value).join(", ")})`;
  };
  const law = lawOf((name) => name);
  const cos = amplitudes(state, "cos"), sin = amplitudes(state, "sin");
  if (!still(state)) {
    const motion = moves(state) ? `, motion=gz.Forcing(${state.omega}, ${state.t0}, cos=(${state.cos_A},), sin=(${state.sin_A},))` : "";
    const upper = state.two ? `, gz.wall(${state.sigma_B}, ${lawOf((name) => (name.includes(".") ? `B.${plain(name)}` : `${name}_B`))}, side="above"${motion})` : "";
    return `gz.Oscillator(\n    ${state.alpha}, ${state.k}, forcing=gz.Forcing(${state.omega}, ${state.t0}, ${state.offset}, ${numbers(cos)}, ${numbers(sin)}),\n    walls=[gz.wall(${state.sigma}, ${law}${motion})${upper}],\n)`;
  }
  return `gz.Oscillator(${state.alpha}, ${state.k}, gz.Forcing(${state.omega}, ${state.t0}, ${state.offset}, ${numbers(cos)}, ${numbers(sin)}), ${law}, ${state.sigma})`;
}

/** What the model calls a parameter. @param {State} state @param {string} name */
function calledIn(state, name) {
  const given = brought(state);
  if (given) return given.names[name];
  if (!still(state)) return ofWalls(state, name);
  return name === "offset" && isPinball(state) ? "d" : plain(name);
}

const called = (/** @type {State} */ state) => calledIn(state, state.vary);

/** A word of a command as a shell reads it. @param {string} text */
const shelled = (text) => (/^[\w./:-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);

/** The user's own map at a state, as a program has it: the line that makes it, and what it calls parameters. @param {State} state @param {import("./laws.js").Model} own */
function mapped(state, own) {
  const values = valuesOf(state, own), plainly = values.every(([name]) => /^\w+$/.test(name));
  return `P = runpy.run_path(${JSON.stringify(own.file)})["${own.name}"].replace(${plainly ? values.map(([name, value]) => `${name}=${value}`).join(", ") : `**{${values.map(([name, value]) => `"${name}": ${value}`).join(", ")}}`})`;
}

/** The map of the user's own as options of a command, without the parameters that vary. @param {State} state @param {import("./laws.js").Model} own @param {string[]} varied */
const mapOptions = (state, own, varied) => [`--map ${shelled(own.said)}`, ...valuesOf(state, own).filter(([name]) => !varied.includes(name)).map(([name, value]) => `${name}=${value}`)].join(" ");

/** Whether a state is that of a figure of the paper, whatever its colours. @param {State} state @param {string} name */
export function isFigure(state, name) {
  const [own, wanted] = /** @type {Record<string, unknown>[]} */ ([state, { ...DEFAULTS, ...PRESETS[name].state }]);
  return Object.keys(DEFAULTS).every((key) => ["tour", "answer", "note", "theory", "colour", "x0", "web", "twin", "sweeps", "pinned"].includes(key) || JSON.stringify(own[key]) === JSON.stringify(wanted[key]));
}

/** The oscillator of a state as options of a command, without the parameters that vary. @param {State} state @param {string[]} varied @param {boolean} section whether there is one */
function options(state, varied, section = true) {
  const given = brought(state);
  if (given) {
    const left = varied.map((name) => given.names[name]);
    const values = valuesOf(state, given).filter(([name]) => !left.includes(name)).map(([name, value]) => `${name}=${value}`);
    return `--model ${shelled(given.said)} ${values.join(" ")}${section ? ` --phase=${state.phase}` : ""}`;
  }
  /** @type {Record<string, number>} */
  const own = { alpha: state.alpha, k: state.k, omega: state.omega, t0: state.t0, [optionOf(state, "offset")]: state.offset };
  for (const name of still(state) ? ofWall(state) : []) own[name] = /** @type {any} */ (state)[name];
  if (section) own.phase = state.phase;
  for (const name of varied) delete own[optionOf(state, name)];
  const text = Object.entries(own).map(([name, value]) => `${name === "offset" ? "" : "--"}${name}=${value}`).join(" ");
  return `${text} ${still(state) ? `--law ${state.law}` : wallOptions(state, varied)} --cos=${amplitudes(state, "cos").join(",")} --sin=${amplitudes(state, "sin").join(",")}`;
}

/** How many starts and steps the diagram of the view has. @param {State} state */
export function steps(state) {
  if (state.view === "gap" || state.view === "map") return { starts: state.starts, transient: state.transient, keep: state.keep };
  return { starts: state.flow_starts, transient: state.flow_transient, keep: state.flow_keep };
}

/** A Python program that computes and draws the picture. @param {State} state @param {Raster} raster */
export function python(state, raster) {
  const map = BROUGHT.model?.map ? BROUGHT.model : null;
  const own = state.view === "gap" || state.view === "edges" || (state.view === "chart" && state.chart === "gap") ? null : ownOf(state);
  const bare = `${own || map ? "import runpy\n\n" : ""}import grazing as gz\n\n${own ? `own = runpy.run_path(${JSON.stringify(own.file)})["${own.name}"]\n` : ""}`;
  const head = bare.replace("import grazing", "import numpy as np\n\nimport grazing");
  if (state.view === "ball" && state.sweeps) {
    const name = called(state), [from, to] = state.reach, { values, transient, keep } = SWEEP;
    return `${head}P = gz.stroboscopic_map(${model(state)}, phase=${state.phase})\nvalues = np.linspace(${from}, ${to}, ${values})\nfigure, panels = gz.plot.panels(174, 120, rows=2, sharex=True)\nresult = {}\nfor sweep, ax in zip(("up", "down"), panels, strict=True):\n    result[sweep] = gz.orbit_diagram(\n        P, "${name}", values, starts=1, transient=${transient}, keep=${keep}, seed=${state.seed}, sweep=sweep, arithmetic="strict"\n    )\n    gz.plot.orbit_diagram(result[sweep], ax)\ngz.plot.save(figure, "sweeps.png")\n`;
  }
  if (state.view === "ball") {
    return `${bare}m = ${model(state)}\nresult = gz.trajectory(m, (${raster.u}, ${raster.v}), ${raster.start}, ${raster.start} + ${raster.periods} * m.period)\ngz.plot.save(gz.plot.trajectory(result), "ball.png")\n`;
  }
  if (state.view === "strobe") {
    const zeroTime = `four = gz.zdm_points(m, (${state.u0}, ${state.v0}), phase=${state.phase})\ngz.plot.save(gz.plot.zdm(four, sigma=${state.sigma}), "zero-time.png")\n`;
    return `${head}m = ${model(state)}\nP = gz.stroboscopic_map(m, phase=${state.phase})\nu = np.linspace(${raster.from}, ${state.line[1]}, ${raster.samples})\nresult = gz.graph(P, "u", u, fixed={"v": ${state.v0}}, order="${state.order}")\ngz.plot.save(gz.plot.graph(result, coordinate="${state.coordinate}"), "graph.png")\n${raster.impact ? zeroTime : ""}`;
  }
  if (state.view === "edges") {
    const [low, high] = state.gaps, [bottom, top] = state.span, [first, last] = state.periods;
    return `import matplotlib.pyplot as plt
import numpy as np

import grazing as gz

lam, l = ${state.lam}, np.linspace(${low}, ${high}, ${raster.samples})
doubling = {N: gz.theory.mu_pd(N, lam, l) for N in range(${first}, ${last + 1})}
collision = {N: np.broadcast_to(gz.theory.mu_bc(N, lam, l), l.shape) for N in doubling}
appears = {N: gz.theory.l_exist(N, lam) for N in doubling}
meets = {(N, N + 1): gz.theory.l_coexist(N, lam) for N in range(${first}, ${last})}
figure, ax = plt.subplots()
for N in doubling:
    colour = gz.plot.style.period_colour(N)
    ends = np.minimum(collision[N], ${2 * top - bottom})
    ax.fill_between(l, doubling[N], ends, where=doubling[N] < ends, color=colour, alpha=0.18, lw=0)
    ax.plot(l, doubling[N], "--", color=colour, label=f"period doubling, {N}")
    ax.plot(l, ends, color=colour, label=f"border collision, {N}")
for value in [*appears.values(), *meets.values()]:
    if ${low} < value < ${high}:
        ax.axvline(value, color="k", ls=":", lw=0.8)
ax.set(xlim=(${low}, ${high}), ylim=(${bottom}, ${top}), xlabel="gap, $l$", ylabel=r"$\\mu$")
ax.legend()
gz.plot.save(figure, "edges.png")
`;
  }
  if (state.view === "chart") {
    if (raster.basins) {
      const grid = raster.names.map((/** @type {string} */ name, /** @type {number} */ i) => `"${name}": np.linspace(${raster.ends[i].join(", ")}, ${raster.sizes[i]})`).join(", ");
      return `${head}${map ? mapped(state, map) : `P = gz.stroboscopic_map(${model(state)}, phase=${state.phase})`}\nresult = gz.basins(\n    P, {${grid}},\n    transient=${raster.transient}, keep=${raster.keep}, arithmetic="strict",\n)\ngz.plot.save(gz.plot.basins(result, graze=-1), "basins.png")\n`;
    }
    const gap = raster.name === "gap";
    const axis = (/** @type {number} */ i) => `"${gap ? raster.names[i] : map ? map.names[raster.names[i]] : calledIn(state, raster.names[i])}": np.linspace(${raster.ends[i].join(", ")}, ${raster.sizes[i]})`;
    const made = map ? mapped(state, map) : gap ? `P = gz.gap_map(lam=${state.lam}, mu=${state.mu}, l=${state.l})` : `P = gz.stroboscopic_map(${model(state)}, phase=${state.phase})`;
    return `${head}${made}\nresult = gz.chart(\n    P, {${axis(0)}, ${axis(1)}},\n    starts=${raster.starts}, transient=${raster.transient}, keep=${raster.keep}, seed=${state.seed}, arithmetic="strict",\n)\ngz.plot.save(gz.plot.chart(result), "chart.png")\n`;
  }
  const { starts, transient, keep } = steps(state);
  /** @param {string} map @param {string} name @param {import("./state.js").Pair} ends @param {string} coordinate */
  const study = (map, name, [from, to], coordinate) =>
    `result = gz.density(\n    ${map}, "${name}", np.linspace(${from}, ${to}, ${state.columns}), bins=${state.bins}, coordinate="${coordinate}",\n    range=(${raster.low}, ${raster.high}), starts=${starts}, transient=${transient}, keep=${keep}, seed=${state.seed},\n    arithmetic="strict",\n)\ngz.plot.save(gz.plot.density(result), "density.png")\n`;
  if (map) return `${head}${mapped(state, map)}\n${study("P", map.names[state.vary], state.reach, state.coordinate)}`;
  if (state.view === "gap") return `${head}G = gz.gap_map(lam=${state.lam}, mu=${state.mu}, l=${state.l})\n${study("G", "mu", state.span, "x")}`;
  return `${head}m = ${model(state)}\nP = gz.stroboscopic_map(m, phase=${state.phase})\n${study("P", called(state), state.reach, state.coordinate)}`;
}

/** The same as a command. @param {State} state @param {Raster} raster */
export function command(state, raster) {
  const own = ownOf(state), map = BROUGHT.model?.map ? BROUGHT.model : null;
  const optional = (/** @type {string[]} */ varied) => (map ? mapOptions(state, map, varied.map((name) => map.names[name])) : options(state, varied));
  const called = (/** @type {string} */ name) => (map ? map.names[name] : optionOf(state, name));
  if (own && !brought(state) && state.view !== "gap" && state.view !== "edges" && !(state.view === "chart" && state.chart === "gap")) {
    return `# a command has the oscillator of ${own.said} as it is, with one wall at rest and its own harmonics: copy the Python program`;
  }
  if (state.view === "strobe") return `grazing graph u=${raster.from}:${state.line[1]}:${raster.samples} --fixed v=${state.v0} --order ${state.order} --coordinate ${state.coordinate} ${options(state, [])} -o graph.png`;
  if (state.view === "edges") {
    const [first, last] = state.periods;
    return `grazing chart l=${state.gaps.join(":")}:${state.chart_columns} mu=${state.span.join(":")}:${state.chart_rows} --map gap --lam ${state.lam} --curves ${first === last ? first : `${first}:${last}`} --seed ${state.seed} --arithmetic strict -o edges.png`;
  }
  if (state.view === "chart") {
    if (raster.basins) {
      const grid = raster.names.map((/** @type {string} */ name, /** @type {number} */ i) => `${name}=${raster.ends[i].join(":")}:${raster.sizes[i]}`).join(" ");
      return `grazing basins ${grid} --transient ${raster.transient} --keep ${raster.keep} --arithmetic strict ${optional([])} -o basins.png`;
    }
    const gap = raster.name === "gap";
    const axis = (/** @type {number} */ i) => `${gap ? raster.names[i] : called(raster.names[i])}=${raster.ends[i].join(":")}:${raster.sizes[i]}`;
    const rest = gap ? `--map gap --lam ${state.lam}` : optional(raster.names);
    return `grazing chart ${axis(0)} ${axis(1)} --starts ${raster.starts} --transient ${raster.transient} --keep ${raster.keep} --seed ${state.seed} --arithmetic strict ${rest} -o chart.png`;
  }
  const { starts, transient, keep } = steps(state);
  /** @param {import("./state.js").Pair} ends @param {string} name @param {string} coordinate */
  const study = ([from, to], name, coordinate) =>
    `grazing density ${name}=${from}:${to}:${state.columns} --bins ${state.bins} --coordinate ${coordinate} --range=${raster.low}:${raster.high} --starts ${starts} --transient ${transient} --keep ${keep} --seed ${state.seed} --arithmetic strict`;
  if (state.view === "gap") return `${study(state.span, "mu", "x")} --map gap --lam ${state.lam} --l ${state.l} -o density.png`;
  if (state.view === "ball" && state.sweeps) {
    const name = optionOf(state, state.vary), { values, transient, keep } = SWEEP;
    const way = (/** @type {string} */ sweep) => `grazing diagram ${name}=${state.reach.join(":")}:${values} --sweep ${sweep} --starts 1 --transient ${transient} --keep ${keep} --seed ${state.seed} --arithmetic strict ${options(state, [state.vary])} -o ${sweep}.png`;
    return `${way("up")}\n${way("down")}`;
  }
  if (state.view === "ball") return `grazing trajectory u=${raster.u} v=${raster.v} --start=${raster.start} --until=${raster.start + raster.periods * ((2 * Math.PI) / state.omega)} ${options(state, [], false)} -o ball.png`;
  return `${study(state.reach, called(state.vary), state.coordinate)} ${optional([state.vary])} -o density.png`;
}
