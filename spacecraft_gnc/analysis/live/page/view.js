// Receives the flight as server-sent events, and draws it. `window.view.state` is for tests.

import { Bodies } from "./bodies.js";
import { Craft } from "./craft.js";
import { Panels } from "./panels.js";
import { Scene } from "./scene.js";
import { showHeader, showNumbers, showSetup } from "./status.js";

const SILENCE = 3000; // [ms] without an event after which the connection counts as lost
const by = (id) => document.getElementById(id);
const style = getComputedStyle(document.documentElement);
const colors = Object.fromEntries(
  ["x", "y", "z", "good", "warn", "bad"].map((name) => [name, style.getPropertyValue(`--${name}`).trim()]),
);
const state = {
  events: 0, drawn: 0, numbers: [], setup: null, frame: null, columns: [], rows: [], axes: {}, span: [],
};
const scenes = {
  sphere: new Scene(by("scene"), colors, schedule),
  bodies: new Bodies(by("scene"), colors, schedule),
  craft: new Craft(by("scene"), colors, schedule),
};
let scene = scenes.sphere;
const panels = new Panels(by("panels"), colors);
let pending = false;
let lastEvent = Date.now();
let seeking = false;

function schedule() {
  if (pending) return;
  pending = true;
  requestAnimationFrame(() => {
    pending = false;
    draw();
  });
}

function column(name) {
  const i = state.columns.indexOf(name);
  return state.rows.map((row) => row[i]);
}

function draw() {
  const { frame, setup } = state;
  if (!frame) return;
  const times = column("time");
  const now = frame.time ?? 0;
  const kept = setup?.trail ? state.columns.indexOf(setup.trail) : state.columns.length - 1;
  const trail = state.rows.filter((row) => row[0] <= now).map((row) => row[kept]).filter((q) => q !== null);
  scene.draw(frame, setup, trail);
  state.span = timeSpan(times, now);
  panels.draw(frame, column, state.span, now);
  state.axes = { ...scene.tips };
  state.ports = { ...scene.ports };
  state.craft = { ...scene.at };
  state.drawn += 1;
}

// What has been flown, and some room ahead: a long flight would else be a blank chart for most of
// it. The room grows in few steps, so that the curves stand still between them. "Whole flight" of a
// recording shows all of it.
function timeSpan(times, now) {
  const { setup, frame } = state;
  const start = Math.min(frame.transport?.start ?? times[0] ?? 0, now);
  const planned = setup?.n_steps && setup.period ? setup.n_steps * setup.period : Infinity;
  const end = Math.max(frame.transport ? frame.transport.end : planned, now, start + 1e-3);
  if (frame.transport && by("whole").checked) return [start, end];
  return [start, Math.min(end, start + roundUp(Math.max(1.15 * (now - start), 10)))];
}

function roundUp(duration) {
  const power = 10 ** Math.floor(Math.log10(duration));
  return power * [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((m) => m * power >= duration * 0.999);
}

function onSetup(setup) {
  state.setup = setup;
  scene = scenes[kind(setup)];
  showSetup(setup);
  panels.build(setup.panels);
  by("legend").replaceChildren(...legend(setup).map((text) => {
    const item = document.createElement("li");
    item.textContent = text;
    return item;
  }));
}

const kind = ({ bodies, craft }) => (craft.length ? "craft" : bodies.length ? "bodies" : "sphere");

function legend({ bodies, craft, zones, wheels }) {
  if (craft.length) {
    return ["dots: craft", "diamonds: commanded places", "dashed: natural ellipse", "lines: limits of a pair kept, red: broken", "cross: lost"];
  }
  if (bodies.length) return ["dots: ports", "green: line of sight", "line: path", "diamond: reference"];
  return [
    "dashed ring: target", "small ring: reference", ...(zones.length ? ["dotted line: instrument of a zone"] : []),
    ...(wheels.length ? ["disk: wheel, its arc the speed", "red: lost", "crossed: excluded"] : []),
  ];
}

function onFrame({ samples, ...frame }) {
  state.rows.push(...samples);
  state.frame = frame;
  state.events += 1;
  state.numbers = [...state.numbers.slice(-999), frame.number];
  showHeader(frame, state.setup);
  showNumbers(frame.readouts);
  showPlayer(frame);
  schedule();
}

function showPlayer({ transport, phase, time }) {
  by("player").hidden = !transport;
  if (!transport) return;
  by("play").textContent = { playing: "Pause", over: "Again" }[phase] ?? "Play";
  by("seek").min = transport.start;
  by("seek").max = transport.end;
  if (!seeking && time !== null) by("seek").value = time;
  if (document.activeElement !== by("rate")) showRate(transport.rate);
}

function showRate(rate) {
  const text = `${rate}`;
  if (![...by("rate").options].some((option) => option.value === text)) by("rate").add(new Option(text, text));
  by("rate").value = text;
}

async function command(action, value = null) {
  await fetch("control", {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify({ action, value }),
  });
}

function listen() {
  const source = new EventSource("events");
  const on = (name, take) => source.addEventListener(name, (event) => {
    lastEvent = Date.now();
    take(JSON.parse(event.data));
  });
  on("setup", onSetup);
  on("history", ({ columns }) => {
    state.columns = columns;
    state.rows = [];
  });
  on("frame", onFrame);
}

by("play").addEventListener("click", () => command(state.frame?.phase === "playing" ? "pause" : "play"));
by("rate").addEventListener("change", () => command("rate", Number(by("rate").value)));
by("seek").addEventListener("input", () => {
  seeking = true;
  command("seek", Number(by("seek").value));
});
by("seek").addEventListener("change", () => { seeking = false; });
by("whole").addEventListener("change", schedule);
window.addEventListener("resize", schedule);
setInterval(() => {
  if (Date.now() - lastEvent < SILENCE) return;
  by("phase").textContent = "connection lost";
  by("phase").className = "badge lost";
}, 500);
window.view = { state, get scene() { return scene; } };
listen();
