// @ts-check
/**
 * A pool of workers. A batch of jobs replaces the one before it on the same channel: what waits is dropped. Jobs of a
 * scene that has been left are held until it is seen again. A worker that goes on with a job that nobody waits for is
 * ended, and another one started in its place.
 */

import { JOBS } from "./jobs.js";
import { machineOf } from "./machine.js";
import { startWorker } from "./where.js";

/** @typedef {typeof JOBS} Jobs */
/** @typedef {{id: number, machine: string, job: keyof Jobs, given: unknown}} Message */
/** @typedef {{channel: string, scene: string, live: () => boolean, message: Message, resolve: (found: any) => void, reject: (error: Error) => void}} Task */
/**
 * `run` resolves with the result, or never if the batch has been replaced; `now`, where it is, does a job in the page.
 * @typedef {{
 *   live: () => boolean,
 *   now?: <Job extends keyof Jobs>(machine: string, job: Job, given: Parameters<Jobs[Job]>[1]) => ReturnType<Jobs[Job]>,
 *   run: <Job extends keyof Jobs>(machine: string, job: Job, given: Parameters<Jobs[Job]>[1]) => Promise<ReturnType<Jobs[Job]>>,
 * }} Batch
 */

/** Milliseconds that a worker is given to finish a job that nobody waits for; to start another one takes about as long. */
const PATIENCE = 150;

export class Pool {
  /** @type {Task[]} */ waiting = [];
  /** @type {Map<number, Task & {worker: Worker, since: number}>} `since` when nobody waits for it, NaN while somebody does */ running = new Map();
  /** @type {Map<string, number>} */ batches = new Map();
  /** @type {Record<string, import("./machine.js").Machine>} */ machines = {};
  /** @type {{name: string, module: WebAssembly.Module | null, described: import("./machine.js").Module}[]} */ #given = [];
  #scene = "";
  #looking = 0;
  /** Whether a worker could not be started, or broke: the page does what is still asked of the pool. */
  #broken = false;
  next = 0;
  /** Workers that were ended in the middle of a job. */
  ended = 0;

  /** @param {() => void} failed called when a worker cannot be started */
  constructor(failed = () => {}, size = Math.min(8, Math.max(1, navigator.hardwareConcurrency || 2))) {
    this.failed = failed;
    this.workers = Array.from({ length: size }, () => this.#start());
    this.idle = [...this.workers];
  }

  #start() {
    const worker = startWorker();
    worker.onmessage = ({ data }) => this.#done(worker, data);
    worker.onerror = (event) => {
      event.preventDefault?.();
      this.#broken = true;
      for (const [id, task] of this.running) {
        if (task.worker === worker && this.running.delete(id)) this.#inPage(task);
      }
      this.#feed();
      this.failed();
    };
    for (const each of this.#given) worker.postMessage(each);
    return worker;
  }

  /** Give a compiled module, or null where the server computes, to all workers. @param {string} name @param {WebAssembly.Module | null} module @param {import("./machine.js").Module} described */
  add(name, module, described) {
    this.machines[name] = machineOf(module, described);
    const given = { name, module, described };
    this.#given.push(given);
    for (const worker of this.workers) worker.postMessage(given);
  }

  /** The scene that is seen: its jobs are done, those of others held. @param {string} scene */
  see(scene) {
    if (scene === this.#scene) return;
    this.#scene = scene;
    this.#look();
  }

  /** Whether somebody waits for what a task finds. @param {Task} task */
  #wanted = (task) => task.live() && task.scene === this.#scene;

  /** After a while, take the workers from jobs that nobody waits for. */
  #look() {
    const now = performance.now(), idly = [...this.running.values()].filter((task) => !this.#wanted(task));
    for (const task of this.running.values()) {
      if (!idly.includes(task)) task.since = NaN;
      else if (Number.isNaN(task.since)) task.since = now;
      else if (now - task.since >= PATIENCE) this.#end(task);
    }
    if (!this.#looking && this.running.size && idly.length) {
      this.#looking = window.setTimeout(() => {
        this.#looking = 0;
        this.#look();
      }, PATIENCE);
    }
    this.#feed();
  }

  /** End the worker of a task, which waits again if it is only held. @param {Task & {worker: Worker, since: number}} running */
  #end({ worker, since: _, ...task }) {
    this.ended += 1;
    worker.terminate();
    this.running.delete(task.message.id);
    if (task.live()) this.waiting.unshift(task);
    const another = this.#start();
    this.workers[this.workers.indexOf(worker)] = another;
    this.idle.push(another);
  }

  /**
   * Begin a batch on a channel; tasks of the batch before it that have not begun are dropped, the others ignored.
   * @param {string} channel
   * @param {boolean} first whether it is short and asked by a hand: done before what waits already
   * @returns {Batch}
   */
  batch(channel, first = false) {
    const number = (this.batches.get(channel) ?? 0) + 1;
    this.batches.set(channel, number);
    this.waiting = this.waiting.filter((task) => task.channel !== channel);
    const live = () => this.batches.get(channel) === number, scene = this.#scene;
    this.#look();
    return {
      live,
      now: (machine, job, given) => /** @type {any} */ (JOBS)[job](this.machines[machine], given),
      run: (machine, job, given) =>
        new Promise((resolve, reject) => {
          if (!live()) return;
          this.waiting[first ? "unshift" : "push"]({ channel, scene, live, message: { id: this.next++, machine, job, given }, resolve, reject });
          this.#feed();
        }),
    };
  }

  /** Do in the page what no worker will do. @param {Task} task */
  #inPage({ live, message: { machine, job, given }, resolve, reject }) {
    setTimeout(() => {
      if (!live()) return;
      try {
        resolve(JOBS[job](this.machines[machine], /** @type {any} */ (given)));
      } catch (error) {
        reject(/** @type {Error} */ (error));
      }
    });
  }

  #feed() {
    for (const task of this.#broken ? this.waiting.splice(0) : []) this.#inPage(task);
    for (;;) {
      const worker = this.idle.at(-1), at = this.waiting.findIndex(this.#wanted);
      if (!worker || at < 0) return;
      const [task] = this.waiting.splice(at, 1);
      this.idle.pop();
      this.running.set(task.message.id, { ...task, worker, since: NaN });
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
