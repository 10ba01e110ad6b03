// @ts-check
/** A worker: gets compiled modules once, then jobs; answers each with its arrays or with the error in words. */
import { JOBS } from "./jobs.js";
import { Machine } from "./machine.js";

const machines = {};

self.onmessage = async ({ data }) => {
  if (data.module) {
    machines[data.name] = new Machine(await WebAssembly.instantiate(/** @type {WebAssembly.Module} */ (data.module), {}), data.described);
    return;
  }
  try {
    if (!machines[data.machine]) throw new Error(`the module ${data.machine} is not loaded`);
    const found = JOBS[data.job](machines[data.machine], data.given);
    const arrays = Object.values(found).filter(ArrayBuffer.isView).map((array) => array.buffer);
    self.postMessage({ id: data.id, found }, /** @type {any} */ (arrays));
  } catch (error) {
    self.postMessage({ id: data.id, error: String(error instanceof Error ? error.message : error) });
  }
};
