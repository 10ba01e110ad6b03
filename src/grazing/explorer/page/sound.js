// @ts-check
/** Impacts as sound: the faster, the higher. Silent until asked for. */

/** The pitch of the slowest impact in Hz, and octaves up to the fastest that the picture shows; seconds that it rings. */
const LOWEST = 196, OCTAVES = 2.5, RINGS = 0.22;

/** The pitch of an impact in Hz. @param {number} speed @param {number} fastest */
export const pitch = (speed, fastest) => LOWEST * 2 ** (OCTAVES * Math.min(1, Math.max(0, speed / (fastest || 1))));

export class Sound {
  /** @type {AudioContext | null} */ #context = null;
  on = false;
  /** The pitches that were asked for last, latest last. @type {number[]} */ played = [];

  /** Switch on or off; what is wrong in words, empty if nothing is. @param {boolean} on */
  turn(on) {
    this.on = false;
    if (!on) return "";
    try {
      this.#context ??= new AudioContext();
      this.#context.resume();
    } catch {
      return "This browser gives the page no sound.";
    }
    this.on = true;
    return "";
  }

  /** @param {number} speed @param {number} fastest */
  hit(speed, fastest) {
    const context = this.#context;
    if (!this.on || !context) return;
    const frequency = pitch(speed, fastest), now = context.currentTime;
    this.played = [...this.played.slice(-15), frequency];
    const tone = new OscillatorNode(context, { type: "triangle", frequency }), loudness = new GainNode(context, { gain: 0 });
    loudness.gain.setValueAtTime(0.25, now);
    loudness.gain.exponentialRampToValueAtTime(1e-3, now + RINGS);
    tone.connect(loudness).connect(context.destination);
    tone.start(now);
    tone.stop(now + RINGS);
  }
}
