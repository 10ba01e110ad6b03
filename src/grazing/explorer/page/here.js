// @ts-check
/** Jobs in the page itself, for a browser that starts no workers: what `Pool` does, slower, a piece at a time. */
import { JOBS } from "./jobs.js";

export class Here {
  /** One piece is computed at a time. */
  workers = [null];
  /** @type {Map<string, number>} */ #batches = new Map();

  /** @param {Record<string, import("./machine.js").Machine>} machines the running modules */
  constructor(machines) {
    this.machines = machines;
  }

  /** Begin a batch on a channel, which replaces the one before it. @param {string} channel */
  batch(channel) {
    const number = (this.#batches.get(channel) ?? 0) + 1;
    this.#batches.set(channel, number);
    const live = () => this.#batches.get(channel) === number;
    /** @param {string} machine @param {keyof typeof JOBS} job @param {any} given @returns {Promise<any>} */
    const run = (machine, job, given) => new Promise((resolve, reject) => setTimeout(() => {
      if (!live()) return;
      try {
        resolve(JOBS[job](this.machines[machine], given));
      } catch (error) {
        reject(error);
      }
    }));
    return { live, run };
  }
}
