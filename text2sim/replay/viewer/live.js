// A watched case: its problems, the progress of its simulation, and its newest recording.

function follow(replay) {
  let shown = "", played = "";
  const source = new EventSource("events");
  source.onmessage = async (event) => {
    const state = JSON.parse(event.data);
    tellState(state);
    if (!state.scene || state.scene.name === shown) return;
    const { name, take, whole } = state.scene;
    shown = name;
    const answer = await fetch("scene/" + name);
    if (!answer.ok) return;
    const { contents, blob } = await answer.json(), data = unpack(contents, await inflated(blob));
    if (shown !== name) return;
    const first = !replay.data, following = replay.time >= replay.span[1] - 1e-9;
    replay.show(data);
    if (first && data.cameras.length) replay.seeThrough(0);  // as in the film
    if (following) replay.seek(replay.span[1]);
    if (following && whole && played !== take) replay.play();
    if (whole) played = take;
    document.documentElement.dataset.scene = name;
  };
  source.onerror = () => tellState({ words: "text2sim watch has ended", tone: "bad" });
}

function tellState(state) {
  const bar = byId("progress"), list = byId("problems");
  byId("status").textContent = state.words;
  byId("status").className = `verdict ${state.tone}`;
  bar.hidden = state.progress === null || state.progress === undefined;
  if (!bar.hidden) bar.value = state.progress;
  byId("frame").classList.toggle("stale", Boolean(state.stale));
  if (state.case === undefined) return;
  document.title = `${state.mark ?? ""} ${state.case}`.trim();
  byId("case").textContent = state.case;
  byId("file").textContent = state.file;
  byId("timing").textContent = state.timing || "";
  list.replaceChildren(...(state.problems || []).map((row) => {
    const item = make("li", undefined, row.severity), place = row.line ? `line ${row.line}${row.column ? ":" + row.column : ""} ` : "";
    item.append(make("b", place), row.message + (row.hint ? `; did you mean \`${row.hint}\`?` : ""));
    if (row.excerpt) item.append(make("pre", row.excerpt));
    item.append(make("small", [row.severity, row.rule, row.path].filter(Boolean).join(" · ")));
    return item;
  }));
  byId("problems-part").hidden = !list.children.length;
}
