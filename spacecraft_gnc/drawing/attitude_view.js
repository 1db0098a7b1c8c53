// The attitude on the unit sphere, and the slider that moves the body axes.

const AXES = ["x", "y", "z"];
const ARROW = 0.12; // length of an arrow's head

function unpackRun(run) {
  const unpacked = { ...run };
  for (const name of ["time", "attitude", "reference", "error"]) unpacked[name] = unpack(run[name]);
  if (run.rotors) {
    unpacked.rotors = { ...run.rotors, rims: run.rotors.rims.map(rowsOf) };
    for (const name of ["turning", "healthy", "trusted"]) unpacked.rotors[name] = unpack(run.rotors[name]);
  }
  unpacked.readout = run.readout.map((line) => ({ ...line, values: unpack(line.values) }));
  return unpacked;
}

function ball(sphere) {
  const x = [], y = [], z = [], turns = 48, bands = 24;
  for (let i = 0; i <= bands; i += 1) {
    const polar = (Math.PI * i) / bands, row = [[], [], []];
    for (let j = 0; j <= turns; j += 1) {
      const turn = (2 * Math.PI * j) / turns;
      row[0].push(0.985 * Math.sin(polar) * Math.cos(turn));
      row[1].push(0.985 * Math.sin(polar) * Math.sin(turn));
      row[2].push(0.985 * Math.cos(polar));
    }
    x.push(row[0]); y.push(row[1]); z.push(row[2]);
  }
  const surface = { type: "surface", x, y, z, opacity: 0.35, showscale: false, hoverinfo: "skip",
    colorscale: [[0, "#eef1f5"], [1, "#eef1f5"]], lighting: { ambient: 0.95, diffuse: 0.1, specular: 0 },
    contours: { x: { highlight: false }, y: { highlight: false }, z: { highlight: false } } };
  const graticule = { line: { color: "#c9ced6", width: 1 } };
  const circles = sphere.graticule.map((packed) => line3d(rowsOf(packed), graticule));
  const axes = AXES.map((name, i) => {
    const tip = [0, 1, 2].map((j) => (i === j ? 1.22 : 0));
    const foot = tip.map((value) => value / 1.22);
    return line3d([foot, tip], { mode: "lines+text", text: ["", name.toUpperCase()],
      textfont: { color: sphere.ink, size: 13 }, line: { color: sphere.ink, width: 2 } });
  });
  return [surface, ...circles, ...axes];
}

function zoneTraces(zone) {
  const points = rowsOf(zone.points), ring = rowsOf(zone.border);
  const pick = (rows, i) => rows.map((row) => row[i]);
  const [i, j, k] = zone.triangles;
  const mesh = { type: "mesh3d", x: pick(points, 0), y: pick(points, 1), z: pick(points, 2), i, j, k,
    color: zone.color, opacity: 0.55, name: zone.name, showlegend: true, hoverinfo: "name",
    flatshading: true, lighting: { ambient: 1, diffuse: 0, specular: 0 } };
  ring.push(ring[0]);
  return [mesh, line3d(ring, { line: { color: zone.color, width: 5 } })];
}

function pathOf(run, vector, options) {
  const points = [];
  for (let k = 0; k < run.count; k += 1) points.push(timesVector(run.attitude, k, vector));
  return line3d(points, options);
}

// A shaft with two barbs, drawn as one line: the scene has no arrows of its own.
function arrow(tip, side) {
  const barb = (sign) => [0, 1, 2].map((i) => (1 - ARROW) * tip[i] + 0.5 * sign * ARROW * side[i]);
  return [[0, 0, 0], tip, barb(1), tip, barb(-1)];
}

// Wheel i at state k: its rim where it works, its rim where it is lost, an arc as long as it is
// fast, from its mark on, and the bars that cross it out where it is excluded.
function rotorAt(run, k, i) {
  const { rims, turning, healthy, trusted } = run.rotors, at = rims.length * k + i;
  const rim = rims[i].map((point) => timesVector(run.attitude, k, point));
  const last = rim.length - 1, steps = Math.round(last * Math.min(Math.abs(turning[at]), 1)) || 0;
  const arc = turning[at] < 0 ? rim.slice(last - steps) : rim.slice(0, steps + 1);
  const quarter = last / 4, none = [];
  const bars = [rim[0], rim[2 * quarter], [null, null, null], rim[quarter], rim[3 * quarter]];
  return [healthy[at] ? rim : none, healthy[at] ? none : rim, arc, trusted[at] ? none : bars];
}

function rotorStyles(rotors) {
  const { names, colors, lost } = rotors;
  return names.flatMap((name, i) => [
    { line: { color: colors[i], width: 3 }, name, showlegend: true },
    { line: { color: lost, width: 3 }, name: `${name} lost`, showlegend: true },
    { line: { color: colors[i], width: 9 } },
    { line: { color: lost, width: 5 } },
  ]);
}

function arrowsAt(run, k) {
  const arrows = AXES.map((_, j) => arrow(columnOf(run.attitude, k, j), columnOf(run.attitude, k, (j + 1) % 3)));
  for (const zone of run.zones.filter((item) => item.boresight)) {
    const tip = timesVector(run.attitude, k, zone.bodyAxis);
    arrows.push([[0, 0, 0], tip]);
  }
  const diamonds = AXES.map((_, j) => [columnOf(run.reference, k, j)]);
  const rotors = run.rotors ? run.rotors.names.flatMap((_, i) => rotorAt(run, k, i)) : [];
  return [...arrows, ...diamonds, ...rotors];
}

function movingTraces(sphere, run, k) {
  const boresights = run.zones.filter((zone) => zone.boresight);
  const styles = [
    ...AXES.map((name, j) => ({ name: `body ${name}`, showlegend: true, line: { color: sphere.axisColors[j], width: 7 } })),
    ...boresights.map((zone) => ({ name: `boresight of ${zone.name}`, showlegend: true, line: { color: zone.color, width: 7 } })),
    ...AXES.map((name, j) => ({ name: `reference ${name}`, mode: "markers",
      marker: { symbol: "diamond-open", size: 6, color: sphere.axisColors[j] } })),
    ...(run.rotors ? rotorStyles(run.rotors) : []),
  ];
  return arrowsAt(run, k).map((points, i) => line3d(points, styles[i]));
}

function sceneLayout() {
  const hidden = { visible: false, range: [-1.3, 1.3] };
  return { margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "#fff", showlegend: true,
    font: { family: "system-ui, sans-serif", size: 12 },
    legend: { orientation: "h", x: 0, y: 0, yanchor: "top" },
    scene: { xaxis: hidden, yaxis: hidden, zaxis: hidden, aspectmode: "manual",
      aspectratio: { x: 2, y: 2, z: 2 }, dragmode: "orbit",
      camera: { eye: { x: 1.05, y: 0.85, z: 0.6 }, projection: { type: "orthographic" } } } };
}

async function drawView(sphere) {
  let first = 0;

  function draw(run) {
    const paths = AXES.map((name, j) => pathOf(run, [0, 1, 2].map((i) => (i === j ? 1 : 0)),
      { line: { color: sphere.axisColors[j], width: 3 } }));
    const fixed = [...ball(sphere), ...run.zones.flatMap(zoneTraces), ...paths];
    first = fixed.length;
    return Plotly.react("view-plot", [...fixed, ...movingTraces(sphere, run, 0)], sceneLayout(), plotConfig);
  }

  function move(run, k) {
    const moved = arrowsAt(run, k);
    const along = (i) => moved.map((points) => points.map((point) => point[i]));
    return Plotly.restyle("view-plot", { x: along(0), y: along(1), z: along(2) }, moved.map((_, i) => first + i));
  }

  const told = (run, k) => `error ${run.error[k].toPrecision(3)} degrees`;
  await connectPlayer(sphere.runs.map(unpackRun), { draw, move, told });
}
