// Bodies that move relative to each other, and the slider that moves them.
// Points lie in the frame of the first body; `turn` takes them to the other frame.

function unpackRun(run) {
  const unpacked = { ...run };
  for (const name of ["time", "turn"]) unpacked[name] = unpack(run[name]);
  for (const name of ["trail", "reference"]) unpacked[name] = rowsOf(run[name]);
  unpacked.bodies = run.bodies.map((body) => (
    { ...body, position: rowsOf(body.position), attitude: unpack(body.attitude) }));
  if (run.region) unpacked.region = { ...run.region, corners: rowsOf(run.region.corners) };
  unpacked.readout = run.readout.map((line) => ({ ...line, values: unpack(line.values) }));
  return unpacked;
}

const plus = (a, b) => a.map((value, i) => value + b[i]);

class Bodies {
  constructor(view) {
    this.view = view;
    this.corners = rowsOf(view.corners);
    this.other = false; // whether the other frame is shown
    this.near = true; // whether the picture follows the approach
  }

  // A point of the frame of the motion, in the frame that is shown at state k.
  placed(run, k, point) {
    return this.other ? timesVector(run.turn, k, point) : point;
  }

  bodyPoint(run, body, k, point) {
    return this.placed(run, k, plus(body.position[k], timesVector(body.attitude, k, point)));
  }

  cornersOf(run, body, k) {
    return this.corners.map((corner) => this.bodyPoint(run, body, k, corner.map((c, i) => 0.5 * c * body.size[i])));
  }

  edgesOf(corners) {
    return this.view.edges.flatMap(([a, b]) => [corners[a], corners[b], GAP]);
  }

  // Every moving line and mesh at state k, in the order of `styles`.
  pointsAt(run, k) {
    const region = run.region ? run.region.corners.map((corner) => this.placed(run, k, corner)) : null;
    const solids = run.bodies.map((body) => this.cornersOf(run, body, k));
    const path = (points, from, to) => points.slice(from, to).map((point, i) => this.placed(run, from + i, point));
    const left = run.bodies.slice(1).flatMap((body) => (
      run.snapshots.filter((at) => at !== k).flatMap((at) => this.edgesOf(this.cornersOf(run, body, at)))));
    return [
      ...solids.flatMap((corners) => [corners, this.edgesOf(corners)]),
      run.bodies.map((body) => this.bodyPoint(run, body, k, body.port)),
      ...(region ? [region, this.edgesOf(region)] : []),
      path(run.trail, 0, k + 1),
      path(run.trail, k, run.count),
      [this.placed(run, k, run.reference[k])],
      left,
    ];
  }

  traces(run) {
    const { view } = this, [i, j, k] = view.triangles;
    const mesh = (options) => ({ type: "mesh3d", i, j, k, flatshading: true, hoverinfo: "name", ...options });
    const line = (options) => line3d([], options);
    const trailColor = run.bodies.at(-1)?.color ?? view.ink;
    const styles = [
      ...run.bodies.flatMap((body) => [
        mesh({ color: body.color, name: body.name, showlegend: true,
          lighting: { ambient: 0.75, diffuse: 0.6, specular: 0.05 }, lightposition: { x: 2000, y: -4000, z: 4000 } }),
        line({ line: { color: view.ink, width: 2 } }),
      ]),
      line({ mode: "markers", name: "ports", showlegend: run.bodies.length > 0, marker: { color: view.portColor, size: 4 } }),
      ...(run.region ? [
        mesh({ color: run.region.color, opacity: 0.1, name: run.region.name, showlegend: true, hoverinfo: "skip" }),
        line({ line: { color: run.region.color, width: 2 } }),
      ] : []),
      line({ name: "path", showlegend: true, line: { color: trailColor, width: 4 } }),
      line({ line: { color: view.grid, width: 3 } }),
      line({ mode: "markers", name: "reference", showlegend: true,
        marker: { symbol: "diamond-open", size: 6, color: view.portColor } }),
      line({ name: "snapshots", showlegend: run.snapshots.length > 0, line: { color: trailColor, width: 1.5 } }),
    ];
    return this.pointsAt(run, 0).map((points, n) => ({ ...styles[n], ...coordinates(points) }));
  }

  // A cube around the bodies: as large as the whole flight, or as their distance now.
  cube(run, k) {
    const away = (at) => Math.hypot(...run.trail[at].map((v) => v || 0));
    const size = Math.max(1, ...run.bodies.map((body) => Math.max(...body.size)));
    const far = this.near ? away(k) : Math.max(...run.trail.map((_, at) => away(at)));
    const centered = this.other && !this.near;
    const middle = centered ? [0, 0, 0] : this.placed(run, k, this.middle(run, k)).map((v) => 0.5 * (v || 0));
    const half = centered ? far + size : 0.55 * far + 0.9 * size;
    return middle.map((v) => [v - half, v + half]);
  }

  middle(run, k) {
    if (this.near) return run.trail[k];
    return [0, 1, 2].map((i) => Math.max(...run.trail.map((p) => p[i] || 0)) + Math.min(...run.trail.map((p) => p[i] || 0)));
  }

  axes(run, k) {
    const { view } = this, names = view.frames[this.other ? 1 : 0].axes;
    return this.cube(run, k).map((range, i) => ({ range, title: { text: `${names[i]} [m]` },
      gridcolor: view.grid, zerolinecolor: view.grid, showbackground: false, nticks: 6, showspikes: false }));
  }

  layout(run) {
    const [xaxis, yaxis, zaxis] = this.axes(run, 0);
    return { margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "#fff", showlegend: true,
      font: { family: "system-ui, sans-serif", size: 12 },
      legend: { orientation: "h", x: 0, y: 0, yanchor: "top" },
      scene: { xaxis, yaxis, zaxis, aspectmode: "cube", dragmode: "orbit",
        camera: { eye: { x: 0.56, y: -1.1, z: 0.56 }, projection: { type: "orthographic" } } } };
  }

  move(run, k) {
    const moved = this.pointsAt(run, k).map(coordinates);
    const along = (name) => moved.map((points) => points[name]);
    const [x, y, z] = this.axes(run, k);
    return Plotly.update("view-plot", { x: along("x"), y: along("y"), z: along("z") },
      { "scene.xaxis": x, "scene.yaxis": y, "scene.zaxis": z }, moved.map((_, i) => i));
  }
}

async function drawView(view) {
  const bodies = new Bodies(view), place = document.getElementById("view-options");
  const redraw = await connectPlayer(view.runs.map(unpackRun), {
    draw: (run) => Plotly.react("view-plot", bodies.traces(run), bodies.layout(run), plotConfig),
    move: (run, k) => bodies.move(run, k),
    told: (run, k) => run.told[k],
  });
  addSwitch(place, "view-near", "zoom in as they approach", true, (on) => { bodies.near = on; redraw(); });
  addSwitch(place, "view-frame", `in ${view.frames[1].name}`, false, (on) => { bodies.other = on; redraw(); });
}
