"use strict";
// What the 3-D views of a page have in common: packed arrays, the readout, the slider and play.

function unpack(array) {
  const bytes = Uint8Array.from(atob(array.bdata), (letter) => letter.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

// Attitudes are 3x3 matrices, row-major, from body to inertial components: column j is body axis j.
const columnOf = (matrices, k, j) => [0, 1, 2].map((i) => matrices[9 * k + 3 * i + j]);
const timesVector = (matrices, k, v) =>
  [0, 1, 2].map((i) => [0, 1, 2].reduce((sum, j) => sum + matrices[9 * k + 3 * i + j] * v[j], 0));

// Points of a curve, three numbers each.
function rowsOf(packed) {
  const numbers = unpack(packed), rows = [];
  for (let k = 0; k < numbers.length; k += 3) rows.push(Array.from(numbers.slice(k, k + 3)));
  return rows;
}

// Between two lines of one trace.
const GAP = [null, null, null];

function coordinates(points) {
  const [x, y, z] = [0, 1, 2].map((i) => points.map((point) => point[i]));
  return { x, y, z };
}

function line3d(points, options) {
  return { type: "scatter3d", mode: "lines", ...coordinates(points), hoverinfo: "skip", showlegend: false, ...options };
}

function readoutRows(run, k) {
  return run.readout.map(({ label, values, width, fixed, significant, notes }) => {
    const shown = (value) => (fixed === undefined ? value.toPrecision(significant) : value.toFixed(fixed));
    const text = (value) => (Number.isFinite(value) ? shown(value) : "-");
    const numbers = Array.from(values.slice(width * k, width * (k + 1)), text).join(", ");
    return [label, notes?.length ? `${numbers} (${notes[k]})` : numbers];
  });
}

function writeReadout(run, k, told) {
  const text = `t = ${run.time[k].toFixed(2)} s, step ${run.step[k]}`;
  document.getElementById("time-text").textContent = text;
  document.getElementById("time").setAttribute("aria-valuetext", `${text}, ${told}`);
  const rows = readoutRows(run, k).map(([name, value]) => {
    const row = document.createElement("tr");
    const head = row.appendChild(document.createElement("th"));
    head.scope = "row";
    head.textContent = name;
    row.appendChild(document.createElement("td")).textContent = value;
    return row;
  });
  document.getElementById("readout").replaceChildren(...rows);
}

function addSwitch(place, id, text, checked, change) {
  const label = document.createElement("label"), box = document.createElement("input");
  Object.assign(box, { type: "checkbox", id, checked });
  label.className = "control";
  label.append(box, ` ${text}`);
  place.append(label);
  box.addEventListener("change", () => change(box.checked));
}

// Slider, play and choice of the run. `view`: draw(run) draws a run at its start, move(run, k) moves
// it to state k, told(run, k) says in words how it stands. Returns what draws the shown run anew.
async function connectPlayer(runs, view) {
  const slider = document.getElementById("time"), select = document.getElementById("view-run");
  const play = document.getElementById("play");
  let run = runs[0], timer = null;

  async function showRun(index) {
    run = runs[index];
    slider.max = String(run.count - 1);
    slider.value = "0";
    await view.draw(run);
    writeReadout(run, 0, view.told(run, 0));
  }

  function moveTo(k) {
    writeReadout(run, k, view.told(run, k));
    return view.move(run, k);
  }

  function stop() {
    window.clearInterval(timer);
    timer = null;
    play.textContent = "▶";
    play.setAttribute("aria-label", "Play the flight");
  }

  function start() {
    if (Number(slider.value) >= run.count - 1) slider.value = "0";
    // A flight lasts some ten seconds.
    const stride = Math.max(1, Math.round(run.count / 300)), wait = Math.min(Math.max(10000 / run.count, 40), 150);
    timer = window.setInterval(() => {
      slider.value = String(Math.min(Number(slider.value) + stride, run.count - 1));
      moveTo(Number(slider.value));
      if (Number(slider.value) >= run.count - 1) stop();
    }, wait);
    play.textContent = "❚❚";
    play.setAttribute("aria-label", "Pause the flight");
  }

  slider.addEventListener("input", () => moveTo(Number(slider.value)));
  play.addEventListener("click", () => (timer === null ? start() : stop()));
  select.addEventListener("change", () => { stop(); return showRun(Number(select.value)); });
  select.value = "0";
  document.getElementById("run-control").hidden = runs.length < 2;
  await showRun(0);
  return () => moveTo(Number(slider.value));
}
