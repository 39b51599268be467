// The figures of the fleet at the time shown.
const TILES = [
  ["Time", "s"], ["Mean speed", "m/s"], ["Smallest gap", "m"], ["Oldest data", "s"], ["Frames lost", "%"], ["Pace", "× real time"],
];

export class Tiles {
  constructor(list) {
    this.values = TILES.map(([name, unit]) => {
      const tile = document.createElement("div");
      const dt = document.createElement("dt");
      const dd = document.createElement("dd");
      const value = document.createElement("span");
      const small = document.createElement("small");
      dt.textContent = name;
      small.textContent = ` ${unit}`;
      dd.append(value, small);
      tile.append(dt, dd);
      list.append(tile);
      return value;
    });
  }

  show(scene, recent, pace) {
    let lost = 0;
    let all = 0;
    for (const picture of recent) {
      const missed = picture.total("lost") + picture.total("collided");
      const sum = missed + picture.total("delivered") + picture.total("late");
      if (sum > 0) {
        lost += missed;
        all += sum;
      }
    }
    const last = recent[recent.length - 1] ?? scene.before;
    const texts = [
      number(scene.time, 1), number(scene.total("mean_speed"), 2), number(scene.total("smallest_gap"), 2),
      number(last.total("oldest"), 2, 0), all ? number((100 * lost) / all, 1) : "–", number(pace, 1),
    ];
    texts.forEach((text, i) => {
      if (this.values[i].textContent !== text) this.values[i].textContent = text;
    });
  }
}

function number(value, places, least = -Infinity) {
  return Number.isFinite(value) && value >= least ? value.toFixed(places).replace("-", "−") : "–";
}
