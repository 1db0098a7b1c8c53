// Bars and strips, drawn on plain canvases.

const MARGIN = { left: 52, right: 10, top: 6, bottom: 20 };
const GRID = "#2b3644";
const TEXT = "#93a1b1";
const FONT = "11px system-ui, 'DejaVu Sans', sans-serif";
export const INK = "#e6ebf1";

// A number with an SI prefix that suits it: [text, factor, prefix].
export function prefix(largest) {
  if (!(largest > 0)) return [1, ""];
  const p = Math.max(-3, Math.min(1, Math.floor((Math.log10(largest) + 0.7) / 3)));
  return [1000 ** -p, { "-3": "n", "-2": "µ", "-1": "m", 0: "", 1: "k" }[p]];
}

function begin(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: w, clientHeight: h } = canvas;
  canvas.width = Math.round(w * ratio);
  canvas.height = Math.round(h * ratio);
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.font = FONT;
  pen.lineJoin = "round";
  return [pen, w, h];
}

function label(pen, text, x, y, align, color = TEXT) {
  pen.fillStyle = color;
  pen.textAlign = align;
  pen.textBaseline = "middle";
  pen.fillText(text, x, y);
}

function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 2.5, 5, 10].find((m) => m * power >= rough * 0.999);
  const found = [];
  for (let t = Math.ceil(low / step); t * step <= high + 1e-9 * step; t += 1) found.push(t * step);
  return found;
}

const amount = (v) => (v !== 0 && Math.abs(v) < 0.01 ? v.toExponential(1) : `${+v.toPrecision(3)}`);

// A bar for each component now, and one for their norm; the limit applies to that or else to each.
// `rows`: [[name, value, color]].
export function drawBars(canvas, rows, { limit, unit }, largest, bad) {
  const [pen, w, h] = begin(canvas);
  const scale = 1.15 * Math.max(limit, largest) || 1;
  const [factor, name] = prefix(Math.max(limit, largest));
  const widest = Math.max(0, ...rows.map(([text]) => pen.measureText(text).width));
  const [left, right] = [Math.max(30, widest + 14), 92];
  const half = (w - left - right) / 2;
  const zero = left + half;
  const row = h / Math.max(rows.length, 1);
  rows.forEach(([text, value, color], i) => {
    const y = i * row + row / 2;
    pen.fillStyle = GRID;
    pen.fillRect(left, y - row * 0.3, 2 * half, row * 0.6);
    label(pen, text, left - 8, y, "right");
    if (value === null || value === undefined) return;
    const length = (half * value) / scale;
    pen.fillStyle = limit > 0 && Math.abs(value) >= 0.999 * limit ? bad : color;
    pen.fillRect(Math.min(zero, zero + length), y - row * 0.3, Math.abs(length), row * 0.6);
    label(pen, `${amount(value * factor)} ${name}${unit}`, w - 4, y, "right", INK);
  });
  line(pen, zero, 0, zero, h, TEXT, 1);
  if (limit > 0) {
    for (const sign of [-1, 1]) {
      const x = zero + (sign * half * limit) / scale;
      line(pen, x, 0, x, h, bad, 1.5, [4, 3]);
    }
  }
}

function line(pen, x0, y0, x1, y1, color, width, dash = []) {
  pen.setLineDash(dash);
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.strokeStyle = color;
  pen.lineWidth = width;
  pen.stroke();
  pen.setLineDash([]);
}

// Series over time. `series`: [{values, color, width}]; `span`: [start, end] [s]; what lies after
// `now` is faint.
export function drawStrip(canvas, times, series, span, now, { log = false, factor = 1, limit = 0, bad = "" } = {}) {
  const [pen, w, h] = begin(canvas);
  const map = (v) => (log ? (v > 0 ? Math.log10(v) : null) : v * factor);
  const rows = series.map((s) => s.values.map((v) => (v === null ? null : map(v))));
  const seen = (row) => row.filter((_, k) => times[k] >= span[0] && times[k] <= span[1]);
  const [low, high] = range(rows.map(seen), log);
  const [x0, x1] = [MARGIN.left, w - MARGIN.right];
  const [y0, y1] = [h - MARGIN.bottom, MARGIN.top];
  const x = (t) => x0 + ((x1 - x0) * (t - span[0])) / (span[1] - span[0]);
  const y = (v) => y0 + ((y1 - y0) * (v - low)) / (high - low);
  const decades = ticks(low, high, 5).filter((v) => !log || Number.isInteger(Math.round(v * 1e6) / 1e6));
  for (const v of decades) {
    line(pen, x0, y(v), x1, y(v), GRID, 1);
    label(pen, log ? decade(v) : `${+v.toPrecision(6)}`, x0 - 6, y(v), "right");
  }
  for (const t of ticks(span[0], span[1], Math.max(2, Math.min(8, w / 90)))) {
    line(pen, x(t), y0, x(t), y0 + 3, TEXT, 1);
    const text = `${+t.toPrecision(6)}${t === 0 ? " s" : ""}`;
    label(pen, text, Math.min(x(t), w - pen.measureText(text).width / 2), h - 8, "center");
  }
  for (const bound of limit > 0 ? [-limit * factor, limit * factor] : []) {
    if (bound > low && bound < high) line(pen, x0, y(bound), x1, y(bound), bad, 1.5, [4, 3]);
  }
  const edge = Math.min(Math.max(x(now), x0), x1);
  for (const [from, to, alpha] of [[x0, edge, 1], [edge, x1, 0.35]]) {
    within(pen, from, y1 - 2, to - from, y0 - y1 + 4, () => {
      pen.globalAlpha = alpha;
      rows.forEach((row, i) => curve(pen, times, row, x, y, series[i]));
    });
  }
  line(pen, edge, y1, edge, y0, INK, 1);
  return { x0, x1 };
}

// Draw inside a rectangle.
function within(pen, x, y, w, h, draw) {
  pen.save();
  pen.beginPath();
  pen.rect(x, y, w, h);
  pen.clip();
  draw();
  pen.restore();
}

function curve(pen, times, row, x, y, { color, width = 1.6 }) {
  pen.beginPath();
  let down = false;
  row.forEach((v, k) => {
    if (v === null) {
      down = false;
      return;
    }
    pen[down ? "lineTo" : "moveTo"](x(times[k]), y(v));
    down = true;
  });
  pen.strokeStyle = color;
  pen.lineWidth = width;
  pen.stroke();
}

function range(rows, log) {
  let [low, high] = [Infinity, -Infinity];
  for (const row of rows) {
    for (const v of row) {
      if (v === null) continue;
      low = Math.min(low, v);
      high = Math.max(high, v);
    }
  }
  if (low > high) return log ? [-3, 2] : [-1, 1];
  if (log) return [Math.floor(low), Math.max(Math.ceil(high), Math.floor(low) + 1)];
  const pad = 0.08 * (high - low) || 0.1 * Math.abs(high) || 1;
  return [Math.min(low - pad, 0), Math.max(high + pad, 0)];
}

function decade(v) {
  const power = Math.round(v);
  return power >= -3 && power <= 3 ? `${+(10 ** power).toPrecision(1)}` : `1e${power}`;
}

// A word over time, by its color.
export function drawBand(canvas, times, words, wordColors, span, now) {
  const [pen, w, h] = begin(canvas);
  const [x0, x1] = [MARGIN.left, w - MARGIN.right];
  const x = (t) => x0 + ((x1 - x0) * (t - span[0])) / (span[1] - span[0]);
  pen.fillStyle = GRID;
  pen.fillRect(x0, 0, x1 - x0, h);
  const edge = Math.min(Math.max(x(now), x0), x1);
  for (const [from, to, alpha] of [[x0, edge, 1], [edge, x1, 0.35]]) {
    within(pen, from, 0, to - from, h, () => {
      pen.globalAlpha = alpha;
      bands(pen, times, words, wordColors, x, h);
    });
  }
  line(pen, edge, 0, edge, h, INK, 1);
}

function bands(pen, times, words, wordColors, x, h) {
  for (let k = 0; k < times.length;) {
    let end = k + 1;
    while (end < times.length && words[end] === words[k]) end += 1;
    const known = wordColors[words[k]];
    if (known) {
      const until = end < times.length ? times[end] : times[end - 1];
      pen.fillStyle = known;
      pen.fillRect(x(times[k]), 0, Math.max(x(until) - x(times[k]), 1), h);
    }
    k = end;
  }
}
