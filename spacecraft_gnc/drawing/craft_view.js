// Craft on their paths in one frame, where they are to be, and the lines between them.

function unpackRun(run) {
  const craft = run.craft.map((one) => ({ ...one, path: rowsOf(one.path), place: rowsOf(one.place) }));
  const readout = run.readout.map((line) => ({ ...line, values: unpack(line.values) }));
  return { ...run, craft, readout, time: unpack(run.time), ring: rowsOf(run.ring) };
}

const isKnown = (point) => point.every(Number.isFinite);
const AROUND = 0.12; // around what is shown, as a share of it
const LEAST_EXTENT = 0.35; // of an axis, as a share of the largest one

class Swarm {
  constructor(view) {
    this.view = view;
    this.near = true; // whether the picture follows the craft
  }

  // Every moving line at state k, in the order of `styles`.
  pointsAt(run, k) {
    const lines = (kept) => run.links.filter((link) => link.kept[k] === kept)
      .flatMap(({ craft: [a, b] }) => [run.craft[a].path[k], run.craft[b].path[k], GAP]);
    return [
      run.ring,
      lines(true),
      lines(false),
      ...run.craft.flatMap(({ path, place }) => [
        path.slice(0, k + 1), path.slice(k), [place[k]], [path[0]], [path[k]],
      ]),
      run.craft.filter(({ answers }) => !answers[k]).map(({ path }) => path[k]),
    ];
  }

  traces(run) {
    const { view } = this;
    const line = (options) => line3d([], options);
    const marks = (marker, options) => line({ mode: "markers", marker, ...options });
    const anyBroken = run.links.some(({ kept }) => kept.includes(false));
    const styles = [
      line({ name: "natural ellipse", showlegend: run.ring.length > 0, line: { color: view.ringColor, width: 3, dash: "dash" } }),
      line({ name: "limits of a pair kept", showlegend: run.links.length > 0, line: { color: view.keptColor, width: 2 } }),
      line({ name: "broken", showlegend: anyBroken, line: { color: view.brokenColor, width: 6 } }),
      ...run.craft.flatMap(({ name, color }) => [
        line({ line: { color, width: 4 } }),
        line({ line: { color: view.grid, width: 2 } }),
        marks({ symbol: "diamond-open", size: 8, color, line: { width: 2 } }),
        marks({ symbol: "circle-open", size: 4, color }),
        marks({ symbol: "circle", size: 7, color }, { name, showlegend: true, hoverinfo: "name" }),
      ]),
      marks({ symbol: "x", size: 6, color: view.brokenColor }, { name: "lost", showlegend: run.craft.some(({ answers }) => answers.includes(false)) }),
    ];
    return this.pointsAt(run, 0).map((points, n) => ({ ...styles[n], ...coordinates(points) }));
  }

  // What has to be seen: the ring with the craft and their places, now or over the whole flight.
  seen(run, k) {
    const rows = (points) => (this.near ? [points[k]] : points);
    const points = run.craft.flatMap(({ path, place }) => [...rows(path), ...rows(place)]);
    return [...run.ring, ...points].filter(isKnown);
  }

  // Ranges of the axes, and how long each is drawn: one scale along all of them.
  box(run, k) {
    const points = this.seen(run, k);
    const limits = [0, 1, 2].map((i) => [Math.min(0, ...points.map((p) => p[i])), Math.max(0, ...points.map((p) => p[i]))]);
    const largest = Math.max(...limits.map(([low, high]) => high - low), 1e-9);
    const ranges = limits.map(([low, high]) => {
      const half = 0.5 * Math.max(high - low, LEAST_EXTENT * largest) + AROUND * largest, middle = 0.5 * (low + high);
      return [middle - half, middle + half];
    });
    const longest = Math.max(...ranges.map(([low, high]) => high - low));
    return { ranges, ratio: ranges.map(([low, high]) => (1.6 * (high - low)) / longest) };
  }

  scene(run, k) {
    const { ranges, ratio: [x, y, z] } = this.box(run, k);
    const axes = ranges.map((range, i) => ({ range, title: { text: this.view.axes[i] }, gridcolor: this.view.grid,
      zerolinecolor: this.view.grid, showbackground: false, nticks: 6, showspikes: false }));
    return { axes, aspect: { x, y, z } };
  }

  layout(run) {
    const { axes: [xaxis, yaxis, zaxis], aspect } = this.scene(run, 0);
    return { margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "#fff", showlegend: true,
      font: { family: "system-ui, sans-serif", size: 12 },
      legend: { orientation: "h", x: 0, y: 0, yanchor: "top" },
      scene: { xaxis, yaxis, zaxis, aspectmode: "manual", aspectratio: aspect, dragmode: "orbit",
        camera: { up: { x: 1, y: 0, z: 0 }, eye: { x: 0.55, y: -0.45, z: -1.3 }, projection: { type: "orthographic" } } } };
  }

  move(run, k) {
    const moved = this.pointsAt(run, k).map(coordinates);
    const along = (name) => moved.map((points) => points[name]);
    const { axes: [x, y, z], aspect } = this.scene(run, k);
    return Plotly.update("view-plot", { x: along("x"), y: along("y"), z: along("z") },
      { "scene.xaxis": x, "scene.yaxis": y, "scene.zaxis": z, "scene.aspectratio": aspect }, moved.map((_, i) => i));
  }
}

async function drawView(view) {
  const swarm = new Swarm(view), place = document.getElementById("view-options");
  const redraw = await connectPlayer(view.runs.map(unpackRun), {
    draw: (run) => Plotly.react("view-plot", swarm.traces(run), swarm.layout(run), plotConfig),
    move: (run, k) => swarm.move(run, k),
    told: (run, k) => run.told[k],
  });
  addSwitch(place, "view-near", "follow the craft", true, (on) => { swarm.near = on; redraw(); });
}
