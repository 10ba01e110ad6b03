// @ts-check
/** Where the kernels come from, and who computes with them. */
import { Here } from "./here.js";
import { machineOf } from "./machine.js";
import { Pool } from "./pool.js";
import { addressOf } from "./where.js";

/** @typedef {Record<string, import("./machine.js").Machine>} Machines */
/** @typedef {{problem: (text: string, about: string) => void, again: () => void}} Told what the page is told: a problem, and that all must be computed again */

/** The workers or, where the browser starts none, the page in their place, which is said. @param {Machines} machines @param {Told} told */
function workers(machines, { problem, again }) {
  const here = new Here(machines);
  const why = "The browser started no workers, so the page computes by itself: the same pictures, more slowly.";
  /** @type {Pool | Here} */
  let now = here;
  const instead = () => {
    if (now === here) return;
    now = here;
    problem(why, "workers");
    again();
  };
  try {
    now = new Pool(() => setTimeout(instead));
  } catch {
    problem(why, "workers");
  }
  const jobs = {
    add: (/** @type {Parameters<Pool["add"]>} */ ...given) => now instanceof Pool && now.add(...given),
    batch: (/** @type {Parameters<Pool["batch"]>} */ ...given) => now.batch(...given),
    see: (/** @type {string} */ scene) => now instanceof Pool && now.see(scene),
    get ended() {
      return now instanceof Pool ? now.ended : 0;
    },
    get workers() {
      return now.workers;
    },
  };
  return /** @type {Pool} */ (/** @type {unknown} */ (jobs));
}

/** What is not there without a module. @type {Record<string, string>} */
const WITHOUT = { gap: "The gap map is", map: "Your map is", oscillator: "The oscillator and the ball are", table: "The table is" };

/** Fetch a module. @param {string} name */
async function compiled(name) {
  const file = await fetch(addressOf(`kernels/${name}`));
  if (!file.ok) throw new Error(`${file.status} ${file.statusText}`);
  return WebAssembly.compile(await file.arrayBuffer());
}

/** Fetch modules and start them, here and in the workers; what cannot be had is said. @param {Told} told @param {string[]} [wanted] */
export async function load(told, wanted) {
  const { problem } = told;
  const answer = await fetch(addressOf("kernels/kernels.json"));
  if (!answer.ok) throw new Error(`kernels.json: ${answer.status} ${answer.statusText}`);
  /** @type {import("./machine.js").Kernels} */
  const described = await answer.json();
  const names = wanted ?? (described.model?.map ? ["map"] : ["gap", "oscillator"]);
  /** @type {Machines} */
  const machines = {};
  if (typeof WebAssembly !== "object") {
    problem("This browser has no WebAssembly, by which the page computes, or it is switched off, as some browsers do in their strictest mode. Allow it for this page, or use another browser; links can be made and copied all the same.", "kernels");
    return { described, machines, pool: null };
  }
  const pool = workers(machines, told);
  await Promise.all(
    Object.entries(described.modules).filter(([name]) => names.includes(name)).map(async ([name, each]) => {
      try {
        const module = each.calls ? null : await compiled(each.file);
        machines[name] = machineOf(module, each);
        pool.add(name, module, each);
      } catch (error) {
        problem(`The module ${each.file} could not be loaded (${error instanceof Error ? error.message : error}). ${WITHOUT[name]} not available; everything else works.`, name);
      }
    }),
  );
  return { described, machines, pool };
}
