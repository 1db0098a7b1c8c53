// Numbers in words: the lists beside the picture.

// A list for each group of lines: {group: [[label, text, mood], ...]}.
export function showNumbers(readouts) {
  document.getElementById("numbers").replaceChildren(...Object.entries(readouts).map(([group, rows]) => {
    const list = document.createElement("dl");
    list.id = `readout-${group}`;
    list.hidden = rows.length === 0;
    list.append(...rows.flatMap(([name, text, mood]) => {
      const [term, detail] = [document.createElement("dt"), document.createElement("dd")];
      term.textContent = name;
      detail.textContent = text;
      if (mood) detail.className = mood;
      return [term, detail];
    }));
    return list;
  }));
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

// Colored words that explain the lines of a chart.
export function showKeys(place, keys) {
  place.replaceChildren(...keys.map(([name, color]) => {
    const [key, text] = [document.createElement("span"), document.createElement("b")];
    key.className = "key";
    key.style.color = color;
    text.textContent = name;
    key.append(text);
    return key;
  }));
}
