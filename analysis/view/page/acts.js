// What a person may do to a run in real time. The key comes with the address that the command prints.
const SURE_MS = 4000;

export class Acts {
  constructor(run, { chosen, trouble }) {
    Object.assign(this, { run, chosen, trouble });
    this.key = location.hash.slice(1);
    this.known = [];
    this.place = document.getElementById("acts");
    this.buttons = { brake: document.getElementById("brake"), kill: document.getElementById("kill") };
    this.buttons.brake.addEventListener("click", () => this.act("brake"));
    this.buttons.kill.addEventListener("click", () => this.#kill());
  }

  async learn() {
    if (!this.key) return;
    this.known = (await (await fetch("acts")).json()).acts;
    for (const [name, button] of Object.entries(this.buttons)) button.hidden = !this.known.includes(name);
  }

  draw() {
    const hidden = !this.known.length || !this.run.live;
    if (this.place.hidden !== hidden) this.place.hidden = hidden;
  }

  async act(name) {
    if (!this.known.includes(name) || !this.run.live) return;
    const answer = await fetch(`acts?act=${name}&vehicle=${this.chosen()}`, { method: "POST", headers: { "X-Zenvoy-Key": this.key } });
    this.trouble(answer.ok ? "" : await answer.text());
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
