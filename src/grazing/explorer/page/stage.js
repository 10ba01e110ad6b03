// @ts-check
/** The page before a room: the whole screen, large letters, controls over the picture. */

const byId = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** What a key is typed into, and not said to the page. @param {EventTarget | null} target */
export const isTyped = (target) => target instanceof HTMLElement && /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName) && /** @type {HTMLInputElement} */ (target).type !== "range";

/** The keys of a presenter's remote control, and the buttons of the tour that they press. */
const TURNS = /** @type {Record<string, string>} */ ({ PageDown: "next", PageUp: "back" });

/** Pixels to the side after which a finger on a slider moves it, and does not scroll the page. */
const SIDEWAYS = 6;

/** A finger that begins to scroll on a slider sets it not. */
function sideways() {
  /** @type {{box: EventTarget | null, x: number, value: string} | null} */
  let held = null;
  const on = (/** @type {string} */ name, /** @type {(event: any) => void} */ act) => document.addEventListener(name, act, true);
  on("pointerdown", ({ pointerType, target, clientX }) => (held = pointerType === "touch" && target.type === "range" ? { box: target, x: clientX, value: target.value } : null));
  on("pointermove", ({ clientX }) => held && Math.abs(clientX - held.x) > SIDEWAYS && (held = null));
  for (const end of ["pointerup", "pointercancel"]) on(end, () => setTimeout(() => (held = null)));
  on("input", (event) => {
    if (!held || event.target !== held.box) return;
    event.target.value = held.value;
    event.stopImmediatePropagation();
  });
}

/** Whether another page of these was presented before this one. @param {boolean} [on] what is so from now on */
function kept(on) {
  try {
    if (on !== undefined) sessionStorage.setItem("presenting", on ? "yes" : "");
    return sessionStorage.getItem("presenting") === "yes";
  } catch {
    return false; // a browser that remembers nothing
  }
}

/** Let the page be presented: by its button or P, and back by either or Escape; what fingers do to sliders. @param {() => void} again what draws everything once more */
export function stage(again) {
  const { classList } = document.body, more = document.getElementById("more"), tour = document.getElementById("tour")?.parentElement;
  let turning = 0, turned = /** @type {Promise<any>} */ (Promise.resolve()); // the page's own ways into the full screen and out of it
  const fill = () => {
    turning++; // one after the other: what is asked for while another is under way is lost
    turned = turned
      .then(() => {
        const on = classList.contains("presenting");
        if (on !== Boolean(document.fullscreenElement)) return on ? document.documentElement.requestFullscreen?.() : document.exitFullscreen();
      })
      .catch(() => {}) // where it is not allowed, the window is filled
      .then(() => new Promise(requestAnimationFrame)) // it is told of in a frame
      .then(() => turning--);
  };
  const all = (/** @type {boolean} */ on) => {
    classList.toggle("all", on);
    if (tour) (on ? byId("controls") : /** @type {HTMLElement} */ (document.querySelector("header")))[on ? "prepend" : "append"](tour);
    if (!more) return;
    more.setAttribute("aria-expanded", String(on));
    more.textContent = `${on ? "Fewer" : "All"} controls`;
  };
  const show = (/** @type {boolean} */ on) => {
    if (classList.contains("presenting") === on) return;
    classList.toggle("presenting", on);
    kept(on);
    byId("stage").hidden = !on;
    all(false);
    fill();
    const picture = /** @type {HTMLElement[]} */ ([...document.querySelectorAll(".view canvas[tabindex], #table")]).find((each) => each.offsetParent);
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
    if (!document.fullscreenElement && !turning) show(false); // by the browser's own key
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (classList.contains("presenting") && TURNS[event.key]) {
      event.preventDefault(); // the slider that was moved last or the field that was typed in has the focus, and is not meant
      document.getElementById(TURNS[event.key])?.click();
    } else if (event.key === "Escape") {
      if (!event.defaultPrevented && !(event.target instanceof HTMLSelectElement)) show(false);
    } else if (event.key.toLowerCase() === "p" && !isTyped(event.target)) show(!classList.contains("presenting"));
  });
  sideways();
  if (kept()) setTimeout(() => show(true)); // a way to another page leaves the room, not the stage
}
