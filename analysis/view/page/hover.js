// What is known of the vehicle under the mouse.
import { vehicleAt } from "./road.js";

export class Hover {
  constructor(canvas, place) {
    Object.assign(this, { canvas, place });
    this.at = null;
    canvas.addEventListener("mousemove", (event) => (this.at = [event.offsetX, event.offsetY]));
    canvas.addEventListener("mouseleave", () => {
      this.at = null;
      place.hidden = true;
    });
  }

  draw(road, scene, within) {
    if (!this.at) return;
    const vehicle = vehicleAt(road, scene, ...this.at, within);
    this.place.hidden = !vehicle;
    this.canvas.style.cursor = vehicle ? "pointer" : "default";
    if (!vehicle) return;
    const i = vehicle - 1;
    const text = words(scene, i);
    if (this.place.textContent !== text) this.place.textContent = text;
    const [x, y] = this.at;
    const left = this.canvas.offsetLeft + Math.min(x + 12, this.canvas.clientWidth - this.place.offsetWidth);
    const top = this.canvas.offsetTop + Math.max(0, y - this.place.offsetHeight - 8);
    this.place.style.transform = `translate(${left}px, ${top}px)`;
    this.place.style.left = this.place.style.top = "0";
  }
}

function words(scene, i) {
  const gap = scene.between("gap")[i];
  const age = scene.ages[i];
  return [
    `vehicle ${i + 1}`,
    scene.about.modes[scene.modes[i]]?.[0],
    `${scene.speeds[i].toFixed(1)} m/s`,
    Number.isFinite(gap) ? `gap ${gap.toFixed(1)} m` : "",
    age >= 0 ? `data ${age.toFixed(2)} s old` : "",
  ].filter(Boolean).join(" · ");
}
