// @ts-check
/** A pool of workers. A batch of jobs replaces the one before it on the same channel: what waits is dropped. */

export class Pool {
  constructor(size = Math.min(8, Math.max(1, (navigator.hardwareConcurrency || 2) - 0))) {
    this.waiting = [];
    this.running = new Map();
    this.batches = new Map();
    this.next = 0;
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

  /** Give a compiled module to all workers. */
  add(name, module, described) {
    for (const worker of this.workers) worker.postMessage({ name, module, described });
  }

  /** Begin a batch on a channel; tasks of the batch before it that have not begun are dropped, the others ignored. */
  batch(channel) {
    const number = (this.batches.get(channel) ?? 0) + 1;
    this.batches.set(channel, number);
    this.waiting = this.waiting.filter((task) => task.channel !== channel);
    const live = () => this.batches.get(channel) === number;
    return {
      live,
      /** Resolves with the result, or never if the batch has been replaced. */
      run: (machine, job, given) =>
        new Promise((resolve, reject) => {
          if (!live()) return;
          this.waiting.push({ channel, live, message: { id: this.next++, machine, job, given }, resolve, reject });
          this.#feed();
        }),
    };
  }

  #feed() {
    while (this.idle.length && this.waiting.length) {
      const task = this.waiting.shift();
      const worker = this.idle.pop();
      this.running.set(task.message.id, { ...task, worker });
      worker.postMessage(task.message);
    }
  }

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
