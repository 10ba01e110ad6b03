// @ts-check
/** A worker: gets compiled modules once, then jobs; answers each with its arrays or with the error in words. */
import { JOBS } from "./jobs.js";
import { machineOf } from "./machine.js";

/** @type {Record<string, import("./machine.js").Machine>} */
const machines = {};

/** Send an answer; arrays go without being copied. @param {object} answer @param {ArrayBuffer[]} arrays */
const send = (answer, arrays = []) => /** @type {any} */ (self).postMessage(answer, arrays);

/** @param {MessageEvent<any>} event a module with its name and description, or a job of `pool.js` */
self.onmessage = ({ data }) => {
  if (data.described) {
    // at once, for a job may come next
    machines[data.name] = machineOf(data.module, data.described);
    return;
  }
  try {
    if (!machines[data.machine]) throw new Error(`the module ${data.machine} is not loaded`);
    const found = JOBS[/** @type {keyof typeof JOBS} */ (data.job)](machines[data.machine], data.given);
    send({ id: data.id, found }, Object.values(found).filter(ArrayBuffer.isView).map((array) => /** @type {ArrayBuffer} */ (array.buffer)));
  } catch (error) {
    send({ id: data.id, error: String(error instanceof Error ? error.message : error) });
  }
};
