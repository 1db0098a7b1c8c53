"use strict";
// Draws the diagrams of a page; nothing is fetched, the data lie in the page.

const page = JSON.parse(document.getElementById("page-data").textContent);
const plotConfig = {
  responsive: true,
  displaylogo: false,
  displayModeBar: "hover",
  showSendToCloud: false, // plotly.js would offer to upload the flight
  plotlyServerURL: "",
  modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
  toImageButtonOptions: { format: "svg" },
};

// Plotly writes into what it draws: a form chosen again must be as it was.
const copyOf = (figure) => structuredClone(figure);

function drawChart(chart) {
  const figure = copyOf(chart.figure);
  return Plotly.newPlot(chart.name, figure.data, figure.layout, plotConfig);
}

function connectScale(box, chart) {
  box.addEventListener("change", () => {
    const type = box.checked ? "log" : "linear";
    Plotly.relayout(chart.name, { [`${chart.scale}.type`]: type, [`${chart.scale}.autorange`]: true });
  });
}

function connectVariants(select, chart) {
  select.addEventListener("change", () => {
    const variant = chart.variants[Number(select.value)];
    const figure = copyOf(variant.figure);
    Plotly.react(chart.name, figure.data, figure.layout, plotConfig);
    document.getElementById(`n-${chart.name}`).textContent = variant.note;
  });
}

// Each column goes on where its last diagram ends, whatever the height of the one beside it.
const ROW = 2; // [px] of the grid, as in page.css
const ROOM = 22; // [px] below a diagram
function packCharts(charts) {
  const observer = new ResizeObserver((changes) => {
    for (const { target } of changes) {
      const rows = Math.ceil((target.getBoundingClientRect().height + ROOM) / ROW);
      target.style.gridRowEnd = `span ${rows}`;
    }
  });
  for (const chart of charts.children) observer.observe(chart);
  charts.classList.add("packed");
}

const chartNamed = (name) => page.charts.find((chart) => chart.name === name);

function connectCharts() {
  for (const box of document.querySelectorAll("[data-scale]")) {
    box.checked = true; // a browser may restore what it was before a reload
    connectScale(box, chartNamed(box.dataset.scale));
  }
  for (const select of document.querySelectorAll("[data-variants]")) {
    select.value = "0";
    connectVariants(select, chartNamed(select.dataset.variants));
  }
  for (const charts of document.querySelectorAll(".charts")) packCharts(charts);
}

async function drawCharts() {
  for (const chart of page.charts) await drawChart(chart);
}

function pageIsReady() {
  document.documentElement.dataset.ready = "true";
}

// A sheet of paper has another width than the window.
for (const event of ["beforeprint", "afterprint"]) {
  window.addEventListener(event, () => {
    for (const plot of document.querySelectorAll(".js-plotly-plot")) Plotly.Plots.resize(plot);
  });
}
