// @ts-check
/** The page before a room: the whole screen, large letters, controls over the picture. */

const byId = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** What a key is typed into, and not said to the page. @param {EventTarget | null} target */
export const isTyped = (target) => target instanceof HTMLElement && /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName) && /** @type {HTMLInputElement} */ (target).type !== "range";

/** The keys of a presenter's remote control, and the buttons of the tour that they press. */
const TURNS = /** @type {Record<string, string>} */ ({ PageDown: "next", PageUp: "back" });

/** Let the page be presented: by its button, by P unless that key means something else, and back by either or Escape. @param {() => void} again what draws everything once more */
export function stage(again, key = "p") {
  const { classList } = document.body, more = document.getElementById("more");
  let ours = false; // whether it is the page that ends the full screen, and not the browser's own key
  const all = (/** @type {boolean} */ on) => {
    classList.toggle("all", on);
    if (!more) return;
    more.setAttribute("aria-expanded", String(on));
    more.textContent = `${on ? "Fewer" : "All"} controls`;
  };
  const show = (/** @type {boolean} */ on) => {
    if (classList.contains("presenting") === on) return;
    classList.toggle("presenting", on);
    byId("stage").hidden = !on;
    all(false);
    if (on) document.documentElement.requestFullscreen?.().catch(() => {}); // where it is not allowed, the window is filled
    else if ((ours = Boolean(document.fullscreenElement))) document.exitFullscreen();
    const picture = /** @type {HTMLElement | null} */ (document.querySelector(".view:not([hidden]) .first canvas, #table"));
    (on ? picture : byId("present"))?.focus({ preventScroll: true }); // the keys of the picture are at hand
    scrollTo(0, 0);
    again();
  };
  byId("present").addEventListener("click", () => show(true));
  byId("end").addEventListener("click", () => show(false));
  // in full screen, Chromium tells the pictures of a page that moves of the wheel only if the whole page listens as well
  document.addEventListener("wheel", () => {}, { passive: true });
  more?.addEventListener("click", () => all(!classList.contains("all")));
  document.addEventListener("fullscreenchange", () => {
    if (!document.fullscreenElement && !ours) show(false);
    ours = false;
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || isTyped(event.target)) return;
    if (event.key.toLowerCase() === key) show(!classList.contains("presenting"));
    else if (classList.contains("presenting") && TURNS[event.key]) document.getElementById(TURNS[event.key])?.click();
    else if (event.key === "Escape" && !event.defaultPrevented) show(false);
  });
}
