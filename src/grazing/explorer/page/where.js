// @ts-check
/** Where files are: beside this one on a server, or in the page itself, where it is one file. */

const HERE = import.meta.url, WORKER = "page/worker.js";
/** @type {Record<string, string>} */
const inside = JSON.parse(document.getElementById("inside")?.textContent ?? "{}");
const TYPES = /** @type {Record<string, string>} */ ({ js: "text/javascript", json: "application/json", wasm: "application/wasm" });

/** The address of a file. @param {string} name as in `kernels/gap.wasm` */
export function addressOf(name) {
  if (!(name in inside)) return new URL(`../${name}`, HERE);
  const bytes = Uint8Array.from(atob(inside[name]), (letter) => letter.charCodeAt(0));
  return URL.createObjectURL(new Blob([bytes], { type: TYPES[name.split(".").at(-1) ?? ""] }));
}

/** Who can open a link to this page, where that is not everybody. @param {string} [out] what is written of it to be sent */
export const reach = (out = "page.html” makes a file to send") => (location.protocol === "file:" ? "; it opens where this file lies" : /^(localhost|127\.|\[::1\])/.test(location.host) ? `; it opens on this machine only: “grazing explore --out ${out}` : "");

/** A worker; what lies in the page is one script, without modules, which browsers refuse there. */
export const startWorker = () => new Worker(addressOf(WORKER), { type: WORKER in inside ? "classic" : "module" });
