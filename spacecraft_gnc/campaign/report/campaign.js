// The campaign's report: its diagrams, and those of two columns that the reader chooses.

const OTHERS = 0, PASSED = 1; // of the counts of a pair

// Rows of a matrix, y by y, of a flat list; turned where x and y of the list are the other way.
function rowsOf(flat, width, turned) {
  const height = flat.length / width;
  if (turned)
    return Array.from({ length: width }, (_, x) =>
      Array.from({ length: height }, (_, y) => flat[y * width + x]));
  return Array.from({ length: height }, (_, y) => flat.slice(y * width, (y + 1) * width));
}

function countsOf(pair, i, j) {
  const turned = pair.name === "rates" && i > j;
  const cells = pair.cells[turned ? `${j},${i}` : `${i},${j}`];
  const width = pair.x[turned ? j : i].edges.length - 1;
  return cells.map((flat) => rowsOf(flat, width, turned));
}

const combined = (a, b, f) => a.map((row, y) => row.map((value, x) => f(value, b[y][x])));

function densityTrace(counts, which) {
  const all = combined(counts[OTHERS], counts[PASSED], (a, b) => a + b);
  const shown = { all, passed: counts[PASSED], "not passed": counts[OTHERS] }[which];
  const most = Math.max(1, ...shown.flat());
  const ticks = [...Array(Math.floor(Math.log10(most)) + 1).keys()];
  return {
    z: shown.map((row) => row.map((count) => (count ? Math.log10(count) : null))),
    customdata: shown,
    zmin: 0,
    zmax: Math.max(1, Math.log10(most)),
    hovertemplate: "%{x:.4g}<br>%{y:.4g}<br>%{customdata} runs<extra></extra>",
    colorbar: { title: { text: "runs" }, tickvals: ticks, ticktext: ticks.map((k) => `${10 ** k}`) },
  };
}

// The colors span the rates of cells with enough runs: those of a few runs are 0 or 100 % by chance.
function spanOf(rates, totals, enough) {
  const sure = rates.flatMap((row, y) => row.filter((_, x) => totals[y][x] >= enough));
  return sure.length ? { zmin: Math.min(...sure), zmax: Math.max(...sure) } : {};
}

function rateTrace(counts, enough) {
  const totals = combined(counts[OTHERS], counts[PASSED], (a, b) => a + b);
  const rates = combined(counts[PASSED], totals, (a, n) => (n ? (100 * a) / n : null));
  return {
    z: rates,
    ...spanOf(rates, totals, enough),
    customdata: combined(counts[PASSED], totals, (a, n) => `${a} of ${n}`),
    hovertemplate: "%{x:.4g}<br>%{y:.4g}<br>%{z:.4g} %, %{customdata} passed<extra></extra>",
    colorbar: { title: { text: "passed [%]" } },
  };
}

function pairFigure(pair, i, j, which) {
  const x = pair.x[i], y = pair.y[j];
  const counts = countsOf(pair, i, j);
  const trace = pair.name === "rates" ? rateTrace(counts, pair.enough) : densityTrace(counts, which);
  trace.colorbar = { thickness: 12, outlinewidth: 0, len: 1, ...trace.colorbar };
  const heat = { type: "heatmap", x: x.edges, y: y.edges, colorscale: pair.colors, ...trace };
  const layout = { ...copyOf(pair.layout), xaxis: copyOf(x.axis), yaxis: copyOf(y.axis) };
  return { data: [heat], layout };
}

const partOf = (pair, part) =>
  document.querySelector(`[data-pair="${pair.name}"][data-part="${part}"]`);

function drawPair(pair) {
  const [i, j] = ["x", "y"].map((part) => Number(partOf(pair, part).value));
  const which = partOf(pair, "which")?.value ?? "";
  const figure = pairFigure(pair, i, j, which);
  return Plotly.react(pair.name, figure.data, figure.layout, plotConfig);
}

// Of two parameters the one may not be the other: it takes the place that is left.
function keepApart(pair, changed) {
  const x = partOf(pair, "x"), y = partOf(pair, "y");
  if (x.value !== y.value) return;
  const other = changed === x ? y : x;
  other.value = String(Number(changed.value) ? 0 : 1);
}

function connectPair(pair) {
  for (const part of ["x", "y"]) {
    const select = partOf(pair, part);
    select.replaceChildren(...pair[part].map((column, k) => new Option(column.label, String(k))));
    select.value = pair.name === "rates" && part === "y" ? "1" : "0";
  }
  for (const select of document.querySelectorAll(`[data-pair="${pair.name}"]`)) {
    select.addEventListener("change", () => {
      if (pair.name === "rates") keepApart(pair, select);
      drawPair(pair);
    });
  }
}

window.addEventListener("DOMContentLoaded", async () => {
  connectCharts();
  for (const pair of page.pairs) connectPair(pair);
  for (const pair of page.pairs) await drawPair(pair);
  await drawCharts();
  pageIsReady();
});
