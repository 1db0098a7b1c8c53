// The flight report: the 3-D view, and the diagrams of the runs.

window.addEventListener("DOMContentLoaded", async () => {
  connectCharts();
  await drawView(page.view);
  await drawCharts();
  pageIsReady();
});
