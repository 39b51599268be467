// What a person may do to a run in real time. The key comes with the address that the command prints.
import { ask, report, request } from "./server.js";

const SURE_MS = 4000;

export class Acts {
  constructor(run, { chosen, refuse }) {
    Object.assign(this, { run, chosen, refuse });
    this.key = location.hash.slice(1);
    this.known = [];
    this.place = document.getElementById("acts");
    this.buttons = { brake: document.getElementById("brake"), kill: document.getElementById("kill") };
    this.buttons.brake.addEventListener("click", () => this.act("brake"));
    this.buttons.kill.addEventListener("click", () => this.#kill());
    this.loss = document.getElementById("loss");
    this.losses = 0;
    this.wanted = null; // the share that was asked for last, until it is in force
    [this.slider, this.said] = [this.loss.querySelector("input"), this.loss.querySelector("output")];
    this.slider.addEventListener("input", () => {
      this.wanted = Number(this.slider.value);
      this.said.textContent = `${this.wanted} %`;
    });
    this.slider.addEventListener("change", () => this.#ask(`act=lose&percent=${this.slider.value}`));
  }

  async learn() {
    if (!this.key) return;
    this.known = (await (await ask("acts")).json()).acts;
    for (const [name, button] of Object.entries(this.buttons)) button.hidden = !this.known.includes(name);
  }

  draw() {
    const hidden = !this.known.length || !this.run.goesOn;
    if (this.place.hidden !== hidden) this.place.hidden = hidden;
    const fixed = hidden || !this.known.includes("lose");
    if (this.loss.hidden !== fixed) this.loss.hidden = fixed;
    this.#showLoss();
  }

  // Shows the share in force, which another page, or this one before it was loaded again, may have set.
  #showLoss() {
    const losses = this.run.events.filter((event) => event.kind === "LOSS");
    if (losses.length === this.losses) return;
    this.losses = losses.length;
    const percent = parseFloat(losses[losses.length - 1].text);
    // Shares that were asked for before the last one take force one after the other.
    if (!(percent >= 0) || (this.wanted !== null && percent !== this.wanted)) return;
    this.wanted = null;
    this.slider.value = percent;
    this.said.textContent = `${percent} %`;
  }

  async act(name) {
    if (!this.known.includes(name) || !this.run.goesOn) return;
    await this.#ask(`act=${name}&vehicle=${this.chosen()}`);
  }

  async #ask(what) {
    try {
      const answer = await request(`acts?${what}`, { method: "POST", headers: { "X-Zenvoy-Key": this.key } });
      this.refuse(answer.ok ? "" : await answer.text());
      if (!answer.ok) this.wanted = null;
    } catch (error) {
      this.wanted = null;
      report(error);
    }
  }

  // A second click within a few seconds kills, because it cannot be undone.
  #kill() {
    const { kill } = this.buttons;
    const asked = `Kill vehicle ${this.chosen()}?`;
    if (kill.textContent !== asked) {
      kill.textContent = asked;
      clearTimeout(this.timer);
      this.timer = setTimeout(() => (kill.textContent = "Kill"), SURE_MS);
      return;
    }
    kill.textContent = "Kill";
    this.act("kill");
  }
}
