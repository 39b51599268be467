// Puts the page together: asks the server for the run, moves the time on, and draws.
import { Acts } from "./acts.js";
import { Surface } from "./canvas.js";
import { Channel } from "./channel.js";
import { Theme } from "./colours.js";
import { Events, troubled } from "./events.js";
import { Hover } from "./hover.js";
import { colourLegend, radioLegend } from "./legends.js";
import { drawLens } from "./lens.js";
import { Playhead } from "./playhead.js";
import { drawRoad, vehicleAt } from "./road.js";
import { Links, Overview, Pictures, Run } from "./run.js";
import { RoadWords } from "./road_words.js";
import { hasDecisions, HOLD, Scene, SLOWEST } from "./scene.js";
import { scaleOf, speedScale } from "./scales.js";
import { failure, report } from "./server.js";
import { SpaceTime } from "./spacetime.js";
import { Status } from "./status.js";
import { Tiles } from "./tiles.js";
import { Transport } from "./transport.js";
import { Charts } from "./vehicles.js";

const ASK_EVERY = 200; // ms, while a run goes on
const ASK_SELDOM = 1000; // ms, after that, to notice when the server ends
const ASK_SOON = 50; // ms, while the server has read more than this page
const MOST_CHOSEN = 3;
const SLOW = 0.2; // at this speed and below, frames are shown on their way
const get = (id) => document.getElementById(id);
const theme = new Theme();
const run = new Run();
const playhead = new Playhead();
const view = { chosen: [], colour: "speed", radio: "sends", scale: { low: 0, high: 1 }, links: null };
const status = new Status(run);
let page = null;


async function ask() {
  try {
    const isNew = await run.refresh();
    if (run.begun) {
      if (!page) begin();
      playhead.reach(performance.now() / 1000, run.lastTime);
      playhead.attend(run.live, run.goesOn);
      if (isNew || page.overview.times.length < run.points) await page.overview.refresh();
    }
  } catch (error) {
    report(error);
  }
  status.show();
  const behind = page && page.overview.times.length < run.points;
  setTimeout(ask, behind && !failure() ? ASK_SOON : run.whole ? ASK_SELDOM : ASK_EVERY);
}

function begin() {
  const { about } = run;
  document.title = `${about.scenario} · Zenvoy`;
  get("name").textContent = about.scenario;
  const road = about.ring ? `ring of ${Math.round(about.ring).toLocaleString("en")} m` : "open road";
  get("facts").textContent = [`${about.vehicles} vehicles`, road, about.model, about.technology,
    about.clock === "realtime" ? "real time" : `lock-step, ${about.engine}`, `seed ${about.seed}`].filter(Boolean).join(" · ");
  get("facts").title = about.description;
  document.body.classList.toggle("open", !about.ring);
  get("number").max = about.vehicles;
  const surface = (id) => new Surface(get(id), theme);
  const overview = new Overview(run);
  page = {
    overview,
    pictures: new Pictures(run),
    road: surface("road"),
    lens: surface("lens"),
    spacetime: new SpaceTime(surface("spacetime"), overview, about),
    channel: new Channel(surface("channel"), get("channel-legend"), overview, theme),
    charts: new Charts(run, get("charts"), theme, { remove, seek: (time) => transport.seek(time) }),
    hover: new Hover(get("road"), get("hover")),
    tiles: new Tiles(get("tiles")),
    words: new RoadWords(about),
    events: new Events(run, get("events"), get("event-count"), (time, vehicle) => {
      transport.seek(time);
      if (vehicle && !view.chosen.includes(vehicle)) choose([vehicle]);
    }),
  };
  const cycle = (select) => () => {
    select.selectedIndex = (select.selectedIndex + 1) % select.options.length;
    select.dispatchEvent(new Event("change"));
  };
  const transport = new Transport(run, playhead, surface("marks"), theme, {
    "[": () => step(-1), "]": () => step(1), t: () => theme.toggle(), b: () => page.acts.act("brake").catch(report), c: cycle(get("colour")), r: cycle(get("radio")),
    "?": () => get("keys").showModal(),
  });
  page.transport = transport;
  page.acts = new Acts(run, { chosen: () => view.chosen[0], refuse: (text) => status.refuse(text) });
  page.acts.learn().catch(report);
  radioLegend(get("radio-legend"));
  choose(about.chosen);
  get("colour").addEventListener("change", (event) => (view.colour = event.target.value));
  get("radio").addEventListener("change", (event) => {
    view.radio = event.target.value;
    links();
  });
  get("choose").addEventListener("submit", (event) => {
    event.preventDefault();
    const vehicle = Number(get("number").value);
    if (!view.chosen.includes(vehicle)) choose([...view.chosen, vehicle].slice(-MOST_CHOSEN));
    get("number").value = "";
  });
  get("road").addEventListener("click", (event) => {
    if (!page.place || !page.scene) return;
    const vehicle = vehicleAt(page.place, page.scene, event.offsetX, event.offsetY, 2 * page.road.em);
    if (!vehicle) return;
    if (event.shiftKey || event.ctrlKey) choose([...view.chosen.filter((one) => one !== vehicle), vehicle].slice(-MOST_CHOSEN));
    else choose([vehicle]);
  });
  get("spacetime").addEventListener("click", (event) => {
    transport.seek(page.diagram.timeAt(event.offsetX));
    const vehicle = page.diagram.vehicleAt(event.offsetY);
    if (event.shiftKey && vehicle >= 1 && vehicle <= about.vehicles) choose([vehicle]);
  });
  get("channel").addEventListener("click", (event) => transport.seek(page.load.timeAt(event.offsetX)));
  if (run.live) playhead.following = playhead.playing = true;
  else playhead.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  requestAnimationFrame(draw);
}

function step(by) {
  const size = run.about.vehicles;
  const others = view.chosen.slice(1);
  let next = view.chosen[0];
  do next = ((next - 1 + by + size) % size) + 1;
  while (others.includes(next));
  choose([next, ...others]);
}

function remove(vehicle) {
  choose(view.chosen.filter((one) => one !== vehicle));
}

function choose(chosen) {
  view.chosen = [...new Set(chosen)];
  view.lensGap = 0;
  page.charts.choose(view.chosen);
  get("lens-title").textContent = `Around vehicle ${view.chosen[0]}`;
  get("vehicles-title").textContent = view.chosen.length === 1 ? `Vehicle ${view.chosen[0]}` : "Chosen vehicles";
  links();
}

function links() {
  if (view.radio === "off") view.links = null;
  else view.links = new Links(run, view.radio === "neighbours" ? [] : view.chosen);
}

function fine(cycles) {
  // At a high speed not every cycle is shown: about 30 of them a second.
  const pace = playhead.following ? 1 : playhead.speed;
  return Math.max(1, Math.floor((pace * cycles) / 30));
}

const RECENT = 20; // cycles over which frames lost are counted
const SELDOM = 100; // ms between drawings of what moves little
let drawnAt = 0;
let seldomAt = 0;
let shown = "";
const frames = (window.zenvoyFrames = { count: 0, since: performance.now() });

function draw(now) {
  requestAnimationFrame(draw);
  const elapsed = Math.min(0.25, (now - drawnAt) / 1000);
  drawnAt = now;
  frames.count += 1;
  status.show();
  const { about } = run;
  const { pictures, charts } = page;
  const stride = fine(1 / about.period);
  const cycleOf = (time) => Math.floor(time / about.period / stride + 1e-6) * stride;
  playhead.advance(elapsed, (time) => pictures.has(Math.min(cycleOf(time), run.last)));
  const cycle = cycleOf(playhead.time);
  // What is needed soon is asked for now.
  const ahead = Math.ceil(Math.max(10, 1.5 / about.period) * (playhead.following ? 1 : Math.max(1, playhead.speed)));
  pictures.want(cycle, cycle + Math.min(ahead, 60 * stride), stride, cycle + Math.min(ahead, 60 * stride) / 2).catch(report);
  pictures.want(cycle - RECENT * stride, cycle, stride, cycle).catch(report); // after a jump, too
  charts.want(playhead.time).catch(report);
  if (view.links && (playhead.following || playhead.speed <= 2)) {
    const exact = Math.floor(playhead.time / about.period + 1e-6);
    const since = exact - Math.ceil(HOLD / about.period) - SLOWEST;
    view.links.want(since, exact + Math.min(ahead, 60), exact + Math.min(ahead, 60) / 2).catch(report);
  }
  if (page.place) page.hover.draw(page.place, page.scene, 1.2 * page.road.em);
  // What has not changed is not drawn again.
  const looks = [theme.version, Surface.resized, view.chosen.join(), view.colour, view.radio, get("upwards").value].join(" ");
  const data = [run.last, run.live, page.overview.times.length, pictures.version, charts.near.version, view.links?.version].join(" ");
  const state = `${playhead.time} ${playhead.playing} ${playhead.following} ${playhead.speed} ${looks} ${data}`;
  if (state === shown) return;
  shown = state;
  drawRoads(cycle, stride);
  const jumped = looks !== page.looks || !(playhead.playing || playhead.following);
  if (now - seldomAt >= SELDOM || jumped) {
    seldomAt = now;
    page.looks = looks;
    drawDiagrams();
  } else {
    shown = ""; // what is left is drawn in a later frame
  }
}

function drawRoads(cycle, stride) {
  const { about } = run;
  const { pictures } = page;
  const before = pictures.before(cycle, 8 * stride);
  if (!before) return;
  const decided = hasDecisions(before) ? before : pictures.before(before.cycle - stride, 8 * stride);
  const scene = new Scene(about, before, pictures.get(before.cycle + stride), playhead.time, decided ?? before);
  page.scene = scene;
  page.recent = { cycle, stride };
  view.scale = scaleOf(view, scene, page.overview);
  view.faulty = troubled(run.events, playhead.time).filter((vehicle) => vehicle <= scene.size);
  view.slow = !playhead.following && playhead.speed <= SLOW;
  page.place = drawRoad(page.road, scene, view);
  drawLens(page.lens, scene, view);
}

function drawDiagrams() {
  const to = run.live ? Math.max(20, playhead.end) : run.lastTime;
  if (page.scene) drawWords(page.scene, page.recent);
  const speeds = speedScale(page.overview);
  colourLegend(get("spacetime-legend"), "speed", speeds, theme);
  page.diagram = page.spacetime.draw({ to, now: playhead.time, upwards: get("upwards").value, scale: speeds, chosen: view.chosen, events: run.events });
  page.charts.draw(playhead.time, run.events);
  page.load = page.channel.draw(to, playhead.time);
  page.events.draw(playhead.time);
  page.transport.draw();
  page.acts.draw();
}

// Figures, legend and description of the road.
function drawWords(scene, { cycle, stride }) {
  const { about } = run;
  const recent = [];
  for (let k = cycle - RECENT * stride; k <= cycle; k += stride) if (page.pictures.get(k)) recent.push(page.pictures.get(k));
  const settled = recent.filter((picture) => picture.total("delivered") >= 0);
  const wall = scene.before.total("wall");
  page.tiles.show(scene, settled, wall > 0 ? (scene.before.cycle * about.period) / wall : NaN);
  page.words.legend(view, scene, theme);
  page.words.describe(scene, drawnAt);
}

get("theme").addEventListener("click", () => theme.toggle());
get("help").addEventListener("click", () => get("keys").showModal());
ask();
