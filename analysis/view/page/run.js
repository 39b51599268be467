// The run as the server tells it: facts, how far it is, and pictures of its cycles.
import { unpack } from "./block.js";
import { ask } from "./server.js";

const KEPT_NUMBERS = 24e6; // of one store, in all its pictures
const AT_ONCE = 3e5; // numbers asked for in one request
const CYCLES_AT_ONCE = 60;

async function block(what) {
  return unpack(await (await ask(what)).arrayBuffer());
}

export class Run {
  constructor() {
    this.about = null;
    this.last = -1;
    this.points = 0;
    this.end = null;
    this.whole = false;
    this.still = false; // whether its log has no end and does not grow any more
    this.events = []; // in order of time
    this.faults = [];
  }

  // Asks how far the run is. Returns whether anything is new.
  async refresh() {
    const state = await (await ask(`state?events=${this.events.length}`)).json();
    if (state.begun && this.about === null) this.about = await (await ask("about")).json();
    const isNew = state.last !== this.last || state.points !== this.points || state.events.length > 0 || state.whole !== this.whole;
    const { last, points, end, whole, still, faults } = state;
    Object.assign(this, { last, points, end, whole, still, faults });
    this.#take(state.events);
    return isNew;
  }

  // What a process reports late, such as the end of another one, has an earlier time.
  #take(events) {
    if (!events.length) return;
    this.events.push(...events);
    this.events.sort((a, b) => a.time - b.time);
  }

  get begun() {
    return this.about !== null;
  }

  // Whether the run goes on, and its log grows.
  get live() {
    return this.goesOn && !this.still;
  }

  // Whether the log has no end yet.
  get goesOn() {
    return this.begun && this.end === null;
  }

  get duration() {
    return this.about.cycles * this.about.period;
  }

  get lastTime() {
    return Math.max(0, this.last) * this.about.period;
  }
}

// A cycle: times, positions and columns of some vehicles.
class Picture {
  constructor(store, cycle, position, columns, totals) {
    this.store = store;
    this.cycle = cycle;
    this.position = position;
    this.columns = columns;
    this.totals = totals;
  }

  // The values of a column, a number for each vehicle of the store.
  column(name) {
    const size = this.store.size;
    const at = this.store.names.indexOf(name) * size;
    return this.columns.subarray(at, at + size);
  }

  total(name) {
    return this.totals[this.store.totals.indexOf(name)];
  }
}

// Pictures of cycles, for all vehicles or for some of them. It asks for one range at a time.
export class Pictures {
  constructor(run, vehicles = []) {
    this.run = run;
    this.vehicles = vehicles;
    this.size = vehicles.length || run.about.vehicles;
    this.names = Object.keys(run.about.columns);
    this.totals = Object.keys(run.about.totals);
    this.kept = new Map(); // null for a cycle that the log does not have
    this.busy = false;
    this.version = 0;
    this.each = this.size * (this.names.length + 2);
  }

  get(cycle) {
    return this.kept.get(cycle) ?? null;
  }

  has(cycle) {
    return this.kept.has(cycle);
  }

  // The newest picture of a cycle at or before this one, within `reach` cycles.
  before(cycle, reach) {
    for (let k = cycle; k >= Math.max(0, cycle - reach); k--) if (this.kept.get(k)) return this.kept.get(k);
    return null;
  }

  // Sees to it that the cycles of a range will be there, one in `step`. While those up to `enough`
  // are there it asks for none, so that requests are few.
  async want(first, last, step, enough) {
    first = Math.max(0, Math.ceil(first / step) * step);
    last = Math.min(last, this.run.last);
    while (first <= last && this.kept.has(first)) first += step;
    if (this.busy || first > last || (first > enough && last < this.run.last)) return;
    let until = first;
    const most = Math.max(1, Math.min(CYCLES_AT_ONCE, Math.floor(AT_ONCE / (this.run.about.vehicles * this.names.length))));
    for (let count = 1; count < most && until + step <= last && !this.kept.has(until + step); count++) until += step;
    this.busy = true;
    try {
      const found = await block(`cycles?from=${first}&to=${until}&step=${step}&vehicles=${this.vehicles.join(",")}`);
      const { size } = this;
      const columns = this.names.length * size;
      for (let k = first; k <= until; k += step) this.kept.set(k, null);
      found.cycle.forEach((cycle, i) => {
        this.kept.set(cycle, new Picture(
          this, cycle,
          found.position.subarray(i * size, (i + 1) * size),
          found.columns.subarray(i * columns, (i + 1) * columns),
          found.totals.subarray(i * this.totals.length, (i + 1) * this.totals.length),
        ));
      });
      this.version += 1;
      this.#forget((first + until) / 2);
    } finally {
      this.busy = false;
    }
  }

  #forget(around) {
    const most = Math.max(64, Math.floor(KEPT_NUMBERS / this.each));
    if (this.kept.size <= most) return;
    const far = [...this.kept.keys()].sort((a, b) => Math.abs(b - around) - Math.abs(a - around));
    for (const cycle of far.slice(0, this.kept.size - Math.floor(0.8 * most))) this.kept.delete(cycle);
  }
}

// The frames that chosen vehicles send or receive, by cycle.
export class Links {
  constructor(run, vehicles) {
    this.run = run;
    this.vehicles = vehicles;
    this.kept = new Map();
    this.busy = false;
    this.version = 0;
  }

  get(cycle) {
    return this.kept.get(cycle) ?? [];
  }

  async want(first, last, enough) {
    first = Math.max(0, first);
    last = Math.min(last, this.run.last);
    while (first <= last && this.kept.has(first)) first += 1;
    if (this.busy || first > last || (first > enough && last < this.run.last)) return;
    this.busy = true;
    try {
      const found = await block(`links?from=${first}&to=${last}&vehicles=${this.vehicles.join(",")}`);
      for (let k = first; k <= last; k++) this.kept.set(k, []);
      found.cycle.forEach((cycle, i) => this.kept.get(cycle)?.push({
        source: found.source[i], destination: found.destination[i], outcome: found.outcome[i],
        sent: found.sent[i], arrived: found.arrived[i],
      }));
      this.version += 1;
      if (this.kept.size > 400) for (const cycle of [...this.kept.keys()].slice(0, 200)) this.kept.delete(cycle);
    } finally {
      this.busy = false;
    }
  }
}

// Samples of the whole run.
export class Overview {
  constructor(run) {
    this.run = run;
    this.times = [];
    this.vehicles = new Uint32Array(0);
    this.positions = [];
    this.speeds = [];
    this.totals = [];
    this.names = Object.keys(run.about.totals);
    this.low = Infinity;
    this.high = -Infinity;
    this.busy = false;
  }

  total(point, name) {
    return this.totals[point][this.names.indexOf(name)];
  }

  async refresh() {
    if (this.busy || this.times.length >= this.run.points) return;
    this.busy = true;
    try {
      const found = await block(`overview?from=${this.times.length}`);
      const size = found.vehicle.length;
      this.vehicles = found.vehicle;
      found.cycle.forEach((cycle, i) => {
        const speeds = found.speed.subarray(i * size, (i + 1) * size);
        this.times.push(cycle * this.run.about.period);
        this.positions.push(found.position.subarray(i * size, (i + 1) * size));
        this.speeds.push(speeds);
        this.totals.push(found.totals.subarray(i * this.names.length, (i + 1) * this.names.length));
        for (const v of speeds) {
          if (v < this.low) this.low = v;
          if (v > this.high) this.high = v;
        }
      });
    } finally {
      this.busy = false;
    }
  }
}
