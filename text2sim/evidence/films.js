// Plays, stops and seeks the films of a case together, by time of film.
for (const group of document.querySelectorAll(".together")) {
  const films = [...group.querySelectorAll("video")];
  const play = group.querySelector("button"), seek = group.querySelector("input"), clock = group.querySelector("span");
  if (!films.length || !play) continue;
  const length = () => Math.max(...films.map(film => film.duration || 0));
  const lead = () => films.reduce((a, b) => ((b.duration || 0) > (a.duration || 0) ? b : a));
  const running = () => films.some(film => !film.paused);
  const go = time => films.forEach(film => { film.currentTime = Math.min(time, film.duration || 0); });
  play.onclick = () => {
    if (running()) { films.forEach(film => film.pause()); go(lead().currentTime); return; }
    if (lead().currentTime >= length() - 0.05) go(0);
    films.forEach(film => film.play());
  };
  seek.oninput = () => { films.forEach(film => film.pause()); go(seek.value * length()); };
  const show = () => {
    play.textContent = running() ? "Pause" : "Play all";
    clock.textContent = lead().currentTime.toFixed(2) + " s";
    if (running() && length()) seek.value = lead().currentTime / length();
  };
  setInterval(show, 50);
}
