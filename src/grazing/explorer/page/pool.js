// @ts-check
/** A pool of workers. A batch of jobs replaces the one before it on the same channel: what waits is dropped. */

import { JOBS } from "./jobs.js";
import { Machine } from "./machine.js";

/** @typedef {typeof JOBS} Jobs */
/** @typedef {{id: number, machine: string, job: keyof Jobs, given: unknown}} Message */
/** @typedef {{channel: string, live: () => boolean, message: Message, resolve: (found: any) => void, reject: (error: Error) => void}} Task */
/**
 * `run` resolves with the result, or never if the batch has been replaced; `now`, where it is, does a job in the page.
 * @typedef {{
 *   live: () => boolean,
 *   now?: (machine: string, job: "raster", given: Parameters<Jobs["raster"]>[1]) => ReturnType<Jobs["raster"]>,
 *   run: <Job extends keyof Jobs>(machine: string, job: Job, given: Parameters<Jobs[Job]>[1]) => Promise<ReturnType<Jobs[Job]>>,
 * }} Batch
 */

export class Pool {
  /** @type {Task[]} */ waiting = [];
  /** @type {Map<number, Task & {worker: Worker}>} */ running = new Map();
  /** @type {Map<string, number>} */ batches = new Map();
  /** @type {Record<string, Machine>} */ machines = {};
  next = 0;

  constructor(size = Math.min(8, Math.max(1, navigator.hardwareConcurrency || 2))) {
    this.workers = Array.from({ length: size }, () => {
      const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
      worker.onmessage = ({ data }) => this.#done(worker, data);
      worker.onerror = (event) => {
        event.preventDefault?.();
        for (const [id, task] of this.running) {
          if (task.worker === worker) this.#done(worker, { id, found: null, error: event.message || "a worker could not be started" });
        }
      };
      return worker;
    });
    this.idle = [...this.workers];
  }

  /** Give a compiled module to all workers. @param {string} name @param {WebAssembly.Module} module @param {import("./machine.js").Module} described */
  add(name, module, described) {
    this.machines[name] = new Machine(new WebAssembly.Instance(module, {}), described);
    for (const worker of this.workers) worker.postMessage({ name, module, described });
  }

  /**
   * Begin a batch on a channel; tasks of the batch before it that have not begun are dropped, the others ignored.
   * @param {string} channel
   * @returns {Batch}
   */
  batch(channel) {
    const number = (this.batches.get(channel) ?? 0) + 1;
    this.batches.set(channel, number);
    this.waiting = this.waiting.filter((task) => task.channel !== channel);
    const live = () => this.batches.get(channel) === number;
    return {
      live,
      now: (machine, job, given) => JOBS[job](this.machines[machine], given),
      run: (machine, job, given) =>
        new Promise((resolve, reject) => {
          if (!live()) return;
          this.waiting.push({ channel, live, message: { id: this.next++, machine, job, given }, resolve, reject });
          this.#feed();
        }),
    };
  }

  #feed() {
    for (;;) {
      const worker = this.idle.at(-1), task = this.waiting[0];
      if (!worker || !task) return;
      this.idle.pop();
      this.waiting.shift();
      this.running.set(task.message.id, { ...task, worker });
      worker.postMessage(task.message);
    }
  }

  /** @param {Worker} worker @param {{id: number, found?: any, error?: string}} answer */
  #done(worker, { id, found, error }) {
    const task = this.running.get(id);
    if (!task) return;
    this.running.delete(id);
    this.idle.push(worker);
    this.#feed();
    if (!task.live()) return;
    if (error) task.reject(new Error(error));
    else task.resolve(found);
  }
}
