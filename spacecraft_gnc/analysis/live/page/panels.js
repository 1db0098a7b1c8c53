// The charts that the vehicle asks for: one card each, drawn from the rows of its history.

import { drawBand, drawBars, drawStrip, prefix } from "./charts.js";
import { componentColor } from "./scene.js";
import { showKeys } from "./status.js";

const make = (tag, name, text = "") => {
  const element = document.createElement(tag);
  if (name) element.className = name;
  element.textContent = text;
  return element;
};
const list = (value) => (Array.isArray(value) ? value : [value]);
const rounded = (value) => `${+value.toPrecision(4)}`;

export class Panels {
  constructor(place, colors) {
    this.place = place;
    this.colors = colors;
    this.cards = [];
  }

  build(panels) {
    this.cards = panels.map((panel) => this.#card(panel));
    this.place.replaceChildren(...this.cards.map(({ section }) => section));
  }

  draw(frame, column, span, now) {
    const times = column("time");
    for (const { panel, canvas, unit, keys } of this.cards) {
      if (panel.kind === "bars") {
        this.#bars(canvas, panel, frame[panel.series[0].key], column(panel.series[0].key));
      } else if (panel.kind === "band") {
        drawBand(canvas, times, column(panel.series[0].key), panel.colors, span, now);
      } else {
        this.#strip(canvas, panel, unit, keys, column, [times, span, now]);
      }
    }
  }

  #card(panel) {
    const [section, head] = [make("section", `chart ${panel.kind}${panel.log ? " log" : ""}`), make("h2", "", panel.title)];
    const [unit, keys] = [make("small", "", this.#about(panel)), make("span", "keys")];
    const canvas = make("canvas");
    [canvas.id, unit.id] = [`panel-${panel.name}`, `panel-${panel.name}-note`];
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", panel.title);
    if (panel.kind === "band") showKeys(keys, Object.entries(panel.colors));
    head.append(unit, keys);
    section.append(head, canvas);
    return { panel, section, canvas, unit, keys };
  }

  #about({ kind, log, limit, norm, unit }) {
    if (kind === "strip") return log ? `${unit}, log` : unit;
    if (kind === "band") return "";
    const [factor, name] = prefix(limit);
    return limit ? `limit of ${norm || "each"} ${rounded(limit * factor)} ${name}${unit}` : "no limit known";
  }

  #name(panel, series, i) {
    return series.names[i] ?? `${panel.numbered}${i + 1}`;
  }

  #color(i) {
    return componentColor(this.colors, i);
  }

  #bars(canvas, panel, value, past) {
    const [series] = panel.series;
    const size = (v) => (panel.norm ? Math.hypot(...v) : Math.max(0, ...v.map(Math.abs)));
    const largest = [...past, value].reduce((most, v) => Math.max(most, v ? size(v) : 0), 0);
    const shown = value ?? Array(series.names.length).fill(null);
    const rows = list(shown).map((v, i) => [this.#name(panel, series, i), v, this.#color(series.first + i)]);
    if (panel.norm) rows.push([panel.norm, value ? Math.hypot(...value) : null, "#c9d3df"]);
    drawBars(canvas, rows, panel, largest, this.colors.bad);
  }

  #strip(canvas, panel, unit, keys, column, [times, span, now]) {
    const curves = panel.series.flatMap((series) => {
      const values = column(series.key);
      const count = Math.max(1, series.names.length, ...values.map((v) => (v ? list(v).length : 0)));
      return Array.from({ length: count }, (_, i) => ({
        name: this.#name(panel, series, i),
        values: values.map((v) => (v === null ? null : list(v)[i])),
        color: series.color || this.#color(series.first + i),
      }));
    });
    const largest = curves.reduce((most, c) => c.values.reduce((m, v) => Math.max(m, Math.abs(v ?? 0)), most), 0);
    const [factor, name] = panel.log || panel.unit === "deg" ? [1, ""] : prefix(largest);
    if (!panel.log) unit.textContent = `${name}${panel.unit}`;
    if (keys.childElementCount !== curves.length) showKeys(keys, curves.map((c) => [c.name, c.color]));
    const { log, limit } = panel;
    drawStrip(canvas, times, curves, span, now, { log, factor, limit, bad: this.colors.bad });
  }
}
