// What has happened, in words; each event is a way to its time.
const BAD = new Set(["COLLISION", "FALLBACK", "PROCESS_LOST", "STOPPED", "SILENT", "FAULT"]);
const SHOWN = 200;

// The vehicles that have a fault at a time, or send no commands.
export function troubled(events, time) {
  const faulty = new Map(); // how many faults a vehicle has
  for (const event of events) {
    if (event.time > time + 1e-9) break;
    const change = { FAULT: 1, SILENT: 1, FAULT_END: -1, SILENT_END: -1 }[event.kind];
    if (change && event.vehicle) faulty.set(event.vehicle, (faulty.get(event.vehicle) ?? 0) + change);
  }
  return [...faulty].filter(([, count]) => count > 0).map(([vehicle]) => vehicle);
}

export const isBad = (event) => BAD.has(event.kind);

export class Events {
  constructor(run, list, count, seek) {
    Object.assign(this, { run, list, count, seek });
    this.first = 0;
    this.made = "";
    this.at = -2;
  }

  draw(time) {
    const { events } = this.run;
    let past = 0;
    while (past < events.length && events[past].time <= time + 1e-9) past += 1;
    const first = Math.max(0, Math.min(events.length - SHOWN, past - SHOWN / 2));
    const made = `${events.length} ${Math.floor(first / 50)}`;
    if (made !== this.made) {
      this.made = made;
      this.first = Math.floor(first / 50) * 50;
      this.#list(events.slice(this.first, this.first + SHOWN));
      this.count.textContent = events.length === 1 ? "1 event" : `${events.length} events`;
      this.at = -2;
    }
    if (past !== this.at) {
      this.at = past;
      [...this.list.children].forEach((item, i) => {
        item.classList.toggle("ahead", this.first + i >= past);
        item.classList.toggle("now", this.first + i === past - 1);
      });
      const now = this.list.children[past - 1 - this.first];
      if (now && !this.list.matches(":hover, :focus-within")) this.list.scrollTop = now.offsetTop - this.list.offsetTop - this.list.clientHeight / 2;
    }
  }

  #list(events) {
    this.list.replaceChildren(...events.map((event) => {
      const item = document.createElement("li");
      const button = document.createElement("button");
      const time = document.createElement("time");
      const text = document.createElement("span");
      button.type = "button";
      time.textContent = `${event.time.toFixed(1)} s`;
      text.textContent = event.words;
      if (isBad(event)) item.className = "bad";
      button.append(time, text);
      button.addEventListener("click", () => this.seek(event.time, event.vehicle));
      item.append(button);
      return item;
    }));
    if (!events.length) {
      const item = document.createElement("li");
      item.className = "quiet";
      item.textContent = "none yet";
      this.list.append(item);
    }
  }
}
