// Numbers in words: the lists beside the picture.

import { prefix } from "./charts.js";

const digits = (v, n, unit = "") => (v === null || v === undefined ? "–" : `${+v.toPrecision(n)}${unit}`);
const small = (v) => (v === null || v === undefined ? "–" : Math.abs(v) >= 0.01 ? digits(v, 4) : v.toExponential(2));
const micro = (v) => {
  if (v === null || v === undefined) return "–";
  return v < 1e-3 ? `${(v * 1e6).toFixed(0)} µs` : `${(v * 1e3).toFixed(2)} ms`;
};

function disturbance(torque) {
  const size = Math.hypot(...(torque ?? []));
  const [factor, name] = prefix(size);
  return size > 0 ? `${+(size * factor).toPrecision(3)} ${name}N m` : "–";
}

function fill(list, rows) {
  const known = rows.filter(([, value]) => value !== "–" && value !== "");
  list.hidden = known.length === 0;
  list.replaceChildren(...known.flatMap(([name, value, mood]) => {
    const [term, detail] = [document.createElement("dt"), document.createElement("dd")];
    term.textContent = name;
    detail.textContent = value;
    if (mood) detail.className = mood;
    return [term, detail];
  }));
}

export function showNumbers(frame, setup) {
  const by = (id) => document.getElementById(id);
  const { solve, decision, timing } = frame;
  const solves = frame.source !== "method";
  const governed = decision && setup?.governor && setup.governor !== "none";
  fill(by("state"), [
    ["error to reference", digits(frame.error_deg, 4, "°")],
    ["error to target", governed ? digits(frame.target_error_deg, 4, "°") : "–"],
    ["torque from", frame.torque ? frame.source : "–", ["optimal", "neighboring extremal", "method"].includes(frame.source) ? "" : "warn"],
    ["disturbed by", disturbance(frame.external_torque)],
    ...Object.entries(frame.margins_deg).map(([name, v]) => [
      `margin to ${name}`, digits(v, 4, "°"), v < 0 ? "bad" : "",
    ]),
  ]);
  fill(by("solver"), solve && solves ? [
    ["solver", solve.status, solve.status === "converged" ? "" : "warn"],
    ["iterations", solve.status === "no solve" ? "–" : `${solve.iterations}`],
    ["residual", small(solve.residual)],
    ["least curvature", small(solve.curvature)],
    ["solve time", micro(solve.solve_time)],
  ] : []);
  fill(by("governor"), governed ? [
    ["governor alpha", digits(decision.alpha, 4)],
    ["margin", small(decision.margin)],
    ["limited by", decision.constraint],
    ["reference held", decision.admissible ? "–" : "yes", "warn"],
  ] : []);
  fill(by("timing"), timing ? [
    ["times real time", digits(timing.speed, 3)],
    ["state to torque", micro(timing.latency)],
    ["deadline slack", micro(timing.slack), timing.slack < 0 ? "bad" : ""],
    ["deadlines missed", `${timing.missed}`, timing.missed ? "bad" : ""],
    ["messages rejected", timing.rejected ? `${timing.rejected}` : "–", "bad"],
  ] : []);
}

export function showHeader(frame, setup) {
  const by = (id) => document.getElementById(id);
  by("phase").textContent = { over: "flight over" }[frame.phase] ?? frame.phase;
  if (!setup?.live && frame.phase === "over") by("phase").textContent = "end of recording";
  by("phase").className = `badge ${frame.phase}`;
  by("note").textContent = frame.note;
  by("note").hidden = frame.note === "";
  const of = setup?.n_steps ? ` of ${setup.n_steps}` : "";
  by("clock").textContent = frame.step < 0 ? "" : `t = ${frame.time.toFixed(1)} s  ·  step ${frame.step}${of}`;
}

export function showSetup(setup) {
  const words = [setup.method, setup.governor && setup.governor !== "none" ? `${setup.governor} governor` : "", setup.mode];
  document.getElementById("title").textContent = setup.title;
  document.getElementById("about").textContent = words.filter(Boolean).join("  ·  ");
  document.title = `${setup.title} – gnc view`;
}

// Coloured words that explain the lines of a chart.
export function showKeys(id, keys) {
  document.getElementById(id).replaceChildren(...keys.map(([name, colour]) => {
    const [key, text] = [document.createElement("span"), document.createElement("b")];
    key.className = "key";
    key.style.color = colour;
    text.textContent = name;
    key.append(text);
    return key;
  }));
}
