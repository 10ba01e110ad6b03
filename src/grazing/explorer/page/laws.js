// @ts-check
/** The reset laws, and the model or the map of the user's own that `grazing explore --model` brings. */

/**
 * A model as kernels.json describes it. `own` are the parameters of its law, if that is the user's, `names` what Python calls fields. Of
 * a map `map` is its name, `reaches` say where its orbits live, and `coordinates` are those of its states.
 * @typedef {{said: string, file: string, name: string, map?: string, coordinates?: string[], law: string, own: string[], names: Record<string, string>, units: Record<string, string>, reaches?: Record<string, [number, number]>, extents: Record<string, [number, number]>, state: Record<string, any>}} Model
 */

/** The parameters that each law has. @type {Record<string, string[]>} */
export const LAWS = { newton: ["r"], active: ["r", "V"], triggered: ["r", "V", "trigger"] };

/** What the user brought. @type {{model: Model | null}} */
export const BROUGHT = { model: null };

/** The model whose law a state has, if that is the user's own. @param {{law: string}} state */
export const ownOf = ({ law }) => (BROUGHT.model?.own.length && BROUGHT.model.law === law ? BROUGHT.model : null);

/** A length in whose units the heights of flights are: 1 but for a model that was brought, of which metres may be large. */
export const unit = () => (BROUGHT.model ? BROUGHT.model.state.positions[1] - BROUGHT.model.state.positions[0] : 1);

/** The name of the file that a model is in. @param {Model} model @returns {string} */
export const fileOf = ({ file }) => /[^\\/]*$/.exec(file)?.[0] ?? file;

/** Whether a parameter is one of the upper wall: r_B, or B.c of a law of the user's own. @param {string} name */
export const above = (name) => /^(\w+_B|B\..+)$/.test(name);

/** What a parameter of the upper wall is called at the lower one. @param {string} name */
export const below = (name) => (!above(name) ? name : name.startsWith("B.") ? `A${name.slice(1)}` : name.slice(0, -2));

/** What a law calls a parameter of its own. @param {string} name */
export const plain = (name) => name.replace(/^[AB]\./, "");

/** Whether a parameter is one of reset laws. @param {string} name */
export const ofLaws = (name) => Object.values(LAWS).some((names) => names.includes(below(name)));

/** Whether a wall kicks, as far as the parameters say. @param {{law: string, V: number, V_B: number}} state */
export const kicks = ({ law, V, V_B }) => ({ below: LAWS[law].includes("V") && V > 0, above: LAWS[law].includes("V") && V_B > 0 });
